#include "render/hemispheres.h"

#include <sys/resource.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "irradia/Error.h"

#include "cl/portable.h"
namespace irradia::host {
#include "cl/sampling.h"
}

namespace irradia {
namespace {
// The Hessian rule's support is accuracy (unit_tau area E / |lambda|)^(1/4): with this factor the same `accuracy` gives
// about as many records as the distance rules do, and their number grows as 1/accuracy² in both.
constexpr float unit_tau = 1000.0f;
constexpr float largest_aspect = 3.0f;                        // theory 6: 2-3 is a fair compromise
constexpr std::size_t largest_cells = std::size_t{64} << 20;  // bytes of one hemisphere
constexpr std::size_t cells_memory = std::size_t{256} << 20;  // bytes of those that run at once, in global memory
// Four and three groups at once on NVIDIA's multiprocessors of 65536 registers. Measured on an H100, of 64, 80, 96,
// 128: without the grid 1.58, 1.45, 1.16, 1.15 G rays/s in a room of 60 k triangles, with it .88, .88, .70, .75.
constexpr int registers(bool grid) { return grid ? 80 : 64; }
// A CPU's core runs the work-items of a group one after the other: there one does it all (cl/group.h).
std::size_t group_size(const Device& device) { return device.cpu_traversal() ? 1 : device.group_size(); }
/// Bytes that a hemisphere may take of the stack that it lies on there, which is as large as the system's limit says.
std::size_t stack_room() {
    constexpr std::size_t most = std::size_t{1} << 20;
    rlimit limit{};
    if (::getrlimit(RLIMIT_STACK, &limit) != 0 || limit.rlim_cur == RLIM_INFINITY) return most;
    return std::min<std::size_t>(most, limit.rlim_cur / 2);
}
constexpr std::size_t floats_a_cell = 9, floats_a_sum = 23;  // cl/sample_hemispheres.cl, cl/make_record.h
}  // namespace

float neighbour_clamp_slope(const RenderSettings& settings) {
    if (!settings.neighbour_clamp) return 0;
    return settings.overlap * (settings.radius == RadiusRule::hessian ? 1.0f : settings.accuracy);
}

HemisphereSampler::HemisphereSampler(Run& run, Hemispheres purpose) : run_(run) {
    const RenderSettings& settings = run.settings;
    const auto m = static_cast<std::size_t>(settings.hemisphere_m), n = static_cast<std::size_t>(settings.hemisphere_n);
    if (settings.hemisphere_m < 1 || settings.hemisphere_n < 3)
        throw Error("--hemisphere " + std::to_string(m) + "x" + std::to_string(n) +
                    ": expected at least 1 ring and 3 sectors");
    const std::size_t group = group_size(run.device);
    cell_bytes_ = sizeof(float) * floats_a_cell * m * n;
    if (cell_bytes_ > largest_cells)
        throw Error("--hemisphere " + std::to_string(m) + "x" + std::to_string(n) + ": " + std::to_string(m * n) +
                    " directions, expected at most " + std::to_string(largest_cells / sizeof(float) / floats_a_cell));
    // GPUs have 48 KiB of local memory: 1203 directions. CPU devices call a core's cache that.
    const std::size_t words = group + 1 + (run.device.cpu_traversal() ? 0 : m * n);  // partial sums; paths put off
    const std::size_t local = run.device.description().local_memory;
    global_cells_ = std::max(cell_bytes_, sizeof(float) * floats_a_sum * group) + sizeof(float) * words >
                    (group == 1 ? std::min(local, stack_room()) : local);
    cells_ = run.device.allocate(global_cells_ ? std::max(cell_bytes_, cells_memory) : 0);
    const bool radiance = purpose == Hemispheres::radiance_records;
    const int gradient = purpose == Hemispheres::irradiance ? 0 : static_cast<int>(settings.gradients);
    // How far radiance may be carried follows from how far what it shows is away, not from how irradiance changes.
    const int radius = purpose == Hemispheres::irradiance_records ? static_cast<int>(settings.radius) : 0;
    defines_ = {{"IR_M", std::to_string(m)},
                {"IR_N", std::to_string(n)},
                {"IR_GROUP", std::to_string(group)},
                {"IR_GRADIENT", std::to_string(gradient)},
                {"IR_RADIUS", std::to_string(radius)},
                {"IR_GLOBAL_CELLS", global_cells_ ? "1" : "0"},
                {"IR_DIRECT_MIS", run.direct_mis() ? "1" : "0"},
                {"IR_GRADIENT_LIMIT", settings.gradient_limit && gradient != 0 && !radiance ? "1" : "0"},
                {"IR_RADIANCE", radiance ? "1" : "0"}};
    const float a = radiance ? settings.glossy_accuracy : settings.accuracy, diagonal = run.scene.info.diagonal;
    parameters_.accuracy = a;
    parameters_.tau = unit_tau * 0.78539816f * a * a * a * a;
    parameters_.min_spacing = settings.min_spacing;
    parameters_.max_spacing = settings.max_spacing;
    parameters_.aspect = largest_aspect;
    parameters_.r_min = 1e-6f * diagonal;
    parameters_.r_max = 10.0f * diagonal;
    parameters_.overlap = settings.overlap;
    parameters_.firefly = settings.firefly;
    parameters_.reach = settings.reach_limit ? 1.0f : 0.0f;
    parameters_.diagonal = diagonal;
    std::vector<float> weights;
    for (std::uint32_t j = 0; j < m; ++j)
        weights.push_back(static_cast<float>(host::ring_rotation_weight(j, static_cast<std::uint32_t>(m))));
    ring_weights_ = run.device.upload(weights);
}

KernelSource HemisphereSampler::kernel_to_come(const IrradianceGrid& grid) const {
    std::map<std::string, std::string> defines = grid.defines_to_come();
    defines.insert(defines_.begin(), defines_.end());
    KernelSource source = run_.scene_source("sample_hemispheres.cl", std::move(defines));
    source.registers = registers(grid.wanted());
    return source;
}

void HemisphereSampler::sample(const Buffer& points, const Buffer& stack, std::size_t count, const IrradianceGrid& grid,
                               const Buffer& keys, const Buffer& values, std::uint32_t first_record, std::uint32_t salt,
                               const KeptSamples* kept) {
    std::map<std::string, std::string> defines = grid.defines();
    defines.insert(defines_.begin(), defines_.end());
    const std::size_t batch = global_cells_ ? cells_.bytes() / cell_bytes_ : std::max<std::size_t>(count, 1);
    for (std::size_t first = 0; first < count; first += batch) {
        Kernel kernel =
            run_.scene_kernel("sample_hemispheres.cl", "sample_hemispheres", defines, registers(grid.used()));
        kernel.arg(points).arg(stack).arg(ring_weights_).arg(keys).arg(values).arg(run_.ray_counters());
        grid.bind(kernel).arg(parameters_).arg(cells_);
        if (kept != nullptr) kernel.arg(*kept->samples).arg(kept->stride).arg(kept->first);
        kernel.arg(static_cast<std::uint32_t>(first))
            .arg(first_record)
            .arg(salt)
            .arg(run_.edges_beyond_hemisphere())
            .arg(run_.seed())
            .run(std::min(batch, count - first), group_size(run_.device));
    }
    run_.collect_rays();
}

}  // namespace irradia
