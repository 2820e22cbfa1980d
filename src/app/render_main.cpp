// render: a scene file in, pictures out.
#include <chrono>
#include <exception>
#include <filesystem>
#include <iostream>
#include <new>
#include <optional>
#include <sstream>

#include "app/carried_records.h"
#include "app/error_text.h"
#include "app/film_size.h"
#include "app/help.h"
#include "app/loading.h"
#include "app/log.h"
#include "app/log_options.h"
#include "app/memory_option.h"
#include "app/options.h"
#include "app/output.h"
#include "app/point_list.h"
#include "app/progress.h"
#include "app/stage_log.h"
#include "app/stats.h"
#include "core/memory.h"
#include "irradia/Error.h"
#include "irradia/PackedScene.h"
#ifndef IRRADIA_MINIMAL
#include "irradia/Accel.h"
#include "irradia/SceneLoader.h"
#endif

namespace irradia::app {
namespace {

double now() { return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count(); }

constexpr const char* kSmallerScene = "take a smaller scene: fewer triangles, smaller textures";

void print_devices() {
    const std::vector<DeviceDescription> devices = list_devices();
    if (devices.empty())
        throw Error("no OpenCL device: install a driver, for example Debian's pocl-opencl-icd for the CPU");
    for (const DeviceDescription& d : devices)
        std::cout << d.index << ": " << d.name << " (" << d.platform << ", " << d.driver << "), "
                  << (d.is_cpu ? "CPU, " : "") << d.compute_units << " compute units, " << (d.global_memory >> 20)
                  << " MiB, " << (d.local_memory >> 10) << " KiB local\n";
}

/// `device`: the one that will render; null: none will, or the scene is to be packed too.
Scene open_scene(const Options& o, Log& log, LoadMonitor& monitor, const Device* device) {
    if (is_packed_scene(o.scene)) {
        if (!o.defines.empty())
            throw Error(o.scene + ": is a packed scene, expected a scene file (.xml) for -D", kBadCommandLine);
        monitor("packed scene", 0);
        require_memory(o.device.memory_limit, std::filesystem::file_size(o.scene), "the packed scene", kSmallerScene);
        Scene scene = read_packed_scene(o.scene);
        scene.source = o.scene;
        set_film_size(scene, o.width, o.height);
        return scene;
    }
#ifdef IRRADIA_MINIMAL
    (void)log, (void)device;
    throw Error(o.scene + ": is not a packed scene, expected one (render SCENE.xml --pack FILE on a full build)");
#else
    LoadOptions load;
    load.defines = o.defines;
    load.lenient = o.lenient;
    const bool both = o.width > 0 && o.height > 0;  // then the shape may change, which only the loader can do
    load.width = both ? o.width : 0;
    load.height = both ? o.height : 0;
    load.warn = [&](const std::string& text) { log.warn(text); };
    load.progress = [&](const std::string& stage, double fraction) {
        monitor(stage, fraction);
        require_memory(o.device.memory_limit, 0, "loading (" + stage + ")", kSmallerScene);
    };
    load.need = [&](std::uint64_t bytes, const std::string& what) {
        require_memory(o.device.memory_limit, bytes, what, kSmallerScene);
    };
    Scene scene = load_scene(o.scene, load);
    if (!both) set_film_size(scene, o.width, o.height);
    const AccelLayouts layouts = device == nullptr         ? AccelLayouts::both
                                 : device->cpu_traversal() ? AccelLayouts::bvh8
                                                           : AccelLayouts::bvh2;
    monitor("hierarchy", 0);
    require_memory(o.device.memory_limit, accel_memory(scene, layouts), "the scene's hierarchy", kSmallerScene);
    build_accel(
        scene, o.device.threads, [&](double fraction) { load.progress("hierarchy", fraction); }, layouts);
    monitor("checks", 0);
    check_scene(o.scene, scene, layouts);  // as read_packed_scene() does: numbers that overflowed on the way to float32
    return scene;
#endif
}

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
        save_picture(o.outputs[i], image, o.exposure);
    }
    stages.finish(now() - began);
    return now() - began;
}

/// --points: no picture, but irradiance.
void answer_points(const Options& o, Log& log, const Scene& scene, Device& device,
                   const std::vector<IrradiancePoint>& points, CarriedRecords& records) {
    StageLog stages(log);
    const ProgressCallback callback = [&](const Progress& p) {
        stages(p);
        check_memory(o, 0, "the render (" + p.stage + ")");
    };
    RenderStatistics statistics;
    const std::vector<PointIrradiance> answers =
        irradiance_at(scene, device, o.settings, points, callback, records.set(), &statistics);
    stages.finish();
    for (const std::string& path : o.outputs) write_points(path, points, answers);
    log.info("wrote " + o.outputs.front() + ": irradiance at " + count_text(static_cast<double>(points.size())) +
             " points, " + time_text(statistics.seconds) + ", " + count_text(static_cast<double>(statistics.records)) +
             " records");
    if (const std::string what = records.save(); !what.empty()) log.info(what);
}

