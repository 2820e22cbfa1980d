// Rays a second of the renderer's sample_hemispheres kernel, beside kernels that do nothing but traverse: the ceiling.
// The ceiling's rays start at the same points, through the same strata; its shadow rays go from where they hit to the
// lamp.
#include <benchmark/benchmark.h>

#include <algorithm>
#include <map>
#include <memory>

#include "bench.h"
#include "irradia/Accel.h"
#include "lit_scene.h"
#include "render/hemispheres.h"
#include "render/run.h"

namespace irradia::bench {
namespace {

using testing::DeviceHit;

// Rays in a device's memory as its packets (CPU: 16 rays a work-item) or single rays want them, and their results.
class Traced {
public:
    Traced(Device& device, const Scene& scene, const std::vector<Ray>& rays, bool shadow)
        : device_(device), count_(rays.size()), shadow_(shadow) {
        const std::size_t tile = device.tile();
        if (tile == 1) {
            rays_ = device.upload(rays);
        } else {
            const std::size_t stride = shadow ? 128 : 64;  // floats a tile: cl/trace_test.cl
            std::vector<float> in((count_ + tile - 1) / tile * stride);
            for (std::size_t i = 0; i < count_; ++i) {
                float *t = in.data() + i / tile * stride, *own = t + i % tile;
                const Ray& r = rays[i];
                if (shadow) {
                    own[0] = r.ox, own[16] = r.oy, own[32] = r.oz, own[48] = r.dx, own[64] = r.dy, own[80] = r.dz;
                    own[96] = r.t_max, t[112] = r.t_min;
                } else {
                    own[0] = r.dx, own[16] = r.dy, own[32] = r.dz;
                    t[48] = r.ox, t[49] = r.oy, t[50] = r.oz, t[51] = r.t_min;
                }
            }
            rays_ = device.upload(in);
        }
        results_ = device.allocate(count_ * sizeof(DeviceHit));
        const bool cpu = device.cpu_traversal();
        nodes_ = cpu ? device.upload(scene.accel.bvh8_nodes) : device.upload(scene.accel.bvh2_nodes);
        leaves_ = cpu ? device.upload(scene.accel.bvh8_triangles) : device.upload(scene.accel.bvh2_triangles);
        unused_ = device.allocate(512);
        info_ = device.upload(&scene.info, sizeof scene.info);
    }

    double trace() {
        const std::size_t tile = device_.tile(), items = (count_ + tile - 1) / tile, group = device_.group_size();
        const char* const names[2][2] = {{"test_closest", "test_occluded"}, {"test_tile", "test_tile_occluded"}};
        DeviceClock clock(device_);
        Kernel kernel = device_.kernel("trace_test.cl", names[tile > 1][shadow_], {{"IR_FEATURES", "0u"}});
        kernel.arg(nodes_).arg(leaves_);
        for (int i = 0; i < 7; ++i) kernel.arg(unused_);  // analytics, triangles, ...: no traversal reads them
        kernel.arg(info_).arg(rays_).arg(static_cast<std::uint32_t>(count_));
        if (tile > 1) kernel.arg(static_cast<std::uint32_t>(tile));
        kernel.arg(results_).run((items + group - 1) / group, group);
        return clock.seconds();
    }

    std::vector<DeviceHit> hits() {
        std::vector<DeviceHit> out(count_);
        device_.read(results_, out.data(), out.size() * sizeof out[0]);
        return out;
    }
    [[nodiscard]] std::size_t count() const { return count_; }

private:
    Device& device_;
    std::size_t count_;
    bool shadow_;
    Buffer rays_, results_, nodes_, leaves_, unused_, info_;
};

// Where random rays of the camera hit: what records are made at.
std::vector<SurfacePoint> seen_points(Device& device, const Scene& scene, std::size_t count) {
    std::mt19937 random(5);
    std::uniform_real_distribution<float> unit(0, 1);
    const shared::Camera& c = scene.info.camera;
    const std::size_t tile = device.tile();
    std::vector<Ray> rays;
    while (rays.size() < 2 * count * tile) {  // a packet's rays are one ray sixteen times over
        const float x = unit(random), y = unit(random);
        const float dx = c.cornerx + x * c.dxx + y * c.dyx, dy = c.cornery + x * c.dxy + y * c.dyy,
                    dz = c.cornerz + x * c.dxz + y * c.dyz, l = std::hypot(dx, dy, dz);
        rays.insert(rays.end(), tile, {c.ox, c.oy, c.oz, 0, dx / l, dy / l, dz / l, 1e30f});
    }
    Traced traced(device, scene, rays, false);
    traced.trace();
    const std::vector<DeviceHit> hits = traced.hits();
    std::vector<SurfacePoint> points;
    for (std::size_t i = 0; i < hits.size() && points.size() < count; i += tile) {
        if (hits[i].primitive == IR_NO_PRIMITIVE) continue;
        const Ray& r = rays[i];
        const shared::Triangle& t = scene.triangles[hits[i].primitive];
        const double side = r.dx * t.nx + r.dy * t.ny + r.dz * t.nz > 0 ? -1 : 1;
        points.push_back(
            {{double{r.ox} + hits[i].t * r.dx, double{r.oy} + hits[i].t * r.dy, double{r.oz} + hits[i].t * r.dz},
             {side * t.nx, side * t.ny, side * t.nz}});
    }
    return points;
}

struct Case {
    LitScene lit;
    Device device;
    std::vector<SurfacePoint> points;
    std::unique_ptr<Traced> closest, shadows;

