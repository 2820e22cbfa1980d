// What records are good for: the scene that they were made in and the settings that they were made by.
#include <array>
#include <sstream>
#include <vector>

#include "core/checksum.h"
#include "irradia/RecordFile.h"
#include "irradia/Renderer.h"

namespace irradia {
namespace {

template <class T>
std::uint64_t hash(std::uint64_t seed, const std::vector<T>& array) {
    return checksum(array.data(), array.size() * sizeof(T), seed);
}

std::string text(double value) {
    std::ostringstream out;
    out << value;
    return out.str();
}
std::string text(float value) { return text(static_cast<double>(value)); }
std::string on(bool value) { return value ? "on" : "off"; }

const char* name(GradientRule rule) {
    return rule == GradientRule::none ? "none" : rule == GradientRule::ward ? "ward" : "crease";
}
const char* name(RadiusRule rule) {
    return rule == RadiusRule::harmonic ? "harmonic" : rule == RadiusRule::minimum ? "minimum" : "hessian";
}

// Of radiance records alone.
bool is_glossy(const std::string& setting) { return setting.rfind("glossy-", 0) == 0; }

std::string value_of(const RecordOrigin& origin, const std::string& name) {
    for (const auto& [known, value] : origin.settings)
        if (known == name) return value;
    return "unknown";
}

}  // namespace

RecordOrigin record_origin(const Scene& scene, const RenderSettings& s) {
    RecordOrigin o;
    o.geometry = checksum(scene.centre.data(), sizeof scene.centre);
    o.geometry = hash(o.geometry, scene.vertices);
    o.geometry = hash(o.geometry, scene.triangles);
    o.geometry = hash(o.geometry, scene.analytics);
    o.materials = hash(hash(hash(0, scene.materials), scene.textures), scene.texels);
    o.emitters = hash(0, scene.lights);
    o.centre = scene.centre;
    o.lower = {scene.info.min_x, scene.info.min_y, scene.info.min_z};
    o.upper = {scene.info.max_x, scene.info.max_y, scene.info.max_z};
    o.settings = {
        {"accuracy", text(s.accuracy)},
        {"hemisphere", std::to_string(s.hemisphere_m) + "x" + std::to_string(s.hemisphere_n)},
        {"max-depth", std::to_string(s.max_depth)},
        {"overlap", text(s.overlap)},
        {"min-spacing", text(s.min_spacing)},
        {"max-spacing", text(s.max_spacing)},
        {"gap-spacing", text(s.gap_spacing)},
        {"gradients", name(s.gradients)},
        {"radius", name(s.radius)},
        {"neighbour-clamp", on(s.neighbour_clamp)},
        {"gradient-limit", on(s.gradient_limit)},
        {"reach-limit", on(s.reach_limit)},
        {"firefly", text(s.firefly)},
        {"grid", on(s.grid)},
        {"grid-paths", s.grid ? std::to_string(s.grid_paths) : "0"},
        {"glossy-accuracy", text(s.glossy_accuracy)},
    };
    return o;
}

std::string record_mismatch(const RecordOrigin& file, const RecordOrigin& render, bool radiance) {
    std::string out;
    const auto add = [&](const std::string& what) { out += (out.empty() ? "" : "; ") + what; };
    if (file.geometry != render.geometry || file.lower != render.lower || file.upper != render.upper ||
        file.centre != render.centre)
        add("other geometry");
    if (file.materials != render.materials) add("other materials or textures");
    if (file.emitters != render.emitters) add("other emitters");
    for (const auto& [setting, value] : render.settings) {
        if (is_glossy(setting) && !radiance) continue;
        const std::string theirs = value_of(file, setting);
        if (theirs != value) add("--" + setting + " is " + theirs + " there, " + value + " here");
    }
    for (const auto& [setting, value] : file.settings)
        if (value_of(render, setting) == "unknown") add("--" + setting + " is " + value + " there, unknown here");
    return out;
}

void keep_radiance_settings(const RecordOrigin& from, RecordOrigin& to) {
    for (auto& [setting, value] : to.settings)
        if (is_glossy(setting)) value = value_of(from, setting);
}

}  // namespace irradia
