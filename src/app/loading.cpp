#include "app/loading.h"

#include <algorithm>
#include <numeric>
#include <sstream>

#include "app/clock.h"

#include "app/progress.h"

namespace irradia::app {
namespace {

// Shares of the whole, in order, as measured on large meshes.
struct Share {
    const char* stage;
    double size;
};
constexpr Share kShares[] = {{"parsing", 0.02},  {"meshes", 0.2},     {"textures", 0.05},
                             {"assembly", 0.05}, {"hierarchy", 0.63}, {"checks", 0.05}};

double overall(const std::string& stage, double fraction) {
    double before = 0;
    for (const Share& share : kShares) {
        if (share.stage == stage) return before + share.size * std::clamp(fraction, 0.0, 1.0);
        before += share.size;
    }
    return 0;
}

template <class T>
std::uint64_t bytes(const std::vector<T>& v) {
    return v.size() * sizeof(T);
}

}  // namespace

void LoadMonitor::operator()(const std::string& stage, double fraction) {
    const std::lock_guard lock(mutex_);
    const double at = now();
    if (stage != stage_) {
        end_stage(at);
        stage_ = stage;
    }
    if (!stages_) return;
    Progress p;
    p.stage = "loading: " + stage;
    p.fraction = overall(stage, fraction);
    p.elapsed = at - began_;
    (*stages_)(p);
}

void LoadMonitor::end_stage(double at) {
    if (!stage_.empty()) {
        const auto known =
            std::find_if(phases_.begin(), phases_.end(), [&](const auto& phase) { return phase.first == stage_; });
        if (known == phases_.end())
            phases_.emplace_back(stage_, at - stage_began_);
        else
            known->second += at - stage_began_;
    }
    stage_began_ = at;
}

void LoadMonitor::pause() {
    const std::lock_guard lock(mutex_);
    end_stage(now());
    stage_.clear();
}

void LoadMonitor::finish() {
    const std::lock_guard lock(mutex_);
    const double at = now();
    end_stage(at);
    stage_.clear();
    if (stages_) stages_->finish(at - began_);
}

std::uint64_t scene_bytes(const Scene& s) {
    return bytes(s.vertices) + bytes(s.triangles) + bytes(s.analytics) + bytes(s.materials) + bytes(s.textures) +
           bytes(s.texels) + bytes(s.lights) + bytes(s.accel.bvh8_nodes) + bytes(s.accel.bvh8_triangles) +
           bytes(s.accel.bvh2_nodes) + bytes(s.accel.bvh2_triangles);
}

std::string load_text(const Scene& scene, const Phases& phases, std::uint64_t peak_bytes) {
    const double seconds =
        std::accumulate(phases.begin(), phases.end(), 0.0, [](double sum, const auto& p) { return sum + p.second; });
    std::ostringstream out;
    out << scene.source << ": " << scene.info.width << " x " << scene.info.height << " pixels, "
        << count_text(static_cast<double>(scene.triangles.size())) << " triangles, " << scene.analytics.size()
        << " spheres, disks and cylinders, " << scene.lights.size() << " emitters, " << scene.textures.size()
        << " textures, loaded in " << time_text(seconds);
    const char* separator = " (";
    for (const auto& [name, time] : phases) {
        if (time < 0.05 * seconds) continue;
        out << separator << name << ' ' << time_text(time);
        separator = ", ";
    }
    if (*separator == ',') out << ')';
    const std::size_t texels = bytes(scene.texels);
    if (!scene.triangles.empty())
        out << ", " << (scene_bytes(scene) - texels) / scene.triangles.size() << " bytes a triangle";
    out << ", peak memory " << (peak_bytes >> 20) << " MiB";
    return out.str();
}

}  // namespace irradia::app
