// What the qualities are. They were chosen by time to an error on cornell-a and conference (docs/measurements.md).
#include "irradia/Renderer.h"

namespace irradia {

void apply_quality(RenderSettings& settings, Quality quality) {
    struct Preset {
        float accuracy;
        int m, n;
        float min_spacing, max_spacing;
        int grid_paths, spp;
        float pixel_error;
    };
    static constexpr Preset presets[] = {
        {0.4f, 8, 32, 3.0f, 30, 1 << 15, 64, 0.1f},         // draft
        {0.2f, 16, 32, 2.0f, 30, 1 << 17, 256, 0.02f},      // medium
        {0.12f, 32, 64, 1.0f, 30, 1 << 19, 1024, 0.007f},   // fine
        {0.07f, 64, 128, 0.4f, 15, 1 << 21, 4096, 0.003f},  // finest
    };
    const Preset& p = presets[static_cast<int>(quality)];
    settings.accuracy = p.accuracy;
    settings.hemisphere_m = p.m;
    settings.hemisphere_n = p.n;
    settings.min_spacing = p.min_spacing;
    settings.max_spacing = p.max_spacing;
    settings.grid_paths = p.grid_paths;
    settings.spp = p.spp;
    settings.pixel_error = p.pixel_error;
}

}  // namespace irradia
