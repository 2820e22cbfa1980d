// Radii and their limits (theory 4.4, 6).
#include <random>

#include "formulas.h"

namespace irradia::test {
namespace {
using namespace irradia::host;

TEST(Radius, HarmonicMeanSurvivesZeroAndMisses) {
    const double r_min = 1e-6 * 5, r_max = 10 * 5;  // a scene of diagonal 5
    EXPECT_NEAR(harmonic_mean_distance(3, 3 * inverse_distance(kMiss, r_min, r_max)), r_max, 1e-12);
    const double one_zero = inverse_distance(0, r_min, r_max) + 1023 * inverse_distance(2, r_min, r_max);
    EXPECT_GT(harmonic_mean_distance(1024, one_zero), 1e-3);
    EXPECT_NEAR(harmonic_mean_distance(2, inverse_distance(1, r_min, r_max) + inverse_distance(3, r_min, r_max)), 1.5,
                1e-15);
}

TEST(Radius, GradientLimitKeepsExtrapolationPositive) {
    EXPECT_EQ(gradient_limited_radius(2, 1, 4), .25);
    EXPECT_EQ(gradient_limited_radius(2, 1, 0), 2);
    EXPECT_EQ(gradient_limited_radius(2, 0, 4), 2);  // channels without light do not limit
    EXPECT_EQ(gradient_scale(.5, 1, 4) * 4, 1 / .5);
    EXPECT_EQ(gradient_scale(.25, 1, 4), 1);
    EXPECT_EQ(gradient_scale(1, 0, 3), 0);
    EXPECT_EQ(extrapolate(2, -5), 0);
    EXPECT_EQ(extrapolate(2, 1), 3);
    EXPECT_EQ(extrapolate(2, 9), 4);
    EXPECT_EQ(extrapolate(0, 9), 0);
    EXPECT_TRUE(is_black(0, 0));
    EXPECT_TRUE(is_black(1e-22, 1));
    EXPECT_FALSE(is_black(1e-10, 1));
}

TEST(Radius, NeighbourClampHoldsAfterOnePass) {
    EXPECT_EQ(neighbour_clamped_radius(3, 1, .5), 1.5);
    EXPECT_EQ(neighbour_clamped_radius(1, 3, .5), 1);
}

TEST(Radius, EigenvectorsRebuildTheMatrix) {
    std::mt19937 random(3);
    std::normal_distribution<double> normal;
    std::vector<real3> cases = {{0, 0, 0},  {1, 0, 1},           {-2, 0, -2},       {1, 0, -1},
                                {0, 1, 0},  {0, -1, 0},          {1, 1, 1},         {3, 0, 0},
                                {0, 0, -3}, {1e12, 3e11, -2e12}, {1e-12, 0, 2e-12}, {-1, 1e-9, -1}};
    for (int i = 0; i < 1000; ++i) cases.push_back(make_real3(normal(random), normal(random), normal(random)));
    for (const real3 m : cases) {  // (xx, xy, yy)
        const Eigen2 e = eigen_symmetric(m.x, m.y, m.z);
        const double size = std::max({std::abs(m.x), std::abs(m.y), std::abs(m.z)});
        EXPECT_GE(std::abs(e.l1), std::abs(e.l2));
        EXPECT_NEAR(e.x1 * e.x1 + e.y1 * e.y1, 1, 1e-14);
        EXPECT_NEAR(e.l1 * e.x1 * e.x1 + e.l2 * e.y1 * e.y1, m.x, 1e-14 * size);
        EXPECT_NEAR((e.l1 - e.l2) * e.x1 * e.y1, m.y, 1e-14 * size);
        EXPECT_NEAR(e.l1 * e.y1 * e.y1 + e.l2 * e.x1 * e.x1, m.z, 1e-14 * size);
    }
}

TEST(Radius, FourthRootAndItsLimits) {  // theory 6: (4 tau a E/(pi |l|))^(1/4)
    EXPECT_NEAR(hessian_radius(-3, 2, 1e-9, .01, .04), std::pow(4 * .01 * .04 * 2 / (kPi * 3), .25), 1e-15);
    EXPECT_NEAR(hessian_radius(0, 2, hessian_floor(2, 10), .01, .04), std::pow(4 * .01 * .04 * 100 / (kPi * .02), .25),
                1e-14);
    // Homogeneous: lengths times s (Hessian / s^2, area * s^2) gives radii times s, at any brightness.
    const Eigen2 h = eigen_symmetric(.3, -.2, 1.1);
    const EllipseRadii one = hessian_ellipse(h, 1.5, 7, .02, 1e-4, 1e-3, 3, 3);
    EXPECT_LE(one.r1, one.r2);
    EXPECT_LE(one.r2, 3 * one.r1);
    const double s = 1e4, brightness = 1e-6;
    const Eigen2 scaled = eigen_symmetric(.3 * brightness / s / s, -.2 * brightness / s / s, 1.1 * brightness / s / s);
    const EllipseRadii many = hessian_ellipse(scaled, 1.5 * brightness, 7 * s, .02, 1e-4 * s * s, 1e-3 * s, 3 * s, 3);
    EXPECT_NEAR(many.r1, one.r1 * s, 1e-9 * s);
    EXPECT_NEAR(many.r2, one.r2 * s, 1e-9 * s);
    const EllipseRadii limited = clamp_ellipse(.01, 8, .5, 4, 3);
    EXPECT_EQ(limited.r1, .5);
    EXPECT_EQ(limited.r2, 1.5);
}

}  // namespace
}  // namespace irradia::test
