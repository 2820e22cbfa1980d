#include <algorithm>
#include <cmath>

#include "irradia/Scene.h"

namespace irradia {

void finish_scene(Scene& scene) {
    for (shared::Triangle& t : scene.triangles) {
        t.reach = 0;
        for (const std::uint32_t corner : {t.v0, t.v1, t.v2}) {
            const shared::Vertex& v = scene.vertices[corner];
            t.reach = std::max({t.reach, std::abs(v.px), std::abs(v.py), std::abs(v.pz)});
        }
    }
    auto& info = scene.info;
    info.triangle_count = static_cast<std::uint32_t>(scene.triangles.size());
    info.analytic_count = static_cast<std::uint32_t>(scene.analytics.size());
    info.light_count = static_cast<std::uint32_t>(scene.lights.size());
    info.environment_light = IR_NO_LIGHT;
    std::uint32_t features = 0;
    if (!scene.textures.empty()) features |= IR_FEATURE_TEXTURES;
    for (const shared::Material& m : scene.materials) {
        if (m.kind != IR_MATERIAL_DIFFUSE) features |= IR_FEATURE_BSDFS;
        if (m.back != IR_NO_MATERIAL && scene.materials[static_cast<std::size_t>(m.back)].kind != m.kind)
            features |= IR_FEATURE_BSDFS;
        if (m.opacity < 1.0f || m.opacity_texture != IR_NO_TEXTURE) features |= IR_FEATURE_MASKS;
        if (m.map != IR_NO_TEXTURE) features |= IR_FEATURE_BUMPS;
    }
    if (info.camera.aperture_radius > 0.0f) features |= IR_FEATURE_THIN_LENS;
    if (!scene.analytics.empty()) features |= IR_FEATURE_ANALYTIC;
    if (std::any_of(scene.triangles.begin(), scene.triangles.end(),
                    [](const shared::Triangle& t) { return (t.flags & IR_TRIANGLE_FLAT) == 0; }))
        features |= IR_FEATURE_SMOOTH_NORMALS;
    for (std::size_t i = 0; i < scene.lights.size(); ++i) {
        const auto kind = scene.lights[i].kind;
        if (kind == IR_LIGHT_CONSTANT || kind == IR_LIGHT_ENVMAP) {
            info.environment_light = static_cast<int>(i);
            features |= IR_FEATURE_ENVIRONMENT;
            if (kind == IR_LIGHT_ENVMAP) features |= IR_FEATURE_ENVMAP;
        } else if (kind == IR_LIGHT_POINT || kind == IR_LIGHT_DIRECTIONAL || kind == IR_LIGHT_SPOT) {
            features |= IR_FEATURE_DELTA_LIGHTS;
        } else if (scene.lights[i].texture != IR_NO_TEXTURE) {
            features |= IR_FEATURE_TEXTURED_LIGHTS;
        }
    }
    scene.features = features;
}

}  // namespace irradia
