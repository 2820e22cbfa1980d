#include <algorithm>

#include "irradia/Scene.h"

namespace irradia {

void finish_scene(Scene& scene) {
    auto& info = scene.info;
    info.triangle_count = static_cast<std::uint32_t>(scene.triangles.size());
    info.analytic_count = static_cast<std::uint32_t>(scene.analytics.size());
    info.light_count = static_cast<std::uint32_t>(scene.lights.size());
    info.environment_light = IR_NO_LIGHT;
    std::uint32_t features = 0;
    if (!scene.textures.empty()) features |= IR_FEATURE_TEXTURES;
    if (!scene.analytics.empty()) features |= IR_FEATURE_ANALYTIC;
    if (std::any_of(scene.triangles.begin(), scene.triangles.end(),
                    [](const shared::Triangle& t) { return (t.flags & IR_TRIANGLE_FLAT) == 0; }))
        features |= IR_FEATURE_SMOOTH_NORMALS;
    for (std::size_t i = 0; i < scene.lights.size(); ++i) {
        const auto kind = scene.lights[i].kind;
        if (kind == IR_LIGHT_CONSTANT) {
            info.environment_light = static_cast<int>(i);
            features |= IR_FEATURE_ENVIRONMENT;
        } else if (kind == IR_LIGHT_POINT || kind == IR_LIGHT_DIRECTIONAL) {
            features |= IR_FEATURE_DELTA_LIGHTS;
        }
    }
    scene.features = features;
}

}  // namespace irradia
