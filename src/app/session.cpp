#include "app/session.h"

#include <algorithm>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <utility>

#include "app/film_size.h"
#include "app/help.h"
#include "app/memory_option.h"
#include "app/stop_signal.h"
#include "core/memory.h"
#include "irradia/Error.h"
#include "irradia/PackedScene.h"
#ifndef IRRADIA_MINIMAL
#include "irradia/Accel.h"
#endif

namespace irradia::app {
namespace {

constexpr const char* kSmallerScene = "take a smaller scene: fewer triangles, smaller textures";

/// Are they the same but for cameras and what origin_of() tells apart?
bool same_film(const Scene& a, const Scene& b) {
    shared::SceneInfo info = a.info;
    info.camera = b.info.camera;
    return std::memcmp(&info, &b.info, sizeof info) == 0 && a.features == b.features &&
           a.sample_count == b.sample_count && a.triangles.size() == b.triangles.size();
}

RecordOrigin origin_of(const Scene& scene) { return record_origin(scene, RenderSettings{}); }

bool same_device(const DeviceOptions& a, const DeviceOptions& b) {
    return a.select == b.select && a.threads == b.threads && a.traversal == b.traversal &&
           a.memory_limit == b.memory_limit;
}

/// Is there anything to load that takes as long as a driver? Else opening it on another thread only costs: on an H200
/// 10 to 30 ms of a process's 0.55 s.
bool takes_a_while(const std::string& scene) {
    std::error_code unreadable;  // which is said when it is read
    if (!std::filesystem::is_regular_file(scene, unreadable)) return false;
    if (is_packed_scene(scene)) return std::filesystem::file_size(scene, unreadable) > (1u << 20);
    std::ifstream in(scene);
    const std::string text{std::istreambuf_iterator<char>(in), {}};
    return text.find("filename") != std::string::npos;  // of a mesh, a picture, an included scene
}

DeviceOptions with_compiler(DeviceOptions o) {
    o.compiler = "/proc/self/exe";  // which render_main.cpp makes one
    return o;
}

}  // namespace

void Session::expect_device(const Options& options) {
    const DeviceOptions& o = options.device;
    if (device_ && same_device(o, device_options_)) return;
    // What a driver takes must not come into a limit's reckoning at any time.
    if (o.threads == 1 || o.memory_limit > 0 || !takes_a_while(options.scene)) {
        device(o);
        return;
    }
    device_.reset();
    told_ = false;
#ifndef IRRADIA_MINIMAL
    prepare_loading();
#endif
    opening_ = Device::open_ahead(with_compiler(o));
    device_options_ = o;
}

// Takes what expect_device() has begun to open, or, if it is not to be waited for, once it is there.
void Session::take_device(bool wait) {
    const std::lock_guard lock(taking_);
    if (!opening_.valid()) return;
    if (!wait && opening_.wait_for(std::chrono::seconds(0)) != std::future_status::ready) return;
    device_ = opening_.get();
}

Device& Session::device(const DeviceOptions& o) {
    if (same_device(o, device_options_)) take_device(true);
    if (!device_ || !same_device(o, device_options_)) {
        opening_ = {};
        device_.reset();
        device_ = std::make_unique<Device>(with_compiler(o));
        device_options_ = o;
        told_ = false;
    }
    if (!std::exchange(told_, true)) {
        const DeviceDescription& d = device_->description();
        log.detail("device " + std::to_string(d.index) + ": " + d.name + " (" + d.platform + "), " +
                   (device_->cpu_traversal() ? "cpu" : "gpu") + " traversal");
    }
    return *device_;
}

Scene Session::load(const Options& o, std::size_t views, LoadMonitor& monitor, bool both_layouts) {
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
    (void)both_layouts, (void)views;
    throw Error(o.scene + ": is not a packed scene, expected one (render SCENE.xml --pack FILE on a full build)");
#else
    LoadOptions load;
    load.defines = o.defines;
    load.lenient = o.lenient;
    load.threads = o.device.threads;
    load.parts = &parts_;
    const bool both = o.width > 0 && o.height > 0;  // then the shape may change, which only the loader can do
    load.width = both ? o.width : 0;
    load.height = both ? o.height : 0;
    load.warn = [&](const std::string& text) { log.warn(text); };
    load.progress = [&](const std::string& stage, double fraction) {
        stop_if_told();
        take_device(false);  // one that is not there is told before a large scene is loaded
        monitor(stage, fraction);
        require_memory(o.device.memory_limit, 0, "loading (" + stage + ")", kSmallerScene);
    };
    load.need = [&](std::uint64_t bytes, const std::string& what) {
        require_memory(o.device.memory_limit, bytes, what, kSmallerScene);
    };
    Scene scene = load_scene(o.scene, load);
    if (!both) set_film_size(scene, o.width, o.height);
    monitor.pause();
    take_device(true);
    const AccelLayouts layouts = both_layouts || !device_   ? AccelLayouts::both
                                 : device_->cpu_traversal() ? AccelLayouts::bvh8
                                                            : AccelLayouts::bvh2;
    monitor("hierarchy", 0);
    const double rays = expected_rays(scene, o.settings) * static_cast<double>(views);
    const AccelQuality quality = accel_quality_for(scene, rays, layouts);
    if (!scene_ || !take_accel(scene, *scene_, layouts, quality)) {
        require_memory(o.device.memory_limit, accel_memory(scene, layouts), "the scene's hierarchy", kSmallerScene);
        build_accel(
            scene, o.device.threads, [&](double fraction) { load.progress("hierarchy", fraction); }, layouts, quality);
    }
    monitor("checks", 0);
    check_scene(o.scene, scene, layouts);  // as read_packed_scene() does: numbers that overflowed on the way to float32
    return scene;
#endif
}

void Session::open(const Options& o, std::size_t views, bool both_layouts, const std::function<void()>& leave) {
    stop_if_told();
    StageLog stages(log);
    LoadMonitor monitor(&stages, now());
    Scene fresh = [&] {
        try {
            return load(o, views, monitor, both_layouts);
        } catch (...) {
            take_device(true);  // if neither can be had it is the device that is told, whichever came first
            throw;
        }
    }();
    monitor.finish();
    set_rfilter(fresh, o.rfilter);
    phases_ = monitor.phases();
    load_peak_bytes_ = peak_resident_memory();
    log.info(load_text(fresh, phases_, load_peak_bytes_),
             {{"scene", fresh.source}, {"triangles", fresh.triangles.size()}, {"peak_bytes", load_peak_bytes_}});
    std::optional<RecordOrigin> fresh_origin;
    if (scene_ && same_film(fresh, *scene_)) fresh_origin = origin_of(fresh);
    if (fresh_origin && *fresh_origin == origin()) {
        scene_->info.camera = fresh.info.camera;
        scene_->accel = std::move(fresh.accel);
        scene_->source = fresh.source;
        return;
    }
    if (leave) leave();
    scene_ = std::make_unique<Scene>(std::move(fresh));
    origin_ = std::move(fresh_origin);
}

const RecordOrigin& Session::origin() {
    if (!origin_) origin_ = origin_of(*scene_);
    return *origin_;
}

}  // namespace irradia::app
