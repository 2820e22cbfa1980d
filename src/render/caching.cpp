// Irradiance and radiance caching. The image is cut into 16x16 blocks; iteration `it` handles one pixel of every block
// at once:
//   1. find_misses         a camera ray; at its diffuse hit look into the octree; without enough records the point goes
//                          on the record stack;
//   2. sample_hemispheres  one record for every point on the stack;
//   3. insert_records      neighbour clamp, then into the octree, which the next iteration looks into.
// Radiance caching does the same once more for the glossy parts of surfaces, with records of its own.
// Before them the irradiance grid is filled, which answers the hemispheres' second bounce. After the 256 iterations
// every pixel is shaded with all its samples. Where a sample finds no record, because clamping un-covered it or because
// samples off the pixel's centre see surfaces of their own, one is made, and the pixel is shaded anew, until none is
// missing. The host owns the stack, the octree's memory and the schedule; everything else happens in kernels.
#include <algorithm>
#include <memory>
#include <numeric>
#include <optional>
#include <set>
#include <string>
#include <tuple>
#include <unordered_set>

#include "cache/RecordCache.h"
#include "irradia/Error.h"
#include "render/carried_records.h"
#include "render/hemispheres.h"
#include "render/iteration_order.h"
#include "render/methods.h"
#include "render/radiance_cache.h"
#include "render/sample_schedule.h"

namespace irradia {
namespace {

constexpr std::uint32_t samples_a_launch = 256;  // float32 sums of a pixel; the host adds launches in double
constexpr std::size_t pixels_a_launch_cpu = 1u << 14, pixels_a_launch_gpu = 1u << 20;
constexpr std::uint32_t record_rounds = 48;  // after so many, samples that still find no record are path traced
constexpr std::uint32_t disagreement_rounds = 2;
constexpr std::uint32_t disagreement_salt = record_rounds, rounds_a_view = disagreement_salt + disagreement_rounds + 1;
constexpr float gap_least = 0.5f;      // footprints: support of a record in a narrow place
constexpr double records_share = 0.5;  // of the progress bar

/// `accuracy`: `a` of the records.
CacheSettings cache_settings(const Run& run, float accuracy) {
    const RenderSettings& s = run.settings;
    const shared::SceneInfo& info = run.scene.info;
    CacheSettings c;
    c.lower = {info.min_x, info.min_y, info.min_z};
    c.upper = {info.max_x, info.max_y, info.max_z};
    // Angles as distances: the picture's weights reach `overlap` times farther than those records are placed by.
    // (1.8): e_n counts in units of a. (1.11): in units of 1/kappa = 2a, times sqrt(1 - cos 10°) = .123257.
    c.inverse_angle =
        (s.weight == WeightRule::tabellion ? 1.0f / (2.0f * accuracy * 0.123257f) : 1.0f / accuracy) / s.overlap;
    c.in_front_slope = s.in_front ? 0.05f : 0.0f;
    c.weight = static_cast<std::uint32_t>(s.weight);
    c.clamp_slope = neighbour_clamp_slope(s);
    c.min_spacing = s.min_spacing * s.overlap;
    c.placement_stretch = s.overlap;
    if (s.reach_limit) {
        c.gap_least = std::min(gap_least, c.min_spacing);
        c.gap_reach = 2 * c.min_spacing;  // wider places are seen by the hemispheres of records around
    }
    return c;
}

CacheSettings radiance_settings(const Run& run) {
    CacheSettings c = cache_settings(run, run.settings.glossy_accuracy);
    // Their supports follow distances: R_i <= R_j + |p_i - p_j|, whatever the rule of irradiance records is.
    if (c.clamp_slope > 0) c.clamp_slope = run.settings.overlap * run.settings.glossy_accuracy;
    return c;
}

}  // namespace

class CachingRenderer::Caching {
public:
    explicit Caching(Run& run)
        : run_(run),
          cache_(run.device, cache_settings(run, run.settings.accuracy)),
          grid_(run),
          pixels_(static_cast<std::size_t>(run.scene.info.width) * run.scene.info.height),
          chunk_(std::min(pixels_, run.device.cpu_traversal() ? pixels_a_launch_cpu : pixels_a_launch_gpu)) {
        hemispheres_.emplace(run, Hemispheres::irradiance_records);
        defines_ = cache_.defines();
        defines_["IR_DIRECT_MIS"] = run.direct_mis() ? "1" : "0";
        defines_["IR_SHARE_LOOKUPS"] = run.settings.share_lookups ? "1" : "0";
        if (run.settings.method != Method::radiance || !RadianceCache::useful(run.scene)) return;
        radiance_.emplace(run, radiance_settings(run));
        defines_["IR_LOBES"] = "1";
        run.phase("lobes");
    }

