// Samples of solid angles in float32 on the device. What float32 can know: the device's receiver is the given one to
// kFew of the largest distance in the picture ("size"). Moved by delta, a receiver at distance d from the line of an
// edge sees the solid angle change by 2 delta/d at most (the edge turns by delta/d, and no edge is longer than pi).
#include <algorithm>
#include <random>

#include "device.h"
#include "solid_angle.h"

namespace irradia::test {
namespace {
using namespace irradia::host;

constexpr double kFew = 8 * kEps;
constexpr double kAngles = 2e-6;  // roundings of angles of size 2 pi: arctangents, fast sines, arccosines

struct Device32 {  // a case as the device sees it, and its answers for stratified u, v, two a stratum
    SolidAngleCase c;
    bool quad;
    double want, solid_angle;  // Girard's; the device's
    std::vector<std::array<double, 2>> uv;
    std::vector<real3> directions;
    [[nodiscard]] std::vector<real3> vertices() const { return quad ? c.rectangle() : c.triangle(); }
    [[nodiscard]] double size() const {
        double s = 0;
        for (const real3 v : vertices()) s = std::max(s, length(v - c.p));
        return s;
    }
    // What a displacement by kFew of the size changes: by all edges, and by the cut at u, no nearer than the plane.
    [[nodiscard]] double change_of_solid_angle() const {
        const std::vector<real3> v = vertices();
        double sum = 0;
        for (std::size_t i = 0; i < v.size(); ++i) {
            const real3 edge = v[(i + 1) % v.size()] - v[i];
            sum += 2 * kFew * size() / (length(cross(v[i] - c.p, edge)) / length(edge));
        }
        return sum;
    }
    [[nodiscard]] double height() const {
        const real3 n = cross(c.e1, c.e2);
        return std::abs(dot(c.corner - c.p, n)) / length(n);
    }
    [[nodiscard]] double change_of_cut() const { return 2 * kFew * size() / height(); }
    [[nodiscard]] std::string name() const {
        return c.name + (quad ? ", rectangle of size " : ", triangle of size ") + std::to_string(size());
    }
};

constexpr int kStrata = 32;

std::vector<Device32> run(bool quad) {
    std::vector<Device32> all;
    for (const SolidAngleCase& c : quad ? rectangle_cases() : triangle_cases())
        for (const double scale : {1e-4, 1.0, 1e6}) {
            SolidAngleCase plain = c;
            for (real3* v : {&plain.corner, &plain.e1, &plain.e2, &plain.p}) *v *= scale;
            all.push_back({plain, quad, 0, 0, {}, {}});
            all.push_back({c.turned(scale), quad, 0, 0, {}, {}});
        }
    std::mt19937 random(13);
    std::uniform_real_distribution<double> uniform(0, 1);
    Inputs in;
    const int count = 2 * kStrata * kStrata;
    for (const Device32& d : all)
        for (int i = 0; i < count; ++i) {
            in.add(d.c.p).add(d.c.corner).add(d.c.e1).add(d.c.e2);
            in.add((i / 2 / kStrata + uniform(random)) / kStrata).add((i / 2 % kStrata + uniform(random)) / kStrata);
        }
    const std::vector<double> out = run_formula(quad ? "formula_rectangle" : "formula_triangle", in, 14, 4);
    std::size_t at = 0;
    for (Device32& d : all) {
        d.c.p = in.vector(at, 14, 0), d.c.corner = in.vector(at, 14, 3);  // rounded
        d.c.e1 = in.vector(at, 14, 6), d.c.e2 = in.vector(at, 14, 9);
        d.want = girard(d.vertices(), d.c.p);
        d.solid_angle = out[4 * at];
        for (int i = 0; i < count; ++i, ++at) {
            d.uv.push_back({in.scalar(at, 14, 12), in.scalar(at, 14, 13)});
            d.directions.push_back(normalize(vector_at(out, 4 * at + 1)));
        }
    }
    return all;
}

// The face of a cube from its centre, a sixth of the sphere; an octant; their middles.
TEST(DeviceSolidAngles, ClosedForms) {
    const real3 centre{0.5, 0.5, 0.5}, o{0, 0, 0}, x{1, 0, 0}, y{0, 1, 0};
    const std::vector<double> face =
        run_formula("formula_rectangle", Inputs().add(centre).add(o).add(x).add(y).add(0.5).add(0.5), 14, 4);
    EXPECT_NEAR(face[0], 4 * kPi / 6, kAngles);
    EXPECT_LE(distance(vector_at(face, 1), {0, 0, -0.5}), kAngles);
    const std::vector<double> octant =
        run_formula("formula_triangle", Inputs().add(o).add(x).add(y - x).add({-1, 0, 1}).add(0.5).add(1), 14, 4);
    EXPECT_NEAR(octant[0], kPi / 2, kAngles);
    EXPECT_LE(distance(vector_at(octant, 1), {std::sqrt(0.5), 0, std::sqrt(0.5)}), kAngles);
}

class DeviceSolidAngle : public ::testing::TestWithParam<bool> {};

TEST_P(DeviceSolidAngle, IsGirards) {
    double worst = 0;
    for (const Device32& d : run(GetParam())) {
        EXPECT_NEAR(d.solid_angle, d.want, kAngles + d.change_of_solid_angle()) << d.name();
        if (d.height() > 0.05 * d.size()) worst = std::max(worst, std::abs(d.solid_angle - d.want) / d.want);
    }
    RecordProperty("worst_relative_error_of_plain_cases", std::to_string(worst * 1e6) + "e-6");
    EXPECT_LE(worst, 3e-5);  // where nothing is hard: kAngles of 0.07 sr
}

// The part that u cuts off. Directions next to the vertex that cuts meet in (v < 0.05) do not tell which cut they lie
// on.
TEST_P(DeviceSolidAngle, SamplesAreCutInProportion) {
    for (const Device32& d : run(GetParam())) {
        const real3 n = cross(d.c.e1, d.c.e2);
        double worst = 0;
        for (std::size_t i = 0; i < d.uv.size(); ++i) {
            const auto [u, v] = d.uv[i];
            const real3 w = d.directions[i];
            ASSERT_NEAR(length(w), 1, 1e-12) << d.name();  // finite
            if (v < 0.05 || u < 0.01 || u > 0.99) continue;
            std::vector<real3> part;
            if (d.quad) {
                const real3 x = w * (dot(d.c.corner - d.c.p, n) / dot(w, n)) - (d.c.corner - d.c.p);
                const real3 cut = d.c.e1 * (dot(x, d.c.e1) / dot(d.c.e1, d.c.e1));
                part = {d.c.corner, d.c.corner + cut, d.c.corner + cut + d.c.e2, d.c.corner + d.c.e2};
            } else {
                const real3 plane = cross(d.c.corner + d.c.e1 - d.c.p, w);
                const real3 end = d.c.corner - (dot(d.c.corner - d.c.p, plane) / dot(d.c.e2, plane)) * d.c.e2;
                part = {d.c.corner, d.c.corner + d.c.e1, end};
            }
            worst = std::max(worst, std::abs(girard(part, d.c.p) - u * d.want));
        }
        EXPECT_LE(worst, 2 * kAngles + d.change_of_solid_angle() + d.change_of_cut()) << d.name();
    }
}

// What light needs: solid angle times mean cosine is the polygon's irradiance. 5 standard errors, told by the pairs
// (168 cases: 1 failure in 10 000, and the seed is fixed), and what float32 cannot know, which shifts a direction by as
// much as it shifts a cut.
TEST_P(DeviceSolidAngle, MeanCosineIsIrradiance) {
    for (const Device32& d : run(GetParam())) {
        double sum = 0, variance = 0;
        for (std::size_t i = 0; i < d.uv.size(); i += 2) {
            const double x = std::max(dot(d.directions[i], d.c.n), 0.0);
            const double y = std::max(dot(d.directions[i + 1], d.c.n), 0.0);
            sum += (x + y) / 2;
            variance += (x - y) * (x - y) / 4;
        }
        const double strata = kStrata * kStrata, found = d.solid_angle * sum / strata;
        const double error = d.solid_angle * std::sqrt(variance) / strata;
        const double want = polygon_irradiance(clip_to_horizon(d.vertices(), d.c.p, d.c.n), d.c.p, d.c.n).value;
        EXPECT_LE(error, 0.002 * d.solid_angle) << d.name();  // the noise hides nothing
        EXPECT_NEAR(found, want, 5 * error + kAngles + d.change_of_solid_angle() + d.change_of_cut()) << d.name();
    }
}

// Where nothing is hard, every single direction agrees with the host's: kAngles sr, over the 0.1 rad that the smallest
// shapes measure across.
TEST_P(DeviceSolidAngle, SamplesAgreeWithTheHosts) {
    double worst = 0;
    int cases = 0;
    for (const Device32& d : run(GetParam())) {
        if (d.height() < 0.1 * d.size() || d.want < 0.01) continue;
        ++cases;
        const SphericalRectangle q = spherical_rectangle(d.c.p, d.c.corner, d.c.e1, d.c.e2);
        const SphericalTriangle t = spherical_triangle(d.c.p, d.c.corner, d.c.e1, d.c.e2);
        for (std::size_t i = 0; i < d.uv.size(); ++i) {
            const auto [u, v] = d.uv[i];
            const real3 w =
                d.quad ? normalize(sample_spherical_rectangle(&q, u, v)) : sample_spherical_triangle(&t, u, v);
            worst = std::max(worst, distance(w, d.directions[i]));
        }
    }
    EXPECT_GE(cases, 24);
    RecordProperty("worst_direction", std::to_string(worst * 1e6) + "e-6");
    EXPECT_LE(worst, 2e-5);
}

INSTANTIATE_TEST_SUITE_P(Shapes, DeviceSolidAngle, ::testing::Bool(),
                         [](const auto& p) { return p.param ? "Rectangle" : "Triangle"; });

}  // namespace
}  // namespace irradia::test
