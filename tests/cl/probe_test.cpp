// The estimate of a pixel's squared error: probe.json at 1e-12 (theory 9), and its expectation.
#include <random>

#include "formulas.h"

namespace irradia::test {
namespace {
using namespace irradia::host;

TEST(Probe, MatchesVectors) {
    for (const json& c : load_vectors("probe", "cases")) {
        Moments m = moments_zero();
        for (const json& x : c["samples"]) m = moments_add(m, x);
        EXPECT_NEAR(squared_error_estimate(c["I"], m), c["q"].get<double>(), 1e-12) << c.dump();
        EXPECT_NEAR(squared_error_estimate(c["I"], m), c["q_U"].get<double>(), 1e-12) << c.dump();
    }
}

TEST(Probe, TwoSamplesGiveTheProduct) {  // n = 2: (I - X1)(I - X2), theory 8
    const Moments m = moments_add(moments_add(moments_zero(), 1.7), .4);
    EXPECT_NEAR(squared_error_estimate(1.2, m), (1.2 - 1.7) * (1.2 - .4), 1e-14);
}

// Truth 1, picture 1.1, exponential samples (sigma 1), n = 4: mean of q within 4 standard errors of .01; the standard
// error from var q of theory 8, 4 d^2/n + 2/n^2 (for the exponential a little more: 3 is used for 2).
TEST(Probe, IsUnbiased) {
    std::mt19937_64 random(7);
    std::exponential_distribution<double> sample(1.0);
    const int repetitions = 400000;
    double sum = 0;
    for (int i = 0; i < repetitions; ++i) {
        Moments m = moments_zero();
        for (int s = 0; s < 4; ++s) m = moments_add(m, sample(random));
        sum += squared_error_estimate(1.1, m);
    }
    const double sd = std::sqrt((4 * .01 / 4 + 3. / 16) / repetitions);
    EXPECT_NEAR(sum / repetitions, .01, 4 * sd);
}

}  // namespace
}  // namespace irradia::test
