// Reconstruction filters: distributions against the integrals of the filters (Mitsuba's definitions), quantiles against
// the distributions that they invert.
#include "formulas.h"

namespace irradia::test {
namespace {
using namespace irradia::host;

// Integral of f over [a, b] by Simpson's rule.
template <typename F>
double integral(double a, double b, F f) {
    constexpr int kSteps = 2000;
    const double h = (b - a) / kSteps;
    double sum = f(a) + f(b);
    for (int i = 1; i < kSteps; ++i) sum += (i % 2 ? 4 : 2) * f(a + i * h);
    return sum * h / 3;
}
double gaussian(double x) { return std::exp(-0.5 * x * x) - std::exp(-8.0); }  // Mitsuba's, of unit deviation

TEST(Filter, DistributionsIntegrateTheFilters) {
    for (double x = -4; x <= 4; x += 0.125) {
        EXPECT_NEAR(gaussian_distribution(3 * x, 3, 12), integral(-4, x, gaussian) / integral(-4, 4, gaussian), 2e-9);
        const double tent = x < 0 ? integral(-4, x, [](double t) { return 4 + t; })
                                  : 8 + integral(0, x, [](double t) { return 4 - t; });
        EXPECT_NEAR(tent_distribution(x, 4), tent / 16, 1e-12);
    }
}

// The gaussian's distribution without differences of equals in the tail: by erfc.
double left_tail(double x) {
    const double k = std::sqrt(kPi / 2), half = k * std::erf(std::sqrt(8.0)) - 4 * std::exp(-8.0);
    return (k * (std::erfc(-x / std::sqrt(2.0)) - std::erfc(std::sqrt(8.0))) - (x + 4) * std::exp(-8.0)) / (2 * half);
}

TEST(Filter, GaussianQuantileIsTheInverse) {
    for (double distance = 1e-3; distance <= 4; distance *= 1.003) {
        const double x = distance - 4, u = left_tail(x);
        EXPECT_NEAR(gaussian_quantile(u, 1), x, 1.1e-6);
        EXPECT_NEAR(gaussian_quantile(1 - u, 0.25), -0.25 * x, 0.25 * 1.1e-6 + 1e-13 / u);  // 1 - u rounds
    }
    EXPECT_EQ(gaussian_quantile(0.5, 1), 0);
    EXPECT_NEAR(gaussian_quantile(0, 1), -4, 1.1e-6);
    EXPECT_NEAR(gaussian_quantile(1, 1), 4, 1.1e-6);
}

TEST(Filter, TentQuantileIsTheInverse) {
    for (double x = -2; x <= 2; x += 1 / 64.0) EXPECT_NEAR(tent_quantile(tent_distribution(x, 2), 2), x, 1e-7);
}
}  // namespace
}  // namespace irradia::test
