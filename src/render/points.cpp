// Irradiance at given points: records where there are none, then look-ups (cl/irradiance_points.cl).
#include "irradia/Points.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <string>

#include "core/spatial_order.h"
#include "irradia/Error.h"
#include "irradia/RecordFile.h"
#include "render/methods.h"

namespace irradia {
namespace {

constexpr std::uint32_t samples_a_launch = 64;
constexpr std::size_t coarsest = 256;  // every so many points first, then those between

/// How wide a pixel of the camera would be there: what records are spaced by.
float footprint(const Scene& scene, const std::array<float, 3>& p) {
    const shared::Camera& c = scene.info.camera;
    const float distance = std::hypot(p[0] - c.ox, p[1] - c.oy, p[2] - c.oz);
    return std::max(distance, 1e-3f * scene.info.diagonal) * c.pixel_size;
}

std::vector<shared::ShadingPoint> shading_points(const Scene& scene, const std::vector<IrradiancePoint>& points,
                                                 std::size_t known) {
    std::vector<shared::ShadingPoint> out;
    out.reserve(points.size());
    for (const IrradiancePoint& given : points) {
        std::array<float, 3> p{}, n{};
        const double length = std::hypot(given.normal[0], given.normal[1], given.normal[2]);
        float largest = 0;
        bool finite = std::isfinite(length) && length > 0;
        for (std::size_t k = 0; k < 3; ++k) {
            p[k] = static_cast<float>(given.position[k] - scene.centre[k]);
            n[k] = static_cast<float>(given.normal[k] / length);
            largest = std::max(largest, std::abs(p[k]));
            finite = finite && std::isfinite(p[k]);
        }
        if (!finite)
            throw Error("point " + std::to_string(out.size()) +
                        ": expected finite numbers and a normal that is not zero");
        shared::ShadingPoint q{};
        q.px = p[0], q.py = p[1], q.pz = p[2];
        q.nx = q.gx = n[0], q.ny = q.gy = n[1], q.nz = q.gz = n[2];
        q.state = IR_POINT_MISS;
        q.footprint = footprint(scene, p);
        q.offset = 4e-6f * std::max(largest, scene.info.diagonal);  // cl/surface.h, by a ray across the scene
        q.pixel = static_cast<std::uint32_t>(known + out.size());   // other random numbers than records before
        out.push_back(q);
    }
    return out;
}

/// Where the points lie in the order in which the device is given them. A file's may be in any: at random places a
/// look-up among many records waits for memory.
std::vector<std::uint32_t> order_of(const std::vector<shared::ShadingPoint>& points) {
    std::vector<std::array<float, 3>> positions;
    positions.reserve(points.size());
    for (const shared::ShadingPoint& q : points) positions.push_back({q.px, q.py, q.pz});
    return spatial_order(positions);
}

/// Makes records until every point is covered, coarse to fine: every 256th along the curve first, so that those made at
/// once lie apart.
void cover(Run& run, CachingRenderer& caching, const std::vector<shared::ShadingPoint>& points) {
    const std::size_t group = run.device.pixel_group();
    Buffer buffer = run.device.upload(points);
    std::vector<shared::ShadingPoint> host(points.size());
    std::size_t done = 0;
    for (std::size_t step = coarsest; step > 0; step /= 2) {
        std::vector<std::uint32_t> indices;
        const std::size_t first = step == coarsest ? 0 : step, stride = step == coarsest ? step : 2 * step;
        for (std::size_t i = first; i < points.size(); i += stride) indices.push_back(static_cast<std::uint32_t>(i));
        if (indices.empty()) continue;
        Kernel kernel = run.device.kernel("irradiance_points.cl", "find_point_misses", [&] {
            std::map<std::string, std::string> defines = caching.irradiance().defines();
            defines.merge(run.scene_defines());
            return defines;
        }());
        caching.irradiance()
            .bind(kernel, true)
            .arg(buffer)
            .arg(run.device.upload(indices))
            .arg(static_cast<std::uint32_t>(indices.size()))
            .run(group_count(indices.size(), group), group);
        run.device.read(buffer, host.data(), host.size() * sizeof host[0]);
        RecordStack stack;
        for (const std::uint32_t i : indices)
            if (host[i].state != IR_POINT_NONE) stack.indices.push_back(i);
        caching.make(buffer, stack);
        done += indices.size();
        run.report("records", 0.5 * static_cast<double>(done) / static_cast<double>(points.size()),
                   caching.irradiance().size());
    }
    run.phase("records");
}

/// A point's answer lies at its place, which is its `pixel`.
std::vector<PointIrradiance> answer(Run& run, const CachingRenderer& caching,
                                    const std::vector<shared::ShadingPoint>& points, bool indirect) {
    const std::size_t group = run.device.pixel_group();
    const Buffer buffer = run.device.upload(points);
    std::vector<float> answers(6 * points.size());
    Buffer out = run.device.allocate(answers.size() * sizeof(float));
    std::vector<std::array<double, 6>> sums(points.size());
    for (std::uint32_t first = 0; first < run.spp(); first += samples_a_launch) {
        const std::uint32_t samples = std::min(samples_a_launch, run.spp() - first);
        Kernel kernel = run.scene_kernel("irradiance_points.cl", "point_irradiance", caching.irradiance().defines());
        caching.irradiance()
            .bind(kernel, false)
            .arg(buffer)
            .arg(out)
            .arg(run.ray_counters())
            .arg(static_cast<std::uint32_t>(points.size()))
            .arg(first)
            .arg(samples)
            .arg(run.edges_beyond_camera() >= 1 ? 1u : 0u)
            .arg(run.seed())
            .run(group_count(points.size(), group), group);
        run.device.read(out, answers.data(), answers.size() * sizeof(float));
        run.collect_rays();
        for (std::size_t i = 0; i < answers.size(); ++i)
            (i % 6 < 3 ? sums[i / 6][i % 6] += static_cast<double>(answers[i])
                       : sums[i / 6][i % 6] = static_cast<double>(answers[i]));
        run.report("shade", 0.5 + 0.5 * (first + samples) / run.spp(), caching.irradiance().size());
    }
    run.phase("shade");
    std::vector<PointIrradiance> result(points.size());
    for (std::size_t i = 0; i < points.size(); ++i) {
        const std::uint32_t place = points[i].pixel;
        if (indirect && sums[i][3] < 0)
            throw Error("point " + std::to_string(place) +
                        ": the record made there does not cover it (an error in the program: please report it)");
        for (std::size_t k = 0; k < 3; ++k) {
            result[place].direct[k] = static_cast<float>(sums[i][k] / run.spp());
            result[place].indirect[k] = indirect ? static_cast<float>(sums[i][3 + k]) : 0.0f;
        }
    }
    return result;
}

}  // namespace

std::vector<PointIrradiance> irradiance_at(const Scene& scene, Device& device, const RenderSettings& settings,
                                           const std::vector<IrradiancePoint>& points, const ProgressCallback& progress,
                                           RecordSet* records, RenderStatistics* statistics) {
    if (settings.method != Method::irradiance && settings.method != Method::radiance)
        throw Error("irradiance at points: expected method irradiance or radiance");
    RenderSettings diffuse = settings;
    diffuse.method = Method::irradiance;
    check_settings(scene, diffuse);
    Run run(scene, device, diffuse, progress);
    CachingRenderer caching(run);
    if (records != nullptr) caching.load(*records);
    const std::vector<shared::ShadingPoint> given = shading_points(scene, points, caching.irradiance().size());
    const std::vector<std::uint32_t> order = order_of(given);
    std::vector<shared::ShadingPoint> asked;
    asked.reserve(order.size());
    for (const std::uint32_t i : order) asked.push_back(given[i]);
    const bool indirect = run.edges_beyond_camera() >= 2;
    std::vector<PointIrradiance> result;
    if (!asked.empty()) {
        if (indirect) cover(run, caching, asked);
        // Now the point's place: its light samples are its own, whatever the number of records before.
        for (std::size_t i = 0; i < asked.size(); ++i) asked[i].pixel = order[i];
        result = answer(run, caching, asked, indirect);
    }
    if (records != nullptr) caching.store(*records);
    run.statistics.records = caching.irradiance().size();
    run.statistics.stages = run.device.stage_times();
    run.statistics.seconds = run.elapsed();
    if (statistics != nullptr) *statistics = run.statistics;
    return result;
}

}  // namespace irradia
