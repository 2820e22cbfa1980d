// Stage 4 and its rounds: pixels take the samples that the schedule wants, and where one finds no record the pixel gets
// one and is shaded anew.
#include <algorithm>

#include "core/in_ranges.h"
#include "render/caching.h"
#include "render/carried_records.h"
#include "render/shared_order.h"

namespace irradia {
namespace {

constexpr std::uint32_t samples_a_launch = 256;  // float32 sums of a pixel; the host adds launches in double

// A GPU with fewer work-items than this has idle ones, and waits for the one that takes longest. So several share a
// pixel's samples, but not fewer than so many each, which share look-ups.
constexpr std::size_t items_of_gpus = std::size_t{1} << 17;
constexpr std::uint32_t least_share = 8;

std::uint32_t share_of(std::uint32_t samples, std::size_t pixels) {
    const auto shares = static_cast<std::uint32_t>(std::max<std::size_t>(items_of_gpus / pixels, 1));
    return std::min(samples, std::max(least_share, (samples + shares - 1) / shares));
}

// Adds what later shares of the samples of `count` sums have come to, to those of the first.
void add_shares(std::span<float> sums, std::size_t count, int threads) {
    if (sums.size() == count) return;
    in_ranges(threads, count, [&](std::size_t, std::size_t begin, std::size_t end) {
        for (std::size_t share = count; share < sums.size(); share += count)
            for (std::size_t i = begin; i < end; ++i) sums[i] += sums[share + i];
    });
}

// The pixels of this view at which records were made.
void add_pixels(const RecordCache& cache, std::size_t first, std::vector<std::uint32_t>& pixels) {
    const std::vector<shared::RecordValue> values = cache.download_values();
    for (std::size_t i = first; i < values.size(); ++i) pixels.push_back(values[i].pixel);
}

void add_octree(RenderStatistics& s, const RecordCache& cache) {
    s.octree_nodes += cache.octree().nodes;
    s.octree_entries += cache.octree().entries;
    s.octree_depth = std::max(s.octree_depth, cache.octree().depth);
    s.octree_growths += cache.octree().growths;
}

// Adds the points that a launch has found to `missed`; of a pixel that an earlier launch of the same pixels (from
// missed[first] on) has found, that first one counts, and one of those that the shares of its samples have found.
void add_missed(PointList& points, std::size_t first, std::vector<shared::ShadingPoint>& missed) {
    const auto by_pixel = [](const shared::ShadingPoint& a, const shared::ShadingPoint& b) {
        return a.pixel < b.pixel;
    };
    points.read();
    const std::size_t known = missed.size();
    const auto at = [&](std::size_t i) { return missed.begin() + static_cast<std::ptrdiff_t>(i); };
    for (const shared::ShadingPoint& q : points.points())
        if ((missed.size() == known || missed.back().pixel != q.pixel) &&
            !std::binary_search(at(first), at(known), q, by_pixel))
            missed.push_back(q);
    std::inplace_merge(at(first), at(known), missed.end(), by_pixel);
}

}  // namespace

// Whatever the schedule wants; the pixels of records made since `before_`.
std::vector<std::uint32_t> CachingRenderer::Caching::shade(Film& film) {
    for (;; schedule_->advance(film)) {
        if (!sweep_) {
            if (schedule_->pixels().empty()) break;
            start_pass(copied(run_.device.host_threads(), std::span(schedule_->pixels())), schedule_->first(),
                       schedule_->end(), false, schedule_->halves());
        }
        shade_pass(film);
    }
    run_.phase("shade");
    if (stage_ != Stage::finished) {
        ++views_;
        const RecordView view = view_of(run_, radiance_.has_value());
        if (!contains(known_, view)) known_.push_back(view);
        stage_ = Stage::finished;
    }
    RenderStatistics& s = run_.statistics;
    s.records = cache_.size();
    s.octree_nodes = s.octree_entries = 0;
    add_octree(s, cache_);
    std::vector<std::uint32_t> pixels;
    add_pixels(cache_, before_.records, pixels);
    if (radiance_) {
        const RecordCache& records = radiance_->records();
        s.radiance_records = records.size();
        s.radiance_record_bytes = radiance_->record_bytes();
        add_octree(s, records);
        add_pixels(records, before_.lobes, pixels);
    }
    return pixels;
}

void CachingRenderer::Caching::start_pass(PixelList pixels, std::uint32_t first, std::uint32_t end, bool known,
                                          bool halves) {
    sweep_.emplace();
    sweep_->pixels = std::move(pixels);
    sweep_->begin = sweep_->sample = first;
    sweep_->end = end;
    sweep_->known = known;
    sweep_->halves = halves;
    made_.clear();
    made_lobes_.clear();
}

// One pass, in one sweep or several. A pixel that misses a record gets it and is shaded anew, from its first sample on.
void CachingRenderer::Caching::shade_pass(Film& film) {
    while (!sweep_->pixels.empty()) {
        sweep(film);
        const Missed &missed = sweep_->missed, &missed_lobes = sweep_->missed_lobes;
        const RecordStack stack = choose(missed, made_), lobe_stack = choose(missed_lobes, made_lobes_);
        if (!stack.empty()) make_records(run_.device.upload(missed), stack, salt(round_));
        if (!lobe_stack.empty()) make_lobe_records(run_.device.upload(missed_lobes), lobe_stack, salt(round_));
        if (!stack.empty() || !lobe_stack.empty()) {
            ++run_.statistics.iterations;
            ++round_;
        }
        PixelList pixels;
        for (const Missed* const m : {&missed, &missed_lobes})
            for (const shared::ShadingPoint& q : *m) pixels.push_back(q.pixel);
        std::sort(pixels.begin(), pixels.end());
        pixels.erase(std::unique(pixels.begin(), pixels.end()), pixels.end());
        for (const std::uint32_t pixel : pixels) sweep_->known != 0 ? film.clear_indirect(pixel) : film.clear(pixel);
        Sweep next;
        next.pixels = std::move(pixels);
        next.end = sweep_->end;
        next.known = sweep_->known;
        next.halves = sweep_->halves;
        sweep_ = std::move(next);
    }
    sweep_.reset();
}

// Adds the sweep's samples to the film.
void CachingRenderer::Caching::sweep(Film& film) {
    Sweep& s = *sweep_;
    const bool requests = round_ < record_rounds;
    // On diffuse surfaces only what finds no record goes on as a path.
    if (run_.edges_beyond_camera() >= 2 && (!requests || (run_.scene.features & IR_FEATURE_BSDFS))) fill_grid();
    cache_.settle();
    if (radiance_) radiance_->settle();
    Launch& launch = this->launch(film);
    std::map<std::string, std::string> defines = shade_defines(grid_.defines());
    if (!requests && (run_.scene.features & IR_FEATURE_BSDFS) == 0) defines["IR_NO_REQUESTS"] = "1";
    for (; s.first < s.pixels.size(); s.first += chunk_) {
        const auto end = std::min<std::uint64_t>(s.pixels.size(), s.first + chunk_);
        const std::span<const std::uint32_t> pixels(s.pixels.data() + s.first, end - s.first);
        std::vector<std::uint32_t> order;
        if (run_.device.cpu_traversal()) order = shared_order(pixels, run_.device.pixel_group());
        const std::span<const std::uint32_t> part = order.empty() ? pixels : order;
        const Buffer list = run_.device.upload(part.data(), part.size_bytes());
        while (s.sample < s.end) {
            run_.rest();
            const std::uint32_t samples = std::min(samples_a_launch, s.end - s.sample);
            const std::uint32_t share = run_.device.cpu_traversal() ? samples : share_of(samples, part.size());
            const std::size_t slots = part.size() * ((samples + share - 1) / share);
            Kernel kernel = run_.scene_kernel("shade_pixels.cl", "shade_pixels", defines);
            cache_.bind(kernel, false);
            if (radiance_) radiance_->bind(kernel, false).arg(launch.lobe_points.emptied());
            grid_.bind(kernel)
                .arg(list)
                .arg(launch.film)
                .arg(launch.points.emptied())
                .arg(run_.ray_counters())
                .arg(static_cast<std::uint32_t>(part.size()))
                .arg(s.sample)
                .arg(samples)
                .arg(share)
                .arg(run_.edges_beyond_camera())
                .arg((requests ? 1u : 0u) | (s.known != 0 ? 2u : 0u) |
                     (s.halves != 0 ? 4u : 0u))  // IR_SHADE_* of cl/shade_pixels.cl
                .arg(run_.seed())
                .run(group_count(slots, run_.device.pixel_group()), run_.device.pixel_group());
            const std::size_t sums = part.size() * film.channels(), halves = s.halves != 0 ? part.size() : 0;
            run_.device.read(launch.film, launch.sums.data(), (slots * film.channels() + halves) * sizeof(float));
            add_shares({launch.sums.data(), slots * film.channels()}, sums, run_.device.host_threads());
            s.known != 0 ? film.add_indirect(launch.sums, part) : film.add(launch.sums, part, samples);
            if (halves > 0) film.set_halves({launch.sums.data() + sums, halves}, part);
            if (run_.collect_rays() > 0) {
                add_missed(launch.points, s.earlier, s.missed);
                if (radiance_) add_missed(launch.lobe_points, s.earlier_lobes, s.missed_lobes);
            }
            s.sample += samples;
            const double part_done = static_cast<double>(s.sample - s.begin) / (s.end - s.begin);
            const double done = (static_cast<double>(s.first) + static_cast<double>(part.size()) * part_done) /
                                static_cast<double>(s.pixels.size());
            run_.report("shade",
                        records_share + (1 - records_share) * (s.begin + done * (s.end - s.begin)) / run_.spp(),
                        record_count());
        }
        s.sample = s.begin;
        s.earlier = s.missed.size();
        s.earlier_lobes = s.missed_lobes.size();
    }
}

CachingRenderer::Caching::Launch& CachingRenderer::Caching::launch(const Film& film) {
    if (launch_) return *launch_;
    const std::size_t most = chunk_ * (samples_a_launch / least_share);
    const std::size_t items = run_.device.cpu_traversal() ? chunk_ : std::max(chunk_, std::min(items_of_gpus, most));
    launch_.emplace(Launch{run_.device.allocate(items * (film.channels() + 1) * sizeof(float)),
                           PointList(run_.device, items), PointList(run_.device, radiance_ ? items : 0),
                           run_.landing(items * (film.channels() + 1))});
    return *launch_;
}

}  // namespace irradia
