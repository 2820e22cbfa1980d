#include "app/picture_output.h"

#include <algorithm>
#include <filesystem>
#include <sstream>

#include "app/error_text.h"
#include "app/output.h"
#include "app/progress.h"
#include "app/stage_log.h"
#include "irradia/Error.h"
#ifndef IRRADIA_MINIMAL
#include "app/report.h"
#endif

namespace irradia::app {
namespace {

std::string done_text(const Options& o, const RenderResult& result) {
    std::ostringstream out;
    for (const std::string& path : o.outputs) out << (path == o.outputs.front() ? "wrote " : ", ") << path;
    out << ": " << result.image.width << " x " << result.image.height << ", " << result.statistics.spp
        << " samples a pixel, " << name_of(method_names(), o.settings.method) << ", "
        << time_text(result.statistics.seconds);
    if (result.statistics.records > 0)
        out << ", " << count_text(static_cast<double>(result.statistics.records)) << " records";
    if (result.statistics.radiance_records > 0)
        out << ", " << count_text(static_cast<double>(result.statistics.radiance_records)) << " radiance records";
    return out.str();
}

Fields done_fields(const Options& o, const RenderResult& result) {
    Fields fields{{"output", o.outputs}, {"seconds", result.statistics.seconds}};
    if (result.statistics.records > 0) fields["records"] = result.statistics.records;
    if (result.statistics.radiance_records > 0) fields["radiance_records"] = result.statistics.radiance_records;
    if (result.error) fields["relative_rmse"] = result.error->rel_rmse.value;
    return fields;
}

/// Seconds that it took.
double write_pictures(const Options& o, Log& log, const Image& image) {
    StageLog stages(log);
    const double began = now();
    Progress progress;
    progress.stage = "writing";
    for (std::size_t i = 0; i < o.outputs.size(); ++i) {
        progress.fraction = static_cast<double>(i) / static_cast<double>(o.outputs.size());
        progress.elapsed = now() - began;
        stages(progress);
        save_picture(o.outputs[i], image, o.exposure, o.device.threads);
    }
    stages.finish(now() - began);
    return now() - began;
}

}  // namespace

void check_outputs(const Options& o, Log& log) {
    bool exr = false;
    for (const std::string& path : o.outputs) {
        if (!o.points.empty()) {
            check_writable(path);
            continue;
        }
        check_picture_path(path);
        exr = exr || path.ends_with(".exr") || path.ends_with(".EXR");
    }
    if (!o.stats.empty()) check_writable(o.stats);
    if (!o.pack.empty()) check_writable(o.pack);
#ifndef IRRADIA_MINIMAL
    if (!o.report.empty()) check_report(o.report);
#endif
    if (!o.settings.aovs.empty() && !exr && !o.outputs.empty()) log.warn("--aov: only .exr files hold layers");
}

bool results_there(const Options& o) {
    const auto there = [](const std::string& path) {
        std::error_code ignored;
        return path.empty() || std::filesystem::exists(path, ignored);
    };
    return std::all_of(o.outputs.begin(), o.outputs.end(), there) && there(o.stats) && there(o.report);
}

std::optional<Image> open_reference(const Options& o) {
    if (o.reference.empty()) return std::nullopt;
#ifdef IRRADIA_MINIMAL
    return std::nullopt;
#else
    return read_image(o.reference);
#endif
}

void check_reference_size(const Options& o, const std::optional<Image>& reference, const Scene& scene) {
#ifdef IRRADIA_MINIMAL
    (void)o, (void)reference, (void)scene;
#else
    if (reference)
        check_reference(o.reference, *reference, static_cast<int>(scene.info.width),
                        static_cast<int>(scene.info.height));
#endif
}

RenderSettings render_settings(const Options& o) {
    RenderSettings settings = o.settings;
    if (!o.report.empty()) settings.aovs = aov_names();
    return settings;
}

void write_results(const Options& o, Session& session, const shared::Camera& camera, RenderResult& result,
                   const RecordSet* records, const std::optional<Image>& reference, double began) {
    Log& log = session.log;
    const Device& device = session.device(o.device);
    Run run{o,
            session.scene(),
            device.description(),
            device.cpu_traversal(),
            device.peak_memory(),
            result.statistics,
            session.load_phases(),
            session.load_peak_bytes()};
    run.camera = &camera;
    if (result.error) run.error = &*result.error;
    for (auto& [key, value] : picture_metadata(run)) result.image.metadata[key] = value;
#ifdef IRRADIA_MINIMAL
    (void)records, (void)reference;
    run.write_seconds = write_pictures(o, log, result.image);
#else
    run.write_seconds =
        write_pictures(o, log, o.report.empty() ? result.image : with_layers(result.image, o.settings.aovs));
#endif
    run.total_seconds = now() - began;
    if (!o.stats.empty()) save_text(o.stats, stats_json(run));
    log.info(done_text(o, result), done_fields(o, result));
    if (result.error) log.info(error_text(*result.error));
    if (log.shows(Level::detail))
        log.table("statistics", stats_table(run), {{"statistics", Fields::parse(stats_json(run))}});
#ifndef IRRADIA_MINIMAL
    if (!o.report.empty()) {  // last: a page that fails costs nothing else
        write_report(o.report, {run, result.image, records, reference ? &*reference : nullptr});
        log.info("wrote " + o.report + ": report", {{"output", o.report}});
    }
#endif
}

}  // namespace irradia::app
