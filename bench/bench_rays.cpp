// Mrays/s of the traversal headers beside Embree's, one thread each: hemispheres of 16 x 64 cosine-distributed strata
// from random surface points, as sample_hemispheres traces them.
#include <benchmark/benchmark.h>

#include <algorithm>
#include <cstdlib>
#include <ctime>
#include <map>
#include <memory>
#include <random>

#include "irradia/Accel.h"
#include "reference.h"
#include "shapes.h"
#include "traversal.h"

namespace {

using namespace irradia;
using irradia::testing::DeviceHit;
using irradia::testing::EmbreeScene;
using irradia::testing::Ray;
using irradia::testing::Traversal;

constexpr int kRings = 16, kSectors = 64, kHemispheres = 192;

// CPU time of the process: on a busy machine wall time would measure the neighbours.
double cpu_seconds() {
    timespec t{};
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &t);
    return static_cast<double>(t.tv_sec) + 1e-9 * static_cast<double>(t.tv_nsec);
}

// Sixteen consecutive rays are a 4x4 tile of neighbouring strata.
std::vector<Ray> hemispheres(const Scene& scene, int count) {
    std::mt19937 random(1);
    std::uniform_real_distribution<double> unit(0, 1);
    std::vector<double> area;
    const auto edge = [&](std::uint32_t a, std::uint32_t b) {
        const shared::Vertex &p = scene.vertices[a], &q = scene.vertices[b];
        return testing::Double3{double{q.px} - p.px, double{q.py} - p.py, double{q.pz} - p.pz};
    };
    for (const shared::Triangle& t : scene.triangles) {
        const testing::Double3 n = testing::cross(edge(t.v0, t.v1), edge(t.v0, t.v2));
        area.push_back(std::sqrt(testing::dot(n, n)));
    }
    std::discrete_distribution<std::size_t> pick(area.begin(), area.end());
    std::vector<Ray> rays;
    for (int h = 0; h < count; ++h) {
        const shared::Triangle& t = scene.triangles[pick(random)];
        const testing::Double3 e1 = edge(t.v0, t.v1), e2 = edge(t.v0, t.v2);
        testing::Double3 n = testing::cross(e1, e2);
        const double l = (h % 2 ? -1 : 1) * std::sqrt(testing::dot(n, n));  // both sides of the surfaces
        n = {n.x / l, n.y / l, n.z / l};
        const double s = std::sqrt(unit(random)), b1 = s * (1 - unit(random)), b2 = s - b1;
        const shared::Vertex& p = scene.vertices[t.v0];
        const testing::Double3 o{p.px + b1 * e1.x + b2 * e2.x, p.py + b1 * e1.y + b2 * e2.y,
                                 p.pz + b1 * e1.z + b2 * e2.z};
        testing::Double3 x = std::abs(n.x) < 0.5 ? testing::Double3{0, n.z, -n.y} : testing::Double3{-n.z, 0, n.x};
        const double lx = std::sqrt(testing::dot(x, x));
        x = {x.x / lx, x.y / lx, x.z / lx};
        const testing::Double3 y = testing::cross(n, x);
        for (int tile = 0; tile < kRings * kSectors / 16; ++tile)
            for (int i = 0; i < 16; ++i) {
                const int ring = tile % (kRings / 4) * 4 + i % 4, sector = tile / (kRings / 4) * 4 + i / 4;
                const double sin2 = (ring + unit(random)) / kRings,
                             phi = 2 * 3.14159265358979 * (sector + unit(random)) / kSectors;
                const double a = std::sqrt(sin2) * std::cos(phi), b = std::sqrt(sin2) * std::sin(phi),
                             c = std::sqrt(1 - sin2);
                rays.push_back({static_cast<float>(o.x), static_cast<float>(o.y), static_cast<float>(o.z), 1e-4f,
                                static_cast<float>(a * x.x + b * y.x + c * n.x),
                                static_cast<float>(a * x.y + b * y.y + c * n.y),
                                static_cast<float>(a * x.z + b * y.z + c * n.z), 1e30f});
            }
    }
    return rays;
}

// From the hemispheres' hits to random points of the ceiling: the shadow rays of next-event estimation.
std::vector<Ray> shadow_rays(const std::vector<Ray>& rays, const std::vector<DeviceHit>& hits) {
    std::mt19937 random(2);
    std::uniform_real_distribution<float> unit(-0.25f, 0.25f);
    std::vector<Ray> shadows;
    for (std::size_t i = 0; i < rays.size(); ++i) {
        const float t = hits[i].primitive == IR_NO_PRIMITIVE ? 0.0f : hits[i].t * 0.9999f;
        Ray r = rays[i];
        r.ox += t * r.dx, r.oy += t * r.dy, r.oz += t * r.dz;
        r.dx = unit(random) - r.ox, r.dy = 0.98f - r.oy, r.dz = unit(random) - r.oz;
        const float l = std::hypot(r.dx, r.dy, r.dz);
        r.dx /= l, r.dy /= l, r.dz /= l;
        r.t_max = l;
        shadows.push_back(r);
    }
    return shadows;
}

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
        rays = hemispheres(scene, kHemispheres);
        shadows = shadow_rays(rays, cpu->closest(rays));
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
            state, set.count, [&] { device.launch("test_tile_occluded", set, set.count / 16, {16}); }, embree);
    else
        compare(
            state, set.count, [&] { device.launch("test_occluded", set, set.count, {}); }, embree);
}

}  // namespace

int main(int argc, char** argv) {
    setenv("POCL_MAX_PTHREAD_COUNT", "1", 0);
    for (const std::string scene : {"cornell", "mesh60k", "mesh250k"}) {
        for (const std::string mode : {"tile", "single", "gpu"})
            benchmark::RegisterBenchmark((scene + "/closest/" + mode).c_str(),
                                         [=](benchmark::State& s) { closest(s, scene, mode); })
                ->UseManualTime()
                ->Unit(benchmark::kMillisecond);
        for (const std::string mode : {"tile", "single", "gpu"})
            benchmark::RegisterBenchmark((scene + "/shadow/" + mode).c_str(),
                                         [=](benchmark::State& s) { shadow(s, scene, mode); })
                ->UseManualTime()
                ->Unit(benchmark::kMillisecond);
    }
    benchmark::Initialize(&argc, argv);
    if (benchmark::ReportUnrecognizedArguments(argc, argv)) return 1;
    benchmark::RunSpecifiedBenchmarks();
    return 0;
}
