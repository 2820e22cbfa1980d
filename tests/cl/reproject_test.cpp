// Re-projected samples: reproject.json at 1e-9 (theory 9), and a furnace.
#include "formulas.h"

namespace irradia::test {
namespace {
using namespace irradia::host;

TEST(Reproject, MatchesVectors) {
    for (const json& c : load_vectors("reproject", "cases")) {
        const real3 pi = vec3(c["record_p"]), ni = vec3(c["record_n"]), p = vec3(c["p"]);
        const Frame frame = frame_of(c);
        const real3 wo = vec3(c["wo_local"]);
        ReprojectedSum flat = reprojected_sum_zero();
        std::vector<ReprojectedSample> samples;
        for (std::size_t s = 0; s < c["dirs"].size(); ++s) {
            const real3 w = vec3(c["dirs"][s]);
            samples.push_back(reproject_sample(pi - p, w, c["r"][s], vec3(c["hit_normal"][s]), dot(ni, w), frame.n));
            expect_relative(samples[s].weight, c["W"][s], 1e-9, "W of sample " + std::to_string(s));
            const double L = c["L"][s];
            flat = reprojected_add(flat, samples[s], 1, make_real3(L, L, L));
        }
        expect_relative(reprojected_radiance(flat, kPi).x, c["E"], 1e-9, "E");
        for (const auto& [alpha, wanted] : c["Lo_over_albedo"].items()) {
            ReprojectedSum sum = reprojected_sum_zero();
            for (std::size_t s = 0; s < samples.size(); ++s) {
                const double f = ggx_brdf(to_local(frame, samples[s].direction), wo, std::stod(alpha));
                const double L = c["L"][s];
                sum = reprojected_add(sum, samples[s], f, make_real3(L, L, L));
            }
            expect_relative(reprojected_radiance(sum, 1).x, wanted, 1e-9, "Lo/albedo, alpha " + alpha);
        }
    }
}

TEST(Reproject, IsExactInAFurnaceAndSurvivesMissesAndContact) {
    const real3 n{0, 0, 1};
    ReprojectedSum sum = reprojected_sum_zero();
    for (uint s = 0; s < 64; ++s) {
        const real3 w = stratum_direction(s / 8, s % 8, 8, 8, .3, .6);
        const double r = s % 3 == 0 ? kMiss : s % 3 == 1 ? .5 + s : .2;
        // The point asked for lies exactly on the hit of sample 8.
        const real3 moved = .2 * stratum_direction(1, 0, 8, 8, .3, .6);
        const ReprojectedSample t = reproject_sample(-moved, w, r, -w, w.z, n);
        EXPECT_TRUE(std::isfinite(t.weight) && std::isfinite(t.cosine));
        sum = reprojected_add(sum, t, ggx_brdf(t.direction, make_real3(.6, 0, .8), .3), make_real3(1, 2, 3));
    }
    expect_relative(reprojected_radiance(sum, .9), make_real3(.9, 1.8, 2.7), 1e-12, "furnace");
    const ReprojectedSample miss = reproject_sample(make_real3(3, 2, 1), make_real3(.6, 0, .8), kMiss, n, .8, n);
    EXPECT_EQ(miss.direction.x, .6);
    EXPECT_EQ(miss.weight, 1 / .8);
}

}  // namespace
}  // namespace irradia::test
