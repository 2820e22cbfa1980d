// Irradiance and radiance caching. The image is cut into 16x16 blocks; iteration `it` is one pixel of every block.
// Iterations are taken in steps (iteration_order.h), of one at first and of many at last, in rounds:
//   1. find_misses         a camera ray; at its diffuse hit look into the octree; without enough records the point goes
//                          on a list, from which one of a tile at most goes on the record stack (later pixels of plain
//                          surroundings are spared that on CPUs: plain_pixels.h);
//   2. sample_hemispheres  one record for every point on the stack;
//   3. insert_records      neighbour clamp, then into the octree, which the next round looks into, for the points that
//                          have been left, along with the next step's, until none wants a record.
// Radiance caching does the same once more for the glossy parts of surfaces, with records of its own.
// Before them the irradiance grid is filled, which answers the hemispheres' second bounce. After the 256 iterations
// every pixel is shaded with all its samples. Where a sample finds no record, because clamping un-covered it or because
// samples off the pixel's centre see surfaces of their own, one is made, and the pixel is shaded anew, until none is
// missing. The host owns the stack, the octree's memory and the schedule; everything else happens in kernels.
#include "render/caching.h"

#include <algorithm>
#include <memory>

#include "render/carried_records.h"
#include "render/sky_view.h"

namespace irradia {
namespace {

constexpr std::size_t pixels_a_launch_cpu = 1u << 14, pixels_a_launch_gpu = 1u << 20;
constexpr std::uint32_t rounds_a_view = disagreement_salt + disagreement_rounds + 1;

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
        c.gap_least = std::min(s.gap_spacing, s.min_spacing) * s.overlap;
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

CachingRenderer::Caching::Caching(Run& run)
    : run_(run),
      cache_(run.device, cache_settings(run, run.settings.accuracy)),
      grid_(run),
      pixels_(static_cast<std::size_t>(run.scene.info.width) * run.scene.info.height),
      chunk_(std::min(pixels_, run.device.cpu_traversal() ? pixels_a_launch_cpu : pixels_a_launch_gpu)),
      plain_(run.device, run.scene.info.width, run.scene.info.height) {
    hemispheres_.emplace(run, Hemispheres::irradiance_records);
    defines_ = cache_.defines();
    defines_["IR_DIRECT_MIS"] = run.direct_mis() ? "1" : "0";
    defines_["IR_SHARE_LOOKUPS"] = run.settings.share_lookups ? "1" : "0";
    if (run.settings.method != Method::radiance || !RadianceCache::useful(run.scene)) {
        expect_kernels();
        return;
    }
    radiance_.emplace(run, radiance_settings(run));
    defines_["IR_LOBES"] = "1";
    expect_kernels();
    radiance_->tabulate();
    run.phase("lobes");
}

// In the order in which they are asked for, but the slowest to compile before the quickest: two processes then end at
// about the same time. What is left out is compiled when it is asked for, no worse than before.
void CachingRenderer::Caching::expect_kernels() {
    if (run_.edges_beyond_camera() < 2) return;  // direct light alone
    std::vector<KernelSource> kernels;
    if (radiance_) kernels.push_back(radiance_->table_kernel());
    if (learns_sky(run_)) kernels.push_back(run_.scene_source("learn_sky.cl", {}));
    kernels.push_back({"fill_grid.cl", run_.scene_defines()});
    kernels.push_back(hemispheres_->kernel_to_come(grid_));
    kernels.push_back(run_.scene_source("find_misses.cl", miss_defines()));
    if (radiance_) kernels.push_back(radiance_->hemisphere_kernel(grid_));
    kernels.push_back(run_.scene_source("shade_pixels.cl", shade_defines(grid_.defines_to_come())));
    kernels.push_back({"merge_grid.cl", {}});
    kernels.push_back({"insert_records.cl", cache_.defines()});
    run_.device.expect(kernels);
}

std::map<std::string, std::string> CachingRenderer::Caching::miss_defines() const {
    std::map<std::string, std::string> defines = cache_.defines();
    if (radiance_) defines["IR_LOBES"] = "1";
    return defines;
}

std::map<std::string, std::string> CachingRenderer::Caching::shade_defines(
    std::map<std::string, std::string> grid) const {
    grid.insert(defines_.begin(), defines_.end());
    return grid;
}

void CachingRenderer::Caching::begin_view() {
    stage_ = Stage::records;
    iteration_ = settled_ = 0;
    left_.clear();
    left_lobes_.clear();
    round_ = 1;
    before_ = known();
    schedule_.reset();
    sweep_.reset();
}

std::vector<std::uint32_t> CachingRenderer::Caching::go_on(Film& film) {
    if (stage_ == Stage::records) {
        if (run_.edges_beyond_camera() >= 2) {
            grid_.announce();
            if (cache_.size() == 0) fill_grid();
            if (!contains(known_, view_of(run_, radiance_.has_value()))) {
                place_records();
                settle_disagreements();
            }
            run_.phase("records");
        }
        schedule_.emplace(static_cast<int>(run_.scene.info.width), static_cast<int>(run_.scene.info.height), run_.spp(),
                          run_.settings.pixel_error, run_.device.host_threads(), run_.device.tile() > 1);
        if (!counted_.empty()) schedule_->spare(counted_, spared_spp_);
        stage_ = Stage::samples;
    }
    return shade(film);
}

void CachingRenderer::Caching::spare(std::vector<std::uint8_t> counted, std::uint32_t spp) {
    counted_ = std::move(counted);
    spared_spp_ = spp;
}

std::vector<std::uint32_t> CachingRenderer::Caching::refine(Film& film, float factor) {
    stage_ = Stage::samples;
    known_.clear();  // with farther records
    cache_.rescale(factor, cache_settings(run_, run_.settings.accuracy));
    hemispheres_.emplace(run_, Hemispheres::irradiance_records);
    if (run_.settings.grid_paths >= 2 * grid_paths_) grid_paths_ = 0;  // to be filled anew
    if (run_.edges_beyond_camera() >= 2) fill_grid();
    if (radiance_ && radiance_->fits(run_.settings))
        radiance_->rescale(factor, radiance_settings(run_));
    else if (radiance_)
        radiance_.emplace(run_, radiance_settings(run_)).tabulate();
    before_ = known();
    if (run_.edges_beyond_camera() >= 2) {
        iteration_ = settled_ = 0;
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
    round_ = 1;
    for (const auto& [samples, pixels] : by_samples) {
        start_pass({pixels.begin(), pixels.end()}, 0, samples, true);
        shade_pass(film);
    }
    schedule_->allow(film, run_.spp(), run_.settings.pixel_error);
    return shade(film);
}

std::vector<std::uint32_t> CachingRenderer::Caching::sample_more(Film& film) {
    stage_ = Stage::samples;
    before_ = known();
    round_ = 1;
    schedule_->allow(film, run_.spp(), run_.settings.pixel_error);
    return shade(film);
}

void CachingRenderer::Caching::load(const RecordSet& set) {
    check_records("records", set);
    known_ = known_views(set, run_, radiance_.has_value());
    cache_.load(set.irradiance.keys, set.irradiance.values);
    if (radiance_) radiance_->load(set.radiance);
    views_ += static_cast<std::uint32_t>(set.views.size());
    run_.phase("load records");
}

void CachingRenderer::Caching::store(RecordSet& set) const {
    set.irradiance = {cache_.download_keys(), cache_.download_values()};
    if (radiance_) set.radiance = radiance_->store();
    set.views = known_;
    conclude(set, run_, radiance_.has_value());
}

void CachingRenderer::Caching::make(const Buffer& points, const RecordStack& stack) {
    make_records(points, stack, salt(disagreement_salt));
    cache_.settle();
}

std::uint64_t CachingRenderer::Caching::record_count() const {
    return cache_.size() + (radiance_ ? radiance_->records().size() : 0);
}

std::uint32_t CachingRenderer::Caching::salt(std::uint32_t round) const { return round + views_ * rounds_a_view; }

void CachingRenderer::Caching::state(Checkpoint& c) {
    cache_.state(c);
    grid_.state(c);
    if (radiance_) radiance_->state(c);
    c(views_)(grid_paths_)(known_)(counted_)(spared_spp_);
    c(stage_)(iteration_)(left_)(left_lobes_)(settled_)(round_)(before_);
    plain_.state(c);
    if (c.has(schedule_, [&] { schedule_.emplace(1, 1, 1, 0.0, run_.device.host_threads()); })) schedule_->state(c);
    if (c.has(sweep_, [&] { sweep_.emplace(); })) {
        Sweep& s = *sweep_;
        c(s.pixels)(s.begin)(s.end)(s.known)(s.halves)(s.first)(s.sample);
        c(s.missed)(s.missed_lobes)(s.earlier)(s.earlier_lobes);
    }
    if (!c.reading()) return;
    made_.clear();  // the fault that they would show shows again
    made_lobes_.clear();
}

CachingRenderer::CachingRenderer(Run& run) : caching_(std::make_unique<Caching>(run)) {}
CachingRenderer::~CachingRenderer() = default;
std::vector<std::uint32_t> CachingRenderer::render(Film& film) {
    caching_->begin_view();
    return caching_->go_on(film);
}
std::vector<std::uint32_t> CachingRenderer::go_on(Film& film) { return caching_->go_on(film); }
void CachingRenderer::state(Checkpoint& checkpoint) { caching_->state(checkpoint); }
void CachingRenderer::spare(std::vector<std::uint8_t> counted, std::uint32_t spp) {
    caching_->spare(std::move(counted), spp);
}
std::vector<std::uint32_t> CachingRenderer::refine(Film& film, float factor) { return caching_->refine(film, factor); }
std::vector<std::uint32_t> CachingRenderer::sample_more(Film& film) { return caching_->sample_more(film); }
double CachingRenderer::squared_noise() const { return caching_->squared_noise(); }
void CachingRenderer::load(const RecordSet& set) { caching_->load(set); }
void CachingRenderer::store(RecordSet& set) const { caching_->store(set); }
const RecordCache& CachingRenderer::irradiance() const { return caching_->irradiance(); }
void CachingRenderer::make(const Buffer& points, const RecordStack& stack) { caching_->make(points, stack); }

}  // namespace irradia
