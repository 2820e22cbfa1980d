// Closed forms: furnaces, integrating spheres, form factors, disks (furnace.json at 1e-9, theory 9).
#include <random>

#include "polygon.h"

namespace irradia::test {
namespace {
using namespace irradia::host;

// All that a hemisphere's kernel computes, from samples that `sample(direction)` gives.
template <class F>
HemisphereSums sum_cells(uint m, uint n, std::mt19937* random, const F& sample) {
    std::uniform_real_distribution<double> uniform;
    std::vector<HemisphereSample> s(m * n);
    for (uint j = 0; j < m; ++j)
        for (uint k = 0; k < n; ++k) {
            const double x = random ? uniform(*random) : .5, y = random ? uniform(*random) : .5;
            s[j * n + k] = sample(stratum_direction(j, k, m, n, x, y));
        }
    HemisphereSums sums = hemisphere_sums_zero();
    for (uint j = 0; j < m; ++j)
        for (uint k = 0; k < n; ++k) {
            const HemisphereSample& own = s[j * n + k];
            cell_moments(&sums, k, n, ring_rotation_weight(j, m), own, own.radiance, 1e-6, kMiss, 0);
            cell_edges(&sums, j, k, m, n, own, s[(j > 0 ? j - 1 : 0) * n + k], s[j * n + (k + n - 1) % n]);
        }
    return sums;
}

// Inside a sphere of unit radius, at its south pole: every direction sees the wall at distance 2 cos.
HemisphereSample sphere_sample(real3 d, double L, double radius) {
    const double r = 2 * radius * d.z;
    return {d, normalize(make_real3(0, 0, radius) - r * d), make_real3(L, 2 * L, 3 * L), r};
}

TEST(Furnace, SeriesGradientAndVarianceAreExact) {
    std::mt19937 random(5);
    for (const json& c : load_vectors("furnace", "furnace")) {
        const double rho = c["rho"], Le = c["Le"];
        double L = 0;  // radiance of the walls after each bounce; E from a jittered hemisphere
        for (const json& wanted : c["E_after_bounces"]) {
            L = Le + rho * L;
            const HemisphereSums s = sum_cells(16, 64, &random, [&](real3 d) { return sphere_sample(d, L, 1); });
            expect_relative(kPi / 1024 * s.irradiance.x, wanted, 1e-9, "E, rho " + c["rho"].dump());
            EXPECT_LE(std::hypot(s.gx.x, s.gy.x, s.gz.x), 1e-12 * L);
            EXPECT_EQ(std::abs(s.hxx) + std::abs(s.hxy) + std::abs(s.hyy), 0);
            EXPECT_LE(std::hypot(s.rx.x, s.ry.x), 1e-10 * L);
            L = kPi / 1024 * s.irradiance.x / kPi;  // what a white wall would send back
        }
        expect_relative(Le / (1 - rho), c["L_total"], 1e-9, "L_total");
        expect_relative(kPi * Le / (1 - rho), c["E_total"], 1e-9, "E_total");
    }
}

TEST(Furnace,
     IntegratingSphere) {  // E_indirect from a hemisphere inside the sphere whose wall radiance is rho E_total/pi
    for (const json& c : load_vectors("furnace", "integrating_sphere")) {
        const double rho = c["rho"], radius = c["radius"], first = c["E_first"];
        expect_relative(first, c["flux"].get<double>() / (4 * kPi * radius * radius), 1e-9, "E_first");
        double indirect = 0;
        for (int bounce = 0; bounce < 1000; ++bounce) {
            const double L = rho * (first + indirect) / kPi;
            const HemisphereSums s = sum_cells(2, 4, nullptr, [&](real3 d) { return sphere_sample(d, L, radius); });
            indirect = kPi / 8 * s.irradiance.x;
        }
        expect_relative(indirect, c["E_indirect"], 1e-9, "E_indirect");
    }
}

TEST(Furnace, SphereDistances) {
    const json c = load_vectors("furnace", "sphere_distances");
    const HemisphereSums s = sum_cells(16, 64, nullptr, [](real3 d) { return sphere_sample(d, 1, 1); });
    expect_relative(harmonic_mean_distance(1024, s.inverse_distance), c["M16_mid"], 1e-9, "R_HMD");
    // The exact value is the radius, 1; the midpoints' error is of first order in sqrt(1/M): a fourth at 16 times M.
    const HemisphereSums fine = sum_cells(256, 4, nullptr, [](real3 d) { return sphere_sample(d, 1, 1); });
    EXPECT_NEAR(harmonic_mean_distance(1024, fine.inverse_distance), 1, .0205);
}

TEST(Furnace, DisksFillWholeRings) {  // a disk is sin^2 <= r^2/(r^2+h^2): whole rings of 2 and of 401
    for (const json& c : load_vectors("furnace", "disk")) {
        const double radius = c["radius"], height = c["height"];
        const uint m = radius == 1 ? 2 : 401;
        const HemisphereSums s = sum_cells(m, 8, nullptr, [&](real3 d) {
            const bool hit = std::hypot(d.x, d.y) * height <= radius * d.z;
            const double L = hit ? 1 : 0;
            return HemisphereSample{d, make_real3(0, 0, -1), make_real3(L, L, L), hit ? height / d.z : kMiss};
        });
        expect_relative(kPi / (8 * m) * s.irradiance.x, c["E_over_L"], 1e-9, "E/L");
    }
}

// Form factors: the mean of polygon irradiance / pi over a rectangle, by the tanh-sinh rule, which converges
// exponentially although the integrand of rectangles that touch is not smooth in their corners.
template <class F>
double mean_over_square(const F& f) {
    const int n = 160;
    std::vector<double> x(n), w(n);
    const double h = 7.2 / n;
    for (int i = 0; i < n; ++i) {
        const double t = -3.6 + h * (i + .5), u = .5 * kPi * std::sinh(t);
        x[i] = 1 / (1 + std::exp(-2 * u));
        w[i] = h * kPi * std::cosh(t) * x[i] / (1 + std::exp(2 * u));
    }
    double sum = 0;
    for (int i = 0; i < n; ++i)
        for (int j = 0; j < n; ++j) sum += w[i] * w[j] * f(x[i], x[j]);
    return sum;
}

TEST(Furnace, FormFactorsOfRectangles) {
    for (const json& c : load_vectors("furnace", "form_factors")) {
        double found = 0;
        if (c["kind"] == "parallel_rect") {
            const double a = c["a"], b = c["b"], z = c["c"];
            const std::vector<real3> lamp = {{0, 0, z}, {a, 0, z}, {a, b, z}, {0, b, z}};
            found = mean_over_square([&](double s, double t) {
                return polygon_irradiance(lamp, make_real3(s * a, t * b, 0), make_real3(0, 0, 1)).value / kPi;
            });
        } else {
            const double w = c["w"], h = c["h"], l = c["l"];
            const std::vector<real3> lamp = {{0, 0, 0}, {0, l, 0}, {0, l, h}, {0, 0, h}};
            found = mean_over_square([&](double s, double t) {
                return polygon_irradiance(lamp, make_real3(s * w, t * l, 0), make_real3(0, 0, 1)).value / kPi;
            });
        }
        EXPECT_NEAR(found, c["F"].get<double>(), 1e-9) << c.dump();
    }
}

}  // namespace
}  // namespace irradia::test
