// What the renders of one process share: the log, the device, and what the last scene has read and built.
#pragma once
#include <future>
#include <memory>
#include <mutex>
#include <optional>
#include <string>

#include "app/clock.h"
#include "app/loading.h"
#include "app/log.h"
#include "app/options.h"
#include "irradia/Device.h"
#include "irradia/RecordFile.h"
#include "irradia/Scene.h"

#ifndef IRRADIA_MINIMAL
#include "irradia/SceneLoader.h"
#endif

namespace irradia::app {

class Session {
public:
    explicit Session(Log& log_in) : log(log_in) {}

    Log& log;

    /// Begins to open the device that will be asked for, on a thread of its own: meanwhile a scene can be loaded.
    void expect_device(const Options& options);
    /// The device that the options ask for, opened once.
    Device& device(const DeviceOptions& options);

    /// Loads o.scene in place of the last scene; files that it has read before are not read again, and the hierarchy is
    /// built only if geometry has changed. Says what was loaded. If it is the last scene but for its camera, that one
    /// stays where it is and has the new camera. Otherwise whoever refers to the last scene has to let go of it when
    /// `leave` is called. `views`: how many pictures will be rendered of it.
    void open(const Options& o, std::size_t views, bool both_layouts, const std::function<void()>& leave = {});
    [[nodiscard]] Scene& scene() { return *scene_; }
    /// Hashes of what is in it. Of large scenes they take a while: asked for once a scene.
    [[nodiscard]] const RecordOrigin& origin();
    [[nodiscard]] const Phases& load_phases() const { return phases_; }
    [[nodiscard]] std::uint64_t load_peak_bytes() const { return load_peak_bytes_; }

private:
    Scene load(const Options& o, std::size_t views, LoadMonitor& monitor, bool both_layouts);
    void take_device(bool wait);

    std::mutex taking_;  // of what expect_device() has begun, by whichever thread of a loader hears of progress
    std::future<std::unique_ptr<Device>> opening_;
    std::unique_ptr<Device> device_;
    DeviceOptions device_options_;
    bool told_ = false;  // which one it is
    std::unique_ptr<Scene> scene_;
    std::optional<RecordOrigin> origin_;
    Phases phases_;
    std::uint64_t load_peak_bytes_ = 0;
#ifndef IRRADIA_MINIMAL
    SceneParts parts_;
#endif
};

}  // namespace irradia::app
