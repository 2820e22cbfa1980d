// The benchmark's geometry with everything that rendering needs: a lamp, one grey material, a camera, bounds.
#pragma once
#include <algorithm>
#include <cmath>
#include <string>

#include "hemisphere_rays.h"
#include "irradia/Scene.h"
#include "shapes.h"

namespace irradia::bench {

struct LitScene {
    Scene scene;
    Lamp lamp;
};

inline void add_camera(Scene& scene, float z, float half_width) {
    shared::Camera& c = scene.info.camera;
    scene.info.width = scene.info.height = 256;
    scene.info.rfilter = IR_RFILTER_BOX;
    scene.info.rfilter_radius = 0.5f;
    c.oz = z;
    c.near_clip = 0.01f, c.far_clip = 100.0f;
    c.cornerx = -half_width, c.cornery = half_width, c.cornerz = -1;
    c.dxx = 2 * half_width, c.dyy = -2 * half_width;
    c.forwardz = -1;
    c.pixel_size = 2 * half_width / 256;
}

/// Turns geometry into a scene: `lamp` (u x v points to where it shines) is added to it.
inline LitScene lit(Scene scene, const Lamp& lamp, float camera_z, float half_width) {
    shapes::add_quad(scene, {lamp.px, lamp.py, lamp.pz}, {lamp.ux, lamp.uy, lamp.uz}, {lamp.vx, lamp.vy, lamp.vz});
    shared::Material grey = blank_material();
    grey.r = grey.g = grey.b = 0.5f;
    grey.back = 0;
    scene.materials = {grey};
    for (shared::Triangle& t : scene.triangles) {
        const Double3 n = testing::cross(edge(scene, t.v0, t.v1), edge(scene, t.v0, t.v2));
        const double l = std::sqrt(testing::dot(n, n));
        t.nx = static_cast<float>(n.x / l), t.ny = static_cast<float>(n.y / l), t.nz = static_cast<float>(n.z / l);
    }
    const shared::Triangle& lamp_triangle = scene.triangles.back();
    shared::Light light{};
    light.kind = IR_LIGHT_QUAD;
    light.px = lamp.px, light.py = lamp.py, light.pz = lamp.pz;
    light.e1x = lamp.ux, light.e1y = lamp.uy, light.e1z = lamp.uz;
    light.e2x = lamp.vx, light.e2y = lamp.vy, light.e2z = lamp.vz;
    light.nx = lamp_triangle.nx, light.ny = lamp_triangle.ny, light.nz = lamp_triangle.nz;
    light.area = std::hypot(lamp.ux, lamp.uy, lamp.uz) * std::hypot(lamp.vx, lamp.vy, lamp.vz);
    light.r = light.g = light.b = 10;
    light.probability = light.cdf = 1;
    light.texture = IR_NO_TEXTURE;
    scene.lights = {light};
    scene.triangles[scene.triangles.size() - 2].light = scene.triangles.back().light = 0;

    shared::SceneInfo& info = scene.info;
    info.light_count = 1;
    info.environment_light = IR_NO_LIGHT;
    info.min_x = info.min_y = info.min_z = 1e30f;
    info.max_x = info.max_y = info.max_z = -1e30f;
    for (const shared::Vertex& v : scene.vertices) {
        info.min_x = std::min(info.min_x, v.px), info.max_x = std::max(info.max_x, v.px);
        info.min_y = std::min(info.min_y, v.py), info.max_y = std::max(info.max_y, v.py);
        info.min_z = std::min(info.min_z, v.pz), info.max_z = std::max(info.max_z, v.pz);
    }
    info.diagonal = std::hypot(info.max_x - info.min_x, info.max_y - info.min_y, info.max_z - info.min_z);
    add_camera(scene, camera_z, half_width);
    return {std::move(scene), lamp};
}

/// "cornell", "mesh60k" or "mesh250k".
inline LitScene lit_scene(const std::string& name) {
    if (name == "cornell")
        return lit(shapes::cornell_box(), {-0.23f, 0.989f, -0.18f, 0.46f, 0, 0, 0, 0, 0.38f}, 3.9f, 0.36f);
    return lit(shapes::mesh_room(name == "mesh60k" ? 60000 : 250000), {-0.5f, 1.24f, -0.5f, 1, 0, 0, 0, 0, 1}, 1.9f,
               0.9f);
}

}  // namespace irradia::bench
