#include "app/report_facts.h"

#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "app/progress.h"
#include "app/report_chart.h"
#include "app/report_html.h"

namespace irradia::app {
namespace {

using Json = nlohmann::ordered_json;
using html::Row;

std::string count(std::uint64_t n) { return count_text(static_cast<double>(n)); }

std::string bytes_text(std::uint64_t bytes) {
    return fmt::format("{:.1f} MiB", static_cast<double>(bytes) / (1 << 20));
}

std::string seconds_text(double seconds) { return seconds < 60 ? html::number(seconds) + " s" : time_text(seconds); }

std::string text_of(const Json& value) {
    if (value.is_string()) return value.get<std::string>();
    if (value.is_boolean()) return value.get<bool>() ? "yes" : "no";
    if (!value.is_array()) return value.dump();
    std::string out;
    for (const Json& one : value) out += (out.empty() ? "" : ", ") + text_of(one);
    return out.empty() ? "none" : out;
}

std::string words(std::string key) {
    for (char& c : key)
        if (c == '_') c = ' ';
    return key;
}

std::string figure(const std::string& name, const std::string& value, const std::string& more = "") {
    return fmt::format("<div class=\"figure\"><dt>{}</dt><dd>{}{}</dd></div>\n", html::escape(name),
                       html::escape(value), more.empty() ? "" : " <small>" + html::escape(more) + "</small>");
}

}  // namespace

std::string exact_percent(double share) { return fmt::format("{:.4f} %", 100 * share); }

std::string key_figures(const ReportInput& in) {
    const RenderStatistics& s = in.run.statistics;
    std::string out = "<dl class=\"figures\">\n";
    out += figure("Rendering", time_text(s.seconds), "of " + time_text(in.run.total_seconds) + " in all");
    const std::string most = std::to_string(s.spp);
    const bool all = s.mean_spp > s.spp - 0.005;
    out += figure("Samples a pixel", all ? most : html::number(s.mean_spp), all ? "" : "of at most " + most);
    if (s.records > 0) out += figure("Records", count(s.records));
    if (s.radiance_records > 0) out += figure("Radiance records", count(s.radiance_records));
    out += figure("Rays", count(s.total_rays()),
                  s.seconds > 0 ? count_text(static_cast<double>(s.total_rays()) / s.seconds) + " a second" : "");
    if (in.run.error != nullptr)
        out += figure("Estimated error", html::percent(in.run.error->rel_rmse.value),
                      in.run.error->doubt.empty() ? "" : "in doubt");
    return out + "</dl>\n";
}

std::string times_section(const Run& run) {
    const RenderStatistics& s = run.statistics;
    const auto bar = [](const std::string& name, double seconds) {
        return Bar{words(name), seconds, seconds_text(seconds)};
    };
    std::vector<Bar> wall, device;
    double small = 0;
    const auto add = [&](const std::string& name, double seconds) {
        if (seconds >= 0.005 * run.total_seconds)
            wall.push_back(bar(name, seconds));
        else
            small += seconds;
    };
    for (const auto& [phase, seconds] : run.load_phases) add("load: " + phase, seconds);
    std::vector<std::pair<std::string, double>> phases(s.phases.begin(), s.phases.end());
    std::stable_sort(phases.begin(), phases.end(), [](const auto& a, const auto& b) { return a.second > b.second; });
    for (const auto& [phase, seconds] : phases) add("render: " + phase, seconds);
    add("write pictures", run.write_seconds);
    if (small > 0) wall.push_back(bar("all others", small));

    double busy = 0, short_ones = 0;
    for (const auto& [name, time] : s.stages) busy += time.seconds;
    for (const auto& [name, time] : s.stages)
        if (time.seconds >= 0.002 * busy)
            device.push_back({name, time.seconds,
                              seconds_text(time.seconds) + " in " + count(time.launches) +
                                  (time.launches == 1 ? " launch" : " launches")});
        else
            short_ones += time.seconds;
    std::stable_sort(device.begin(), device.end(), [](const Bar& a, const Bar& b) { return a.value > b.value; });
    if (short_ones > 0) device.push_back(bar("all others", short_ones));
    return "<section id=\"times\" aria-labelledby=\"times-title\"><h2 id=\"times-title\">Time</h2>\n<div "
           "class=\"columns\"><div>\n" +
           bar_chart("By stage, on the clock", wall) + "</div><div>\n" + bar_chart("On the device, by kernel", device) +
           "</div></div></section>\n";
}

std::string rays_section(const Run& run) {
    const RenderStatistics& s = run.statistics;
    const auto total = static_cast<double>(s.total_rays());
    std::vector<Bar> bars;
    for (const auto& [kind, rays] : s.rays)
        if (rays > 0)
            bars.push_back({kind, static_cast<double>(rays),
                            count(rays) + " (" + html::percent(static_cast<double>(rays) / total, 2) + ")"});
    std::stable_sort(bars.begin(), bars.end(), [](const Bar& a, const Bar& b) { return a.value > b.value; });
    return "<section id=\"rays\" aria-labelledby=\"rays-title\"><h2 id=\"rays-title\">Rays</h2>\n" +
           bar_chart("By kind", bars) + "</section>\n";
}

std::string settings_section(const Run& run) {
    const Json stats = Json::parse(stats_json(run));
    const Options plain;
    Run usual{plain, run.scene, run.device, run.cpu_traversal, run.device_peak_bytes, run.statistics};
    const Json defaults = Json::parse(stats_json(usual))["settings"];
    std::vector<Row> settings, scene, device;
    for (const auto& [key, value] : stats["settings"].items())
        settings.push_back(
            {words(key), text_of(value), key == "spp" ? run.options.settings.spp > 0 : value != defaults[key]});
    settings.push_back({"exposure", html::number(run.options.exposure) + " stops", run.options.exposure != 0});
    const auto number_or_text = [](const Json& value) {
        return value.is_number_integer() ? count_text(value.get<double>()) : text_of(value);
    };
    for (const auto& [key, value] : stats["scene"].items()) scene.push_back({words(key), number_or_text(value)});
    scene.push_back({"diagonal", html::number(static_cast<double>(run.scene.info.diagonal)) + " world units"});
    for (const auto& [name, value] : run.options.defines) scene.push_back({"$" + name, value});
    for (const auto& [key, value] : stats["device"].items())
        device.push_back({words(key), key == "threads" && value == 0 ? "all" : text_of(value)});
    device.push_back({"peak memory, host", bytes_text(stats["memory"]["host_peak_bytes"])});
    device.push_back({"peak memory, device buffers", bytes_text(stats["memory"]["device_peak_bytes"])});
    device.push_back({"Irradia", IRRADIA_VERSION});
    return "<section id=\"settings\" aria-labelledby=\"settings-title\"><h2 id=\"settings-title\">Settings, scene, "
           "device</h2>\n<p>Marked settings differ from their defaults.</p>\n<div class=\"columns\"><div>\n" +
           html::table("Settings", settings) + "</div><div>\n" + html::table("Scene", scene) +
           html::table("Device", device) + "</div></div></section>\n";
}

std::string error_section(const Run& run) {
    if (run.error == nullptr) return "";
    const ErrorReport& e = *run.error;
    std::string out =
        "<section id=\"error\" aria-labelledby=\"error-title\"><h2 id=\"error-title\">Estimated error</h2>\n";
    if (!e.doubt.empty())
        out +=
            "<p class=\"warning\"><strong>Do not trust these intervals:</strong> " + html::escape(e.doubt) + "</p>\n";
    if (e.target > 0 && !e.reached)
        out += "<p class=\"warning\">The target of " + html::percent(e.target) + " was not reached" +
               (e.time_is_up ? " in the time allowed" : ": this is as good as it gets") + ".</p>\n";
    out += "<p>What the renderer found by paths of its own, without a reference, with 95 % intervals.</p>\n";
    out += interval_chart("Estimated error with 95 % intervals",
                          {{"relative RMSE", e.rel_rmse.value, e.rel_rmse.low, e.rel_rmse.high},
                           {"mean bias", e.mean_bias.value, e.mean_bias.low, e.mean_bias.high}});
    std::vector<Row> rows = {{"direct light's part of the error", html::percent(e.direct_rel_rmse)},
                             {"indirect light's part", html::percent(e.indirect_rel_rmse)},
                             {"pixels that count (they show no lamp)", html::percent(e.counted)},
                             {"probes", count(e.probes)},
                             {"paths", count(e.paths)},
                             {"time for it", seconds_text(e.seconds)}};
    if (e.target > 0) rows.push_back({"target", html::percent(e.target) + (e.reached ? ", reached" : ", not reached")});
    if (e.steps > 0) rows.push_back({"pictures made on the way", std::to_string(e.steps)});
    return out + html::table("How it was found", rows) + "</section>\n";
}

}  // namespace irradia::app
