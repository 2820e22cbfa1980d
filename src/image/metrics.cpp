#include "irradia/Metrics.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "image/metrics_detail.h"
#include "irradia/Error.h"

namespace irradia {
namespace {

constexpr std::size_t kTile = 16;        // pixels, edge of a tile of the bias interval
constexpr double kRelMseEpsilon = 1e-2;  // keeps relMSE finite where the reference is black

void check_size(const char* what, const Image& image, const Image& picture) {
    if (image.width != picture.width || image.height != picture.height)
        throw Error(fmt::format("sizes differ: the picture has {} x {} pixels, the {} {} x {}", picture.width,
                                picture.height, what, image.width, image.height));
}

const float* beauty_of(const char* what, const Image& image) {
    const std::size_t pixels = static_cast<std::size_t>(image.width) * static_cast<std::size_t>(image.height);
    if (image.layers.empty() || image.layers[0].channels != 3 || image.layers[0].data.size() != pixels * 3)
        throw Error(fmt::format("the {} has no layer of three channels to compare", what));
    return image.layers[0].data.data();
}

// Sums of (x − ref) over tiles, to see how far their mean can be trusted.
double bias_interval(const detail::Comparison& c) {
    struct Tile {
        double sum = 0, count = 0;
    };
    const std::size_t tiles_x = (c.width + kTile - 1) / kTile, tiles_y = (c.height + kTile - 1) / kTile;
    std::vector<Tile> tiles(tiles_x * tiles_y);
    for (std::size_t p = 0; p < c.pixels; ++p) {
        if (!c.counted[p]) continue;
        Tile& tile = tiles[(p / c.width / kTile) * tiles_x + (p % c.width) / kTile];
        for (std::size_t i = 3 * p; i < 3 * p + 3; ++i) tile.sum += c.x[i] - c.reference(i);
        tile.count += 3;
    }
    double n = 0, sum = 0, used = 0;
    for (const Tile& tile : tiles) {
        n += tile.count;
        sum += tile.sum;
        used += tile.count > 0 ? 1 : 0;
    }
    if (used < 2) return std::numeric_limits<double>::quiet_NaN();
    // Variance of a ratio of sums, Σ D_t / Σ n_t, over independent tiles.
    const double mean = sum / n;
    double spread = 0;
    for (const Tile& tile : tiles) spread += (tile.sum - mean * tile.count) * (tile.sum - mean * tile.count);
    return 1.96 * std::sqrt(spread * used / (used - 1)) / n / c.mean_reference;
}

}  // namespace

namespace detail {

Comparison make_comparison(const Image& picture, const Image& reference, const MetricsOptions& options) {
    check_size("reference", reference, picture);
    Comparison c;
    c.width = static_cast<std::size_t>(picture.width);
    c.height = static_cast<std::size_t>(picture.height);
    c.pixels = c.width * c.height;
    c.x = beauty_of("picture", picture);
    c.a = c.b = beauty_of("reference", reference);
    if (options.reference_b) {
        check_size("second reference", *options.reference_b, picture);
        c.b = beauty_of("second reference", *options.reference_b);
    }
    c.counted.assign(c.pixels, 1);
    if (options.mask) {
        check_size("mask", *options.mask, picture);
        const float* mask = beauty_of("mask", *options.mask);
        for (std::size_t p = 0; p < c.pixels; ++p) c.counted[p] = mask[3 * p] > 0.5f;
    }
    for (std::size_t p = 0; p < c.pixels; ++p) {
        if (!c.counted[p]) continue;
        ++c.count;
        for (std::size_t i = 3 * p; i < 3 * p + 3; ++i) {
            if (!std::isfinite(c.x[i]) || !std::isfinite(c.reference(i)))
                throw Error(fmt::format("the {} is {} at pixel ({}, {}), expected a finite number",
                                        std::isfinite(c.x[i]) ? "reference" : "picture",
                                        std::isfinite(c.x[i]) ? c.reference(i) : static_cast<double>(c.x[i]),
                                        p % c.width, p / c.width));
            c.mean_x += c.x[i];
            c.mean_reference += c.reference(i);
        }
    }
    if (c.count == 0) throw Error("the mask counts no pixel: it is 0 everywhere");
    c.mean_x /= 3.0 * static_cast<double>(c.count);
    c.mean_reference /= 3.0 * static_cast<double>(c.count);
    if (c.mean_reference <= 0)
        throw Error(fmt::format("the reference's mean is {}: errors relative to it have no meaning", c.mean_reference));
    return c;
}

}  // namespace detail

Metrics compare_images(const Image& picture, const Image& reference, const MetricsOptions& options) {
    const detail::Comparison c = detail::make_comparison(picture, reference, options);
    Metrics m;
    m.pixels = c.count;
    m.mean = c.mean_x;
    m.mean_reference = c.mean_reference;
    double raw = 0, product = 0, relative = 0, halves = 0;
    for (std::size_t p = 0; p < c.pixels; ++p) {
        if (!c.counted[p]) continue;
        for (std::size_t i = 3 * p; i < 3 * p + 3; ++i) {
            const double x = c.x[i], a = c.a[i], b = c.b[i], ref = c.reference(i);
            raw += (x - ref) * (x - ref);
            product += (x - a) * (x - b);
            relative += (x - a) * (x - b) / (ref * ref + kRelMseEpsilon);
            halves += (a - b) * (a - b);
            if (std::abs(x - ref) > m.max_error) {
                m.max_error = std::abs(x - ref);
                m.max_x = static_cast<int>(p % c.width);
                m.max_y = static_cast<int>(p / c.width);
            }
        }
    }
    const double n = 3.0 * static_cast<double>(c.count);
    m.reference_rel_rmse =
        options.reference_b ? std::sqrt(halves / n) / 2 / c.mean_reference : options.reference_rel_rmse;
    // (x−a)(x−b) = (x−ref)² − (a−b)²/4: its mean is free of the halves' noise. A single reference needs its
    // variance from outside.
    const double known = options.reference_b ? 0 : options.reference_rel_rmse * c.mean_reference;
    m.mse = product / n - known * known;
    m.rel_rmse = std::sqrt(std::max(m.mse, 0.0)) / c.mean_reference;
    m.rel_rmse_raw = std::sqrt(raw / n) / c.mean_reference;
    m.rel_mse = relative / n;
    m.mean_bias = (c.mean_x - c.mean_reference) / c.mean_reference;
    m.mean_bias_interval = bias_interval(c);
    m.ssim = detail::mean_ssim(c);
    return m;
}

double relative_rmse_of_halves(const Image& a, const Image& b, const Image* mask) {
    MetricsOptions options;
    options.mask = mask;
    options.reference_b = &b;
    return compare_images(a, a, options).reference_rel_rmse;
}

}  // namespace irradia
