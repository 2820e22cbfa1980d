#include "core/spatial_order.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace irradia {
namespace {

constexpr int bits_an_axis = 21;

// Bit i of x to bit 3 i.
std::uint64_t spread(std::uint64_t x) {
    x = (x | x << 32) & 0x001f00000000ffffu;
    x = (x | x << 16) & 0x001f0000ff0000ffu;
    x = (x | x << 8) & 0x100f00f00f00f00fu;
    x = (x | x << 4) & 0x10c30c30c30c30c3u;
    return (x | x << 2) & 0x1249249249249249u;
}

}  // namespace

std::vector<std::uint32_t> spatial_order(std::span<const std::array<float, 3>> points) {
    std::array<double, 3> lower{HUGE_VAL, HUGE_VAL, HUGE_VAL}, upper{-HUGE_VAL, -HUGE_VAL, -HUGE_VAL};
    for (const std::array<float, 3>& p : points)
        for (std::size_t k = 0; k < 3; ++k) {
            lower[k] = std::min(lower[k], static_cast<double>(p[k]));
            upper[k] = std::max(upper[k], static_cast<double>(p[k]));
        }
    double extent = 0;
    for (std::size_t k = 0; k < 3; ++k) extent = std::max(extent, upper[k] - lower[k]);
    const double scale = extent > 0 ? ((1 << bits_an_axis) - 1) / extent : 0;
    std::vector<std::pair<std::uint64_t, std::uint32_t>> along(points.size());
    for (std::size_t i = 0; i < points.size(); ++i) {
        std::uint64_t code = 0;
        for (std::size_t k = 0; k < 3; ++k)
            code |= spread(static_cast<std::uint64_t>((static_cast<double>(points[i][k]) - lower[k]) * scale)) << k;
        along[i] = {code, static_cast<std::uint32_t>(i)};
    }
    std::sort(along.begin(), along.end());
    std::vector<std::uint32_t> order(points.size());
    for (std::size_t i = 0; i < order.size(); ++i) order[i] = along[i].second;
    return order;
}

}  // namespace irradia
