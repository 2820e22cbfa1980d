// What every BSDF has to satisfy, whatever its model: samples that agree with the values, reciprocity, finite numbers.
#include "bsdf_kernels.h"

namespace irradia::test {
namespace {

struct Named {
    std::string name;
    std::uint32_t triangle;
};

/// One of each kind and of what it makes a difference to.
std::vector<Named> add_all(BsdfKernels& kernels, const std::vector<double>& alphas) {
    std::vector<Named> all;
    const auto add = [&](const std::string& name, const shared::Material& m) {
        all.push_back({name, kernels.add(m, true)});
    };
    add("diffuse", of_colour(blank_material(), 0.3, 0.6, 0.9));
    add("conductor", conductor(IR_MATERIAL_CONDUCTOR, 0.2, 3.9));
    add("dielectric", dielectric(IR_MATERIAL_DIELECTRIC, 1.5));
    add("dielectric into thinner", dielectric(IR_MATERIAL_DIELECTRIC, 0.75));
    add("thin dielectric", dielectric(IR_MATERIAL_THIN_DIELECTRIC, 1.5));
    add("plastic", plastic(IR_MATERIAL_PLASTIC, 1.5, 0.5, false));
    add("nonlinear plastic", plastic(IR_MATERIAL_PLASTIC, 1.9, 0.9, true));
    for (const bool beckmann : {false, true})
        for (const double alpha : alphas) {
            const std::string rest = (beckmann ? ", Beckmann " : ", GGX ") + std::to_string(alpha);
            add("conductor" + rest, conductor(IR_MATERIAL_ROUGH_CONDUCTOR, 0.2, 3.9, alpha, beckmann));
            add("dielectric" + rest, dielectric(IR_MATERIAL_ROUGH_DIELECTRIC, 1.5, alpha, beckmann));
            add("plastic" + rest, plastic(IR_MATERIAL_ROUGH_PLASTIC, 1.5, 0.5, true, alpha, beckmann));
            shared::Material brushed = conductor(IR_MATERIAL_ROUGH_CONDUCTOR, 0.2, 3.9, alpha, beckmann);
            brushed.alpha_v = static_cast<float>(std::min(1.0, 4 * alpha));
            add("brushed conductor" + rest, brushed);
        }
    return all;
}

float unit_random(std::mt19937& random) { return static_cast<float>(random() >> 8) * 0x1p-24f; }

Vec random_direction(std::mt19937& random) {
    const auto cosine = static_cast<double>(2 * unit_random(random) - 1);
    const Vec d = direction_at(cosine, 2 * kPi * static_cast<double>(unit_random(random)));
    return {static_cast<double>(static_cast<float>(d[0])), static_cast<double>(static_cast<float>(d[1])),
            static_cast<double>(static_cast<float>(d[2]))};
}

// Weight times density is the BSDF times the cosine, and the density is what other samplers will be told of.
TEST(Bsdf, SamplesWeighTheValueOverTheDensity) {
    BsdfKernels kernels;
    const std::vector<Named> all = add_all(kernels, {0.05, 0.3, 1.0});
    std::mt19937 random(11);
    std::vector<BsdfKernels::Draw> draws;
    for (const Named& m : all)
        for (int i = 0; i < 1000; ++i)
            draws.push_back({m.triangle,
                             random_direction(random),
                             {unit_random(random), unit_random(random), unit_random(random)}});
    const std::vector<BsdfSample> samples = kernels.sample(draws);
    std::vector<BsdfKernels::Pair> pairs;
    for (std::size_t i = 0; i < draws.size(); ++i)
        pairs.push_back({draws[i].triangle, draws[i].view, samples[i].direction});
    const std::vector<BsdfValue> values = kernels.evaluate(pairs);
    int with_density = 0, without = 0;
    for (std::size_t i = 0; i < draws.size(); ++i) {
        const BsdfSample& s = samples[i];
        const std::string name = all[i / 1000].name;
        if (!s.valid) continue;
        ASSERT_NEAR(dot(s.direction, s.direction), 1, 4e-6) << name;
        const bool crosses = s.direction[2] * draws[i].view[2] < 0;
        if (s.density == 0) {
            ++without;
            continue;
        }
        ++with_density;
        ASSERT_TRUE(s.eta == 1 || crosses) << name;
        ASSERT_NEAR(values[i].density, s.density, 1e-5 * s.density) << name;
        for (std::size_t c = 0; c < 3; ++c) {
            ASSERT_NEAR(values[i].diffuse[c], s.diffuse[c] * s.density, 1e-5 * s.density) << name;
            ASSERT_NEAR(values[i].glossy[c], s.glossy[c] * s.density, 1e-5 * s.density) << name;
        }
    }
    EXPECT_GT(with_density, 20000);
    EXPECT_GT(without, 4000);
}

// f(wi, wo) = f(wo, wi) for reflection. Refraction compresses radiance by the square of the index: with eta the index
// on wo's side over that on wi's, f(wi, wo) = f(wo, wi) / eta^2, where light comes along wo and leaves along wi.
TEST(Bsdf, IsReciprocal) {
    BsdfKernels kernels;
    const std::vector<Named> all = add_all(kernels, {0.05, 0.3, 1.0});
    std::mt19937 random(12);
    std::vector<BsdfKernels::Pair> there, back;
    for (const Named& m : all)
        for (int i = 0; i < 500; ++i) {
            Vec a = random_direction(random), b = random_direction(random);
            if (i % 2 == 1)
                b = {-a[0] + 0.1 * b[0], -a[1] + 0.1 * b[1], a[2] + 0.1 * b[2]};  // about where facets shine
            const double length = std::sqrt(dot(b, b));
            for (double& x : b) x = static_cast<double>(static_cast<float>(x / length));
            there.push_back({m.triangle, a, b});
            back.push_back({m.triangle, b, a});
        }
    const std::vector<BsdfValue> f = kernels.evaluate(there), g = kernels.evaluate(back);
    int compared = 0, refracted = 0;
    for (std::size_t i = 0; i < f.size(); ++i) {
        const Vec &wi = there[i].view, &wo = there[i].direction;
        double square = 1;
        if (wi[2] * wo[2] < 0) {
            const auto eta = static_cast<double>(kernels.material(there[i].triangle).eta);
            square = wi[2] > 0 ? eta * eta : 1 / (eta * eta);
        }
        for (std::size_t c = 0; c < 3; ++c) {
            const double a = f[i].sum()[c] / std::abs(wo[2]) * square, b = g[i].sum()[c] / std::abs(wi[2]);
            // The tails of a facets' lobe magnify the rounding of the half vector: by D'/D, up to 1 / alpha^2.
            ASSERT_NEAR(a, b, 1e-3 * std::max(a, b) + 1e-6) << all[i / 500].name << ", case " << i % 500;
            if (a > 1e-4) ++compared, refracted += square != 1 ? 1 : 0;
        }
    }
    EXPECT_GT(compared, 10000);
    EXPECT_GT(refracted, 300);
}

// Any view, any random numbers: grazing and normal incidence, roughness at both ends, numbers at the ends of [0, 1).
TEST(Bsdf, NeverGivesAnythingButNumbers) {
    BsdfKernels kernels;
    const std::vector<Named> all = add_all(kernels, {1e-4, 0.02, 0.5, 1.0});
    std::mt19937 random(13);
    const std::vector<double> ends{0, 0x1p-24, 0.5, 1 - 0x1p-24};
    const std::vector<double> cosines{1, 1 - 6e-8, 0.9999, 0.5, 1e-2, 1e-3, 1e-4, 1e-6, 1e-8, 1e-12, 0};
    std::vector<BsdfKernels::Draw> draws;
    for (const Named& m : all) {
        for (const double c : cosines)
            for (const double side : {1.0, -1.0})
                for (const double a : ends)
                    for (const double b : ends)
                        for (const double d : ends)
                            draws.push_back({m.triangle, direction_at(side * c, c * 100), {a, b, d}});
        for (int i = 0; i < 25000; ++i) {
            Vec view = random_direction(random);
            if (i % 4 == 0) view = direction_at(std::pow(10.0, -6.0 * static_cast<double>(unit_random(random))), i);
            draws.push_back({m.triangle, view, {unit_random(random), unit_random(random), unit_random(random)}});
        }
    }
    ASSERT_GT(draws.size(), 900000u);
    const std::vector<BsdfSample> samples = kernels.sample(draws);
    std::vector<BsdfKernels::Pair> pairs;
    for (std::size_t i = 0; i < draws.size(); ++i)
        pairs.push_back({draws[i].triangle, draws[i].view,
                         i % 2 == 0 && samples[i].valid ? samples[i].direction : random_direction(random)});
    const std::vector<BsdfValue> values = kernels.evaluate(pairs);
    const auto good = [](const Vec& v) {
        return std::all_of(v.begin(), v.end(), [](double x) { return std::isfinite(x) && x >= 0; });
    };
    const std::size_t each = draws.size() / all.size();
    for (std::size_t i = 0; i < draws.size(); ++i) {
        const BsdfSample& s = samples[i];
        const auto where = [&] {
            std::ostringstream text;
            const auto& [triangle, v, u] = draws[i];
            text << all[i / each].name << ", view " << v[0] << " " << v[1] << " " << v[2] << ", random " << u[0] << " "
                 << u[1] << " " << u[2];
            return text.str();
        };
        ASSERT_TRUE(good(s.diffuse) && good(s.glossy) && std::isfinite(s.density) && s.density >= 0 && s.eta >= 0 &&
                    std::isfinite(dot(s.direction, s.direction)))
            << where();
        if (s.valid) {
            ASSERT_NEAR(dot(s.direction, s.direction), 1, 1e-5) << where();
            // No fireflies: what a sample carries is at most what a white surface reflects, over the probability of the
            // part (plastic: of coat or base, at least 0.3 here), times the index squared into the thinner medium.
            ASSERT_LE(largest(s.weight()), 6) << where();
        }
        ASSERT_TRUE(good(values[i].diffuse) && good(values[i].glossy) && std::isfinite(values[i].density) &&
                    values[i].density >= 0)
            << where();
    }
}

// The back of what has one side only reflects nothing, whatever the front is made of.
TEST(Bsdf, IsDarkBehind) {
    BsdfKernels kernels;
    const std::vector<std::uint32_t> all{kernels.add(of_colour(blank_material(), 0.5, 0.5, 0.5)),
                                         kernels.add(conductor(IR_MATERIAL_CONDUCTOR, 0.2, 3.9)),
                                         kernels.add(conductor(IR_MATERIAL_ROUGH_CONDUCTOR, 0.2, 3.9)),
                                         kernels.add(plastic(IR_MATERIAL_PLASTIC, 1.5, 0.5, false))};
    for (const double side : {1.0, -1.0}) {
        std::vector<BsdfKernels::Pair> pairs;
        std::vector<BsdfKernels::Draw> draws;
        for (const std::uint32_t t : all) {
            pairs.push_back({t, direction_at(side * 0.8, 1), direction_at(side * 0.8, 1 + kPi)});
            draws.push_back({t, direction_at(side * 0.8, 1), {0.1, 0.2, 0.3}});
        }
        for (const BsdfSample& s : kernels.sample(draws)) EXPECT_EQ(s.valid && largest(s.weight()) > 0, side > 0);
        const std::vector<BsdfValue> values = kernels.evaluate(pairs);
        for (const std::size_t i : {0, 2, 3}) EXPECT_EQ(largest(values[i].sum()) > 0, side > 0) << i;  // 1: a mirror
    }
}

// alpha_u is the roughness along the texture coordinate u, wherever that runs. Of the same directions, turned:
TEST(Bsdf, TurnsBrushesWithTheTexture) {
    BsdfKernels kernels;
    shared::Material brushed = conductor(IR_MATERIAL_ROUGH_CONDUCTOR, 0.2, 3.9, 0.05);
    brushed.alpha_v = 0.4f;
    const std::uint32_t straight = kernels.add(brushed), turned = kernels.add(brushed, false, true);
    const Vec view = direction_at(0.7, 0.3);
    std::vector<BsdfKernels::Pair> pairs;
    for (const auto& [dx, dy] : {std::pair{0.0, 0.0}, {0.1, 0.0}, {0.0, 0.1}, {-0.2, 0.3}}) {
        Vec w{-view[0] + dx, -view[1] + dy, 0};
        w[2] = std::sqrt(1 - dot(w, w));
        pairs.push_back({straight, view, w});
        pairs.push_back({turned, {-view[1], view[0], view[2]}, {-w[1], w[0], w[2]}});
    }
    const std::vector<BsdfValue> values = kernels.evaluate(pairs);
    for (std::size_t i = 0; i < values.size(); i += 2)
        EXPECT_NEAR(values[i].glossy[0], values[i + 1].glossy[0], 1e-4 * values[0].glossy[0]) << i;
    EXPECT_GT(values[4].glossy[0], 3 * values[2].glossy[0]);  // off the mirror direction: wide along v, narrow along u
}

}  // namespace
}  // namespace irradia::test
