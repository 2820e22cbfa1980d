// What metrics.cpp, ssim.cpp and heatmap.cpp share.
#pragma once
#include <cstddef>
#include <string>
#include <vector>

#include "irradia/Metrics.h"

namespace irradia::detail {

/// Picture, reference(s) and mask checked against each other. Arrays hold 3 values a pixel.
struct Comparison {
    std::size_t width = 0, height = 0, pixels = 0;
    const float* x = nullptr;
    const float* a = nullptr;
    const float* b = nullptr;   ///< second half, or the same as a
    std::vector<char> counted;  ///< 1 a counted pixel
    std::size_t count = 0;
    double mean_x = 0, mean_reference = 0;
    [[nodiscard]] double reference(std::size_t i) const { return 0.5 * (static_cast<double>(a[i]) + b[i]); }
};

/// Throws Error as compare_images() does.
Comparison make_comparison(const Image& picture, const Image& reference, const MetricsOptions& options);

/// Metrics::ssim.
double mean_ssim(const Comparison& c);

}  // namespace irradia::detail
