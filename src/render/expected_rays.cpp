#include <algorithm>
#include <cmath>
#include <limits>

#include "irradia/Renderer.h"
#include "render/run.h"

namespace irradia {

// Measured (--stats) on six scenes at draft, medium and fine. Pixels that stop at an error take some 24, 48, 96 of at
// most 64, 256, 1024 samples; scenes want 5 (an empty room) to 40 records a pixel of the picture's edge.
double expected_rays(const Scene& scene, const RenderSettings& s) {
    if (s.target_error > 0 || s.time_limit > 0) return std::numeric_limits<double>::infinity();
    const double pixels = static_cast<double>(scene.info.width) * scene.info.height;
    const double most = asked_spp(scene, s);
    const double hemisphere = static_cast<double>(s.hemisphere_m) * s.hemisphere_n;
    constexpr double path = 8;  // rays of one that ends by chance, with those to lamps
    if (s.method == Method::path) return pixels * most * path;
    if (s.method == Method::gather) return pixels * most * hemisphere * path;
    const double samples = s.pixel_error > 0 ? std::min(most, std::max(16.0, 3 * std::sqrt(most))) : most;
    const double records = 25 * std::sqrt(pixels), of_grid = s.grid ? s.grid_paths * path : 0;
    const double of_records = records * hemisphere * (s.grid ? 3 : path);
    return 2 * pixels * samples + of_records + of_grid;
}

}  // namespace irradia
