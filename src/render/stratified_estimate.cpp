#include "render/stratified_estimate.h"

#include <algorithm>
#include <cmath>

#include "core/in_ranges.h"

namespace irradia {

Estimate stratified_estimate(std::size_t strata, const std::vector<Draw>& draws) {
    struct Stratum {
        double count = 0, mean = 0, squares = 0;
    };
    std::vector<Stratum> of(strata);
    Estimate e;
    double all = 0, largest = 0;
    for (const Draw& d : draws) {  // Welford's update
        Stratum& s = of[d.stratum];
        s.count += 1;
        const double step = d.value - s.mean;
        s.mean += step / s.count;
        s.squares += step * (d.value - s.mean);
        all += std::abs(d.value);
        largest = std::max(largest, std::abs(d.value));
    }
    const double parts = static_cast<double>(strata);
    std::vector<double> cubes(strata, 0.0);
    for (const Draw& d : draws) {
        const double off = d.value - of[d.stratum].mean;
        cubes[d.stratum] += off * off * off;
    }
    double variance = 0, fourth = 0, third = 0;
    for (std::size_t h = 0; h < strata; ++h) {
        const Stratum& s = of[h];
        if (s.count > 2)  // third central moment of a stratum's draws, without bias, and of their mean: / count²
            third +=
                cubes[h] * s.count / ((s.count - 1) * (s.count - 2)) / (s.count * s.count) / (parts * parts * parts);
        e.mean += s.mean / parts;
        const double own = s.squares / (s.count - 1) / s.count / (parts * parts);
        variance += own;
        fourth += own * own / (s.count - 1);
    }
    e.deviation = std::sqrt(variance);
    e.skewness = variance > 0 ? third / (variance * e.deviation) : 0;
    e.freedom = fourth > 0 ? variance * variance / fourth : 1e9;
    e.largest_share = all > 0 ? largest / all : 0;
    return e;
}

double student_quantile(double freedom) {
    const double n = std::max(freedom, 3.0), z = 1.959963984540054;
    // Cornish-Fisher expansion in 1/n (Abramowitz and Stegun 26.7.5); of 3 degrees, 3.182, it makes 3.179.
    const double z2 = z * z, g1 = (z2 + 1) * z / 4, g2 = ((5 * z2 + 16) * z2 + 3) * z / 96,
                 g3 = (((3 * z2 + 19) * z2 + 17) * z2 - 15) * z / 384,
                 g4 = ((((79 * z2 + 776) * z2 + 1482) * z2 - 1920) * z2 - 945) * z / 92160;
    return z + (g1 + (g2 + (g3 + g4 / n) / n) / n) / n;
}

Interval interval_of(const Estimate& e) {
    const double z = student_quantile(e.freedom), half = z * e.deviation;
    const double shift = std::clamp(e.skewness, -1.0, 1.0) * (2 * z * z + 1) / 6 * e.deviation;
    return {e.mean, e.mean - half + std::min(shift, half), e.mean + half + std::max(shift, -half)};
}

Interval interval_of_squares(const Estimate& e) {
    const Interval i = interval_of(e);
    return {std::max(i.value, 0.0), std::max(i.low, 0.0), std::max(i.high, e.deviation)};
}

StratifiedPixels::StratifiedPixels(std::span<const double> weights, std::size_t strata, int threads) : strata_(strata) {
    struct Weighted {
        double weight;
        std::uint32_t pixel;
    };
    UntouchedVector<Weighted> sorted(weights.size());
    in_ranges(threads, sorted.size(), [&](std::size_t, std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i)  // what is no number is not drawn
            sorted[i] = {weights[i] > 0 ? weights[i] : 0, static_cast<std::uint32_t>(i)};
    });
    sort_in_parts(threads, sorted, [](const Weighted& a, const Weighted& b) {
        return a.weight < b.weight || (a.weight == b.weight && a.pixel < b.pixel);
    });
    const auto first =
        std::partition_point(sorted.begin(), sorted.end(), [](const Weighted& w) { return !(w.weight > 0); });
    const auto count = static_cast<std::size_t>(sorted.end() - first);
    order_.reserve(count);
    cumulative_.reserve(count);
    double sum = 0;
    for (auto w = first; w != sorted.end(); ++w) {
        order_.push_back(w->pixel);
        cumulative_.push_back(sum += w->weight);
    }
    in_ranges(threads, count, [&](std::size_t, std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) cumulative_[i] /= sum;
    });
}

StratifiedPixels::Pixel StratifiedPixels::draw(std::size_t stratum, double u) const {
    const double at = (static_cast<double>(stratum) + u) / static_cast<double>(strata_);
    const std::size_t i = std::min<std::size_t>(
        static_cast<std::size_t>(std::upper_bound(cumulative_.begin(), cumulative_.end(), at) - cumulative_.begin()),
        order_.size() - 1);
    return {order_[i], cumulative_[i] - (i > 0 ? cumulative_[i - 1] : 0.0)};
}

}  // namespace irradia
