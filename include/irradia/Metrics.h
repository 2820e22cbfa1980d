// How far a picture is from its reference.
#pragma once
#include <limits>
#include <string>

#include "irradia/Image.h"

namespace irradia {

/// All means run over the counted pixels and their three channels. ref is the reference, or (a+b)/2 of two halves.
struct Metrics {
    std::size_t pixels = 0;  ///< counted: inside the mask
    double mean = 0;         ///< of the picture
    double mean_reference = 0;
    double mse = 0;  ///< mean((x−ref)²) minus the reference's own variance; halves: mean((x−a)(x−b)), may be < 0
    double rel_rmse = 0;            ///< sqrt(max(mse, 0)) / mean(ref)
    double rel_rmse_raw = 0;        ///< sqrt(mean((x−ref)²)) / mean(ref): the reference's noise included
    double reference_rel_rmse = 0;  ///< the part that was subtracted: the reference's own error, 0 if unknown
    double rel_mse = 0;    ///< mean((x−ref)² / (ref² + 1e-2)); halves: mean((x−a)(x−b) / (ref² + 1e-2))
    double mean_bias = 0;  ///< (mean(x) − mean(ref)) / mean(ref)
    /// Half width of mean_bias's 95 % interval, from the spread of 16×16-pixel tiles taken as independent; errors that
    /// differ from place to place count as noise, so it is on the safe side. NaN with fewer than two tiles.
    double mean_bias_interval = std::numeric_limits<double>::quiet_NaN();
    double max_error = 0;      ///< largest |x−ref| of a channel
    int max_x = 0, max_y = 0;  ///< where, from the top left
    /// Mean structural similarity (Wang et al. 2004: Gaussian window of 11×11, σ 1.5, K 0.01 and 0.03) of luminances
    /// scaled so that mean(ref) = 0.18, then sRGB-coded and clamped to [0, 1]. Pixels outside the mask have no weight.
    double ssim = 0;
};

struct MetricsOptions {
    const Image* mask = nullptr;         ///< counted where its first channel is > 0.5; null: everywhere
    const Image* reference_b = nullptr;  ///< second independent half of a noisy reference
    double reference_rel_rmse = 0;       ///< known relative RMSE of a single reference; its square is subtracted
};

/// Compares the beauty layers. Throws Error: sizes differ, nothing is counted, a counted pixel that is not finite,
/// or a black reference (every measure is relative to its mean).
Metrics compare_images(const Image& picture, const Image& reference, const MetricsOptions& options = {});

/// Relative RMSE of (a+b)/2 from two independent halves: sqrt(mean((a−b)²)/4) / mean((a+b)/2).
double relative_rmse_of_halves(const Image& a, const Image& b, const Image* mask = nullptr);

/// A picture of the error: root mean square over a pixel's channels of (x−ref), relative to mean(ref), through the
/// "inferno" colour map (lightness rises with the error), grey outside the mask.
struct ErrorPicture {
    Image image;       ///< linear RGB; metadata states quantity, colour map and scale
    double scale = 0;  ///< relative error shown as the map's last colour
};

/// `scale` 0: the 99th percentile of the counted pixels.
ErrorPicture error_picture(const Image& picture, const Image& reference, const MetricsOptions& options = {},
                           double scale = 0);

}  // namespace irradia
