#include "render/sky_view.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <numbers>
#include <numeric>
#include <unordered_map>

#include "irradia/shared/sky_types.h"

#include "cl/portable.h"
namespace irradia::host {
#include "cl/grid_parent.h"
#include "cl/random.h"
#include "cl/sky_tiles.h"
}  // namespace irradia::host

namespace irradia {
namespace {

using host::tile_begin;

constexpr float cells_across = 32;  // finest cells along the scene's longest side
// One path for so many samples of the picture: a twentieth of the time.
constexpr std::size_t samples_a_path = 8, most_paths = std::size_t{1} << 20;
// Before, so many are asked whether there is anything to learn: where more than half of the directions from what the
// camera sees are open, other samples are hardly better, and the paths are time lost.
constexpr std::size_t first_paths = 4096;
constexpr double open_sky = 0.5;
constexpr std::size_t paths_a_launch = std::size_t{1} << 17;
constexpr std::uint32_t least_known = 16;  // paths that left from a cell that is entered, but for the coarsest
// What the cell around has seen counts as much as so many paths: tiles that few have met keep a probability.
constexpr double of_parent = 16;

using Tiles = std::array<std::uint32_t, IR_SKY_TILES>;
using Shares = std::array<double, IR_SKY_TILES>;

std::uint32_t total(const Tiles& tiles) { return std::accumulate(tiles.begin(), tiles.end(), 0u); }

/// How many paths left through each tile, of every cell of a level by its key, in the order in which cells were met
/// first.
class Seen {
public:
    Tiles& operator[](std::uint32_t key) {
        const auto [place, fresh] = places_.try_emplace(key, keys_.size());
        if (fresh) {
            keys_.push_back(key);
            tiles_.emplace_back();
        }
        return tiles_[place->second];
    }
    [[nodiscard]] const Tiles& of(std::uint32_t key) const { return tiles_[places_.at(key)]; }
    [[nodiscard]] const std::vector<std::uint32_t>& keys() const { return keys_; }

private:
    std::unordered_map<std::uint32_t, std::size_t> places_;
    std::vector<std::uint32_t> keys_;
    std::vector<Tiles> tiles_;
};
using Levels = std::array<Seen, IR_GRID_LEVELS>;

Levels levels_of(const std::vector<std::uint32_t>& events) {
    Levels levels;
    for (std::size_t i = 0; i < events.size(); i += IR_SKY_EVENT_WORDS)
        if (events[i] != 0) ++levels[0][events[i]][events[i + 1]];
    for (std::size_t level = 1; level < levels.size(); ++level)
        for (const std::uint32_t key : levels[level - 1].keys()) {
            const Tiles& seen = levels[level - 1].of(key);
            Tiles& around = levels[level][host::grid_parent(key)];
            for (std::size_t t = 0; t < seen.size(); ++t) around[t] += seen[t];
        }
    return levels;
}

std::uint32_t word(float x) { return std::bit_cast<std::uint32_t>(x); }

const shared::Light& sky_of(const Scene& scene) { return scene.lights[scene.info.environment_light]; }

const shared::Texture& picture_of(const Scene& scene) {
    return scene.textures[static_cast<std::size_t>(sky_of(scene).texture)];
}

/// The picture in tiles: the running sums that kernels search, and each tile's mean luminance, up to a common factor.
struct Picture {
    std::vector<float> bands;
    Shares mean{}, angle{};  // angle: the tile's share of all directions

