// The methods, each in its own file. They fill `film` and run.statistics.
#pragma once
#include <cstdint>
#include <memory>
#include <vector>

#include "cache/RecordCache.h"
#include "render/run.h"

namespace irradia {

struct RecordSet;

/// Throws Error for settings out of range.
void check_settings(const Scene& scene, const RenderSettings& settings);

void render_path(Run& run, Film& film);
void render_gather(Run& run, Film& film);
/// Irradiance and radiance caching. What it has learned of the scene serves all views that it renders.
class CachingRenderer {
public:
    explicit CachingRenderer(Run& run);
    ~CachingRenderer();
    CachingRenderer(const CachingRenderer&) = delete;
    CachingRenderer& operator=(const CachingRenderer&) = delete;

    /// Renders the run's present view. Returns the pixel of every record made for it.
    std::vector<std::uint32_t> render(Film& film);
    /// Enters records made elsewhere, before the first view. Throws Error if they do not fit.
    void load(const RecordSet& set);
    /// Hands out all records; radiance records of `set` stay if this run knows none. `picture`: one was rendered.
    void store(RecordSet& set, bool picture) const;

    [[nodiscard]] const RecordCache& irradiance() const;
    /// Irradiance records for points[stack[i]].
    void make(const Buffer& points, const RecordStack& stack);

private:
    class Caching;
    std::unique_ptr<Caching> caching_;
};

}  // namespace irradia
