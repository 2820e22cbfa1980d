// The methods, each in its own file. They fill `film` and run.statistics.
#pragma once
#include <cstdint>
#include <memory>
#include <vector>

#include "cache/RecordCache.h"
#include "irradia/Checkpoint.h"
#include "render/run.h"

namespace irradia {

struct RecordSet;

/// Throws Error for settings out of range.
void check_settings(const Scene& scene, const RenderSettings& settings);

/// How far a method that only takes samples has come: what the film holds.
struct SamplePosition {
    std::uint32_t sample = 0;  ///< the one that is being taken: of every pixel those before it
    std::uint64_t pixel = 0;   ///< the first that it is still missing of
    void state(Checkpoint& checkpoint) { checkpoint(sample)(pixel); }
};

/// Samples up to run.spp() of every pixel.
void render_path(Run& run, Film& film, SamplePosition& at);
void render_gather(Run& run, Film& film, SamplePosition& at);
/// Irradiance and radiance caching. What it has learned of the scene serves all views that it renders.
class CachingRenderer {
public:
    explicit CachingRenderer(Run& run);
    ~CachingRenderer();
    CachingRenderer(const CachingRenderer&) = delete;
    CachingRenderer& operator=(const CachingRenderer&) = delete;

    /// Renders the run's present view. Returns the pixel of every record made for it.
    std::vector<std::uint32_t> render(Film& film);
    /// Goes on with a view that was being rendered when its state was saved.
    std::vector<std::uint32_t> go_on(Film& film);
    /// All that the renderer knows. Whole only where run.rest() was called.
    void state(Checkpoint& checkpoint);
    /// Enters records made elsewhere, before the first view. Throws Error if they do not fit.
    void load(const RecordSet& set);
    /// Hands out all records; radiance records of `set` stay if this run knows none.
    void store(RecordSet& set) const;

    [[nodiscard]] const RecordCache& irradiance() const;
    /// Irradiance records for points[stack[i]].
    void make(const Buffer& points, const RecordStack& stack);

    /// Pixels where `counted` is 0 take no more than `spp` samples.
    void spare(std::vector<std::uint8_t> counted, std::uint32_t spp);
    /// run.settings have changed and ask for supports that are `factor` times as large, and for better records: those
    /// that are there stay, with their supports so scaled. Of the film's samples only indirect light is looked up anew;
    /// they become as many as are asked for.
    std::vector<std::uint32_t> refine(Film& film, float factor);
    /// run.settings and run.spp() have changed and ask for more samples: adds them to the film that render() has left.
    std::vector<std::uint32_t> sample_more(Film& film);
    /// What noise of samples adds to the picture's squared error: see SampleSchedule.
    [[nodiscard]] double squared_noise() const;

private:
    class Caching;
    std::unique_ptr<Caching> caching_;
};

}  // namespace irradia
