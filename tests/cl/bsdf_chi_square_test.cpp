// Samples of BSDFs against their densities: Pearson's test over cells of polar angle and azimuth; and what the
// densities and the values integrate to.
#include "bsdf_kernels.h"

namespace irradia::test {
namespace {

constexpr std::size_t kRows = 40, kColumns = 24;  // cells over the whole sphere; the horizon is an edge of them
// Nodes: Gauss and Legendre's rule of two in polar angle (lobes of glass are narrow at the pole), midpoints in azimuth.
constexpr std::size_t kFineRows = 12 * kRows, kFineColumns = 8 * kColumns;
constexpr std::size_t kSamples = 40000;

struct Case {
    std::string name;
    std::uint32_t triangle;
    double cosine;  // of the view; below 0: from behind
};

double polar_angle(std::size_t fine_row) {
    const double within = 0.5 + (fine_row % 2 == 0 ? -0.5 : 0.5) / std::sqrt(3.0);
    return (static_cast<double>(fine_row / 2) + within) * 2 * kPi / kFineRows;
}

Vec view_of(const Case& c) { return direction_at(c.cosine, 0.7); }

std::vector<Case> add_cases(BsdfKernels& kernels) {
    std::vector<Case> all;
    const auto add = [&](const std::string& name, const shared::Material& m, double alpha, bool behind) {
        const std::uint32_t triangle = kernels.add(m);
        for (const double c : {1.0, 0.6, 0.15}) {
            if (c == 0.15 && alpha < 0.2) continue;  // lobes of some cells only
            all.push_back({name + ", cosine " + std::to_string(c), triangle, c});
            if (behind) all.push_back({name + ", cosine " + std::to_string(-c), triangle, -c});
        }
    };
    add("diffuse", of_colour(blank_material(), 1, 1, 1), 1, false);
    add("plastic", plastic(IR_MATERIAL_PLASTIC, 1.5, 1, true), 1, false);
    for (const bool beckmann : {false, true})
        for (const double alpha : {0.1, 0.3, 1.0}) {
            const std::string rest = (beckmann ? " Beckmann " : " GGX ") + std::to_string(alpha);
            add("conductor" + rest, conductor(IR_MATERIAL_ROUGH_CONDUCTOR, 0.1, 1e4, alpha, beckmann), alpha, false);
            add("dielectric" + rest, dielectric(IR_MATERIAL_ROUGH_DIELECTRIC, 1.5, alpha, beckmann), alpha, true);
            add("plastic" + rest, plastic(IR_MATERIAL_ROUGH_PLASTIC, 1.5, 1, true, alpha, beckmann), alpha, false);
            Case lobe = all.back();
            lobe.name = "lobe of " + lobe.name, lobe.triangle |= BsdfKernels::lobe;
            all.push_back(lobe);
            if (alpha > 0.2) continue;
            shared::Material brushed = conductor(IR_MATERIAL_ROUGH_CONDUCTOR, 0.1, 1e4, alpha, beckmann);
            brushed.alpha_v = 0.4f;
            add("brushed conductor" + rest, brushed, alpha, false);
        }
    return all;
}

struct Integrals {
    std::vector<double> cells = std::vector<double>(kRows * kColumns);  // of the density
    double density = 0;
    double albedo = 0;  // of the BSDF times the cosine, without the compression of radiance by refraction
};

Integrals integrate(BsdfKernels& kernels, const Case& c) {
    std::vector<BsdfKernels::Pair> pairs;
    for (std::size_t i = 0; i < kFineRows; ++i)
        for (std::size_t k = 0; k < kFineColumns; ++k)
            pairs.push_back(
                {c.triangle, view_of(c),
                 direction_at(std::cos(polar_angle(i)), (static_cast<double>(k) + 0.5) * 2 * kPi / kFineColumns)});
    const std::vector<BsdfValue> values = kernels.evaluate(pairs);
    const auto eta = static_cast<double>(kernels.material(c.triangle).eta);
    Integrals result;
    for (std::size_t i = 0; i < kFineRows; ++i) {
        const double solid_angle = std::sin(polar_angle(i)) * kPi / kFineRows * 2 * kPi / kFineColumns;
        for (std::size_t k = 0; k < kFineColumns; ++k) {
            const BsdfValue& v = values[i * kFineColumns + k];
            const double share = v.density * solid_angle;
            result.cells[i / 12 * kColumns + k / 8] += share;
            result.density += share;
            const bool refracted = pairs[i * kFineColumns + k].direction[2] * c.cosine < 0;
            const double compression = refracted ? (c.cosine > 0 ? eta * eta : 1 / (eta * eta)) : 1;
            result.albedo += (c.triangle & BsdfKernels::lobe ? v.glossy : v.sum())[1] * solid_angle * compression;
        }
    }
    return result;
}

struct Counts {
    std::vector<double> cells = std::vector<double>(kRows * kColumns);
    double specular = 0, absorbed = 0;
    double weight = 0, variance = 0;  // mean of the samples' weights, its variance; compression undone
};

Counts count(BsdfKernels& kernels, const Case& c, unsigned seed) {
    std::mt19937 random(seed);
    const auto uniform = [&] { return static_cast<double>(static_cast<float>(random() >> 8) * 0x1p-24f); };
    std::vector<BsdfKernels::Draw> draws;
    for (std::size_t i = 0; i < kSamples; ++i)
        draws.push_back({c.triangle, view_of(c), {uniform(), uniform(), uniform()}});
    Counts counts;
    double square = 0;
    for (const BsdfSample& s : kernels.sample(draws)) {
        if (!s.valid) {
            ++counts.absorbed;
            continue;
        }
        const double weight = s.weight()[1] * s.eta * s.eta;
        counts.weight += weight / kSamples, square += weight * weight / kSamples;
        if (s.density == 0) {
            ++counts.specular;
            continue;
        }
        const double theta = std::acos(std::clamp(s.direction[2], -1.0, 1.0));
        double turns = std::atan2(s.direction[1], s.direction[0]) / (2 * kPi);
        turns -= std::floor(turns);
        const auto row = std::min(static_cast<std::size_t>(theta / kPi * kRows), kRows - 1);
        ++counts.cells[row * kColumns + std::min(static_cast<std::size_t>(turns * kColumns), kColumns - 1)];
    }
    counts.variance = std::max(square - counts.weight * counts.weight, 0.0) / kSamples;
    return counts;
}

/// Probability that Pearson's statistic is at least as large by chance (Wilson and Hilferty's approximation). Cells in
/// which fewer than five are expected, and what is in none, are counted together.
double pearson(const Counts& counts, const Integrals& integrals) {
    double statistic = 0, expected_rest = (1 - integrals.density) * kSamples;
    double rest = counts.specular + counts.absorbed;
    int cells = 0;
    const auto add = [&](double found, double expected) {
        statistic += (found - expected) * (found - expected) / expected;
        ++cells;
    };
    for (std::size_t i = 0; i < counts.cells.size(); ++i) {
        const double expected = integrals.cells[i] * kSamples;
        if (expected >= 5) {
            add(counts.cells[i], expected);
        } else {
            expected_rest += expected;
            rest += counts.cells[i];
        }
    }
    if (expected_rest >= 5)
        add(rest, expected_rest);
    else
        EXPECT_LE(rest, 30) << "of " << expected_rest << " expected";
    const double k = cells - 1;
    const double z = (std::cbrt(statistic / k) - (1 - 2 / (9 * k))) / std::sqrt(2 / (9 * k));
    return 0.5 * std::erfc(z / std::sqrt(2.0));
}

TEST(BsdfSamples, AreDistributedAsTheDensitySays) {
    BsdfKernels kernels;
    const std::vector<Case> cases = add_cases(kernels);
    unsigned seed = 100;
    for (const Case& c : cases) {
        const Integrals integrals = integrate(kernels, c);
        const Counts counts = count(kernels, c, ++seed);
        // One percent for all cases together (Bonferroni).
        EXPECT_GT(pearson(counts, integrals), 0.01 / static_cast<double>(cases.size())) << c.name;
        // The same, less finely, of what is no direction.
        const double lost = (counts.specular + counts.absorbed) / kSamples;
        EXPECT_NEAR(integrals.density + lost, 1, 4.5 * std::sqrt(0.25 / kSamples)) << c.name;
        EXPECT_LE(integrals.density, 1.002) << c.name;
        // White furnace: nothing returns more light than came. Plastics' mirror reflection is no part of the integral.
        EXPECT_LE(integrals.albedo, 1.002) << c.name;
        EXPECT_LE(counts.weight, 1 + 4.5 * std::sqrt(counts.variance) + 1e-6) << c.name;
        if (counts.specular == 0) {
            EXPECT_NEAR(counts.weight, integrals.albedo, 4.5 * std::sqrt(counts.variance) + 2e-3) << c.name;
        }
    }
    EXPECT_GT(cases.size(), 50u);
}

// The test itself: a roughness one tenth off is noticed.
TEST(BsdfSamples, OfAnotherDensityAreFoundOut) {
    BsdfKernels kernels;
    const std::uint32_t a = kernels.add(conductor(IR_MATERIAL_ROUGH_CONDUCTOR, 0.1, 1e4, 0.3));
    const std::uint32_t b = kernels.add(conductor(IR_MATERIAL_ROUGH_CONDUCTOR, 0.1, 1e4, 0.33));
    EXPECT_LT(pearson(count(kernels, {"", a, 0.6}, 1), integrate(kernels, {"", b, 0.6})), 1e-6);
    EXPECT_GT(pearson(count(kernels, {"", a, 0.6}, 1), integrate(kernels, {"", a, 0.6})), 1e-3);
}

// Samples of the glossy part alone are those of the whole BSDF that chose it, without what they say of the diffuse
// part.
TEST(BsdfSamples, OfLobesAloneAreThoseThatChoseThem) {
    BsdfKernels kernels;
    const std::vector<std::uint32_t> all{kernels.add(plastic(IR_MATERIAL_PLASTIC, 1.5, 0.5, true)),
                                         kernels.add(plastic(IR_MATERIAL_ROUGH_PLASTIC, 1.5, 0.5, true, 0.2)),
                                         kernels.add(conductor(IR_MATERIAL_ROUGH_CONDUCTOR, 0.2, 4, 0.2)),
                                         kernels.add(dielectric(IR_MATERIAL_ROUGH_DIELECTRIC, 1.5, 0.2))};
    std::mt19937 random(1);
    const auto uniform = [&] { return static_cast<double>(static_cast<float>(random() >> 8) * 0x1p-24f); };
    for (const std::uint32_t triangle : all) {
        std::vector<BsdfKernels::Draw> whole, lobes;
        for (int i = 0; i < 4000; ++i) {
            whole.push_back({triangle, direction_at(0.3 + 0.6 * uniform(), 0.7), {uniform(), uniform(), uniform()}});
            lobes.push_back({triangle | BsdfKernels::lobe, whole.back().view, whole.back().u});
        }
        const std::vector<BsdfSample> a = kernels.sample(whole), b = kernels.sample(lobes);
        int left_out = 0;
        for (std::size_t i = 0; i < a.size(); ++i) {
            left_out += a[i].valid && !b[i].valid;
            if (!b[i].valid) continue;
            ASSERT_TRUE(a[i].valid);
            EXPECT_EQ(a[i].direction, b[i].direction);
            EXPECT_EQ(b[i].diffuse, (Vec{0, 0, 0}));
            if (a[i].density == 0) {
                EXPECT_EQ(a[i].glossy, b[i].glossy);
                continue;
            }
            EXPECT_LE(b[i].density, a[i].density * (1 + 1e-6));
            EXPECT_NEAR(a[i].glossy[0] * a[i].density, b[i].glossy[0] * b[i].density,
                        1e-6 * a[i].glossy[0] * a[i].density);
        }
        const bool mixed = triangle < all[2];  // of a coat and a base
        EXPECT_EQ(left_out > 2000, mixed) << left_out << " of triangle " << triangle;
        if (!mixed) {
            EXPECT_EQ(left_out, 0);
        }
    }
}

// Lossless and smooth: every sample carries all of the light.
TEST(BsdfSamples, OfClearGlassLoseNothing) {
    BsdfKernels kernels;
    const std::vector<std::uint32_t> all{kernels.add(dielectric(IR_MATERIAL_DIELECTRIC, 1.5)),
                                         kernels.add(dielectric(IR_MATERIAL_DIELECTRIC, 0.75)),
                                         kernels.add(dielectric(IR_MATERIAL_THIN_DIELECTRIC, 1.5))};
    std::vector<BsdfKernels::Draw> draws;
    for (const std::uint32_t t : all)
        for (double c = -1; c <= 1; c += 0.0625)
            for (double u = 0; u < 1; u += 0.0625) draws.push_back({t, direction_at(c, 2), {u, 0, 0}});
    const std::vector<BsdfSample> samples = kernels.sample(draws);
    int refracted = 0;
    for (std::size_t i = 0; i < samples.size(); ++i) {
        const BsdfSample& s = samples[i];
        ASSERT_TRUE(s.valid);
        EXPECT_EQ(s.density, 0);
        EXPECT_NEAR(s.weight()[0] * s.eta * s.eta, 1, 3e-7);
        if (s.eta == 1) continue;
        ++refracted;  // Snell's law, in the plane of incidence
        const Vec& v = draws[i].view;
        EXPECT_NEAR(s.direction[0] * s.eta, -v[0], 1e-6);
        EXPECT_NEAR(s.direction[1] * s.eta, -v[1], 1e-6);
        EXPECT_LT(s.direction[2] * v[2], 0);
    }
    EXPECT_GT(refracted, 500);
}

}  // namespace
}  // namespace irradia::test