    std::vector<std::uint32_t> render(Film& film) {
        const Known known = this->known();
        if (run_.edges_beyond_camera() >= 2) {
            grid_.announce();
            if (cache_.size() == 0) fill_grid();
            if (!placed_) {
                place_records();
                settle_disagreements();
            }
            placed_ = false;
            run_.phase("records");
        }
        schedule_.emplace(static_cast<int>(run_.scene.info.width), static_cast<int>(run_.scene.info.height), run_.spp(),
                          run_.settings.pixel_error);
        if (!counted_.empty()) schedule_->spare(counted_, spared_spp_);
        return shade(film, known, 1);
    }

    void spare(std::vector<std::uint8_t> counted, std::uint32_t spp) {
        counted_ = std::move(counted);
        spared_spp_ = spp;
    }

    std::vector<std::uint32_t> refine(Film& film, float factor) {
        cache_.rescale(factor, cache_settings(run_, run_.settings.accuracy));
        hemispheres_.emplace(run_, Hemispheres::irradiance_records);
        if (run_.settings.grid_paths >= 2 * grid_paths_) grid_paths_ = 0;  // to be filled anew
        if (run_.edges_beyond_camera() >= 2) fill_grid();
        if (radiance_ && radiance_->fits(run_.settings))
            radiance_->rescale(factor, radiance_settings(run_));
        else if (radiance_)
            radiance_.emplace(run_, radiance_settings(run_));
        const Known known = this->known();
        if (run_.edges_beyond_camera() >= 2) {
            place_records();
            settle_disagreements();
            run_.phase("records");
        }
        // What the samples have seen and their direct light stay. Their indirect light is looked up anew.
        std::map<std::uint32_t, std::vector<std::uint32_t>> by_samples;
        for (std::uint32_t i = 0; i < pixels_; ++i) {
            film.clear_indirect(i);
            by_samples[static_cast<std::uint32_t>(film.samples(i))].push_back(i);
        }
        std::uint32_t round = 1;
        for (const auto& [samples, pixels] : by_samples) shade_pass(film, pixels, 0, samples, true, round);
        schedule_->allow(film, run_.spp(), run_.settings.pixel_error);
        return shade(film, known, round);
    }

    std::vector<std::uint32_t> sample_more(Film& film) {
        const Known known = this->known();
        schedule_->allow(film, run_.spp(), run_.settings.pixel_error);
        return shade(film, known, 1);
    }

    [[nodiscard]] double squared_noise() const { return schedule_ ? schedule_->squared_noise() : 0; }

    void load(const RecordSet& set) {
        check_records("records", set);
        placed_ = knows_view(set, run_, radiance_.has_value());
        cache_.load(set.irradiance.keys, set.irradiance.values);
        if (radiance_) radiance_->load(set.radiance);
        views_ += static_cast<std::uint32_t>(set.views.size());
        run_.phase("load records");
    }

    void store(RecordSet& set, bool picture) const {
        set.irradiance = {cache_.download_keys(), cache_.download_values()};
        if (radiance_) set.radiance = radiance_->store();
        conclude(set, run_, radiance_.has_value(), picture);
    }

    [[nodiscard]] const RecordCache& irradiance() const { return cache_; }

    void make(const Buffer& points, const RecordStack& stack) { make_records(points, stack, salt(disagreement_salt)); }

private:
    // Once, before the first record is made or the first path asks. Where records were loaded that may be never.
    void fill_grid() {
        if (grid_paths_ > 0) return;
        grid_paths_ = run_.settings.grid_paths;
        grid_.fill();
        run_.phase("grid");
    }

    // Records that there were at some time.
    struct Known {
        std::size_t records, lobes;
    };
    [[nodiscard]] Known known() const { return {cache_.size(), radiance_ ? radiance_->records().size() : 0}; }

