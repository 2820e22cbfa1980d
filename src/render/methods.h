// The methods, each in its own file. They fill `film` and run.statistics.
#pragma once
#include <cstdint>
#include <memory>
#include <vector>

#include "render/run.h"

namespace irradia {

struct RecordSet;

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
    /// Hands out all records, with the view that was rendered; radiance records of `set` stay if this run knows none.
    void store(RecordSet& set) const;

private:
    class Caching;
    std::unique_ptr<Caching> caching_;
};

}  // namespace irradia
