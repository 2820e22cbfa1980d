// Irradiance and radiance caching: all that CachingRenderer knows. What it does is at the top of caching.cpp.
#pragma once
#include <map>
#include <optional>
#include <set>
#include <string>
#include <tuple>
#include <vector>

#include "cache/RecordCache.h"
#include "irradia/RecordFile.h"
#include "render/hemispheres.h"
#include "render/irradiance_grid.h"
#include "render/methods.h"
#include "render/plain_pixels.h"
#include "render/point_list.h"
#include "render/radiance_cache.h"
#include "render/sample_schedule.h"

namespace irradia {

/// A rendering can be left wherever run.rest() is called, and be gone on with in another process: what it needs from
/// there on is in members, which state() exchanges.
class CachingRenderer::Caching {
public:
    explicit Caching(Run& run);
    void begin_view();
    std::vector<std::uint32_t> go_on(Film& film);
    void spare(std::vector<std::uint8_t> counted, std::uint32_t spp);
    std::vector<std::uint32_t> refine(Film& film, float factor);
    std::vector<std::uint32_t> sample_more(Film& film);
    [[nodiscard]] double squared_noise() const { return schedule_ ? schedule_->squared_noise() : 0; }
    void load(const RecordSet& set);
    void store(RecordSet& set) const;
    void state(Checkpoint& checkpoint);
    [[nodiscard]] const RecordCache& irradiance() const { return cache_; }
    void make(const Buffer& points, const RecordStack& stack);

private:
    /// Records that there were at some time.
    struct Known {
        std::uint64_t records = 0, lobes = 0;
    };
    /// Places that no record reaches, one a pixel.
    using Missed = std::vector<shared::ShadingPoint>;
    /// Places where records were made in one pass: the same place twice is a fault.
    using Made = std::set<std::tuple<std::uint32_t, float, float, float>>;
    /// Buffers of launches of shade_pixels: of up to chunk_ pixels, or of shares of fewer pixels' samples.
    struct Launch {
        Buffer film;
        PointList points, lobe_points;
        UntouchedVector<float> sums;
    };
    /// Samples [begin, end) of pixels being added to the film, launch by launch.
    struct Sweep {
        PixelList pixels;
        std::uint32_t begin = 0, end = 0;
        std::uint8_t known = 0;                        // the film has all but the samples' indirect light
        std::uint8_t halves = 0;                       // the film is to know how they differ
        std::uint64_t first = 0;                       // of pixels: the present launch's
        std::uint32_t sample = 0;                      // its next one
        Missed missed, missed_lobes;                   // of irradiance, and of radiance: the first place of each pixel
        std::uint64_t earlier = 0, earlier_lobes = 0;  // of these, in pixels of earlier launches
    };
    enum class Stage : std::uint32_t { records, samples, finished };

    [[nodiscard]] Known known() const { return {cache_.size(), radiance_ ? radiance_->records().size() : 0}; }
    [[nodiscard]] std::uint64_t record_count() const;
    /// Tells records of one pixel apart: those of the iterations (round 0), of later rounds, of later views.
    [[nodiscard]] std::uint32_t salt(std::uint32_t round) const;

    void expect_kernels();
    /// Definitions of find_misses and shade_pixels.
    [[nodiscard]] std::map<std::string, std::string> miss_defines() const;
    [[nodiscard]] std::map<std::string, std::string> shade_defines(std::map<std::string, std::string> grid) const;

    // place_records.cpp
    void fill_grid();
    void make_records(const Buffer& points, const RecordStack& stack, std::uint32_t salt);
    void make_lobe_records(const Buffer& points, const RecordStack& stack, std::uint32_t salt);
    void place_records();
    void place_round(PixelList& asked, std::uint32_t tile, PointList& points, PointList& lobe_points);
    /// Not every pixel is looked at (plain_): that is a tenth of a draft's time on CPUs, while GPUs look at all in the
    /// time that finding out takes.
    [[nodiscard]] bool spares_pixels() const { return run_.device.cpu_traversal(); }
    void settle_disagreements();
    RecordStack choose(const Missed& missed, Made& made) const;

    // shade_passes.cpp
    std::vector<std::uint32_t> shade(Film& film);
    void shade_pass(Film& film);
    void sweep(Film& film);
    void start_pass(PixelList pixels, std::uint32_t first, std::uint32_t end, bool known, bool halves = false);
    Launch& launch(const Film& film);

    Run& run_;
    RecordCache cache_;
    std::optional<HemisphereSampler> hemispheres_;
    IrradianceGrid grid_;
    std::optional<RadianceCache> radiance_;
    std::optional<Launch> launch_;
    Buffer asked_, stack_;  // pixels that find_misses looks at; points that get records
    std::size_t pixels_, chunk_;
    std::uint32_t views_ = 0;        // renderings, also those that loaded records were made for
    std::int32_t grid_paths_ = 0;    // that the grid was filled with
    std::vector<RecordView> known_;  // pictures whose records are all there
    std::map<std::string, std::string> defines_;
    std::vector<std::uint8_t> counted_;  // see spare()
    std::uint32_t spared_spp_ = 0;

    // The view being rendered.
    Stage stage_ = Stage::records;
    std::uint32_t iteration_ = 0, settled_ = 0;  // iterations begun, rounds done
    PixelList left_, left_lobes_;                // pixels of those iterations that may want more
    PlainPixels plain_;
    std::uint32_t round_ = 1;  // of shading: the next one that makes records
    Known before_;             // it
    std::optional<SampleSchedule> schedule_;
    std::optional<Sweep> sweep_;
    Made made_, made_lobes_;  // in the present pass
};

// Rounds in which shading makes records; after so many, samples that still find none are path traced.
inline constexpr std::uint32_t record_rounds = 48, disagreement_rounds = 2;
inline constexpr std::uint32_t disagreement_salt = record_rounds;
inline constexpr double records_share = 0.5;  // of the progress bar

}  // namespace irradia