    Case(const std::string& name, const DeviceOptions& options) : lit(lit_scene(name)), device(options) {
        build_accel(lit.scene);
        // A GPU is full with some thousand groups only.
        points = seen_points(device, lit.scene, device.description().is_cpu ? 192 : 8192);
        const std::vector<Ray> rays = hemisphere_rays(points);
        closest = std::make_unique<Traced>(device, lit.scene, rays, false);
        closest->trace();
        shadows = std::make_unique<Traced>(device, lit.scene, shadow_rays(rays, closest->hits(), lit.lamp), true);
        shadows->trace();
    }
};

Case& get_case(const std::string& name, const DeviceOptions& options) {
    static std::map<std::string, std::unique_ptr<Case>> cases;
    std::unique_ptr<Case>& c = cases[name];
    if (!c) c = std::make_unique<Case>(name, options);
    return *c;
}

std::vector<shared::ShadingPoint> shading_points(const std::vector<SurfacePoint>& points) {
    std::vector<shared::ShadingPoint> out;
    for (const auto& [p, n] : points) {
        shared::ShadingPoint q{};
        q.px = static_cast<float>(p.x), q.py = static_cast<float>(p.y), q.pz = static_cast<float>(p.z);
        q.nx = q.gx = static_cast<float>(n.x), q.ny = q.gy = static_cast<float>(n.y);
        q.nz = q.gz = static_cast<float>(n.z);
        q.state = IR_POINT_MISS;
        q.footprint = 0.01f;
        q.offset = 1e-5f;
        q.pixel = static_cast<std::uint32_t>(out.size());
        out.push_back(q);
    }
    return out;
}

// form "grid": as the renderer does by default, light of the second bounce from the irradiance grid; "bounce": no grid,
// and paths end where the hemisphere's ray hits, with a shadow ray and a ray along the BSDF, which weighs against it;
// "paths": no grid, paths of any length.
void hemisphere(benchmark::State& state, const DeviceOptions& options, const std::string& name,
                const std::string& form) {
    Case& c = get_case(name, options);
    RenderSettings settings;
    settings.hemisphere_m = rings, settings.hemisphere_n = sectors;
    settings.grid = form == "grid";
    settings.max_depth = form == "bounce" ? 3 : -1;
    Run run(c.lit.scene, c.device, settings, {});
    IrradianceGrid grid(run);
    grid.fill();
    HemisphereSampler sampler(run, Hemispheres::irradiance_records);
    const auto points = shading_points(c.points);
    const std::size_t n = points.size();
    std::vector<std::uint32_t> order(n);
    for (std::size_t i = 0; i < n; ++i) order[i] = static_cast<std::uint32_t>(i);
    const Buffer shading = c.device.upload(points), stack = c.device.upload(order);
    const Buffer keys = c.device.allocate(n * sizeof(shared::RecordKey)),
                 values = c.device.allocate(n * sizeof(shared::RecordValue));
    const auto sample = [&] { sampler.sample(shading, stack, n, grid, keys, values, 0, 0); };
    sample();  // compiles
    run.statistics.rays.clear();
    double best = 1e30, closest = 1e30, shadows = 1e30;
    std::size_t rounds = 0;
    for (auto _ : state) {  // in turns, so that the ratio is of equal conditions
        DeviceClock clock(c.device);
        sample();
        const double seconds = clock.seconds();
        best = std::min(best, seconds);
        closest = std::min(closest, c.closest->trace());
        shadows = std::min(shadows, c.shadows->trace());
        state.SetIterationTime(seconds);
        ++rounds;
    }
    const auto& rays = run.statistics.rays;
    const double hemisphere_rays = static_cast<double>(n * rays_a_hemisphere),
                 shadow_rays = static_cast<double>(rays.at("shadow")) / static_cast<double>(rounds),
                 bounces = static_cast<double>(rays.at("bounce")) / static_cast<double>(rounds);
    const double closest_rate = static_cast<double>(c.closest->count()) / closest,
                 shadow_rate = static_cast<double>(c.shadows->count()) / shadows;
    const double all = hemisphere_rays + shadow_rays + bounces;
    // What traversal alone would take for these rays; bounces are counted as if they were as coherent as the first
    // rays.
    const double ceiling = (hemisphere_rays + bounces) / closest_rate + shadow_rays / shadow_rate;
    state.counters["M hemisphere rays/s"] = 1e-6 * hemisphere_rays / best;
    state.counters["M all rays/s"] = 1e-6 * all / best;
    state.counters["shadow a ray"] = shadow_rays / hemisphere_rays;
    state.counters["bounces a ray"] = bounces / hemisphere_rays;
    state.counters["ceiling closest"] = 1e-6 * closest_rate;
    state.counters["ceiling shadow"] = 1e-6 * shadow_rate;
    state.counters["ceiling all"] = 1e-6 * all / ceiling;
    state.counters["of ceiling"] = ceiling / best;
}

}  // namespace

void register_hemispheres(const DeviceOptions& options) {
    for (const std::string scene : {"cornell", "mesh60k", "mesh250k"})
        for (const std::string form : {"grid", "bounce", "paths"})
            benchmark::RegisterBenchmark(("hemisphere/" + scene + "/" + form).c_str(),
                                         [=](benchmark::State& s) { hemisphere(s, options, scene, form); })
                ->UseManualTime()
                ->Unit(benchmark::kMillisecond);
}

}  // namespace irradia::bench
