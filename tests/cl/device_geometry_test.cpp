// The formulas in float32 on the device against the same headers in double, from the same (rounded) inputs.
// Tolerances count roundings (kEps each) and the 2.4e-7 of the device's fast sine; where they are larger, the comment
// at the test says why.
#include <random>

#include "device.h"

namespace irradia::test {
namespace {
using namespace irradia::host;

std::mt19937 generator(23);
double uniform(double lo, double hi) { return std::uniform_real_distribution<double>(lo, hi)(generator); }
real3 random_direction() {
    std::normal_distribution<double> g;
    const double x = g(generator), y = g(generator), z = g(generator);
    return normalize(make_real3(x, y, z));
}
constexpr double kFew = 16 * kEps;  // a short chain of operations on numbers of size 1

// s2 is rounded to kEps, so z^2 is good to a few kEps and z itself only to that over 2z: at the horizon 1e-4. The
// azimuth: rounding of turns (2 pi kEps) and of the argument, and the fast sine: 1e-6 in all.
TEST(DeviceSampling, Strata) {
    Inputs in;
    for (int i = 0; i < 4000; ++i) {
        const int m = i % 2 ? 16 : 32, n = i % 3 ? 64 : 50;
        in.add(i % m).add((i / 7) % n).add(m).add(n).add(uniform(0, .9999999)).add(uniform(0, .9999999));
    }
    for (const double xi : {0.0, .99999994}) in.add(15).add(63).add(16).add(64).add(xi).add(xi);
    const std::vector<double> out = run_formula("formula_stratum", in, 6, 3);
    for (std::size_t i = 0; i < out.size() / 3; ++i) {
        const auto u = [&](std::size_t k) { return static_cast<uint>(in.scalar(i, 6, k)); };
        const real3 want = stratum_direction(u(0), u(1), u(2), u(3), in.scalar(i, 6, 4), in.scalar(i, 6, 5));
        const real3 d = vector_at(out, 3 * i);
        EXPECT_NEAR(d.x, want.x, 1.2e-6);
        EXPECT_NEAR(d.y, want.y, 1.2e-6);
        EXPECT_NEAR(d.z * d.z, want.z * want.z, 2e-7);
        EXPECT_GE(d.z, 2.4e-4);                // never on the tangent plane
        EXPECT_NEAR(dot(d, d), 1, 2e-6) << i;  // never normalised, and need not be
    }
}

TEST(DeviceSampling, RingTables) {  // w_j subtracts angles of size 1 and multiplies by m: m times a few roundings
    Inputs in;
    for (uint m : {4u, 16u, 32u})
        for (uint j = 0; j < m; ++j) in.add(j).add(m);
    const std::vector<double> out = run_formula("formula_ring", in, 2, 5);
    for (std::size_t i = 0; i < out.size() / 5; ++i) {
        const uint j = static_cast<uint>(in.scalar(i, 2, 0)), m = static_cast<uint>(in.scalar(i, 2, 1));
        EXPECT_NEAR(out[5 * i], ring_rotation_weight(j, m), m * 8 * kEps);
        EXPECT_NEAR(out[5 * i + 1], ring_sin(j, m), 4 * kEps);
        EXPECT_NEAR(out[5 * i + 2], ring_cos(j, m), 4 * kEps);
        EXPECT_NEAR(out[5 * i + 3], ring_edge_weight(j, m), 4 * kEps);
        expect_relative(out[5 * i + 4], azimuth_edge_weight(j, m), 6 * kEps, "azimuth weight");
    }
}

TEST(DeviceSampling, FramesAndShapes) {
    Inputs normals, points;
    for (const real3 n : {real3{0, 0, 1}, real3{0, 0, -1}, real3{1, 0, 0}, real3{0, -1, 0}}) normals.add(n);
    for (int i = 0; i < 1000; ++i) normals.add(random_direction());
    const std::vector<double> frames = run_formula("formula_frame", normals, 3, 6);
    for (std::size_t i = 0; i < frames.size() / 6; ++i) {
        const Frame f = make_frame(normals.vector(i, 3, 0));
        EXPECT_LE(distance(vector_at(frames, 6 * i), f.t), kFew);
        EXPECT_LE(distance(vector_at(frames, 6 * i + 3), f.b), kFew);
    }
    points.add(0).add(0).add(.99999994).add(.99999994);
    for (int i = 0; i < 1000; ++i) points.add(uniform(0, 1)).add(uniform(0, 1));
    const std::vector<double> shapes = run_formula("formula_shapes", points, 2, 9);
    for (std::size_t i = 0; i < shapes.size() / 9; ++i) {
        const double u = points.scalar(i, 2, 0), v = points.scalar(i, 2, 1);
        EXPECT_LE(distance(vector_at(shapes, 9 * i), sample_triangle(u, v)), kFew);
        EXPECT_LE(distance(vector_at(shapes, 9 * i + 3), sample_disk(u, v)), 1.2e-6);  // the fast sine, as above
        EXPECT_LE(distance(vector_at(shapes, 9 * i + 6), sample_sphere(u, v)), 1.2e-6);
    }
}

// Both start from the same rounded u, so a steep quantile costs nothing; the gaussian is a chain of 13 operations.
TEST(DeviceFilter, QuantilesAndDistributions) {
    Inputs in;
    for (const double width : {0.25, 1.0, 30.0}) {
        for (const double u : {0.0, 5.9604645e-8, 1e-6, 1e-3, 0.5, 0.999, 0.99999994}) in.add(u).add(width).add(0);
        for (int i = 0; i < 2000; ++i) in.add(uniform(0, .9999999)).add(width).add(uniform(-4.5, 4.5) * width);
    }
    const std::vector<double> out = run_formula("formula_filter", in, 3, 4);
    for (std::size_t i = 0; i < out.size() / 4; ++i) {
        const double u = in.scalar(i, 3, 0), width = in.scalar(i, 3, 1), x = in.scalar(i, 3, 2);
        EXPECT_NEAR(out[4 * i], tent_quantile(u, width), width * kFew) << u;
        EXPECT_NEAR(out[4 * i + 1], tent_distribution(x, width), kFew);
        EXPECT_NEAR(out[4 * i + 2], gaussian_quantile(u, width), width * 4 * kFew) << u;
        EXPECT_NEAR(out[4 * i + 3], gaussian_distribution(x, width, 4 * width), kFew);
    }
}

TEST(DeviceFlux, AngleOverSine) {  // flux.h states 4e-7
    Inputs in;
    for (int i = 1; i < 20000; ++i) {
        const double angle = kPi * i / 20000, size = std::pow(10, uniform(-6, 6));
        in.add(std::pow(size * std::sin(angle), 2)).add(size * std::cos(angle));
    }
    for (int i = 0; i < 1000; ++i) in.add(std::pow(10, uniform(-12, -2))).add(1);
    in.add(1).add(0);
    const std::vector<double> out = run_formula("formula_angle", in, 2, 1);
    double worst = 0;
    for (std::size_t i = 0; i < out.size(); ++i) {
        const double root = std::sqrt(in.scalar(i, 2, 0)), want = std::atan2(root, in.scalar(i, 2, 1)) / root;
        worst = std::max(worst, std::abs(out[i] - want) / want);
    }
    RecordProperty("worst_relative_error", std::to_string(worst * 1e7) + "e-7");
    EXPECT_LE(worst, 4e-7);
}

// Edges of cells, lengths 1e-4 to 1e6, distance ratios to 2: relative error of g 2e-5 and of H 7e-5 (theory 5: what
// cancels in I2 .. U3 at the small angles of cells).
TEST(DeviceFlux, CellEdges) {
    Inputs in;
    const uint m = 16, n = 64;
    for (int i = 0; i < 3000; ++i) {
        const uint j = static_cast<uint>(uniform(0, m)), k = static_cast<uint>(uniform(0, n));
        const real3 w0 = make_real3(ring_sin(j, m) * std::cos(2 * kPi * k / n),
                                    ring_sin(j, m) * std::sin(2 * kPi * k / n), ring_cos(j, m));
        const bool ring = i % 2 && j > 0;
        const uint j1 = ring ? j : j + 1, k1 = ring ? k + 1 : k;
        const real3 w1 = make_real3(ring_sin(j1, m) * std::cos(2 * kPi * k1 / n),
                                    ring_sin(j1, m) * std::sin(2 * kPi * k1 / n), ring_cos(j1, m));
        const double r = std::pow(10, uniform(-4, 6));
        in.add(w0 * r).add(w1 * (r * std::pow(2, uniform(-1, 1)))).add(make_real3(0, 0, 1));
    }
    const std::vector<double> out = run_formula("formula_edge_flux", in, 9, 9);
    double worst_g = 0, worst_h = 0;
    for (std::size_t i = 0; i < out.size() / 9; ++i) {
        const EdgeFlux f = edge_flux(in.vector(i, 9, 0), in.vector(i, 9, 3), in.vector(i, 9, 6));
        worst_g = std::max(worst_g, distance(vector_at(out, 9 * i), f.g) / length(f.g));
        const double want[6] = {
            f.c.x * f.v.x, .5 * (f.c.x * f.v.y + f.c.y * f.v.x), .5 * (f.c.x * f.v.z + f.c.z * f.v.x),
            f.c.y * f.v.y, .5 * (f.c.y * f.v.z + f.c.z * f.v.y), f.c.z * f.v.z};
        double size = 0, error = 0;
        for (std::size_t q = 0; q < 6; ++q) {
            const double twice = q == 1 || q == 2 || q == 4 ? 2 : 1;
            size += twice * want[q] * want[q];
            error += twice * (out[9 * i + 3 + q] - want[q]) * (out[9 * i + 3 + q] - want[q]);
        }
        worst_h = std::max(worst_h, std::sqrt(error / size));
    }
    RecordProperty("worst_gradient", std::to_string(worst_g * 1e7) + "e-7");
    RecordProperty("worst_hessian", std::to_string(worst_h * 1e7) + "e-7");
    EXPECT_LE(worst_g, 2e-5);
    EXPECT_LE(worst_h, 7e-5);
}

// Edges of the vectors, whatever their shape: g and H at the tolerance above.
TEST(DeviceFlux, Vectors) {
    const json cases = load_vectors("edges", "cases");
    Inputs in;
    for (const json& c : cases) {
        const real3 ra = vec3(c["ra"]), rb = vec3(c["rb"]);
        const bool forward = dot(cross(ra, rb), vec3(c["omegaAB"])) > 0;
        in.add(forward ? ra : rb).add(forward ? rb : ra).add(vec3(c["n"]));
    }
    const std::vector<double> out = run_formula("formula_edge_flux", in, 9, 9);
    for (std::size_t i = 0; i < cases.size(); ++i) {
        expect_relative(vector_at(out, 9 * i), vec3(cases[i]["flux_grad"]), 2e-5, "g");
        const json& h = cases[i]["flux_hess_sym"];
        double size = 0;
        for (const json& row : h)
            for (const json& x : row) size += x.get<double>() * x.get<double>();
        const std::size_t at[3][3] = {{3, 4, 5}, {4, 6, 7}, {5, 7, 8}};
        for (std::size_t r = 0; r < 3; ++r)
            for (std::size_t c = 0; c < 3; ++c)
                EXPECT_NEAR(out[9 * i + at[r][c]], h[r][c].get<double>(), 7e-5 * std::sqrt(size));
    }
}

// Two neighbouring samples on one plane, on two planes that meet, or one before the other. A comparison that is decided
// within rounding may fall the other way (one in 1000 allowed); the rest agrees to the conditioning of f/ft:
// f > .02 of the inverse distance, so 1e-7/.02 a rounding, and as much again for cos at the hit >= .1.
TEST(DeviceCrease, NeighbouringSamples) {
    Inputs in;
    const uint m = 16, n = 64;
    const int count = 6000;
    for (int i = 0; i < count; ++i) {
        const uint j = 1 + static_cast<uint>(uniform(0, m - 1)), k = static_cast<uint>(uniform(0, n));
        const real3 a = stratum_direction(j, k, m, n, uniform(0, 1), uniform(0, 1));
        const real3 b = stratum_direction(j, k + 1, m, n, uniform(0, 1), uniform(0, 1));
        const real3 w0 = stratum_direction(j, k + 1, m, n, 0, 0), w1 = stratum_direction(j, k + 1, m, n, 1, 0);
        const double scale = std::pow(10, uniform(-3, 3));
        const auto facing = [&](real3 d) {  // cos at the hit at least .1
            for (;;) {
                const real3 q = random_direction();
                if (dot(q, d) < -.15) return q;
            }
        };
        const real3 na = facing(a);
        real3 nb = i % 3 == 0 ? na : facing(b);
        double ra = scale, rb = -1;
        if (i % 3 == 0) rb = ra * dot(na, a) / dot(na, b);  // one plane
        if (i % 3 == 1) {                                   // planes that meet at w between
            const real3 w = normalize(a + b);
            rb = ra * dot(na, a) / dot(na, w) * dot(nb, w) / dot(nb, b);
        }
        if (i % 3 == 2) rb = ra * uniform(1.5, 30);  // an occlusion
        if (!(rb > 0)) rb = kMiss;
        in.add(a).add(ra).add(na).add(b).add(rb).add(nb).add(w0).add(w1);
    }
    const std::vector<double> out = run_formula("formula_crease", in, 20, 3);
    int different = 0, finite = 0;
    for (std::size_t i = 0; i < out.size() / 3; ++i) {
        const CellEdge e =
            crease_edge(in.vector(i, 20, 0), in.scalar(i, 20, 3), in.vector(i, 20, 4), in.vector(i, 20, 7),
                        in.scalar(i, 20, 10), in.vector(i, 20, 11), in.vector(i, 20, 14), in.vector(i, 20, 17));
        const double worst = std::max({std::abs(out[3 * i] - e.inverse0), std::abs(out[3 * i + 1] - e.inverse1),
                                       std::abs(out[3 * i + 2] - e.centre)});
        if (worst > 1e-4 * e.centre) ++different;
        // Whatever was decided, corners stay within a factor 2 of a positive centre.
        const double c = out[3 * i + 2];
        if (c > 0 && out[3 * i] >= .4999 * c && out[3 * i] <= 2.001 * c && out[3 * i + 1] >= .4999 * c &&
            out[3 * i + 1] <= 2.001 * c)
            ++finite;
    }
    EXPECT_EQ(finite, count);
    EXPECT_LE(different, count / 1000);
}

}  // namespace
}  // namespace irradia::test