    // Whatever the schedule wants; the pixels of records made since `known`. `round`: the next one of this rendering.
    std::vector<std::uint32_t> shade(Film& film, const Known& known, std::uint32_t round) {
        for (; !schedule_->pixels().empty(); schedule_->advance(film))
            shade_pass(film, schedule_->pixels(), schedule_->first(), schedule_->end(), false, round);
        run_.phase("shade");
        ++views_;
        RenderStatistics& s = run_.statistics;
        s.records = cache_.size();
        s.octree_nodes = s.octree_entries = 0;
        add_octree(s, cache_);
        std::vector<std::uint32_t> pixels;
        add_pixels(cache_, known.records, pixels);
        if (radiance_) {
            const RecordCache& records = radiance_->records();
            s.radiance_records = records.size();
            s.radiance_record_bytes = radiance_->record_bytes();
            add_octree(s, records);
            add_pixels(records, known.lobes, pixels);
        }
        return pixels;
    }

    // The pixels of this view at which records were made.
    static void add_pixels(const RecordCache& cache, std::size_t first, std::vector<std::uint32_t>& pixels) {
        const std::vector<shared::RecordValue> values = cache.download_values();
        for (std::size_t i = first; i < values.size(); ++i) pixels.push_back(values[i].pixel);
    }

    // Tells records of one pixel apart: those of the iterations (round 0), of later rounds, of later views.
    [[nodiscard]] std::uint32_t salt(std::uint32_t round) const { return round + views_ * rounds_a_view; }

    static void add_octree(RenderStatistics& s, const RecordCache& cache) {
        s.octree_nodes += cache.octree().nodes;
        s.octree_entries += cache.octree().entries;
        s.octree_depth = std::max(s.octree_depth, cache.octree().depth);
        s.octree_growths += cache.octree().growths;
    }

    [[nodiscard]] std::uint64_t record_count() const {
        return cache_.size() + (radiance_ ? radiance_->records().size() : 0);
    }

    // Stages 2 and 3 for points[indices]. `salt`: see HemisphereSampler.
    void make_records(const Buffer& points, const RecordStack& stack, std::uint32_t salt) {
        if (stack.empty()) return;
        fill_grid();
        const Buffer indices = run_.device.upload(stack.indices);
        const std::uint32_t first = cache_.reserve(stack.size());
        hemispheres_->sample(points, indices, stack.size(), grid_, cache_.keys(), cache_.values(), first, salt);
        cache_.insert(stack.size(), points, indices);
    }

    void make_lobe_records(const Buffer& points, const RecordStack& stack, std::uint32_t salt) {
        if (stack.empty()) return;
        fill_grid();
        radiance_->make(points, stack, grid_, salt);
    }

    // The points of an array that want a record.
    static RecordStack wanting(const std::vector<shared::ShadingPoint>& points) {
        RecordStack stack;
        for (std::uint32_t i = 0; i < points.size(); ++i)
            if (points[i].state != IR_POINT_NONE) stack.indices.push_back(i);
        return stack;
    }

    void place_records() {
        const std::uint32_t blocks_x = (run_.scene.info.width + block_edge - 1) / block_edge;
        const std::uint32_t blocks_y = (run_.scene.info.height + block_edge - 1) / block_edge;
        const std::size_t blocks = static_cast<std::size_t>(blocks_x) * blocks_y;
        Buffer points = run_.device.allocate(blocks * sizeof(shared::ShadingPoint));
        Buffer lobe_points = run_.device.allocate(blocks * sizeof(shared::ShadingPoint));
        std::vector<shared::ShadingPoint> host(blocks);
        std::map<std::string, std::string> defines = cache_.defines();
        if (radiance_) defines["IR_LOBES"] = "1";
        for (std::uint32_t it = 0; it < iteration_count; ++it) {
            const BlockPixel pixel = block_pixel(it);
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
            run_.report("records", records_share * (it + 1) / iteration_count, record_count());
        }
    }

    // Radiance records that disagree about a pixel get others between them: one a round in a 4x4 tile.
    void settle_disagreements() {
        if (!radiance_ || run_.settings.glossy_spread <= 0 || radiance_->records().size() == 0) return;
        Buffer points = run_.device.allocate(chunk_ * sizeof(shared::ShadingPoint));
        std::vector<shared::ShadingPoint> host(chunk_);
        const std::size_t asked =
            (run_.scene.info.width + 1) / 2 * static_cast<std::size_t>((run_.scene.info.height + 1) / 2);
        for (std::uint32_t round = 1; round <= disagreement_rounds; ++round) {
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
            make_lobe_records(run_.device.upload(missed.points), stack, salt(disagreement_salt + round));
            ++run_.statistics.iterations;
            run_.report("records", records_share, record_count());
        }
    }

