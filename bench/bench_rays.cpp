// Mrays/s of the traversal headers beside Embree's, one thread each: hemispheres of 16 x 64 cosine-distributed strata
// from random surface points, as sample_hemispheres traces them.
#include <benchmark/benchmark.h>

#include <algorithm>
#include <map>
#include <memory>

#include "bench.h"
#include "hemisphere_rays.h"
#include "irradia/Accel.h"
#include "reference.h"
#include "shapes.h"
#include "traversal.h"

namespace irradia::bench {
namespace {

using testing::DeviceHit;
using testing::EmbreeScene;
using testing::Traversal;

constexpr int hemispheres = 192;
// Where shadow rays go: below the Cornell box's lamp, inside the room of meshes.
constexpr Lamp lamp{-0.25f, 0.98f, -0.25f, 0.5f, 0, 0, 0, 0, 0.5f};

struct Case {
    Scene scene;
    std::unique_ptr<EmbreeScene> embree;
    std::unique_ptr<Traversal> cpu, gpu;
    std::vector<Ray> rays, shadows;

    explicit Case(Scene s) : scene(std::move(s)) {
        build_accel(scene);
        embree = std::make_unique<EmbreeScene>(scene, false);
        cpu = std::make_unique<Traversal>(scene, true);
        gpu = std::make_unique<Traversal>(scene, false);
        rays = hemisphere_rays(surface_points(scene, hemispheres));
        shadows = shadow_rays(rays, cpu->closest(rays), lamp);
    }
};

Case& get_case(const std::string& name) {
    static std::map<std::string, std::unique_ptr<Case>> cases;
    std::unique_ptr<Case>& c = cases[name];
    if (!c)
        c = std::make_unique<Case>(name == "cornell" ? shapes::cornell_box()
                                                     : shapes::mesh_room(name == "mesh60k" ? 60000 : 250000));
    return *c;
}

// Times `device` and `embree` in turns and reports both from their best round, so that the ratio is of equal
// conditions.
template <class DeviceRun, class EmbreeRun>
void compare(benchmark::State& state, std::size_t rays, const DeviceRun& device, const EmbreeRun& embree) {
    device();  // compiles the kernel
    double best_device = 1e30, best_embree = 1e30;
    for (auto _ : state) {
        double start = cpu_seconds();
        embree();
        best_embree = std::min(best_embree, cpu_seconds() - start);
        start = cpu_seconds();
        device();
        const double seconds = cpu_seconds() - start;
        best_device = std::min(best_device, seconds);
        state.SetIterationTime(seconds);
    }
    state.counters["Mrays/s"] = 1e-6 * static_cast<double>(rays) / best_device;
    state.counters["Embree"] = 1e-6 * static_cast<double>(rays) / best_embree;
    state.counters["ratio"] = best_embree / best_device;
}

// Of Embree's answers: the share with another primitive (or none), and the share whose distance is another too, by more
// than 1e-4 of it. The first without the second are rays through edges, which belong to both neighbours.
void count_differences(benchmark::State& state, const Case& c, const std::vector<DeviceHit>& hits) {
    std::size_t other_primitive = 0, other_distance = 0;
    for (std::size_t i = 0; i < hits.size(); ++i) {
        const DeviceHit e = c.embree->closest(c.rays[i]);
        if (e.primitive == hits[i].primitive) continue;
        ++other_primitive;
        other_distance += !(std::abs(e.t - hits[i].t) <= 1e-4f * e.t);
    }
    const auto n = static_cast<double>(hits.size());
    state.counters["rays"] = n;
    state.counters["other primitive"] = static_cast<double>(other_primitive) / n;
    state.counters["other distance"] = static_cast<double>(other_distance) / n;
}

void closest(benchmark::State& state, const std::string& name, const std::string& mode) {
    Case& c = get_case(name);
    Traversal& device = mode == "gpu" ? *c.gpu : *c.cpu;
    const auto embree = [&] {
        for (const Ray& r : c.rays) benchmark::DoNotOptimize(c.embree->closest(r));
    };
    const bool tiles = mode == "tile";
    const Traversal::RaySet set = tiles ? device.prepare_tiles(c.rays, 16) : device.prepare(c.rays);
    if (tiles)
        compare(
            state, set.count, [&] { device.launch("test_tile", set, set.count / 16, {16}); }, embree);
    else
        compare(
            state, set.count, [&] { device.launch("test_closest", set, set.count, {}); }, embree);
    count_differences(state, c, device.results<DeviceHit>(set));
}

void shadow(benchmark::State& state, const std::string& name, const std::string& mode) {
    Case& c = get_case(name);
    Traversal& device = mode == "gpu" ? *c.gpu : *c.cpu;
    const auto embree = [&] {
        for (const Ray& r : c.shadows) benchmark::DoNotOptimize(c.embree->occluded(r));
    };
    const bool tiles = mode == "tile";
    const Traversal::RaySet set = tiles ? device.prepare_own_origins(c.shadows, 16) : device.prepare(c.shadows);
    if (tiles)
        compare(
            state, set.count, [&] { device.launch("test_tile_occluded", set, (set.count + 15) / 16, {16}); }, embree);
    else
        compare(
            state, set.count, [&] { device.launch("test_occluded", set, set.count, {}); }, embree);
    const auto occluded = device.results<std::uint32_t>(set);
    std::size_t others = 0, hidden = 0;
    for (std::size_t i = 0; i < occluded.size(); ++i) {
        others += (occluded[i] != 0) != c.embree->occluded(c.shadows[i]);
        hidden += occluded[i] != 0;
    }
    const auto n = static_cast<double>(occluded.size());
    state.counters["rays"] = n;
    state.counters["occluded"] = static_cast<double>(hidden) / n;
    state.counters["other answer"] = static_cast<double>(others) / n;
}

}  // namespace

void register_rays() {
    const auto add = [](const std::string& name, auto run) {
        benchmark::RegisterBenchmark(name.c_str(), run)->UseManualTime()->Unit(benchmark::kMillisecond);
    };
    for (const std::string scene : {"cornell", "mesh60k", "mesh250k"}) {
        for (const std::string mode : {"tile", "single", "gpu"})
            add("rays/" + scene + "/closest/" + mode, [=](benchmark::State& s) { closest(s, scene, mode); });
        for (const std::string mode : {"tile", "single", "gpu"})
            add("rays/" + scene + "/shadow/" + mode, [=](benchmark::State& s) { shadow(s, scene, mode); });
    }
}

}  // namespace irradia::bench
