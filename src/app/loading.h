// Loading as the user sees it: progress while it goes on, seconds by phase and memory afterwards.
#pragma once
#include <mutex>
#include <string>
#include <utility>
#include <vector>

#include "app/stage_log.h"
#include "irradia/Scene.h"

namespace irradia::app {

/// Seconds by phase, in the order in which they came.
using Phases = std::vector<std::pair<std::string, double>>;

/// Listens to load_scene() and build_accel(): shows the fraction done and takes the time of each stage.
class LoadMonitor {
public:
    /// `stages`: shows progress; null: nobody does. `began`: when loading did, by the steady clock's seconds.
    LoadMonitor(StageLog* stages, double began) : stages_(stages), began_(began), stage_began_(began) {}
    /// `fraction` of `stage` is done. From any thread.
    void operator()(const std::string& stage, double fraction);
    /// Ends the last stage; what comes until the next one belongs to none.
    void pause();
    /// Ends the last stage and clears the bar.
    void finish();
    [[nodiscard]] const Phases& phases() const { return phases_; }

private:
    void end_stage(double at);

    std::mutex mutex_;
    StageLog* stages_;
    double began_, stage_began_;
    std::string stage_;
    Phases phases_;
};

/// Bytes of a scene's arrays, hierarchies included.
std::uint64_t scene_bytes(const Scene& scene);

/// "a.xml: 320 x 240 pixels, 10 M triangles, ..., read in 24 s (meshes 3.1 s, hierarchy 19 s), 221 bytes a triangle,
/// peak memory 2.8 GiB": phases of a twentieth of the time and more.
std::string load_text(const Scene& scene, const Phases& phases, std::uint64_t peak_bytes);

}  // namespace irradia::app
