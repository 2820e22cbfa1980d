// The scene as a device sees it: flat arrays, nothing to parse, nothing to build. What --pack writes.
#pragma once
#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "irradia/shared/scene_types.h"

namespace irradia {

/// How a hierarchy was built. Rays get the same answers, but for which of two surfaces at one distance they meet.
enum class AccelQuality {
    quick,  ///< by the surface area heuristic
    best    ///< with spatial splits: rays are up to a third faster, building takes two to four times as long
};

/// Both flattenings of one host BVH (built by Embree). The host never knows which of them a device traverses.
struct Accel {
    AccelQuality quality = AccelQuality::best;
    std::vector<shared::Bvh8Node> bvh8_nodes;            ///< CPU devices; node 0 is the root
    std::vector<shared::TriangleBlock> bvh8_triangles;   ///< CPU devices
    std::vector<shared::Bvh2Node> bvh2_nodes;            ///< GPU devices; node 0 is the root
    std::vector<shared::TrianglePacked> bvh2_triangles;  ///< GPU devices
};

/// Which of the two a scene has: a device reads one, a packed scene holds both.
enum class AccelLayouts { both, bvh8, bvh2 };

/// Everything `render` needs. Positions are world positions minus `centre`; see shared/scene_types.h for units.
struct Scene {
    std::vector<shared::Vertex> vertices;
    std::vector<shared::Triangle> triangles;
    std::vector<shared::Analytic> analytics;
    std::vector<shared::Material> materials;
    std::vector<shared::Texture> textures;
    std::vector<std::uint32_t> texels;
    std::vector<shared::Light> lights;
    shared::SceneInfo info{};         ///< camera, film size and filter, counts, bounds
    Accel accel;                      ///< filled by build_accel() (src/accel) or read from a packed scene
    std::array<double, 3> centre{};   ///< world position of the device's origin
    std::uint32_t features = 0;       ///< IR_FEATURE_*: which kernels this scene needs
    std::uint32_t sample_count = 64;  ///< the file's samples a pixel; --spp overrides
    std::string source;               ///< file it was loaded from, for messages and metadata
};

/// A black, opaque, diffuse material without textures, one-sided: what a loader fills in.
inline shared::Material blank_material() {
    shared::Material m{};
    m.kind = IR_MATERIAL_DIFFUSE;
    m.back = IR_NO_MATERIAL;
    m.texture = m.specular_texture = m.opacity_texture = m.alpha_texture = m.map = IR_NO_TEXTURE;
    m.opacity = 1.0f;
    m.specular_r = m.specular_g = m.specular_b = 1.0f;
    m.transmittance_r = m.transmittance_g = m.transmittance_b = 1.0f;
    m.eta = 1.0f;
    m.alpha_u = m.alpha_v = 0.1f;
    m.map_scale = 1.0f;
    return m;
}

/// Sets the triangles' reach, and info.{triangle,analytic,light}_count, environment_light and features from the arrays.
void finish_scene(Scene& scene);

}  // namespace irradia
