// What every method shares while it runs: the scene on the device, ray counters, progress, statistics.
#pragma once
#include <chrono>
#include <cstdint>
#include <functional>
#include <limits>
#include <map>
#include <string>
#include <vector>

#include "irradia/Checkpoint.h"
#include "irradia/Device.h"
#include "irradia/Renderer.h"
#include "render/film.h"

namespace irradia {

/// Samples a pixel that are asked for.
[[nodiscard]] std::uint32_t asked_spp(const Scene& scene, const RenderSettings& settings);

class Run {
public:
    Run(const Scene& scene, Device& device, const RenderSettings& settings, const ProgressCallback& progress);

    const Scene& scene;
    Device& device;
    const RenderSettings& settings;
    RenderStatistics statistics;

    /// A kernel specialised by what the scene needs, with IR_SCENE_ARGS set.
    Kernel scene_kernel(const std::string& file, const std::string& name, std::map<std::string, std::string> defines,
                        int registers = 0);
    /// What scene_kernel() compiles.
    [[nodiscard]] KernelSource scene_source(const std::string& file, std::map<std::string, std::string> defines) const;
    /// Definitions every kernel that traces rays gets.
    [[nodiscard]] std::map<std::string, std::string> scene_defines() const;
    /// Memory for what a launch gives back, `count` floats. All threads touch what a GPU's driver, on one thread, will
    /// copy to; CPU devices share that out.
    [[nodiscard]] UntouchedVector<float> landing(std::size_t count) const {
        return device.cpu_traversal() ? UntouchedVector<float>(count) : filled(device.host_threads(), count, 0.0f);
    }
    /// Another view of the scene: kernels set up from now on see it through this camera.
    void set_camera(const shared::Camera& camera);
    /// What is seen of the sky: kernels set up from now on find `tables` (cl/sky_view.h) behind the scene's texels;
    /// none: all of it. Earlier ones are forgotten.
    void see_sky(const std::vector<std::uint32_t>& tables);
    /// Statistics and time start anew.
    void restart();
    [[nodiscard]] const shared::Camera& camera() const noexcept { return camera_; }
    /// Device counters that kernels add to: rays by kind (irradia/shared/counter_types.h).
    [[nodiscard]] const Buffer& ray_counters() const noexcept { return ray_counters_; }
    /// Adds the device's counters to the statistics and clears them (they are 32 bits wide: call after every launch or
    /// few). Returns how many pixels have asked for a record since the last call (shade_pixels).
    std::uint32_t collect_rays();

    [[nodiscard]] std::uint32_t seed() const noexcept { return seed_; }
    /// Path edges beyond the viewing ray, and beyond a hemisphere's ray: see cl/path.h.
    [[nodiscard]] std::uint32_t edges_beyond_camera() const noexcept;
    [[nodiscard]] std::uint32_t edges_beyond_hemisphere() const noexcept;
    [[nodiscard]] std::uint32_t spp() const noexcept { return static_cast<std::uint32_t>(statistics.spp); }
    void set_spp(std::uint32_t spp) noexcept { statistics.spp = static_cast<int>(spp); }
    /// Is direct light sampled by BSDF samples too (DirectMis)? What IR_DIRECT_MIS is defined as.
    [[nodiscard]] bool direct_mis() const noexcept;
    [[nodiscard]] bool aovs() const noexcept;  ///< kernels must gather albedo, normal, depth

    /// Thrown by report() once the time that stop_after() has set is over.
    struct TimeIsUp {};
    /// `elapsed`: of elapsed(); infinity: never.
    void stop_after(double elapsed) noexcept { stop_ = elapsed; }
    /// Called where a method's state is whole and nothing is running: what a checkpoint is made of.
    void rest() {
        if (at_rest_) at_rest_(!in_step_);
    }
    /// `at_rest` is told whether the state is whole, not only the method's.
    void on_rest(std::function<void(bool)> at_rest) { at_rest_ = std::move(at_rest); }
    /// In a step of a search, which cannot be gone on with in its middle.
    void in_step(bool yes) { in_step_ = yes; }
    /// Statistics, camera and the time so far.
    void state(Checkpoint& checkpoint);
    void report(const std::string& stage, double fraction, std::uint64_t records = 0);
    /// Wall seconds since the previous call go to phases[name].
    void phase(const std::string& name);
    [[nodiscard]] double elapsed() const;
    /// What has been spent so far, where shares of it decide about the picture or what is said of it. On CPU devices
    /// rays, which cost about as much whatever they are traced for (.8 to 1.5 times: docs/error.md), so that a seed's
    /// result does not go by the clock; on GPUs, where few rays take as long as many, seconds.
    [[nodiscard]] double effort() const;

private:
    void clear_statistics();
    using Clock = std::chrono::steady_clock;
    const ProgressCallback& progress_;
    Clock::time_point start_, phase_start_;
    shared::Camera camera_;
    std::function<void(bool)> at_rest_;
    bool in_step_ = false;
    double stop_ = std::numeric_limits<double>::infinity();
    std::uint32_t seed_ = 0;
    Buffer ray_counters_;
    Buffer nodes_, leaves_, analytics_, triangles_, vertices_, materials_, textures_, texels_, lights_, info_;
};

/// Groups of `size` that cover `count` items.
constexpr std::size_t group_count(std::size_t count, std::size_t size) { return (count + size - 1) / size; }

}  // namespace irradia
