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

void render_path(Run& run, Film& film, SamplePosition& at) {
    const std::size_t chunk =
        std::min(film.pixels(), run.device.cpu_traversal() ? pixels_a_launch_cpu : pixels_a_launch_gpu);
    Buffer buffer = run.device.allocate(chunk * film.channels() * sizeof(float));
    UntouchedVector<float> sums = run.landing(chunk * film.channels());
    const double total = static_cast<double>(film.pixels()) * run.spp();
    double done = static_cast<double>(film.pixels()) * at.sample +
                  static_cast<double>(at.pixel) * std::min(samples_a_launch, run.spp() - at.sample);
    while (at.sample < run.spp()) {
        const std::uint32_t samples = std::min(samples_a_launch, run.spp() - at.sample);
        while (at.pixel < film.pixels()) {
            run.rest();
            const std::size_t first = at.pixel, count = std::min(chunk, film.pixels() - first);
            run.scene_kernel("trace_paths.cl", "trace_paths", {})
                .arg(buffer)
                .arg(run.ray_counters())
                .arg(static_cast<std::uint32_t>(first))
                .arg(static_cast<std::uint32_t>(count))
                .arg(at.sample)
                .arg(samples)
                .arg(run.edges_beyond_camera())
                .arg(run.seed())
                .run(group_count(count, run.device.pixel_group()), run.device.pixel_group());
            run.device.read(buffer, sums.data(), count * film.channels() * sizeof(float));
            film.add(sums, first, count, samples);
            run.collect_rays();
            done += static_cast<double>(count) * samples;
            at.pixel += count;
            run.report("path", done / total);
        }
        at.pixel = 0;
        at.sample += samples;
    }
    run.phase("path");
}

}  // namespace irradia
