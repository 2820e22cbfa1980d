// Where records are made: at the points that the iterations find without enough of them, between radiance records that
// disagree, and where shading found none.
#include <algorithm>
#include <array>
#include <iterator>
#include <span>
#include <unordered_set>

#include "irradia/Error.h"
#include "render/caching.h"
#include "render/iteration_order.h"

namespace irradia {
namespace {

// Pixels of iterations [first, end) of all blocks, in ascending order, to `pixels`.
void take_pixels(std::uint32_t first, std::uint32_t end, std::uint32_t width, std::uint32_t height, int threads,
                 PixelList& pixels) {
    std::array<std::vector<std::uint32_t>, block_edge> columns;  // of each row of a block
    for (std::uint32_t it = first; it < end; ++it) columns[block_pixel(it).y].push_back(block_pixel(it).x);
    std::array<std::size_t, block_edge> of_row{};  // of the picture
    for (std::size_t row = 0; row < block_edge; ++row) {
        std::sort(columns[row].begin(), columns[row].end());
        const auto in_part = std::lower_bound(columns[row].begin(), columns[row].end(), width % block_edge);
        of_row[row] = width / block_edge * columns[row].size() +
                      static_cast<std::size_t>(std::distance(columns[row].begin(), in_part));
    }
    std::vector<std::size_t> at(height + 1);
    for (std::uint32_t y = 0; y < height; ++y) at[y + 1] = at[y] + of_row[y % block_edge];
    pixels.resize(at[height]);
    in_ranges(threads, pixels.size(), [&](std::size_t, std::size_t begin, std::size_t stop) {  // rows that begin there
        for (std::size_t y = std::lower_bound(at.begin(), at.end(), begin) - at.begin(); y < height && at[y] < stop;
             ++y) {
            std::size_t to = at[y];
            for (std::uint32_t block = 0; block < width; block += block_edge)
                for (const std::uint32_t x : columns[y % block_edge])
                    if (block + x < width) pixels[to++] = static_cast<std::uint32_t>(y) * width + block + x;
        }
    });
}

// Tiles of `edge` x `edge` pixels that have had one of their pixels chosen.
class Tiles {
public:
    Tiles(std::uint32_t width, std::uint32_t edge) : width_(width), edge_(edge) {}
    /// Is this the first pixel of its tile?
    bool choose(std::uint32_t pixel) {
        const std::uint64_t x = pixel % width_ / edge_, y = pixel / width_ / edge_;
        return chosen_.insert(y << 32 | x).second;
    }

private:
    std::uint32_t width_, edge_;
    std::unordered_set<std::uint64_t> chosen_;
};

// Of the points that want a record those that get one at once: one of each tile, since a record often covers others,
// and at most `most`. All others that wanted one are left in `left`, if they were among it or `step`, both ascending.
RecordStack take(const PointList& points, std::uint32_t width, std::uint32_t tile, std::size_t most,
                 std::span<const std::uint32_t> step, PixelList& left) {
    RecordStack stack;
    PixelList later;
    Tiles tiles(width, tile);
    for (std::size_t i = 0; i < points.points().size(); ++i) {
        const std::uint32_t pixel = points.points()[i].pixel;
        if (!std::binary_search(left.begin(), left.end(), pixel) &&
            !std::binary_search(step.begin(), step.end(), pixel))
            continue;
        if (stack.size() < most && tiles.choose(pixel))
            stack.indices.push_back(points.index(i));
        else
            later.push_back(pixel);
    }
    left = std::move(later);
    return stack;
}

}  // namespace

// Once, before the first record is made or the first path asks. Where records were loaded that may be never.
void CachingRenderer::Caching::fill_grid() {
    if (grid_paths_ > 0) return;
    grid_paths_ = run_.settings.grid_paths;
    grid_.fill();
    run_.phase("grid");
}

// Stages 2 and 3 for points[indices]. `salt`: see HemisphereSampler.
void CachingRenderer::Caching::make_records(const Buffer& points, const RecordStack& stack, std::uint32_t salt) {
    if (stack.empty()) return;
    fill_grid();
    run_.device.upload_to(stack_, stack.indices);
    const std::uint32_t first = cache_.reserve(stack.size());
    hemispheres_->sample(points, stack_, stack.size(), grid_, cache_.keys(), cache_.values(), first, salt);
    cache_.insert(stack.size(), points, stack_);
}

void CachingRenderer::Caching::make_lobe_records(const Buffer& points, const RecordStack& stack, std::uint32_t salt) {
    if (stack.empty()) return;
    fill_grid();
    radiance_->make(points, stack, grid_, salt);
}

void CachingRenderer::Caching::place_records() {
    const std::uint32_t width = run_.scene.info.width, height = run_.scene.info.height;
    std::size_t most = 0;
    for (std::uint32_t it = 0; it < iteration_count; it = step_end(it))
        most = std::max<std::size_t>(most, step_end(it) - it);
    const std::size_t blocks = block_count(width, height), room = (most + 1) * blocks;
    PointList points(run_.device, room), lobe_points(run_.device, radiance_ ? room : 0);
    if (spares_pixels() && iteration_ == 0) plain_.forget();
    PixelList asked;  // this round
    asked.reserve(room);
    const auto left = [&] { return left_.size() + left_lobes_.size(); };
    while (iteration_ < iteration_count || left() > 0) {
        run_.rest();
        const bool rest = iteration_ == iteration_count;
        asked.clear();
        // Along with those left: a round of few would take threads and GPUs as long.
        if (!rest && left() <= blocks) {
            const std::uint32_t end = step_end(iteration_);
            take_pixels(iteration_, end, width, height, run_.device.host_threads(), asked);
            if (spares_pixels() && iteration_ >= lattice_iterations)
                plain_.drop(asked, 2e-6f * cache_.parameters(true).coordinate);
            iteration_ = end;
        }
        const std::uint32_t tile = rest ? rest_tile(left(), blocks) : step_tile(iteration_);
        if (!asked.empty() || left() > 0)
            place_round(asked, tile, points, lobe_points);  // small pictures lack iterations
        run_.report("records", records_share * iteration_ / iteration_count, record_count());
    }
}

// Looks at the pixels left and at those of a step, which are in `asked`, makes records at some of those that want one,
// and leaves the others.
void CachingRenderer::Caching::place_round(PixelList& asked, std::uint32_t tile, PointList& points,
                                           PointList& lobe_points) {
    const std::size_t of_step = asked.size();
    std::set_union(left_.begin(), left_.end(), left_lobes_.begin(), left_lobes_.end(), std::back_inserter(asked));
    const std::span<const std::uint32_t> step(asked.data(), of_step);
    run_.device.upload_to(asked_, asked);
    Kernel kernel = run_.scene_kernel("find_misses.cl", "find_misses", miss_defines());
    cache_.bind(kernel, true);
    if (radiance_) radiance_->bind(kernel, true).arg(lobe_points.emptied());
    kernel.arg(points.emptied())
        .arg(asked_)
        .arg(static_cast<std::uint32_t>(asked.size()))
        .arg(spares_pixels() ? plain_.words() : asked_)
        .arg(spares_pixels() && iteration_ <= lattice_iterations ? 1u : 0u)
        .run(group_count(asked.size(), run_.device.pixel_group()), run_.device.pixel_group());
    run_.statistics.rays["camera"] += asked.size();
    const std::uint32_t width = run_.scene.info.width;
    // No more at once than blocks: memory for radiance records' samples is by batch.
    const std::size_t most = block_count(width, run_.scene.info.height);
    points.read();
    if (spares_pixels() && iteration_ > sparse_iterations)
        for (const shared::ShadingPoint& q : points.points()) plain_.disturb(q.pixel);
    make_records(points.buffer(), take(points, width, tile, most, step, left_), salt(0));
    if (radiance_) {
        lobe_points.read();
        make_lobe_records(lobe_points.buffer(), take(lobe_points, width, tile, most, step, left_lobes_), salt(0));
    }
    ++run_.statistics.iterations;
}

// Radiance records that disagree about a pixel get others between them: one a round in a 4x4 tile.
void CachingRenderer::Caching::settle_disagreements() {
    if (!radiance_ || run_.settings.glossy_spread <= 0 || radiance_->records().size() == 0) return;
    PointList points(run_.device, chunk_);
    const std::size_t asked =
        (run_.scene.info.width + 1) / 2 * static_cast<std::size_t>((run_.scene.info.height + 1) / 2);
    while (settled_ < disagreement_rounds) {
        run_.rest();
        Missed missed;
        for (std::size_t first = 0; first < asked; first += chunk_) {
            const std::size_t count = std::min(chunk_, asked - first);
            Kernel kernel = run_.scene_kernel("find_disagreements.cl", "find_disagreements", cache_.defines());
            radiance_->bind(kernel, false)
                .arg(points.emptied())
                .arg(static_cast<std::uint32_t>(first))
                .arg(static_cast<std::uint32_t>(count))
                .run(group_count(count, run_.device.pixel_group()), run_.device.pixel_group());
            points.read();
            missed.insert(missed.end(), points.points().begin(), points.points().end());
        }
        Made made;
        const RecordStack stack = choose(missed, made);
        if (stack.empty()) return;
        make_lobe_records(run_.device.upload(missed), stack, salt(disagreement_salt + ++settled_));
        ++run_.statistics.iterations;
        run_.report("records", records_share, record_count());
    }
}

// Of the pixels of a 4x4 tile that miss a record one gets it a round, since that often covers the others; every
// round makes progress, so it ends.
RecordStack CachingRenderer::Caching::choose(const Missed& missed, Made& made) const {
    RecordStack stack;
    const std::uint32_t width = run_.scene.info.width;
    Tiles tiles(width, 4);
    for (std::uint32_t i = 0; i < missed.size(); ++i) {
        const shared::ShadingPoint& q = missed[i];
        if (!tiles.choose(q.pixel)) continue;
        stack.indices.push_back(i);
        if (!made.insert({q.pixel, q.px, q.py, q.pz}).second)
            throw Error("pixel " + std::to_string(q.pixel % width) + ", " + std::to_string(q.pixel / width) +
                        ": the record made there does not cover it (an error in the program: please report it)");
    }
    return stack;
}

}  // namespace irradia
