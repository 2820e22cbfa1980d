// Structural similarity: Z. Wang, A. C. Bovik, H. R. Sheikh, E. P. Simoncelli, "Image quality assessment: from error
// visibility to structural similarity", IEEE Transactions on Image Processing 13(4), 2004, eq. (13).
#include <array>
#include <cmath>
#include <vector>

#include "image/image_check.h"
#include "image/metrics_detail.h"

namespace irradia::detail {
namespace {

constexpr int kRadius = 5;
constexpr double kSigma = 1.5;                          // pixels
constexpr double kC1 = 0.01 * 0.01, kC2 = 0.03 * 0.03;  // (K L)² for values in [0, 1]
constexpr double kGrey = 0.18;                          // mean luminance both pictures are scaled to

using Plane = std::vector<double>;

// Gaussian window, separable; outside the picture there is nothing (the weights are divided out by the caller).
Plane blur(const Plane& in, std::size_t width, std::size_t height) {
    std::array<double, 2 * kRadius + 1> g{};
    for (int k = -kRadius; k <= kRadius; ++k)
        g[static_cast<std::size_t>(k + kRadius)] = std::exp(-k * k / (2 * kSigma * kSigma));
    const int w = static_cast<int>(width), h = static_cast<int>(height);
    Plane rows(in.size()), out(in.size());
    for (int y = 0; y < h; ++y)
        for (int x = 0; x < w; ++x) {
            double sum = 0;
            for (int k = std::max(-kRadius, -x); k <= std::min(kRadius, w - 1 - x); ++k)
                sum += g[static_cast<std::size_t>(k + kRadius)] * in[static_cast<std::size_t>(y * w + x + k)];
            rows[static_cast<std::size_t>(y * w + x)] = sum;
        }
    for (int y = 0; y < h; ++y)
        for (int x = 0; x < w; ++x) {
            double sum = 0;
            for (int k = std::max(-kRadius, -y); k <= std::min(kRadius, h - 1 - y); ++k)
                sum += g[static_cast<std::size_t>(k + kRadius)] * rows[static_cast<std::size_t>((y + k) * w + x)];
            out[static_cast<std::size_t>(y * w + x)] = sum;
        }
    return out;
}

}  // namespace

double mean_ssim(const Comparison& c) {
    // Rec. 709 luminance of a pixel, from a function that gives channel i.
    const auto luminance = [](auto&& value, std::size_t p) {
        return 0.2126 * value(3 * p) + 0.7152 * value(3 * p + 1) + 0.0722 * value(3 * p + 2);
    };
    const auto picture = [&](std::size_t i) { return static_cast<double>(c.x[i]); };
    const auto reference = [&](std::size_t i) { return c.reference(i); };
    double mean = 0;
    for (std::size_t p = 0; p < c.pixels; ++p)
        if (c.counted[p]) mean += luminance(reference, p);
    mean /= static_cast<double>(c.count);
    const double scale = mean > 0 ? kGrey / mean : 1;

    Plane one(c.pixels), x(c.pixels), y(c.pixels), xx(c.pixels), yy(c.pixels), xy(c.pixels);
    for (std::size_t p = 0; p < c.pixels; ++p) {
        if (!c.counted[p]) continue;
        one[p] = 1;
        x[p] = srgb_encode(static_cast<float>(scale * luminance(picture, p)));
        y[p] = srgb_encode(static_cast<float>(scale * luminance(reference, p)));
        xx[p] = x[p] * x[p];
        yy[p] = y[p] * y[p];
        xy[p] = x[p] * y[p];
    }
    for (Plane* plane : {&one, &x, &y, &xx, &yy, &xy}) *plane = blur(*plane, c.width, c.height);

    double sum = 0;
    for (std::size_t p = 0; p < c.pixels; ++p) {
        if (!c.counted[p]) continue;
        const double mx = x[p] / one[p], my = y[p] / one[p];
        const double vx = xx[p] / one[p] - mx * mx, vy = yy[p] / one[p] - my * my, cov = xy[p] / one[p] - mx * my;
        sum += (2 * mx * my + kC1) * (2 * cov + kC2) / ((mx * mx + my * my + kC1) * (vx + vy + kC2));
    }
    return sum / static_cast<double>(c.count);
}

}  // namespace irradia::detail