    // Pixels with a sample that no record reaches, and the first such place of each.
    struct Missed {
        std::vector<std::uint32_t> pixels;
        std::vector<shared::ShadingPoint> points;
    };

    // Buffers of launches of shade_pixels, up to chunk_ pixels each.
    struct Launch {
        Buffer film, points, lobe_points;
        std::vector<float> sums;
        std::vector<shared::ShadingPoint> host;  // filled where pixels miss records
    };

    Launch& launch(const Film& film) {
        if (!launch_)
            launch_.emplace(Launch{run_.device.allocate(chunk_ * film.channels() * sizeof(float)),
                                   run_.device.allocate(chunk_ * sizeof(shared::ShadingPoint)),
                                   run_.device.allocate(radiance_ ? chunk_ * sizeof(shared::ShadingPoint) : 4),
                                   std::vector<float>(chunk_ * film.channels()),
                                   {}});
        return *launch_;
    }

    void add_missed(const Buffer& points, const std::vector<std::uint32_t>& part, Launch& launch, Missed& missed,
                    std::vector<bool>& seen) {
        launch.host.resize(std::max(launch.host.size(), part.size()));
        seen.resize(part.size(), false);
        run_.device.read(points, launch.host.data(), part.size() * sizeof launch.host[0]);
        for (std::size_t i = 0; i < part.size(); ++i)
            if (launch.host[i].state != IR_POINT_NONE && !seen[i]) {
                seen[i] = true;
                missed.pixels.push_back(part[i]);
                missed.points.push_back(launch.host[i]);
            }
    }

    // Adds samples [begin, end) of `pixels` to the film; `missed` of irradiance, and of radiance.
    void shade_pixels(Film& film, const std::vector<std::uint32_t>& pixels, std::uint32_t begin, std::uint32_t end,
                      bool requests, bool known, Missed& missed, Missed& missed_lobes) {
        // On diffuse surfaces only what finds no record goes on as a path.
        if (run_.edges_beyond_camera() >= 2 && (!requests || (run_.scene.features & IR_FEATURE_BSDFS))) fill_grid();
        Launch& launch = this->launch(film);
        std::map<std::string, std::string> defines = grid_.defines();
        defines.insert(defines_.begin(), defines_.end());
        for (std::size_t first = 0; first < pixels.size(); first += chunk_) {
            const std::vector<std::uint32_t> part(
                pixels.begin() + static_cast<std::ptrdiff_t>(first),
                pixels.begin() + static_cast<std::ptrdiff_t>(std::min(pixels.size(), first + chunk_)));
            const Buffer list = run_.device.upload(part);
            std::vector<bool> seen, seen_lobes;
            for (std::uint32_t sample = begin; sample < end; sample += samples_a_launch) {
                const std::uint32_t samples = std::min(samples_a_launch, end - sample);
                Kernel kernel = run_.scene_kernel("shade_pixels.cl", "shade_pixels", defines);
                cache_.bind(kernel, false);
                if (radiance_) radiance_->bind(kernel, false).arg(launch.lobe_points);
                grid_.bind(kernel)
                    .arg(list)
                    .arg(launch.film)
                    .arg(launch.points)
                    .arg(run_.ray_counters())
                    .arg(static_cast<std::uint32_t>(part.size()))
                    .arg(sample)
                    .arg(samples)
                    .arg(run_.edges_beyond_camera())
                    .arg((requests ? 1u : 0u) | (known ? 2u : 0u))  // IR_SHADE_* of cl/shade_pixels.cl
                    .arg(run_.seed())
                    .run(group_count(part.size(), run_.device.pixel_group()), run_.device.pixel_group());
                run_.device.read(launch.film, launch.sums.data(), part.size() * film.channels() * sizeof(float));
                known ? film.add_indirect(launch.sums, part) : film.add(launch.sums, part, samples);
                // The points, 80 bytes a pixel, are read where there are any.
                if (run_.collect_rays() > 0) {
                    add_missed(launch.points, part, launch, missed, seen);
                    if (radiance_) add_missed(launch.lobe_points, part, launch, missed_lobes, seen_lobes);
                }
                const double part_done = static_cast<double>(sample + samples - begin) / (end - begin);
                const double done = (static_cast<double>(first) + static_cast<double>(part.size()) * part_done) /
                                    static_cast<double>(pixels.size());
                run_.report("shade", records_share + (1 - records_share) * (begin + done * (end - begin)) / run_.spp(),
                            record_count());
            }
        }
    }

