// Lobes as radiance records are asked by them (cl/lobe.h) against the BSDFs, and their tables against integrals in
// double.
#include "radiance_kernels.h"

namespace irradia::test {
namespace {
using namespace irradia::host;

class RadianceLobe : public RadianceTest {};
INSTANTIATE_TEST_SUITE_P(Traversals, RadianceLobe, ::testing::Values("cpu", "gpu"), traversal_name);

constexpr double kLeastAlpha = .02;  // IR_LEAST_ALPHA of lobe.h

std::mt19937 generator(31);
double uniform(double lo, double hi) { return std::uniform_real_distribution<double>(lo, hi)(generator); }

// ---- weights
// ---------------------------------------------------------------------------------------------------------

struct Weights {
    real3 direction;  // local frame
    double weight, schlick;
    Vec reflection;
};

/// Of `octets` times eight directions about the lobe of a material seen from `view` (local frame) over normal n: about
/// the mirror direction as facets turn it, and all over the hemisphere.
std::vector<Weights> lobe_weights(Device& device, const shared::Material& m, real3 n, real3 view, int octets) {
    const Frame frame = make_frame(n);
    const Microfacets facets = facets_of(m, static_cast<double>(m.alpha_u));
    Inputs questions, directions;
    for (int i = 0; i < octets; ++i) {
        questions.add(0).add(static_cast<double>(m.alpha_u)).add({0, 0, 0}).add(n).add(to_world(frame, view));
        std::vector<real3> ws;
        while (ws.size() < 8) {
            real3 w = cosine_direction(uniform(0, 1), uniform(0, 1));
            if (ws.size() < 6) {
                const real3 h = sample_visible_normal(&facets, view, uniform(0, 1), uniform(0, 1));
                w = h * (2 * dot(h, view)) - view;
            }
            if (w.z > 1e-2) ws.push_back(to_world(frame, w));
        }
        for (const real3& w : ws) directions.add(w.x);
        for (const real3& w : ws) directions.add(w.y);
        for (const real3& w : ws) directions.add(w.z);
    }
    std::vector<float> out(static_cast<std::size_t>(octets) * 40);
    const Buffer list = device.upload(std::vector<shared::Material>{m}), asked = device.upload(questions.values()),
                 to = device.upload(directions.values()), answers = device.upload(out);
    device.kernel("radiance_test.cl", "test_lobe_weights", {{"IR_FEATURES", "33u"}})
        .arg(list)
        .arg(asked)
        .arg(to)
        .arg(answers)
        .arg(static_cast<std::uint32_t>(octets))
        .run((static_cast<std::size_t>(octets) + 15) / 16, 16);
    device.read(answers, out.data(), out.size() * sizeof(float));
    std::vector<Weights> all;
    for (std::size_t i = 0; i < static_cast<std::size_t>(octets); ++i)
        for (std::size_t k = 0; k < 8; ++k) {
            const auto a = [&](std::size_t set) { return static_cast<double>(out[40 * i + 8 * set + k]); };
            const auto d = [&](std::size_t axis) { return directions.scalar(i, 24, 8 * axis + k); };
            all.push_back({to_local(frame, {d(0), d(1), d(2)}), a(0), a(1), {a(2), a(3), a(4)}});
        }
    return all;
}

// facet_reflection of bsdf.h gives the factor where it is largest; everywhere else both must agree, to some roundings
// of the facets' slope over the roughness (2^-24 / .05 = 1.2e-6), steepened by the square of the denominator of D and,
// in the tails of grazing views, by that factor's own error: 4e-5 were found.
void expect_proportional(const std::vector<Weights>& all, const shared::Material& m, double tolerance) {
    Vec f0{1, 1, 1};
    if (m.kind == IR_MATERIAL_ROUGH_CONDUCTOR) f0 = facet_fresnel(m, 1);
    for (std::size_t channel = 0; channel < 3; ++channel) {
        const auto weight = [&](const Weights& w) {
            return m.kind == IR_MATERIAL_ROUGH_CONDUCTOR ? w.weight * (f0[channel] + (1 - f0[channel]) * w.schlick)
                                                         : w.weight;
        };
        double largest = 0, factor = 0;
        for (const Weights& w : all)
            if (w.reflection[channel] > largest)
                largest = w.reflection[channel], factor = weight(w) / w.reflection[channel];
        ASSERT_GT(largest, 0);
        for (const Weights& w : all)
            ASSERT_NEAR(weight(w) / factor, w.reflection[channel], tolerance * largest)
                << "roughness " << m.alpha_u << " flags " << m.flags << " kind " << m.kind << " channel " << channel;
    }
}

constexpr std::array<double, 6> roughnesses{.05, .1, .2, .4, .7, 1};
constexpr std::array<double, 6> view_cosines{1, .9, .6, .3, .1, .02};

real3 random_normal() { return normalize(make_real3(uniform(-1, 1), uniform(-1, 1), uniform(-1, 1))); }

TEST_P(RadianceLobe, WeightsAreTheBsdfUpToAFactor) {
    for (const bool beckmann : {false, true})
        for (const double alpha : roughnesses)
            for (const auto& m : {coated(1.5, alpha, beckmann), metal("none", alpha, beckmann)})
                for (const double c : view_cosines) {
                    const real3 view = to_real3(direction_at(c, uniform(0, 6)));
                    expect_proportional(lobe_weights(device(), m, random_normal(), view, 40), m, 1e-4);
                }
}

// Few directions: quick enough for oclgrind (oclgrind_test.cpp).
TEST_P(RadianceLobe, WeightsOfOneView) {
    for (const auto& m : {coated(1.5, .3), metal("none", .3, true)})
        expect_proportional(lobe_weights(device(), m, {0, 0, 1}, to_real3(direction_at(.6, 1)), 2), m, 1e-4);
}

// Schlick's shape of a metal's reflectance, over cosines between view and facet from 0 to 1: how far it is off,
// relative to the exact reflectance. Figures of these three metals, found by this loop.
const std::map<std::string, double> kSchlickError{{"Cu", .036}, {"Al", .15}, {"Au", .074}};

TEST(RadianceLobeShape, SchlicksErrorIsAsStated) {
    for (const auto& [name, stated] : kSchlickError) {
        const shared::Material m = metal(name, .3);
        double worst = 0;
        for (int i = 0; i <= 1000; ++i) {
            const Vec exact = facet_fresnel(m, i / 1000.0), shape = schlick_fresnel(m, i / 1000.0);
            for (std::size_t k = 0; k < 3; ++k) worst = std::max(worst, std::abs(shape[k] / exact[k] - 1));
        }
        EXPECT_LE(worst, stated) << name;
        EXPECT_GE(worst, .9 * stated) << name;
    }
}

// The factor is taken where the reflection is largest, so that the error counts twice at most.
TEST_P(RadianceLobe, WeightsOfMetalsAreWithinSchlicksError) {
    for (const auto& [name, error] : kSchlickError)
        for (const bool beckmann : {false, true})
            for (const double alpha : roughnesses)
                for (const double c : view_cosines) {
                    const shared::Material m = metal(name, alpha, beckmann);
                    const real3 view = to_real3(direction_at(c, uniform(0, 6)));
                    const auto all = lobe_weights(device(), m, random_normal(), view, 20);
                    expect_proportional(all, m, 2 * error);
                    // With the exact reflectance taken out, nothing but Schlick's is left.
                    std::vector<Weights> without = all;
                    for (Weights& w : without) {
                        const double cosine = dot(normalize(w.direction + view), view);
                        const Vec exact = facet_fresnel(m, cosine), shape = schlick_fresnel(m, cosine);
                        for (std::size_t k = 0; k < 3; ++k) w.reflection[k] *= shape[k] / exact[k];
                    }
                    expect_proportional(without, m, 1e-4);
                }
}

// ---- tables
// ----------------------------------------------------------------------------------------------------------

/// Albedo and coefficients of a lobe for a view of azimuth 0, in the order of lobe.h, by another rule than the tables'
/// own.
std::vector<double> lobe_integrals(const shared::Material& m, double alpha, double cosine, uint order) {
    const real3 wi = to_real3(direction_at(std::max(cosine, 1e-3), 0));  // as the tables have it
    std::vector<double> out(3 + 3 * (order * (order + 1) / 2)), basis(order * order);
    integrate_lobe(m, alpha, wi, [&](real3 wo, const Vec& share) {
        hsh_basis(wo, order, basis.data());
        for (std::size_t k = 0; k < 3; ++k) {
            out[k] += share[k];
            for (uint l = 0; l < order; ++l)
                for (uint q = 0; q <= l; ++q) out[3 + 3 * (l * (l + 1) / 2 + q) + k] += share[k] * basis[l * l + l + q];
        }
    });
    return out;
}

/// Largest difference, relative to the albedo of its channel: of the albedo, of a coefficient.
std::array<double, 2> table_error(const std::vector<double>& found, const std::vector<double>& wanted) {
    std::array<double, 2> error{0, 0};
    for (std::size_t i = 0; i < wanted.size(); ++i) {
        double& e = error[i < 3 ? 0 : 1];
        e = std::max(e, std::abs(found.at(i) - wanted[i]) / wanted[i % 3]);
    }
    return error;
}

/// Cosine of the view in the table of 64 entries, `step` (0 to 63) of its steps over the horizon.
double cosine_at(double step) { return std::sin(.5 * kPi * step / 63); }

/// The largest table_error over plastics and copper of both distributions at three roughnesses and these steps.
std::array<double, 2> largest_error(Device& device, const std::vector<double>& steps) {
    constexpr uint order = 5;
    std::vector<shared::Material> materials;
    for (const double alpha : {.05, .3, 1.0})
        for (const bool beckmann : {false, true}) {
            materials.push_back(coated(1.5, alpha, beckmann));
            materials.push_back(metal("Cu", alpha, beckmann));
        }
    LobeTables tables(device, materials, order);
    std::array<double, 2> largest{0, 0};
    for (std::size_t i = 0; i < materials.size(); ++i)
        for (const double step : steps) {
            const auto alpha = static_cast<double>(materials[i].alpha_u);
            const auto wanted = lobe_integrals(materials[i], alpha, cosine_at(step), order);
            const auto error = table_error(tables.values(i, {{false, alpha, cosine_at(step)}}), wanted);
            for (std::size_t k = 0; k < 2; ++k) largest[k] = std::max(largest[k], error[k]);
        }
    return largest;
}

// The quadrature alone, at entries of the table: .1 % of the albedo and .18 % of it in coefficients were found.
TEST_P(RadianceLobe, TablesHoldTheIntegrals) {
    const auto error = largest_error(device(), {63, 44, 19, 6, 1, 0});
    EXPECT_LE(error[0], 1.2e-3);
    EXPECT_LE(error[1], 2.2e-3);
}

// With interpolation, half-way between entries: .15 % and .25 % beyond a quarter of a right angle over the surface; .6
// % and .9 % below, where narrow lobes change as fast as the angle itself.
TEST_P(RadianceLobe, TablesInterpolateOverTheAngle) {
    const auto error = largest_error(device(), {62.5, 61.5, 44.5, 19.5}),
               grazing = largest_error(device(), {6.5, 1.5, .5});
    EXPECT_LE(error[0], 1.6e-3);
    EXPECT_LE(error[1], 2.6e-3);
    EXPECT_LE(grazing[0], 7e-3);
    EXPECT_LE(grazing[1], 1e-2);
}

// Roughness from a texture, half-way between the table's 24 (.04 apart): 2 % at roughness .06, .1 % in the middle.
TEST_P(RadianceLobe, TablesInterpolateOverTheRoughness) {
    constexpr uint order = 5;
    const std::map<double, double> tolerances{{1, 3e-3},   {1.5, 4e-2},    {2.5, 2.5e-2}, {4.5, 1.2e-2},
                                              {9.5, 3e-3}, {15.5, 1.5e-3}, {22.5, 2e-3},  {23, 2e-3}};
    for (const bool beckmann : {false, true}) {
        std::vector<shared::Material> materials{coated(1.5, .3, beckmann), metal("Cu", .3, beckmann)};
        for (shared::Material& m : materials) m.alpha_texture = 0;
        LobeTables tables(device(), materials, order);
        for (std::size_t i = 0; i < 2; ++i)
            for (const auto& [row, tolerance] : tolerances)
                for (const double step : {63.0, 32.0, 6.0}) {
                    const double alpha = kLeastAlpha + (1 - kLeastAlpha) * row / 23;
                    const auto error = table_error(tables.values(i, {{true, alpha, cosine_at(step)}}),
                                                   lobe_integrals(materials[i], alpha, cosine_at(step), order));
                    EXPECT_LE(std::max(error[0], error[1]), tolerance) << "row " << row << " step " << step;
                }
    }
}

// Rounding may ask beyond the table: its outermost entries answer.
TEST_P(RadianceLobe, OutermostEntriesOfATable) {
    shared::Material textured = metal("none", .3);
    textured.alpha_texture = 0;
    LobeTables tables(device(), {textured}, 2, 4, 2);
    const auto v = tables.values(0, {{true, 1, 1}, {true, 1.1, 1.1}, {true, kLeastAlpha, 0}, {true, .01, -.1}});
    for (std::size_t k = 0; k < tables.entry(); ++k) {
        EXPECT_NEAR(v[k], v[tables.entry() + k], 1e-6);
        EXPECT_NEAR(v[2 * tables.entry() + k], v[3 * tables.entry() + k], 1e-6);
    }
    EXPECT_GT(std::abs(v[0] - v[2 * tables.entry()]), 1e-3) << "they differ";
}

}  // namespace
}  // namespace irradia::test
