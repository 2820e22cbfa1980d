// Means from stratified draws, with intervals: the statistics of error probes, apart from rendering.
#pragma once
#include <cstdint>
#include <span>
#include <vector>

#include "irradia/Checkpoint.h"
#include "irradia/ErrorReport.h"

namespace irradia {

/// A draw from one of several strata of equal probability. `value`: already divided by the density it was drawn with.
struct Draw {
    std::uint32_t stratum;
    double value;
};

struct Estimate {
    double mean = 0;
    double deviation = 0;      ///< standard error of the mean
    double skewness = 0;       ///< of the mean's own distribution; 0 with fewer than three draws a stratum
    double freedom = 0;        ///< degrees of freedom of `deviation` (Satterthwaite)
    double largest_share = 0;  ///< of a single draw in the sum of all |value|
};

/// Every stratum holds at least two draws.
Estimate stratified_estimate(std::size_t strata, const std::vector<Draw>& draws);

/// 95 % interval of a mean, by Student's distribution, with the first correction for skewness (Hall, "On the removal of
/// skewness by transformation", J. R. Statist. Soc. B 54, 1992): squared errors are skewed, and without it the interval
/// ends too low.
Interval interval_of(const Estimate& estimate);

/// The same of a mean that cannot be negative, as of squared errors. Its draws can, less the noise of what they are
/// compared with; where the mean is small against that noise one interval in forty would lie below 0 as a whole, and
/// say that there is no error at all. It ends no lower than a standard error above 0.
Interval interval_of_squares(const Estimate& estimate);

/// Quantile .975 of Student's distribution (below 3 degrees of freedom that of 3).
double student_quantile(double freedom);

/// Pixels drawn with density in proportion to `weights` (>= 0, not all 0), in strata of equal probability.
class StratifiedPixels {
public:
    StratifiedPixels(std::span<const double> weights, std::size_t strata, int threads = 1);

    struct Pixel {
        std::uint32_t index;
        double density;  ///< with which it is drawn, a pixel: sums to 1 over all
    };
    /// u in [0, 1).
    [[nodiscard]] Pixel draw(std::size_t stratum, double u) const;
    void state(Checkpoint& checkpoint) { checkpoint(strata_)(order_)(cumulative_); }
    [[nodiscard]] std::size_t strata() const noexcept { return strata_; }

private:
    std::size_t strata_;
    std::vector<std::uint32_t> order_;  // by weight, so that a stratum's pixels are alike
    std::vector<double> cumulative_;    // of the pixels in that order
};

}  // namespace irradia
