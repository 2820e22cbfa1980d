#include "render/irradiance_grid.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <vector>

#include "cache/buffer_state.h"

namespace irradia {
namespace {

constexpr std::uint32_t paths_a_launch_cpu = 1u << 14, paths_a_launch_gpu = 1u << 20;
constexpr float cells_a_diagonal = 256;  // finest cells; keys count to 509 along an axis
constexpr float shortest_ray = 2;        // cells
// Up to so many the grid answers behind diffuse surfaces at any distance (IR_GRID=2, cl/indirect.h). Pictures that want
// more are to have less error than that adds.
constexpr int paths_of_drafts = 1 << 17;
// Estimates in a cell that answers. Where only few paths are wanted, cells with fewer answer: else most rays would go
// on as paths, which costs more than it mends in pictures that coarse.
std::uint32_t least_estimates(int paths) { return std::clamp(static_cast<std::uint32_t>(paths) / 2048u, 4u, 16u); }

/// Irradiance of the order that the lights cause over the whole scene, W·m⁻²: sums count in small parts of it.
double typical_irradiance(const Scene& scene) {
    constexpr double pi = 3.14159265358979323846;
    const double square = static_cast<double>(scene.info.diagonal) * static_cast<double>(scene.info.diagonal);
    double sum = 0;
    for (const shared::Light& l : scene.lights) {
        const double colour = std::max({l.r, l.g, l.b});
        if (l.kind == IR_LIGHT_POINT || l.kind == IR_LIGHT_SPOT)
            sum += colour * 4 * pi / square;
        else if (l.kind == IR_LIGHT_DIRECTIONAL)
            sum += colour;
        else if (l.kind == IR_LIGHT_CONSTANT || l.kind == IR_LIGHT_ENVMAP)
            sum += colour * pi;
        else
            sum += colour * pi * std::min(static_cast<double>(l.area) / square, 1.0);
    }
    return sum;
}

}  // namespace

IrradianceGrid::IrradianceGrid(Run& run)
    : run_(run),
      cells_(run.device.allocate(sizeof(shared::GridCell))),
      overflow_(run.device.allocate(sizeof(std::uint32_t))) {
    const shared::SceneInfo& info = run.scene.info;
    parameters_.origin_x = info.min_x;
    parameters_.origin_y = info.min_y;
    parameters_.origin_z = info.min_z;
    parameters_.cell = info.diagonal / cells_a_diagonal;
    parameters_.unit = std::max(static_cast<float>(typical_irradiance(run.scene) * 0x1p-20), 1e-30f);
    parameters_.shortest = shortest_ray;
    parameters_.edges = run.edges_beyond_hemisphere();
    parameters_.slots = 1;
    run.device.fill(cells_, 0, sizeof(shared::GridCell));  // without a key: it knows nothing
}

void IrradianceGrid::fill() {
    announce();
    if (!on_) return;
    // A path leaves up to 8 estimates; few paths leave most of them in cells of their own, many mostly in cells that
    // others have been to. A full table is filled anew, larger, which costs more than one too large by half.
    const auto paths = static_cast<std::size_t>(run_.settings.grid_paths);
    const std::size_t slots_a_path = paths <= 1u << 15 ? 8 : paths <= 1u << 17 ? 4 : 2;
    std::size_t slots = std::bit_ceil(std::clamp<std::size_t>(paths, 1u << 10, 1u << 20)) * slots_a_path;
    const shared::GridParameters before = parameters_;
    try {
        while (!try_fill(slots)) slots *= 2;
    } catch (...) {  // the old cells are still there
        parameters_ = before;
        throw;
    }
}

// Where nothing but direct light is wanted behind a hemisphere's rays it has nothing to say.
bool IrradianceGrid::wanted() const { return run_.settings.grid && run_.edges_beyond_hemisphere() >= 2; }

void IrradianceGrid::announce() { on_ = wanted(); }

bool IrradianceGrid::try_fill(std::size_t slots) {
    const auto paths = static_cast<std::uint32_t>(run_.settings.grid_paths);
    const std::size_t group = run_.device.pixel_group();
    parameters_.slots = static_cast<std::uint32_t>(slots);
    parameters_.least = least_estimates(run_.settings.grid_paths);
    Buffer sums = run_.device.allocate(slots * sizeof(shared::GridSum));
    run_.device.fill(sums, 0, slots * sizeof(shared::GridSum));
    run_.device.fill(overflow_, 0, sizeof(std::uint32_t));
    Buffer taken = run_.device.allocate((slots + 1) * sizeof(std::uint32_t));
    run_.device.fill(taken, 0, sizeof(std::uint32_t));
    const auto first_word = [&](const Buffer& buffer) {
        std::uint32_t word = 0;
        run_.device.read(buffer, &word, sizeof word);
        return word;
    };
    const auto full = [&] { return first_word(overflow_) != 0; };
    const std::uint32_t launch = run_.device.cpu_traversal() ? paths_a_launch_cpu : paths_a_launch_gpu;
    for (std::uint32_t first = 0; first < paths; first += launch) {
        const std::uint32_t count = std::min(launch, paths - first);
        run_.scene_kernel("fill_grid.cl", "trace_grid_paths", {})
            .arg(sums)
            .arg(parameters_)
            .arg(taken)
            .arg(overflow_)
            .arg(run_.ray_counters())
            .arg(first)
            .arg(count)
            .arg(paths)
            .arg(run_.seed())
            .run(group_count(count, group), group);
        run_.collect_rays();
        if (full()) return false;
        run_.report("grid", 0);
    }
    const std::size_t cell_group = run_.device.group_size();
    Buffer answers = run_.device.allocate(sizeof(std::uint32_t));
    run_.device.fill(answers, 0, sizeof(std::uint32_t));
    std::uint32_t cells = 0;  // whose levels are merged
    for (std::uint32_t level = 0; level + 1 < IR_GRID_LEVELS; ++level) {
        const std::uint32_t end = first_word(taken);
        if (end == cells) break;  // of a scene in which no path leaves anything
        run_.device.kernel("merge_grid.cl", "merge_grid_level", {})
            .arg(sums)
            .arg(parameters_)
            .arg(taken)
            .arg(overflow_)
            .arg(answers)
            .arg(cells)
            .arg(end - cells)
            .run(group_count(end - cells, cell_group), cell_group);
        cells = end;
    }
    if (full()) return false;
    const std::uint32_t all = first_word(taken);
    make_cells(sums, taken, all, first_word(answers) + (all - cells));  // nearly all of the last level answer
    return !full();
}

void IrradianceGrid::make_cells(const Buffer& sums, const Buffer& taken, std::uint32_t cells, std::uint32_t answers) {
    const std::size_t group = run_.device.group_size(), groups = group_count(std::max(cells, 1u), group);
    const std::uint32_t slots = std::bit_ceil(std::max(2 * answers, 64u));
    cells_ = run_.device.allocate(slots * sizeof(shared::GridCell));
    run_.device.fill(cells_, 0, slots * sizeof(shared::GridCell));
    run_.device.kernel("merge_grid.cl", "grid_means", {})
        .arg(sums)
        .arg(cells_)
        .arg(parameters_)
        .arg(taken)
        .arg(overflow_)
        .arg(slots)
        .arg(cells)
        .run(groups, group);
    parameters_.slots = slots;
}

void IrradianceGrid::state(Checkpoint& c) {
    c(parameters_)(on_);
    exchange(c, run_.device, cells_, parameters_.slots * sizeof(shared::GridCell));
}

std::map<std::string, std::string> IrradianceGrid::defines() const { return defines(on_); }

std::map<std::string, std::string> IrradianceGrid::defines_to_come() const { return defines(wanted()); }

std::map<std::string, std::string> IrradianceGrid::defines(bool on) const {
    const char* const asked = run_.settings.grid_paths <= paths_of_drafts ? "2" : "1";
    return {{"IR_GRID", on ? asked : "0"}};
}

Kernel& IrradianceGrid::bind(Kernel& kernel) const { return kernel.arg(cells_).arg(parameters_); }

}  // namespace irradia
