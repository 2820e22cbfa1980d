// Uniform samples of solid angles, in double, where all is exact to rounding: to 1e-16 of the shape's size over the
// receiver's distance from its edges and plane, which are 1e-5 at the least. Hence 1e-10.
#include "solid_angle.h"

#include <functional>
#include <random>

namespace irradia::test {
namespace {
using namespace irradia::host;

constexpr double kRounding = 1e-10;

// What the tests need of either shape.
struct Sampled {
    SolidAngleCase c;
    std::vector<real3> vertices;
    double solid_angle;
    std::function<real3(double, double)> sample;  // unit direction
};

Sampled rectangle(const SolidAngleCase& c) {
    const SphericalRectangle q = spherical_rectangle(c.p, c.corner, c.e1, c.e2);
    return {c, c.rectangle(), q.solid_angle,
            [q](double u, double v) { return normalize(sample_spherical_rectangle(&q, u, v)); }};
}
Sampled triangle(const SolidAngleCase& c) {
    const SphericalTriangle t = spherical_triangle(c.p, c.corner, c.e1, c.e2);
    return {c, c.triangle(), t.solid_angle, [t](double u, double v) { return sample_spherical_triangle(&t, u, v); }};
}

std::vector<Sampled> all_shapes() {
    std::vector<Sampled> all;
    for (const SolidAngleCase& c : rectangle_cases())
        for (const SolidAngleCase& d : {c, c.turned(1)}) all.push_back(rectangle(d));
    for (const SolidAngleCase& c : triangle_cases())
        for (const SolidAngleCase& d : {c, c.turned(1)}) all.push_back(triangle(d));
    return all;
}

// Where the ray from p in direction w meets the shape's plane: a, b of corner + a e1 + b e2.
struct Place {
    double a, b;
};
Place place(const SolidAngleCase& c, real3 w) {
    const real3 n = cross(c.e1, c.e2), x = c.p + w * (dot(c.corner - c.p, n) / dot(w, n)) - c.corner;
    return {dot(cross(x, c.e2), n) / dot(n, n), dot(cross(c.e1, x), n) / dot(n, n)};
}

TEST(SolidAngle, Arctangent) {
    for (int i = -4000; i <= 4000; ++i) {
        const double t = std::tan(kPi / 2 * i / 4000.5);
        expect_relative(arctangent_polynomial(t), std::atan(t), 1.7e-8, "arctangent");
    }
}

TEST(SolidAngle, ClosedForms) {
    // The face of a cube from its centre: a sixth of the sphere. A rectangle of half edges a, b from d above its
    // centre: 4 asin(a b / sqrt((a² + d²) (b² + d²))). An octant of the sphere: pi/2.
    const auto quad = [](double a, double b, double d) {
        return spherical_rectangle({0, 0, d}, {-a, -b, 0}, {2 * a, 0, 0}, {0, 2 * b, 0}).solid_angle;
    };
    EXPECT_NEAR(quad(1, 1, 1), 4 * kPi / 6, kRounding);
    for (const double a : {0.01, 0.3, 1.0, 40.0})
        for (const double b : {0.02, 1.0, 7.0})
            for (const double d : {1e-5, 0.1, 1.0, 5.0})
                expect_relative(quad(a, b, d), 4 * std::asin(a * b / std::sqrt((a * a + d * d) * (b * b + d * d))),
                                2e-8, "on the axis");
    for (const double s : {1e-4, 1.0, 1e6})
        EXPECT_NEAR(spherical_triangle({0, 0, 0}, {s, 0, 0}, {-s, s, 0}, {-s, 0, s}).solid_angle, kPi / 2, 5e-8);
}

TEST(SolidAngle, IsGirards) {
    for (const Sampled& s : all_shapes()) {
        const double want = girard(s.vertices, s.c.p);
        EXPECT_GT(want, 0.005) << s.c.name;
        EXPECT_NEAR(s.solid_angle, want, kRounding) << s.c.name;
        // Small ones keep relative precision: a triangle always, a rectangle if its four angles do not cancel.
        if (s.vertices.size() == 3) expect_relative(s.solid_angle, want, 3e-8, s.c.name);
    }
    const SphericalTriangle small = spherical_triangle({0, 0, 1}, {0, 0, 0}, {1e-6, 0, 0}, {0, 1e-6, 0});
    expect_relative(small.solid_angle, 0.5e-12, 1e-6, "area over distance²");  // second order: 1e-12 of it
}

// The parametrisation itself: u cuts off a part of u times the solid angle; on the cut, v goes in proportion to the
// sine of the angle along it. 1e-7: the guard against division by sin 0, which shifts the one cut overhead by as much.
TEST(SolidAngle, RectangleIsCutInProportion) {
    for (const SolidAngleCase& c : rectangle_cases()) {
        const Sampled s = rectangle(c);
        for (const double u : {0.001, 0.1, 0.37, 0.5, 0.74, 0.999}) {
            const double cut = place(c, s.sample(u, 0.5)).a;
            EXPECT_NEAR(girard({c.corner, c.corner + cut * c.e1, c.corner + cut * c.e1 + c.e2, c.corner + c.e2}, c.p),
                        u * s.solid_angle, 1.1e-7)
                << c.name << " u " << u;
            const auto sine = [&](double b) {  // of the angle along the cut
                const real3 d = c.corner + cut * c.e1 + b * c.e2 - c.p;
                return dot(d, c.e2) / (length(d) * length(c.e2));
            };
            for (const double v : {0.001, 0.2, 0.5, 0.9, 0.999}) {
                const Place at = place(c, s.sample(u, v));
                EXPECT_NEAR(at.a, cut, kRounding) << c.name << " u " << u << " v " << v;
                EXPECT_NEAR((sine(at.b) - sine(0)) / (sine(1) - sine(0)), v, kRounding) << c.name << " u " << u;
            }
        }
    }
}

// The same of a triangle: cuts go from its second vertex to the side across; 1 - cos of the angle from the vertex is v
// times that of the cut's whole length.
TEST(SolidAngle, TriangleIsCutInProportion) {
    for (const SolidAngleCase& c : triangle_cases()) {
        const Sampled s = triangle(c);
        const real3 to_b = normalize(c.corner + c.e1 - c.p);
        for (const double u : {0.001, 0.1, 0.37, 0.5, 0.74, 0.999}) {
            const real3 plane = normalize(cross(to_b, s.sample(u, 0.5)));
            const real3 end = c.corner - (dot(c.corner - c.p, plane) / dot(c.e2, plane)) * c.e2;
            EXPECT_NEAR(girard({c.corner, c.corner + c.e1, end}, c.p), u * s.solid_angle, kRounding)
                << c.name << " u " << u;
            for (const double v : {0.001, 0.2, 0.5, 0.9, 0.999}) {
                const real3 w = s.sample(u, v);
                EXPECT_NEAR(length(w), 1, kRounding) << c.name;
                EXPECT_NEAR(dot(w, plane), 0, kRounding) << c.name << " u " << u << " v " << v;
                EXPECT_NEAR((1 - dot(w, to_b)) / (1 - dot(normalize(end - c.p), to_b)), v, kRounding)
                    << c.name << " u " << u;
            }
        }
    }
}

TEST(SolidAngle, SamplesLieInside) {
    std::mt19937 random(3);
    std::uniform_real_distribution<double> uniform(0, 1);
    for (const Sampled& s : all_shapes()) {
        for (int i = 0; i < 3000; ++i) {
            // Corners of the unit square first.
            const double u = i < 4 ? (i & 1) * 0.99999994 : uniform(random);
            const double v = i < 4 ? (i >> 1) * 0.99999994 : uniform(random);
            const real3 w = s.sample(u, v);
            ASSERT_TRUE(std::isfinite(w.x + w.y + w.z)) << s.c.name;
            const Place at = place(s.c, w);
            EXPECT_GT(dot(w, s.c.corner + at.a * s.c.e1 + at.b * s.c.e2 - s.c.p), 0) << s.c.name << ": behind p";
            EXPECT_GE(std::min(at.a, at.b), -1e-6) << s.c.name << " " << u << " " << v;
            EXPECT_LE(s.vertices.size() == 4 ? std::max(at.a, at.b) : at.a + at.b, 1 + 1e-6) << s.c.name;
        }
    }
}

// Solid angle times the mean cosine over samples is Lambert's irradiance of the polygon, in Stokes form. Samples are
// stratified, two a stratum, which tell their own standard error; 5 of it (60 cases: 1 failure in 30 000 runs, and the
// seed is fixed), and the arctangents'. The error itself is 0.1 % at most, so that the test has teeth.
TEST(SolidAngle, MeanCosineIsIrradiance) {
    std::mt19937 random(5);
    std::uniform_real_distribution<double> uniform(0, 1);
    const int strata = 96;
    for (const Sampled& s : all_shapes()) {
        double sum = 0, variance = 0;
        for (int i = 0; i < strata * strata; ++i) {
            double x[2];
            for (double& sample : x) {
                const double u = (i / strata + uniform(random)) / strata, v = (i % strata + uniform(random)) / strata;
                sample = std::max(dot(s.sample(u, v), s.c.n), 0.0);
            }
            sum += (x[0] + x[1]) / 2;
            variance += (x[0] - x[1]) * (x[0] - x[1]) / 4;
        }
        const double cells = strata * strata, found = s.solid_angle * sum / cells;
        const double error = s.solid_angle * std::sqrt(variance) / cells;
        const double want = polygon_irradiance(clip_to_horizon(s.vertices, s.c.p, s.c.n), s.c.p, s.c.n).value;
        EXPECT_LE(error, 1e-3 * want) << s.c.name;
        EXPECT_NEAR(found, want, 5 * error + kRounding) << s.c.name;
    }
}

// polygon_irradiance.json, made by a script independent of this project: the same with its E.
TEST(SolidAngle, IrradianceMatchesVectors) {
    std::mt19937 random(7);
    std::uniform_real_distribution<double> uniform(0, 1);
    const int strata = 128;
    int tested = 0;
    for (const json& j : load_vectors("polygon_irradiance", "cases")) {
        std::vector<real3> v;
        for (const json& x : j["vertices"]) v.push_back(vec3(x));
        if (v.size() > 4) continue;
        const real3 n = vec3(j["n"]);
        SolidAngleCase c{"", v[0], v[1] - v[0], v.back() - v[0], vec3(j["p"]), n};
        if (v.size() == 4 && std::abs(dot(c.e1, c.e2)) > 1e-12) continue;
        const Sampled s = v.size() == 4 ? rectangle(c) : triangle(c);
        double sum = 0, variance = 0;
        for (int i = 0; i < strata * strata; ++i) {
            double x[2];
            for (double& sample : x)
                sample =
                    dot(s.sample((i / strata + uniform(random)) / strata, (i % strata + uniform(random)) / strata), n);
            sum += (x[0] + x[1]) / 2;
            variance += (x[0] - x[1]) * (x[0] - x[1]) / 4;
        }
        const double cells = strata * strata, scale = s.solid_angle * j["radiance"].get<double>();
        EXPECT_NEAR(scale * sum / cells, j["E"].get<double>(), scale * (5 * std::sqrt(variance) / cells + 1e-7));
        ++tested;
    }
    EXPECT_GE(tested, 6);
}

// Random samples fall into parts of the shape in proportion to the parts' solid angles (Girard's): chi². Parts are
// equal areas, 4x4 of a rectangle, 16 similar triangles, so that near receivers have parts of very different solid
// angle.
TEST(SolidAngle, SamplesAreUniform) {
    std::mt19937 random(11);
    std::uniform_real_distribution<double> uniform(0, 1);
    const int samples = 20000;
    for (const Sampled& s : all_shapes()) {
        const bool quad = s.vertices.size() == 4;
        const auto at = [&](double a, double b) { return s.c.corner + (a / 4) * s.c.e1 + (b / 4) * s.c.e2; };
        std::vector<double> expected(32), found(32);
        for (int i = 0; i < 4; ++i)
            for (int j = 0; j < 4; ++j) {  // both halves of every square; the upper one may lie outside of a triangle
                const auto part = static_cast<std::size_t>(2 * (4 * i + j));
                expected[part] = girard({at(i, j), at(i + 1, j), at(i, j + 1)}, s.c.p);
                if (quad || i + j < 3)
                    expected[part + 1] = girard({at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)}, s.c.p);
                if (!quad && i + j > 3) expected[part] = 0;
            }
        double total = 0;
        for (double& e : expected) total += e;
        EXPECT_NEAR(total, s.solid_angle, kRounding) << s.c.name;
        for (int k = 0; k < samples; ++k) {
            const Place q = place(s.c, s.sample(uniform(random), uniform(random)));
            const double a = std::clamp(4 * q.a, 0.0, 3.9999999), b = std::clamp(4 * q.b, 0.0, 3.9999999);
            const int i = static_cast<int>(a), j = static_cast<int>(b);
            found[static_cast<std::size_t>(2 * (4 * i + j) + (a - i + b - j > 1 ? 1 : 0))] += 1;
        }
        double chi2 = 0, rest_expected = 0, rest_found = 0;
        int degrees = -1;
        const auto add = [&](double e, double f) {
            chi2 += (f - e) * (f - e) / e;
            ++degrees;
        };
        for (std::size_t k = 0; k < 32; ++k) {
            const double e = expected[k] / total * samples;
            if (e >= 10)
                add(e, found[k]);
            else
                rest_expected += e, rest_found += found[k];
        }
        if (rest_expected >= 10)
            add(rest_expected, rest_found);
        else
            EXPECT_LE(rest_found, 40) << s.c.name;  // Poisson: 10 + 9 sigma
        // Wilson and Hilferty 1931: (chi²/k)^(1/3) is normal with mean 1 - 2/(9k), variance 2/(9k). 60 cases: 4.5
        // sigma.
        if (degrees < 1) continue;
        const double spread = 2.0 / (9 * degrees);
        EXPECT_LE((std::cbrt(chi2 / degrees) - 1 + spread) / std::sqrt(spread), 4.5)
            << s.c.name << ": chi² " << chi2 << " of " << degrees;
    }
}

}  // namespace
}  // namespace irradia::test
