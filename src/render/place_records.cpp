// Where records are made: at the points that the iterations find without enough of them, between radiance records that
// disagree, and where shading found none.
#include <algorithm>
#include <unordered_set>

#include "irradia/Error.h"
#include "render/caching.h"
#include "render/iteration_order.h"

namespace irradia {
namespace {

// The points of an array that want a record.
RecordStack wanting(const std::vector<shared::ShadingPoint>& points) {
    RecordStack stack;
    for (std::uint32_t i = 0; i < points.size(); ++i)
        if (points[i].state != IR_POINT_NONE) stack.indices.push_back(i);
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
    const Buffer indices = run_.device.upload(stack.indices);
    const std::uint32_t first = cache_.reserve(stack.size());
    hemispheres_->sample(points, indices, stack.size(), grid_, cache_.keys(), cache_.values(), first, salt);
    cache_.insert(stack.size(), points, indices);
}

void CachingRenderer::Caching::make_lobe_records(const Buffer& points, const RecordStack& stack, std::uint32_t salt) {
    if (stack.empty()) return;
    fill_grid();
    radiance_->make(points, stack, grid_, salt);
}

void CachingRenderer::Caching::place_records() {
    const std::uint32_t blocks_x = (run_.scene.info.width + block_edge - 1) / block_edge;
    const std::uint32_t blocks_y = (run_.scene.info.height + block_edge - 1) / block_edge;
    const std::size_t blocks = static_cast<std::size_t>(blocks_x) * blocks_y;
    Buffer points = run_.device.allocate(blocks * sizeof(shared::ShadingPoint));
    Buffer lobe_points = run_.device.allocate(blocks * sizeof(shared::ShadingPoint));
    std::vector<shared::ShadingPoint> host(blocks);
    const std::map<std::string, std::string> defines = miss_defines();
    for (; iteration_ < iteration_count; ++iteration_) {
        run_.rest();
        const BlockPixel pixel = block_pixel(iteration_);
        Kernel kernel = run_.scene_kernel("find_misses.cl", "find_misses", defines);
        cache_.bind(kernel, true);
        if (radiance_) radiance_->bind(kernel, true).arg(lobe_points);
        kernel.arg(points)
            .arg(pixel.x)
            .arg(pixel.y)
            .arg(blocks_x)
            .arg(static_cast<std::uint32_t>(blocks))
            .run(group_count(blocks, run_.device.pixel_group()), run_.device.pixel_group());
        run_.device.read(points, host.data(), blocks * sizeof host[0]);
        run_.statistics.rays["camera"] += blocks;
        make_records(points, wanting(host), salt(0));
        if (radiance_) {
            run_.device.read(lobe_points, host.data(), blocks * sizeof host[0]);
            make_lobe_records(lobe_points, wanting(host), salt(0));
        }
        ++run_.statistics.iterations;
        run_.report("records", records_share * (iteration_ + 1) / iteration_count, record_count());
    }
}

// Radiance records that disagree about a pixel get others between them: one a round in a 4x4 tile.
void CachingRenderer::Caching::settle_disagreements() {
    if (!radiance_ || run_.settings.glossy_spread <= 0 || radiance_->records().size() == 0) return;
    Buffer points = run_.device.allocate(chunk_ * sizeof(shared::ShadingPoint));
    std::vector<shared::ShadingPoint> host(chunk_);
    const std::size_t asked =
        (run_.scene.info.width + 1) / 2 * static_cast<std::size_t>((run_.scene.info.height + 1) / 2);
    while (settled_ < disagreement_rounds) {
        run_.rest();
        Missed missed;
        for (std::size_t first = 0; first < asked; first += chunk_) {
            const std::size_t count = std::min(chunk_, asked - first);
            Kernel kernel = run_.scene_kernel("find_disagreements.cl", "find_disagreements", cache_.defines());
            radiance_->bind(kernel, false)
                .arg(points)
                .arg(static_cast<std::uint32_t>(first))
                .arg(static_cast<std::uint32_t>(count))
                .run(group_count(count, run_.device.pixel_group()), run_.device.pixel_group());
            run_.device.read(points, host.data(), count * sizeof host[0]);
            for (std::size_t i = 0; i < count; ++i)
                if (host[i].state != IR_POINT_NONE) {
                    missed.pixels.push_back(host[i].pixel);
                    missed.points.push_back(host[i]);
                }
        }
        Made made;
        const RecordStack stack = choose(missed, made);
        if (stack.empty()) return;
        make_lobe_records(run_.device.upload(missed.points), stack, salt(disagreement_salt + ++settled_));
        ++run_.statistics.iterations;
        run_.report("records", records_share, record_count());
    }
}

// Of the pixels of a 4x4 tile that miss a record one gets it a round, since that often covers the others; every
// round makes progress, so it ends.
RecordStack CachingRenderer::Caching::choose(const Missed& missed, Made& made) const {
    RecordStack stack;
    std::unordered_set<std::uint64_t> tiles;
    for (std::uint32_t i = 0; i < missed.pixels.size(); ++i) {
        const shared::ShadingPoint& q = missed.points[i];
        const std::uint32_t x = missed.pixels[i] % run_.scene.info.width, y = missed.pixels[i] / run_.scene.info.width;
        if (!tiles.insert((static_cast<std::uint64_t>(y / 4) << 32) | (x / 4)).second) continue;
        stack.indices.push_back(i);
        if (!made.insert({q.pixel, q.px, q.py, q.pz}).second)
            throw Error("pixel " + std::to_string(x) + ", " + std::to_string(y) +
                        ": the record made there does not cover it (an error in the program: please report it)");
    }
    return stack;
}

}  // namespace irradia
