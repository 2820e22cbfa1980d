// Plain gathering: a hemisphere at every sample of every pixel (cl/gather_pixels.cl). No cache, no interpolation error;
// slow. What the cache's time and error are compared with.
#include <algorithm>

#include "render/hemispheres.h"
#include "render/methods.h"

namespace irradia {
namespace {
// A GPU runs some five hundred hemispheres at once: launches of not many more leave half of it idle at their end.
constexpr std::size_t pixels_a_launch_cpu = 1024, pixels_a_launch_gpu = 16384;
}  // namespace

void render_gather(Run& run, Film& film, SamplePosition& at) {
    HemisphereSampler hemispheres(run, Hemispheres::irradiance);
    const IrradianceGrid no_grid(run);
    const std::size_t chunk =
        std::min(film.pixels(), run.device.cpu_traversal() ? pixels_a_launch_cpu : pixels_a_launch_gpu);
    Buffer buffer = run.device.allocate(chunk * film.channels() * sizeof(float));
    Buffer points = run.device.allocate(chunk * sizeof(shared::ShadingPoint));
    Buffer albedos = run.device.allocate(chunk * 3 * sizeof(float));
    Buffer stack = run.device.allocate(chunk * sizeof(std::uint32_t));
    Buffer keys = run.device.allocate(chunk * sizeof(shared::RecordKey));
    Buffer values = run.device.allocate(chunk * sizeof(shared::RecordValue));
    std::vector<float> sums(chunk * film.channels());
    std::vector<shared::ShadingPoint> host_points(chunk);
    const double total = static_cast<double>(film.pixels()) * run.spp();
    double done = static_cast<double>(film.pixels()) * at.sample + static_cast<double>(at.pixel);
    for (; at.sample < run.spp(); ++at.sample) {
        while (at.pixel < film.pixels()) {
            run.rest();
            const std::size_t first = at.pixel, count = std::min(chunk, film.pixels() - first);
            run.scene_kernel("gather_pixels.cl", "gather_points", {{"IR_DIRECT_MIS", run.direct_mis() ? "1" : "0"}})
                .arg(buffer)
                .arg(points)
                .arg(albedos)
                .arg(run.ray_counters())
                .arg(static_cast<std::uint32_t>(first))
                .arg(static_cast<std::uint32_t>(count))
                .arg(at.sample)
                .arg(run.edges_beyond_camera())
                .arg(run.seed())
                .run(group_count(count, run.device.pixel_group()), run.device.pixel_group());
            run.device.read(points, host_points.data(), count * sizeof(shared::ShadingPoint));
            std::vector<std::uint32_t> indices;
            for (std::uint32_t i = 0; i < count; ++i)
                if (host_points[i].state != IR_POINT_NONE) indices.push_back(i);
            if (!indices.empty()) {
                run.device.write(stack, indices.data(), indices.size() * sizeof(std::uint32_t));
                // Every (sample, pixel) draws its own numbers.
                hemispheres.sample(points, stack, indices.size(), no_grid, keys, values, 0, at.sample);
                run.device.kernel("gather_pixels.cl", "gather_irradiance", run.scene_defines())
                    .arg(buffer)
                    .arg(albedos)
                    .arg(stack)
                    .arg(values)
                    .arg(static_cast<std::uint32_t>(film.channels()))
                    .arg(static_cast<std::uint32_t>(indices.size()))
                    .run(group_count(indices.size(), run.device.pixel_group()), run.device.pixel_group());
            }
            run.device.read(buffer, sums.data(), count * film.channels() * sizeof(float));
            film.add(sums, first, count, 1);
            run.collect_rays();
            done += static_cast<double>(count);
            at.pixel += count;
            run.report("gather", done / total);
        }
        at.pixel = 0;
    }
    run.phase("gather");
}

}  // namespace irradia
