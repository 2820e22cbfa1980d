// Weights and the in-front test: weights.json, in_front.json at 1e-9 (theory 9), and hard cases.
#include "formulas.h"

namespace irradia::test {
namespace {
using namespace irradia::host;

TEST(Weight, MatchesVectors) {
    for (const json& c : load_vectors("weights", "cases")) {
        const real3 p = vec3(c["p"]), n = vec3(c["n"]), pi = vec3(c["pi"]), ni = vec3(c["ni"]);
        const double radius = c["R"], a = c["a"];
        const double e = ward_error(p, n, pi, ni, radius);
        EXPECT_NEAR(e, c["e"].get<double>(), 1e-9) << c.dump();
        expect_relative(ward_weight(e, a), c["w_safe"], 1e-9, "w_safe of " + c.dump());
        EXPECT_NEAR(tabellion_weight(length(p - pi), radius, normal_error(n, ni), c["kappa"]),
                    c["w_tabellion"].get<double>(), 1e-9)
            << c.dump();
    }
}

TEST(Weight, EqualsPrintedFormAwayFromZero) {  // (1.8): 1/e - 1/a
    for (const double a : {.05, .2, .7})
        for (double x = .01; x < 1; x += .013) EXPECT_NEAR(ward_weight(x * a, a), 1 / (x * a) - 1 / a, 1e-9 / a);
    EXPECT_NEAR(ward_weight(0, .2), 100 / .2, 1e-9);
    EXPECT_EQ(ward_weight(.2, .2), 0);  // continuous at the border of the support
    EXPECT_EQ(ward_weight(1e30, .2), 0);
}

// The cubic with value 1 and slope 0 at the record, value 0 and slope 0 at the rim (Hermite's first basis function).
TEST(Weight, CubicIsABell) {
    EXPECT_EQ(cubic_weight_normalised(0), 1);
    EXPECT_EQ(cubic_weight_normalised(1), 0);
    EXPECT_EQ(cubic_weight_normalised(1e30), 0);
    EXPECT_NEAR(cubic_weight_normalised(.5), .5, 1e-15);
    for (double x = 0; x <= 1; x += .01) {
        EXPECT_NEAR(cubic_weight_normalised(x), 1 - 3 * x * x + 2 * x * x * x, 1e-14);
        EXPECT_NEAR(cubic_weight_normalised(x) + cubic_weight_normalised(1 - x), 1, 1e-14);
    }
}

TEST(Weight, EllipseWithEqualAxesIsACircle) {
    const real3 dp{.03, -.02, .01};
    EXPECT_NEAR(elliptic_error(dp, make_real3(0, 1, 0), .5, .5), length(dp) / .5, 1e-15);
    EXPECT_NEAR(elliptic_error(make_real3(0, .3, 0), make_real3(0, 1, 0), .1, .5), .6, 1e-15);
    EXPECT_NEAR(elliptic_error(make_real3(.05, 0, 0), make_real3(0, 1, 0), .1, .5), .5, 1e-15);
    EXPECT_NEAR(elliptic_weight(.25, .1, .4), .5, 1e-15);
    EXPECT_EQ(elliptic_weight(.8, .1, .4), 0);
}

TEST(InFront, MatchesVectors) {
    for (const json& c : load_vectors("in_front", "cases")) {
        const real3 p = vec3(c["p"]), n = vec3(c["n"]), pi = vec3(c["pi"]), ni = vec3(c["ni"]);
        const double coordinate = std::max(largest_coordinate(p), largest_coordinate(pi));
        EXPECT_NEAR(height_over_record(p, n, pi, ni), c["d"].get<double>(), 1e-9) << c["name"];
        EXPECT_NEAR(in_front_tolerance(length(p - pi), .05, coordinate), c["tol"].get<double>(), 1e-9) << c["name"];
        EXPECT_EQ(is_in_front(p, n, pi, ni, .05, coordinate), c["reject"].get<bool>()) << c["name"];
    }
}

TEST(InFront, SpheresAreNeverRejected) {  // d is 0 for two points of a sphere, convex or concave (theory 4.3)
    for (const double side : {1.0, -1.0})
        for (double angle = .01; angle < 1.5; angle += .07) {
            const real3 ni{0, 0, 1}, n{std::sin(angle), 0, std::cos(angle)};
            EXPECT_FALSE(is_in_front(n * 3.0, side * n, ni * 3.0, side * ni, .05, 3));
            EXPECT_FALSE(is_below(n * 3.0, side * n, ni * 3.0, side * ni));
        }
}

TEST(InFront, StepsAreRejectedBothWays) {
    const real3 up{0, 0, 1}, floor{0, 0, 0}, step{.1, 0, .1};
    EXPECT_TRUE(is_in_front(floor, up, step, up, .05, 1));
    EXPECT_FALSE(is_in_front(step, up, floor, up, .05, 1));
    EXPECT_TRUE(is_below(step, up, floor, up));
    EXPECT_FALSE(is_below(floor, up, step, up));
}

}  // namespace
}  // namespace irradia::test
