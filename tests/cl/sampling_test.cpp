// Strata, ring tables, frames, samples of shapes. Numbers: sampling.json, tolerance of theory 9: 1e-12.
#include <random>

#include "formulas.h"

namespace irradia::test {
namespace {
using namespace irradia::host;

TEST(Sampling, StratumDirectionsMatchVectors) {
    for (const json& c : load_vectors("sampling", "cases")) {
        const real3 d = stratum_direction(c["j"], c["k"], c["M"], c["N"], c["xi1"], c["xi2"]);
        EXPECT_LE(distance(d, vec3(c["dir"])), 1e-12) << c.dump();
    }
}

TEST(Sampling, RingTablesMatchVectors) {
    const json vectors = load_vectors("sampling");
    for (const auto& [key, t] : vectors.at("rings").items()) {
        const uint m = static_cast<uint>(std::stoul(key));
        for (uint j = 0; j < m; ++j) {
            const std::string at = "M=" + key + " j=" + std::to_string(j);
            EXPECT_NEAR(ring_rotation_weight(j, m), t["tan_exact_weight"][j].get<double>(), 1e-12) << at;
            EXPECT_NEAR(ring_sin(j, m), t["sin_minus"][j].get<double>(), 1e-12) << at;
            EXPECT_NEAR(ring_edge_weight(j, m), t["cos2sin_minus"][j].get<double>(), 1e-12) << at;
            EXPECT_NEAR(azimuth_edge_weight(j, m), t["ward_azimuth"][j].get<double>(), 1e-12) << at;
            // What the renderer does not use, from the same edges: tan at the centre (1.4), Krivanek's weight (1.5).
            const double s = std::sqrt((j + 0.5) / m), c = std::sqrt(1 - (j + 0.5) / m);
            EXPECT_NEAR(s / c, t["tan_centre"][j].get<double>(), 1e-12) << at;
            EXPECT_NEAR(c * (ring_cos(j, m) - ring_cos(j + 1, m)) / s, t["krivanek_azimuth"][j].get<double>(), 1e-12)
                << at;
        }
    }
}

TEST(Sampling, FramesAreRightHanded) {
    std::mt19937 random(1);
    std::normal_distribution<double> normal;
    std::vector<real3> normals = {{0, 0, 1}, {0, 0, -1}, {1, 0, 0}, {0, -1, 0}, {1e-9, 0, -1}};
    for (int i = 0; i < 1000; ++i)
        normals.push_back(normalize(make_real3(normal(random), normal(random), normal(random))));
    for (const real3 n : normals) {
        const Frame f = make_frame(n);
        EXPECT_LE(distance(cross(f.t, f.b), n), 1e-14);
        EXPECT_NEAR(length(f.t), 1, 1e-14);
        EXPECT_NEAR(dot(f.t, f.b), 0, 1e-14);
        EXPECT_LE(distance(to_world(f, to_local(f, make_real3(.3, -.5, .7))), make_real3(.3, -.5, .7)), 1e-14);
    }
}

TEST(Sampling, FramesAreThoseOfTheVectors) {  // so that local directions mean the same
    for (const json& c : load_vectors("hemisphere_cells", "cases")) {
        const Frame f = make_frame(vec3(c["n"]));
        EXPECT_LE(distance(f.t, vec3(c["T"])) + distance(f.b, vec3(c["B"])), 1e-15) << c["name"];
    }
    for (const json& c : load_vectors("reproject", "cases")) {
        const Frame f = make_frame(vec3(c["n"]));
        EXPECT_LE(distance(f.t, vec3(c["T"])) + distance(f.b, vec3(c["B"])), 1e-14);
    }
}

// First and second moments on a 400 x 400 midpoint grid of (u, v), whose error is below 1e-4, against closed forms.
TEST(Sampling, ShapesHaveUniformDensity) {
    const int n = 400;
    real3 triangle{0, 0, 0}, disk{0, 0, 0}, disk2{0, 0, 0}, sphere{0, 0, 0}, sphere2{0, 0, 0}, triangle2{0, 0, 0};
    for (int i = 0; i < n; ++i)
        for (int j = 0; j < n; ++j) {
            const double u = (i + .5) / n, v = (j + .5) / n, w = 1.0 / (n * n);
            const real3 t = sample_triangle(u, v), d = sample_disk(u, v), s = sample_sphere(u, v);
            EXPECT_TRUE(t.x >= 0 && t.y >= 0 && t.z >= 0);
            triangle += w * t, triangle2 += w * (t * t), disk += w * d, disk2 += w * (d * d);
            sphere += w * s, sphere2 += w * (s * s);
        }
    EXPECT_LE(distance(triangle, make_real3(1. / 3, 1. / 3, 1. / 3)), 1e-4);
    EXPECT_LE(distance(triangle2, make_real3(1. / 6, 1. / 6, 1. / 6)), 1e-4);
    EXPECT_LE(distance(disk, make_real3(0, 0, 0)), 1e-12);
    EXPECT_LE(distance(disk2, make_real3(.25, .25, 0)), 1e-12);
    EXPECT_LE(distance(sphere, make_real3(0, 0, 0)), 1e-12);
    EXPECT_LE(distance(sphere2, make_real3(1. / 3, 1. / 3, 1. / 3)), 1e-4);
}

TEST(Sampling, CosineDensityGivesExactMoments) {  // E[cos] = 2/3, E[cos^2] = 1/2; the midpoint rule is exact for cos^2
    double cosine = 0, cosine2 = 0;
    for (uint j = 0; j < 1000; ++j) {
        const double z = stratum_direction(j, 3, 1000, 7, .5, .5).z;
        cosine += z / 1000, cosine2 += z * z / 1000;
    }
    EXPECT_NEAR(cosine, 2. / 3, 1e-5);
    EXPECT_NEAR(cosine2, .5, 1e-12);
}

}  // namespace
}  // namespace irradia::test
