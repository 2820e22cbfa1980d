#include "app/stats.h"

#include <algorithm>
#include <iomanip>
#include <nlohmann/json.hpp>
#include <sstream>
#include <vector>

#include "app/film_size.h"
#include "app/progress.h"
#include "core/memory.h"

namespace irradia::app {
namespace {

using Json = nlohmann::ordered_json;

std::string number(double value) {
    std::ostringstream out;
    out << value;
    return out.str();
}

std::string mebibytes(std::uint64_t bytes) {
    std::ostringstream out;
    out << std::fixed << std::setprecision(1) << static_cast<double>(bytes) / (1 << 20) << " MiB";
    return out.str();
}

// A float as its decimal text reads: 0.2, not 0.20000000298.
double plain(float value) { return std::stod(number(static_cast<double>(value))); }

Json settings_json(const Options& o, int spp) {
    const RenderSettings& s = o.settings;
    return {{"method", name_of(method_names(), s.method)},
            {"spp", spp},
            {"max_depth", s.max_depth},
            {"seed", s.seed},
            {"accuracy", plain(s.accuracy)},
            {"hemisphere_m", s.hemisphere_m},
            {"hemisphere_n", s.hemisphere_n},
            {"overlap", plain(s.overlap)},
            {"min_spacing", plain(s.min_spacing)},
            {"max_spacing", plain(s.max_spacing)},
            {"gap_spacing", plain(s.gap_spacing)},
            {"glossy", name_of(glossy_names(), s.glossy)},
            {"trace_below", plain(s.trace_below)},
            {"glossy_share", plain(s.glossy_share)},
            {"harmonics_from", plain(s.harmonics_from)},
            {"harmonics_order", s.harmonics_order},
            {"lobe_table", s.lobe_table},
            {"glossy_accuracy", plain(s.glossy_accuracy)},
            {"glossy_reach", plain(s.glossy_reach)},
            {"glossy_spread", plain(s.glossy_spread)},
            {"gradients", name_of(gradient_names(), s.gradients)},
            {"radius", name_of(radius_names(), s.radius)},
            {"weight", name_of(weight_names(), s.weight)},
            {"neighbour_clamp", s.neighbour_clamp},
            {"gradient_limit", s.gradient_limit},
            {"in_front", s.in_front},
            {"reach_limit", s.reach_limit},
            {"direct_mis", name_of(direct_mis_names(), s.direct_mis)},
            {"firefly", plain(s.firefly)},
            {"pixel_error", plain(s.pixel_error)},
            {"grid", s.grid},
            {"grid_paths", s.grid_paths},
            {"learn_sky", s.learn_sky},
            {"share_lookups", s.share_lookups},
            {"specialise", s.specialise},
            {"error_share", plain(s.error_share)},
            {"aovs", s.aovs}};
}

// In the scene file's world: a point `origin + t * direction` is seen at film (x, y), which run over [0, 1] from the
// upper left, along direction = corner + x dx + y dy.
Json camera_json(const Run& r) {
    const shared::Camera& c = r.camera != nullptr ? *r.camera : r.scene.info.camera;
    const auto& centre = r.scene.centre;
    return {{"origin", {centre[0] + double{c.ox}, centre[1] + double{c.oy}, centre[2] + double{c.oz}}},
            {"corner", {c.cornerx, c.cornery, c.cornerz}},
            {"dx", {c.dxx, c.dxy, c.dxz}},
            {"dy", {c.dyx, c.dyy, c.dyz}},
            {"forward", {c.forwardx, c.forwardy, c.forwardz}},
            {"aperture_radius", c.aperture_radius},
            {"focus_distance", c.focus_distance}};
}

Json device_json(const Run& r) {
    return {{"index", r.device.index},
            {"name", r.device.name},
            {"platform", r.device.platform},
            {"driver", r.device.driver},
            {"kind", r.device.is_cpu ? "cpu" : "other"},
            {"compute_units", r.device.compute_units},
            {"threads", r.options.device.threads},
            {"traversal", r.cpu_traversal ? "cpu" : "gpu"}};
}

Json interval_json(const Interval& i) { return {{"value", i.value}, {"low", i.low}, {"high", i.high}}; }

Json error_json(const ErrorReport& e) {
    return {{"rel_rmse", interval_json(e.rel_rmse)},
            {"mean_bias", interval_json(e.mean_bias)},
            {"direct_rel_rmse", e.direct_rel_rmse},
            {"indirect_rel_rmse", e.indirect_rel_rmse},
            {"counted", e.counted},
            {"probes", e.probes},
            {"paths", e.paths},
            {"seconds", e.seconds},
            {"target", e.target},
            {"reached", e.reached},
            {"time_is_up", e.time_is_up},
            {"steps", e.steps},
            {"doubt", e.doubt}};
}

}  // namespace

std::string stats_json(const Run& r) {
    const RenderStatistics& s = r.statistics;
    Json stages = Json::object(), rays = Json::object();
    for (const auto& [name, time] : s.stages) stages[name] = {{"seconds", time.seconds}, {"launches", time.launches}};
    for (const auto& [kind, count] : s.rays) rays[kind] = count;
    rays["total"] = s.total_rays();
    rays["per_second"] = s.seconds > 0 ? static_cast<double>(s.total_rays()) / s.seconds : 0.0;
    Json load = Json::object();
    double load_seconds = 0, accel_seconds = 0;
    for (const auto& [phase, seconds] : r.load_phases) {
        load[phase] = seconds;
        (phase == "hierarchy" ? accel_seconds : load_seconds) += seconds;
    }
    Json j = {{"irradia", IRRADIA_VERSION},
              {"scene",
               {{"file", r.scene.source},
                {"width", r.scene.info.width},
                {"height", r.scene.info.height},
                {"rfilter", rfilter_name(r.scene)},
                {"triangles", r.scene.triangles.size()},
                {"analytic_primitives", r.scene.analytics.size()},
                {"materials", r.scene.materials.size()},
                {"textures", r.scene.textures.size()},
                {"lights", r.scene.lights.size()}}},
              {"camera", camera_json(r)},
              {"settings", settings_json(r.options, s.spp)},
              {"device", device_json(r)},
              {"wall_seconds",
               {{"load", load_seconds},
                {"accel", accel_seconds},
                {"render", s.seconds},
                {"write", r.write_seconds},
                {"total", r.total_seconds}}},
              {"load_seconds", load},
              {"phase_seconds", s.phases},
              {"stages", stages},
              {"rays", rays},
              {"records", s.records},
              {"radiance_records", {{"count", s.radiance_records}, {"bytes_each", s.radiance_record_bytes}}},
              {"octree",
               {{"nodes", s.octree_nodes},
                {"entries", s.octree_entries},
                {"depth", s.octree_depth},
                {"growths", s.octree_growths}}},
              {"iterations", s.iterations},
              {"mean_spp", s.mean_spp},
              {"memory",
               {{"host_peak_bytes", peak_resident_memory()},
                {"load_peak_bytes", r.load_peak_bytes},
                {"scene_bytes", scene_bytes(r.scene)},
                {"device_peak_bytes", r.device_peak_bytes}}}};
    if (r.error != nullptr) j["error"] = error_json(*r.error);
    // Names of files need not be UTF-8.
    return j.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
}

std::map<std::string, std::string> picture_metadata(const Run& r) {
    std::map<std::string, std::string> out;
    const auto add = [&](const std::string& key, const Json& value) {
        out["irradia." + key] = value.is_string() ? value.get<std::string>() : value.dump();
    };
    add("version", IRRADIA_VERSION);
    add("scene", r.scene.source);
    add("rfilter", rfilter_name(r.scene));
    const Json settings = settings_json(r.options, r.statistics.spp);
    for (const auto& [key, value] : settings.items()) add(key, value);
    add("device", r.device.name);
    add("platform", r.device.platform);
    add("driver", r.device.driver);
    add("traversal", r.cpu_traversal ? "cpu" : "gpu");
    add("records", r.statistics.records);
    add("radiance_records", r.statistics.radiance_records);
    add("rays", r.statistics.total_rays());
    if (r.error != nullptr) {
        const Json error = error_json(*r.error);
        for (const auto& [key, value] : error.items()) {
            if (value.is_object())
                for (const auto& [end, number_there] : value.items())
                    add("error." + key + (end == "value" ? "" : "." + end), number_there);
            else
                add("error." + key, value);
        }
    }
    return out;
}

std::vector<std::pair<std::string, std::string>> settings_texts(const Options& o) {
    std::vector<std::pair<std::string, std::string>> out;
    const Json settings = settings_json(o, o.settings.spp);
    for (const auto& [key, value] : settings.items())
        out.emplace_back(key, value.is_string() ? value.get<std::string>() : value.dump());
    out.emplace_back("report_error", o.settings.report_error ? "true" : "false");
    out.emplace_back("target_error", number(static_cast<double>(o.settings.target_error)));
    return out;
}

std::string stats_table(const Run& r) {
    const RenderStatistics& s = r.statistics;
    std::ostringstream out;
    std::vector<std::pair<std::string, StageTime>> stages(s.stages.begin(), s.stages.end());
    std::stable_sort(stages.begin(), stages.end(),
                     [](const auto& a, const auto& b) { return a.second.seconds > b.second.seconds; });
    const auto line = [&](const std::string& name, const std::string& value) {
        out << "  " << name << std::string(name.size() < 24 ? 24 - name.size() : 1, ' ') << value << '\n';
    };
    out << "device time\n";
    for (const auto& [name, time] : stages)
        line(name, number(time.seconds) + " s in " + count_text(static_cast<double>(time.launches)) +
                       (time.launches == 1 ? " launch" : " launches"));
    out << "rays\n";
    for (const auto& [kind, count] : s.rays) line(kind, count_text(static_cast<double>(count)));
    if (s.records + s.radiance_records > 0) {
        out << "cache\n";
        line("records", count_text(static_cast<double>(s.records)) + " in " +
                            count_text(static_cast<double>(s.iterations)) + " iterations");
        if (s.radiance_records > 0)
            line("radiance records", count_text(static_cast<double>(s.radiance_records)) + " of " +
                                         count_text(static_cast<double>(s.radiance_record_bytes)) + " bytes");
        line("octree", count_text(static_cast<double>(s.octree_nodes)) + " nodes, depth " +
                           std::to_string(s.octree_depth) + ", grown " + std::to_string(s.octree_growths) + " times");
    }
    out << "peak memory\n";
    line("host", mebibytes(peak_resident_memory()));
    line("device buffers", mebibytes(r.device_peak_bytes));
    return out.str();
}

}  // namespace irradia::app
