// The etalon: unbiased path tracing in short launches (cl/trace_paths.cl). It has no systematic error, so every other
// method is judged against it.
#include <algorithm>

#include "render/methods.h"

namespace irradia {
namespace {
// One launch: so many samples of so many pixels. The first fixes how float32 sums are cut (and so the bytes of the
// picture), the second only how often progress is shown.
constexpr std::uint32_t samples_a_launch = 16;
constexpr std::size_t pixels_a_launch_cpu = 1u << 14, pixels_a_launch_gpu = 1u << 21;
}  // namespace

void render_path(Run& run, Film& film, std::uint32_t first_sample) {
    const std::size_t chunk =
        std::min(film.pixels(), run.device.cpu_traversal() ? pixels_a_launch_cpu : pixels_a_launch_gpu);
    Buffer buffer = run.device.allocate(chunk * film.channels() * sizeof(float));
    std::vector<float> sums(chunk * film.channels());
    const double total = static_cast<double>(film.pixels()) * (run.spp() - first_sample);
    double done = 0;
    for (std::uint32_t sample = first_sample; sample < run.spp(); sample += samples_a_launch) {
        const std::uint32_t samples = std::min(samples_a_launch, run.spp() - sample);
        for (std::size_t first = 0; first < film.pixels(); first += chunk) {
            const std::size_t count = std::min(chunk, film.pixels() - first);
            run.scene_kernel("trace_paths.cl", "trace_paths", {})
                .arg(buffer)
                .arg(run.ray_counters())
                .arg(static_cast<std::uint32_t>(first))
                .arg(static_cast<std::uint32_t>(count))
                .arg(sample)
                .arg(samples)
                .arg(run.edges_beyond_camera())
                .arg(run.seed())
                .run(group_count(count, run.device.pixel_group()), run.device.pixel_group());
            run.device.read(buffer, sums.data(), count * film.channels() * sizeof(float));
            film.add(sums, first, count, samples);
            run.collect_rays();
            done += static_cast<double>(count) * samples;
            run.report("path", done / total);
        }
    }
    run.phase("path");
}

}  // namespace irradia
