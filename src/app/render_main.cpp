// render: a scene file in, pictures out.
#include <chrono>
#include <exception>
#include <iostream>
#include <new>
#include <optional>
#include <sstream>

#include "app/carried_records.h"
#include "app/error_text.h"
#include "app/film_size.h"
#include "app/help.h"
#include "app/loading.h"
#include "app/options.h"
#include "app/output.h"
#include "app/point_list.h"
#include "app/progress.h"
#include "app/stats.h"
#include "irradia/Error.h"
#include "irradia/PackedScene.h"
#ifndef IRRADIA_MINIMAL
#include "app/report.h"
#include "irradia/Accel.h"
#include "irradia/SceneLoader.h"
#endif

namespace irradia::app {
namespace {

double now() { return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count(); }

/// Lines on stderr: news with --verbose, warnings unless --quiet.
struct Messages {
    const Options& options;
    void warn(const std::string& text) const {
        if (!options.quiet) std::cerr << "render: warning: " << text << '\n';
    }
    void say(const std::string& text) const {
        if (!options.quiet) std::cerr << "render: " << text << '\n';
    }
    void detail(const std::string& text) const {
        if (options.verbose) std::cerr << "render: " << text << '\n';
    }
};

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
Scene open_scene(const Options& o, const Messages& messages, LoadMonitor& monitor, const Device* device) {
    if (is_packed_scene(o.scene)) {
        if (!o.defines.empty())
            throw Error(o.scene + ": is a packed scene, expected a scene file (.xml) for -D", kBadCommandLine);
        monitor("packed scene", 0);
        Scene scene = read_packed_scene(o.scene);
        scene.source = o.scene;
        set_film_size(scene, o.width, o.height);
        return scene;
    }
#ifdef IRRADIA_MINIMAL
    (void)messages, (void)device;
    throw Error(o.scene + ": is not a packed scene, expected one (render SCENE.xml --pack FILE on a full build)");
#else
    LoadOptions load;
    load.defines = o.defines;
    load.lenient = o.lenient;
    const bool both = o.width > 0 && o.height > 0;  // then the shape may change, which only the loader can do
    load.width = both ? o.width : 0;
    load.height = both ? o.height : 0;
    load.warn = [&](const std::string& text) {
        monitor.clear();
        messages.warn(text);
    };
    load.progress = [&](const std::string& stage, double fraction) { monitor(stage, fraction); };
    Scene scene = load_scene(o.scene, load);
    if (!both) set_film_size(scene, o.width, o.height);
    const AccelLayouts layouts = device == nullptr         ? AccelLayouts::both
                                 : device->cpu_traversal() ? AccelLayouts::bvh8
                                                           : AccelLayouts::bvh2;
    monitor("hierarchy", 0);
    build_accel(
        scene, o.device.threads, [&](double fraction) { monitor("hierarchy", fraction); }, layouts);
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

/// --points: no picture, but irradiance.
void answer_points(const Options& o, const Messages& messages, const Scene& scene, Device& device,
                   const std::vector<IrradiancePoint>& points, CarriedRecords& records) {
    ProgressPrinter printer(std::cerr, terminal_columns());
    ProgressCallback callback;
    if (!o.quiet) callback = [&](const Progress& p) { printer(p); };
    RenderStatistics statistics;
    const std::vector<PointIrradiance> answers = [&] {
        try {
            return irradiance_at(scene, device, o.settings, points, callback, records.set(), &statistics);
        } catch (...) {
            printer.clear();
            throw;
        }
    }();
    printer.clear();
    for (const std::string& path : o.outputs) write_points(path, points, answers);
    messages.say("wrote " + o.outputs.front() + ": irradiance at " + count_text(static_cast<double>(points.size())) +
                 " points, " + time_text(statistics.seconds) + ", " +
                 count_text(static_cast<double>(statistics.records)) + " records");
    if (const std::string what = records.save(); !what.empty()) messages.say(what);
}

void render_and_write(const Options& o, const Messages& messages, const Scene& scene, Device& device, double began,
                      const Phases& load_phases, std::uint64_t load_peak_bytes, CarriedRecords& records,
                      const Image* reference) {
    RenderSettings settings = o.settings;
    if (!o.report.empty()) settings.aovs = aov_names();
    ProgressPrinter printer(std::cerr, terminal_columns());
    ProgressCallback callback;
    if (!o.quiet) callback = [&](const Progress& p) { printer(p); };
    RenderResult result = [&] {
        try {
            return render(scene, device, settings, callback, records.set());
        } catch (const std::bad_alloc&) {
            printer.clear();
            throw Error("out of memory for a picture of " + std::to_string(scene.info.width) + " x " +
                        std::to_string(scene.info.height) +
                        " pixels: take a smaller one (--width, --height) or fewer layers (--aov)");
        } catch (...) {
            printer.clear();
            throw;
        }
    }();
    printer.clear();

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
    const double write_began = now();
#ifdef IRRADIA_MINIMAL
    (void)reference;
    for (const std::string& path : o.outputs) save_picture(path, result.image, o.exposure);
#else
    {
        const Image asked = o.report.empty() ? Image{} : with_layers(result.image, o.settings.aovs);
        for (const std::string& path : o.outputs)
            save_picture(path, o.report.empty() ? result.image : asked, o.exposure);
    }
#endif
    run.write_seconds = now() - write_began;
    run.total_seconds = now() - began;
    if (!o.stats.empty()) save_text(o.stats, stats_json(run));
    messages.say(done_text(o, result));
    if (result.error) messages.say(error_text(*result.error));
    if (const std::string what = records.save(); !what.empty()) messages.say(what);
#ifndef IRRADIA_MINIMAL
    if (!o.report.empty()) {
        write_report(o.report, {run, result.image, records.set(), reference});
        messages.say("wrote " + o.report + ": report");
    }
#endif
    if (o.verbose) std::cerr << stats_table(run);
}

void run(const Options& o) {
    const double began = now();
    const Messages messages{o};
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
    std::optional<Image> reference;
#ifndef IRRADIA_MINIMAL
    if (!o.report.empty()) check_report(o.report);
    if (!o.reference.empty()) reference = read_image(o.reference);
#endif
    if (!o.settings.aovs.empty() && !exr && !o.outputs.empty()) messages.warn("--aov: only .exr files hold layers");

    CarriedRecords records(o, [&](const std::string& text) { messages.warn(text); });
    const std::vector<IrradiancePoint> points =
        o.points.empty() ? std::vector<IrradiancePoint>{} : read_points(o.points);

    std::optional<Device> device;  // one that is not there is found before a large scene is loaded
    if (!o.outputs.empty()) device.emplace(o.device);
    ProgressPrinter printer(std::cerr, terminal_columns());
    LoadMonitor monitor(o.quiet ? nullptr : &printer, began);
    Scene scene = [&] {
        try {
            return open_scene(o, messages, monitor, o.pack.empty() && device ? &*device : nullptr);
        } catch (...) {
            monitor.clear();
            throw;
        }
    }();
    monitor.finish();
    set_rfilter(scene, o.rfilter);
    const std::uint64_t load_peak_bytes = peak_host_memory();
    messages.say(load_text(scene, monitor.phases(), load_peak_bytes));
    if (!o.pack.empty()) {
        write_packed_scene(o.pack, scene);
        messages.say("wrote " + o.pack + ": packed scene");
    }
    if (o.outputs.empty()) return;

    messages.detail("device " + std::to_string(device->description().index) + ": " + device->description().name + " (" +
                    device->description().platform + "), " + (device->cpu_traversal() ? "cpu" : "gpu") + " traversal");
    records.check(scene);
#ifndef IRRADIA_MINIMAL
    if (reference)
        check_reference(o.reference, *reference, static_cast<int>(scene.info.width),
                        static_cast<int>(scene.info.height));
#endif
    if (!o.points.empty()) return answer_points(o, messages, scene, *device, points, records);
    render_and_write(o, messages, scene, *device, began, monitor.phases(), load_peak_bytes, records,
                     reference ? &*reference : nullptr);
}

}  // namespace
}  // namespace irradia::app

int main(int argc, char** argv) {
    namespace app = irradia::app;
    app::Options options;
    if (const int status = app::parse_options(argc, argv, options); status >= 0) return status;
    try {
        app::run(options);
        return 0;
    } catch (const irradia::Error& error) {
        std::cerr << "render: " << error.what() << '\n';
        return error.exit_status();
    } catch (const std::bad_alloc&) {
        std::cerr << "render: out of memory\n";
    } catch (const std::exception& error) {
        std::cerr << "render: " << error.what() << '\n';
    }
    return app::kBadInput;
}