void render_and_write(const Options& o, Log& log, const Scene& scene, Device& device, double began,
                      const Phases& load_phases, std::uint64_t load_peak_bytes, CarriedRecords& records) {
    const std::uint64_t pixels = std::uint64_t{scene.info.width} * scene.info.height;
    require_picture_memory(o, scene.info.width, scene.info.height);
    StageLog stages(log);
    const ProgressCallback callback = [&](const Progress& p) {
        stages(p);
        check_memory(o, pixels, "the render (" + p.stage + ")");
    };
    RenderResult result = [&] {
        try {
            return render(scene, device, o.settings, callback, records.set());
        } catch (const std::bad_alloc&) {
            throw Error("out of memory for a picture of " + std::to_string(scene.info.width) + " x " +
                        std::to_string(scene.info.height) +
                        " pixels: take a smaller one (--width, --height) or fewer layers (--aov)");
        }
    }();
    stages.finish();

    Run run{o,
            scene,
            device.description(),
            device.cpu_traversal(),
            device.peak_memory(),
            result.statistics,
            load_phases,
            load_peak_bytes};
    if (result.error) run.error = &*result.error;
    for (auto& [key, value] : picture_metadata(run)) result.image.metadata[key] = value;
    run.write_seconds = write_pictures(o, log, result.image);
    run.total_seconds = now() - began;
    if (!o.stats.empty()) save_text(o.stats, stats_json(run));
    log.info(done_text(o, result), done_fields(o, result));
    if (result.error) log.info(error_text(*result.error));
    if (const std::string what = records.save(); !what.empty()) log.info(what);
    if (log.shows(Level::detail))
        log.table("statistics", stats_table(run), {{"statistics", Fields::parse(stats_json(run))}});
}

void run(const Options& o, Log& log) {
    const double began = now();
    if (o.list_devices) return print_devices();

    // What cannot be written is found now, not after an hour of rendering.
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
    if (!o.settings.aovs.empty() && !exr && !o.outputs.empty()) log.warn("--aov: only .exr files hold layers");

    require_records_memory(o);
    CarriedRecords records(o, [&](const std::string& text) { log.warn(text); });
    const std::vector<IrradiancePoint> points =
        o.points.empty() ? std::vector<IrradiancePoint>{} : read_points(o.points);

    std::optional<Device> device;  // one that is not there is found before a large scene is loaded
    if (!o.outputs.empty()) device.emplace(o.device);
    StageLog stages(log);
    LoadMonitor monitor(&stages, now());
    Scene scene = open_scene(o, log, monitor, o.pack.empty() && device ? &*device : nullptr);
    monitor.finish();
    set_rfilter(scene, o.rfilter);
    const std::uint64_t load_peak_bytes = peak_resident_memory();
    log.info(load_text(scene, monitor.phases(), load_peak_bytes),
             {{"scene", scene.source}, {"triangles", scene.triangles.size()}, {"peak_bytes", load_peak_bytes}});
    if (!o.pack.empty()) {
        write_packed_scene(o.pack, scene);
        log.info("wrote " + o.pack + ": packed scene", {{"output", o.pack}});
    }
    if (o.outputs.empty()) return log.done({o.pack}, now() - began);

    log.detail("device " + std::to_string(device->description().index) + ": " + device->description().name + " (" +
               device->description().platform + "), " + (device->cpu_traversal() ? "cpu" : "gpu") + " traversal");
    records.check(scene);
    if (!o.points.empty())
        answer_points(o, log, scene, *device, points, records);
    else
        render_and_write(o, log, scene, *device, began, monitor.phases(), load_peak_bytes, records);
    log.done(o.outputs, now() - began);
}

}  // namespace
}  // namespace irradia::app

int main(int argc, char** argv) {
    namespace app = irradia::app;
    app::Options options;
    if (const int status = app::parse_options(argc, argv, options); status >= 0) return status;
    app::ignore_closed_pipes();
    app::Log log(app::log_settings(options), app::terminal_columns());
    const auto failed = [&](const std::string& what, int status) {
        log.failed(what, status);
        if (status == app::kBadCommandLine)  // those of parse_options() are plain text, and so are these
            std::cerr << "render: " << what << '\n';
        else
            log.error(what);
        return status;
    };
    try {
        app::run(options, log);
        return 0;
    } catch (const irradia::Error& error) {
        return failed(error.what(), error.exit_status());
    } catch (const std::bad_alloc&) {
        return failed(app::out_of_memory_text(), app::kBadInput);
    } catch (const std::exception& error) {
        return failed(error.what(), app::kBadInput);
    }
}