    explicit Picture(const Scene& scene) {
        const std::uint32_t table = sky_of(scene).table;
        const std::uint32_t width = picture_of(scene).width, rows = picture_of(scene).height - 1;
        const auto sum = [&](std::size_t first, std::size_t i) {  // of those before the i-th
            return i == 0 ? 0.0 : static_cast<double>(std::bit_cast<float>(scene.texels[first + i - 1]));
        };
        bands.reserve(std::size_t{IR_SKY_COLUMNS} * rows);
        for (std::uint32_t j = 0; j < IR_SKY_COLUMNS; ++j) {
            const std::uint32_t begin = tile_begin(j, IR_SKY_COLUMNS, width),
                                end = tile_begin(j + 1, IR_SKY_COLUMNS, width);
            double running = 0;
            for (std::uint32_t row = 0; row < rows; ++row) {
                const std::size_t cells = host::cell_sums(table, width, rows, row);
                running += (sum(table, row + 1) - sum(table, row)) * (sum(cells, end) - sum(cells, begin));
                bands.push_back(static_cast<float>(running));
            }
            const float* const band = bands.data() + std::size_t{j} * rows;
            for (std::uint32_t i = 0; i < IR_SKY_ROWS; ++i) {
                const std::uint32_t top = tile_begin(i, IR_SKY_ROWS, rows),
                                    bottom = tile_begin(i + 1, IR_SKY_ROWS, rows);
                // As kernels take the difference: what is 0 to them is not to be chosen.
                const float flux = band[bottom - 1] - (top > 0 ? band[top - 1] : 0.0f);
                const double height =
                    std::cos(std::numbers::pi * top / rows) - std::cos(std::numbers::pi * bottom / rows);
                const std::size_t t = std::size_t{i} * IR_SKY_COLUMNS + j;
                angle[t] = 0.5 * height * (end - begin) / width;
                mean[t] = static_cast<double>(flux) / angle[t];
            }
        }
    }
};

/// The share of paths from a cell that leave through each tile: of those that did, and of what is seen around it.
Shares shares_of(const Levels& levels, const Picture& picture, std::size_t level, std::uint32_t key) {
    const Tiles& seen = levels[level].of(key);
    const Shares around =
        level + 1 < levels.size() ? shares_of(levels, picture, level + 1, host::grid_parent(key)) : picture.angle;
    const double scale = 1.0 / (total(seen) + of_parent);
    Shares shares;
    for (std::size_t t = 0; t < shares.size(); ++t) shares[t] = scale * (seen[t] + of_parent * around[t]);
    return shares;
}

/// Appends the running sums of the tiles' probabilities: paths that leave through a tile, times its mean luminance, are
/// what it brings. False if all of them are dark.
bool append_tiles(std::vector<std::uint32_t>& words, const Picture& picture, const Shares& shares) {
    Shares sums;
    double running = 0;
    for (std::size_t t = 0; t < sums.size(); ++t) sums[t] = running += picture.mean[t] * shares[t];
    if (!(running > 0)) return false;
    for (const double sum : sums) words.push_back(word(static_cast<float>(sum / running)));
    return true;
}

}  // namespace

bool learns_sky(const Run& run) {
    const Scene& scene = run.scene;
    return run.settings.learn_sky && scene.info.environment_light != IR_NO_LIGHT &&
           sky_of(scene).kind == IR_LIGHT_ENVMAP && picture_of(scene).width >= IR_SKY_COLUMNS &&
           picture_of(scene).height > IR_SKY_ROWS;
}

shared::GridParameters sky_cells(const Scene& scene) {
    const shared::SceneInfo& info = scene.info;
    shared::GridParameters grid{};
    grid.origin_x = info.min_x, grid.origin_y = info.min_y, grid.origin_z = info.min_z;
    grid.cell =
        std::max({info.max_x - info.min_x, info.max_y - info.min_y, info.max_z - info.min_z, 1e-30f}) / cells_across;
    return grid;
}

std::vector<std::uint32_t> sky_tables(const Scene& scene, const std::vector<std::uint32_t>& events, std::size_t first) {
    const Levels levels = levels_of(events);
    const Picture picture(scene);
    const shared::GridParameters grid = sky_cells(scene);
    std::size_t cells = 0;
    for (const Seen& level : levels) cells += level.keys().size();
    const std::size_t slots = std::bit_ceil(2 * cells + 2);
    std::vector<std::uint32_t> words{word(grid.origin_x), word(grid.origin_y), word(grid.origin_z), word(grid.cell),
                                     static_cast<std::uint32_t>(slots)};
    words.resize(IR_SKY_HEADER);
    for (const float x : picture.bands) words.push_back(word(x));
    const std::size_t table = words.size();
    words.resize(table + 2 * slots);
    for (std::size_t level = 0; level < levels.size(); ++level)
        for (const std::uint32_t key : levels[level].keys()) {
            if (level + 1 < levels.size() && total(levels[level].of(key)) < least_known) continue;
            const std::size_t place = words.size();
            if (!append_tiles(words, picture, shares_of(levels, picture, level, key))) continue;
            std::size_t slot = host::hash_slot(key, static_cast<std::uint32_t>(slots));
            while (words[table + 2 * slot] != 0) slot = (slot + 1) & (slots - 1);
            words[table + 2 * slot] = key;
            words[table + 2 * slot + 1] = static_cast<std::uint32_t>(first + place);
        }
    return words;
}

namespace {

/// What `paths` paths tell, IR_SKY_EVENT_WORDS each.
std::vector<std::uint32_t> events_of(Run& run, std::size_t paths) {
    std::vector<std::uint32_t> events(IR_SKY_EVENT_WORDS * paths);
    const auto bytes = [](std::size_t count) { return IR_SKY_EVENT_WORDS * count * sizeof(std::uint32_t); };
    const Buffer buffer = run.device.allocate(bytes(std::min(paths, paths_a_launch)));
    const std::size_t group = run.device.pixel_group();
    for (std::size_t first = 0; first < paths; first += paths_a_launch) {
        const std::size_t count = std::min(paths_a_launch, paths - first);
        run.scene_kernel("learn_sky.cl", "learn_sky", {})
            .arg(sky_cells(run.scene))
            .arg(buffer)
            .arg(run.ray_counters())
            .arg(static_cast<std::uint32_t>(first))
            .arg(static_cast<std::uint32_t>(count))
            .arg(static_cast<std::uint32_t>(paths))
            .arg(run.seed())
            .run(group_count(count, group), group);
        run.collect_rays();
        run.device.read(buffer, events.data() + IR_SKY_EVENT_WORDS * first, bytes(count));
    }
    return events;
}

/// Of the paths that have met a surface the share that left from there.
double openness(const std::vector<std::uint32_t>& events) {
    double met = 0, left = 0;
    for (std::size_t i = 0; i < events.size(); i += IR_SKY_EVENT_WORDS) {
        met += events[i + 2] > 0 ? 1 : 0;
        left += events[i + 2] == 1 && events[i] != 0 ? 1 : 0;
    }
    return met > 0 ? left / met : 1;
}

}  // namespace

void learn_sky(Run& run, std::uint32_t spp, bool counted) {
    if (!learns_sky(run)) return;
    const std::size_t samples = std::size_t{run.scene.info.width} * run.scene.info.height * spp;
    const std::size_t paths = std::clamp<std::size_t>(samples / samples_a_path, 1, most_paths);
    const auto rays = run.statistics.rays;
    std::vector<std::uint32_t> events = events_of(run, std::min(paths, first_paths));
    if (openness(events) > open_sky)
        events.clear();
    else if (paths > first_paths)
        events = events_of(run, paths);
    if (!counted) run.statistics.rays = rays;
    run.see_sky(events.empty() ? events : sky_tables(run.scene, events, run.scene.texels.size()));
    run.phase("sky");
}

}  // namespace irradia