    // Of the pixels of a 4x4 tile that miss a record one gets it a round, since that often covers the others; every
    // round makes progress, so it ends.
    using Made = std::set<std::tuple<std::uint32_t, float, float, float>>;
    RecordStack choose(const Missed& missed, Made& made) const {
        RecordStack stack;
        std::unordered_set<std::uint64_t> tiles;
        for (std::uint32_t i = 0; i < missed.pixels.size(); ++i) {
            const shared::ShadingPoint& q = missed.points[i];
            const std::uint32_t x = missed.pixels[i] % run_.scene.info.width,
                                y = missed.pixels[i] / run_.scene.info.width;
            if (!tiles.insert((static_cast<std::uint64_t>(y / 4) << 32) | (x / 4)).second) continue;
            stack.indices.push_back(i);
            if (!made.insert({q.pixel, q.px, q.py, q.pz}).second)
                throw Error("pixel " + std::to_string(x) + ", " + std::to_string(y) +
                            ": the record made there does not cover it (an error in the program: please report it)");
        }
        return stack;
    }

    // One pass. A pixel that misses a record gets it and is shaded anew, from its first sample on.
    // `known`: the film has all but the samples' indirect light.
    void shade_pass(Film& film, std::vector<std::uint32_t> pixels, std::uint32_t first, std::uint32_t end, bool known,
                    std::uint32_t& round) {
        Made made, made_lobes;
        for (std::uint32_t begin = first; !pixels.empty(); begin = 0) {
            Missed missed, missed_lobes;
            shade_pixels(film, pixels, begin, end, round < record_rounds, known, missed, missed_lobes);
            const RecordStack stack = choose(missed, made), lobe_stack = choose(missed_lobes, made_lobes);
            if (!stack.empty()) make_records(run_.device.upload(missed.points), stack, salt(round));
            if (!lobe_stack.empty())
                make_lobe_records(run_.device.upload(missed_lobes.points), lobe_stack, salt(round));
            if (!stack.empty() || !lobe_stack.empty()) {
                ++run_.statistics.iterations;
                ++round;
            }
            pixels = missed.pixels;
            pixels.insert(pixels.end(), missed_lobes.pixels.begin(), missed_lobes.pixels.end());
            std::sort(pixels.begin(), pixels.end());
            pixels.erase(std::unique(pixels.begin(), pixels.end()), pixels.end());
            for (const std::uint32_t pixel : pixels) known ? film.clear_indirect(pixel) : film.clear(pixel);
        }
    }

    Run& run_;
    RecordCache cache_;
    std::optional<HemisphereSampler> hemispheres_;
    IrradianceGrid grid_;
    std::optional<RadianceCache> radiance_;
    std::optional<Launch> launch_;
    std::size_t pixels_, chunk_;
    std::uint32_t views_ = 0;  // renderings, also those that loaded records were made for
    int grid_paths_ = 0;       // that the grid was filled with
    std::optional<SampleSchedule> schedule_;
    std::vector<std::uint8_t> counted_;  // see spare()
    std::uint32_t spared_spp_ = 0;
    bool placed_ = false;  // the next view's records were loaded
    std::map<std::string, std::string> defines_;
};

CachingRenderer::CachingRenderer(Run& run) : caching_(std::make_unique<Caching>(run)) {}
CachingRenderer::~CachingRenderer() = default;
std::vector<std::uint32_t> CachingRenderer::render(Film& film) { return caching_->render(film); }
void CachingRenderer::spare(std::vector<std::uint8_t> counted, std::uint32_t spp) {
    caching_->spare(std::move(counted), spp);
}
std::vector<std::uint32_t> CachingRenderer::refine(Film& film, float factor) { return caching_->refine(film, factor); }
std::vector<std::uint32_t> CachingRenderer::sample_more(Film& film) { return caching_->sample_more(film); }
double CachingRenderer::squared_noise() const { return caching_->squared_noise(); }
void CachingRenderer::load(const RecordSet& set) { caching_->load(set); }
void CachingRenderer::store(RecordSet& set, bool picture) const { caching_->store(set, picture); }
const RecordCache& CachingRenderer::irradiance() const { return caching_->irradiance(); }
void CachingRenderer::make(const Buffer& points, const RecordStack& stack) { caching_->make(points, stack); }

}  // namespace irradia
