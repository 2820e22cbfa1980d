// What the qualities are. They were chosen by time to an error on cornell-a and conference (docs/measurements.md).
#include "render/quality.h"

#include <algorithm>
#include <cmath>

namespace irradia {

void apply_level(RenderSettings& settings, double level) {
    struct Preset {
        float accuracy;
        int m, n;
        float min_spacing, max_spacing, gap_spacing;
        int grid_paths, spp;
        float pixel_error;
    };
    static constexpr Preset presets[] = {
        {0.4f, 8, 32, 3.0f, 30, 1.5f, 1 << 15, 64, 0.05f},          // draft
        {0.2f, 16, 32, 2.0f, 30, 0.3f, 1 << 17, 256, 0.01f},        // medium
        {0.12f, 32, 64, 1.0f, 30, 0.3f, 1 << 19, 1024, 0.007f},     // fine
        {0.07f, 64, 128, 0.4f, 15, 0.3f, 1 << 21, 4096, 0.003f},    // finest
        {0.042f, 96, 256, 0.2f, 8, 0.2f, 1 << 23, 16384, 0.0014f},  // beyond: what --target-error may come to
        {0.025f, 144, 384, 0.1f, 4, 0.1f, 1 << 24, 65536, 0.0007f},
    };
    const double at = std::clamp(level, 0.0, highest_level), below = std::min(std::floor(at), highest_level - 1);
    const Preset &a = presets[static_cast<int>(below)], &b = presets[static_cast<int>(below) + 1];
    const double part = at - below;
    const auto between = [&](double x, double y) { return part == 0 ? x : part == 1 ? y : x * std::pow(y / x, part); };
    const Preset& nearest = part < 0.5 ? a : b;
    settings.accuracy = static_cast<float>(between(a.accuracy, b.accuracy));
    settings.hemisphere_m = nearest.m;
    settings.hemisphere_n = nearest.n;
    settings.min_spacing = static_cast<float>(between(a.min_spacing, b.min_spacing));
    settings.max_spacing = static_cast<float>(between(a.max_spacing, b.max_spacing));
    settings.gap_spacing = static_cast<float>(between(a.gap_spacing, b.gap_spacing));
    settings.grid_paths = static_cast<int>(between(a.grid_paths, b.grid_paths));
    settings.spp = static_cast<int>(between(a.spp, b.spp));
    settings.pixel_error = static_cast<float>(between(a.pixel_error, b.pixel_error));
}

void apply_quality(RenderSettings& settings, Quality quality) { apply_level(settings, static_cast<int>(quality)); }

}  // namespace irradia
