#include "render/lamps.h"

#include <algorithm>
#include <cmath>

namespace irradia {
namespace {

/// Pixels of the picture that its filter mixes into a pixel's neighbours on each side.
int filter_reach(const shared::SceneInfo& info) {
    return std::max(static_cast<int>(std::ceil(info.rfilter_radius - 0.5f)), 0);
}

}  // namespace

std::vector<std::uint8_t> pixels_without_lamps(Run& run) {
    const std::uint32_t width = run.scene.info.width, height = run.scene.info.height;
    const auto shown = [&](std::uint32_t columns, std::uint32_t rows, float offset) {
        const std::uint32_t positions = columns * rows;
        std::vector<std::uint32_t> shows(positions);
        const Buffer buffer = run.device.allocate(positions * sizeof shows[0]);
        const std::size_t group = run.device.pixel_group();
        run.scene_kernel("probe_pixels.cl", "find_lamps", {})
            .arg(buffer)
            .arg(columns)
            .arg(positions)
            .arg(offset)
            .run(group_count(positions, group), group);  // a work-item does up to 16: the rest have nothing to do
        run.device.read(buffer, shows.data(), positions * sizeof shows[0]);
        return shows;
    };
    const std::vector<std::uint32_t> centres = shown(width, height, 0.5f), corners = shown(width + 1, height + 1, 0.0f);
    const auto lamp = [&](std::uint32_t x, std::uint32_t y) {
        const std::size_t corner = static_cast<std::size_t>(y) * (width + 1) + x;
        return (centres[static_cast<std::size_t>(y) * width + x] | corners[corner] | corners[corner + 1] |
                corners[corner + width + 1] | corners[corner + width + 2]) != 0;
    };
    std::vector<std::uint8_t> counted(static_cast<std::size_t>(width) * height, 1);
    const int reach = filter_reach(run.scene.info), w = static_cast<int>(width), h = static_cast<int>(height);
    for (int y = 0; y < h; ++y)
        for (int x = 0; x < w; ++x) {
            if (!lamp(static_cast<std::uint32_t>(x), static_cast<std::uint32_t>(y))) continue;
            for (int v = std::max(y - reach, 0); v <= std::min(y + reach, h - 1); ++v)
                for (int u = std::max(x - reach, 0); u <= std::min(x + reach, w - 1); ++u)
                    counted[static_cast<std::size_t>(v) * width + static_cast<std::size_t>(u)] = 0;
        }
    // Nothing but lamps: then they are what there is to judge.
    if (std::find(counted.begin(), counted.end(), 1) == counted.end()) counted.assign(counted.size(), 1);
    return counted;
}

}  // namespace irradia
