// Facets and Fresnel's formulas in float32 on the device against the same code in double, where float32 is hard.
#include "bsdf_kernels.h"

namespace irradia::host {
#define R(x) x
#include "cl/fresnel.h"
#include "cl/microfacet.h"
#undef R
}  // namespace irradia::host

namespace irradia::test {
namespace {

std::vector<double> run(const char* name, const Inputs& in, std::size_t stride, std::size_t outputs) {
    const std::size_t count = in.values().size() / stride;
    std::vector<float> out(count * outputs);
    Device& d = device();
    const Buffer from = d.upload(in.values());
    Buffer to = d.upload(out);
    Kernel kernel = d.kernel("bsdf_test.cl", name, {{"IR_FEATURES", "33u"}});
    kernel.arg(from).arg(to).arg(static_cast<std::uint32_t>(count)).run((count + 63) / 64, 64);
    d.read(to, out.data(), out.size() * sizeof(float));
    return {out.begin(), out.end()};
}

TEST(BsdfFormulas, Microfacets) {
    Inputs in;
    for (const double beckmann : {0.0, 1.0})
        for (const double alpha : {1e-4, 1e-3, 0.01, 0.1, 0.5, 1.0})
            for (const double ratio : {1.0, 0.2})
                for (const double c : {1.0, 0.99999, 0.9, 0.5, 0.1, 1e-2, 1e-3, 1e-5})
                    for (const double u0 : {0.0, 0x1p-24, 1e-3, 0.2, 0.5, 0.8, 0.999, 1 - 0x1p-24})
                        for (const double u1 : {0.0, 0.1, 0.37, 0.5, 0.75, 1 - 0x1p-24}) {
                            in.add(alpha).add(alpha * ratio).add(beckmann);
                            const Vec v = direction_at(c, 0.4 + 10 * c);
                            in.add({v[0], v[1], v[2]}).add(u0).add(u1);
                            // A facet of about the slope that matters.
                            const double tan = alpha * (4 * u0), phi = 6.2 * u1;
                            const Vec m = direction_at(1 / std::sqrt(1 + tan * tan), phi);
                            in.add({m[0], m[1], m[2]});
                        }
    const std::vector<double> out = run("test_microfacets", in, 11, 6);
    for (std::size_t i = 0; i < out.size() / 6; ++i) {
        const host::Microfacets f{in.scalar(i, 11, 0), in.scalar(i, 11, 1), in.scalar(i, 11, 2) != 0};
        const host::real3 v = in.vector(i, 11, 3), m = in.vector(i, 11, 8);
        const double u0 = in.scalar(i, 11, 6), u1 = in.scalar(i, 11, 7);
        const host::real3 n = host::sample_visible_normal(&f, v, u0, u1), found = vector_at(out, 6 * i);
        std::ostringstream where;
        for (std::size_t k = 0; k < 11; ++k) where << in.scalar(i, 11, k) << " ";
        // In slopes over the roughness, long ones by their inverse. The outermost quantiles are steep: the next random
        // number, 2^-24 on, is a percent away.
        const double x = n.x / n.z / f.alpha_u, y = n.y / n.z / f.alpha_v;
        const double du = found.x / found.z / f.alpha_u - x, dv = found.y / found.z / f.alpha_v - y;
        const bool outermost = u0 < 1e-6 || u0 > 1 - 1e-6;
        EXPECT_LE(std::hypot(du, dv), (outermost ? 3e-2 : 3e-4) * (1 + x * x + y * y)) << where.str();
        expect_relative(found.z > 0 ? host::dot(found, found) : 0, 1, 1e-6, where.str());
        // Relative to the value; far down Beckmann's tails, where exp() magnifies rounding, to the distribution's peak.
        const double d = host::microfacet_density(&f, m), g = host::smith_g1(&f, v, m);
        const double tolerance = 5e-6 * d + 1e-9 / (kPi * f.alpha_u * f.alpha_v);
        EXPECT_NEAR(out[6 * i + 3], d, tolerance) << where.str();
        expect_relative(out[6 * i + 4], g, 1e-6, where.str());
        EXPECT_NEAR(out[6 * i + 5], host::visible_normal_density(&f, v, m),
                    2 * tolerance * g * std::abs(host::dot(v, m)) / v.z)
            << where.str();
    }
}

// Closed forms: facets along the surface, seen from above, and normals drawn at u0 = 1/2, where GGX's disk is cut into
// halves of equal area (r² = 1/2: tan = alpha) and Beckmann's quantile is the middle.
TEST(BsdfFormulas, FacetsSeenFromAbove) {
    Inputs in;
    const std::vector<double> alphas{0.0009765625, 0.125, 1};
    for (const double beckmann : {0.0, 1.0})
        for (const double alpha : alphas)
            in.add(alpha).add(alpha).add(beckmann).add({0, 0, 1}).add(0.5).add(0.5).add({0, 0, 1});
    const std::vector<double> out = run("test_microfacets", in, 11, 6);
    for (std::size_t i = 0; i < out.size() / 6; ++i) {
        const double alpha = in.scalar(i, 11, 0), peak = 1 / (kPi * alpha * alpha);
        const host::real3 n = vector_at(out, 6 * i);
        EXPECT_NEAR(std::hypot(n.x, n.y) / n.z, i < alphas.size() ? alpha : 0, 1e-6 * alpha);
        expect_relative(out[6 * i + 3], peak, 1e-6, "density");
        EXPECT_EQ(out[6 * i + 4], 1);
        expect_relative(out[6 * i + 5], peak, 1e-6, "density of being drawn");
    }
}

// Near the critical angle, at grazing incidence, of indices that nearly match, of metals.
TEST(BsdfFormulas, Fresnel) {
    Inputs in;
    for (const double eta : {0.4, 1 / 1.5, 0.99, 1.0, 1.0001, 1.33, 1.5, 2.4, 10.0})
        for (const double k : {0.0, 1e-3, 1.0, 3.9, 1e4}) {
            for (const double c : {1.0, 0.9999999, 0.9, 0.5, 0.1, 1e-2, 1e-4, 1e-7, 0.0}) in.add(c).add(eta).add(k);
            if (eta < 1)
                for (const double d : {-1e-2, -1e-4, 1e-4, 1e-2}) in.add(std::sqrt(1 - eta * eta) + d).add(eta).add(k);
        }
    const std::vector<double> out = run("test_fresnel", in, 3, 3);
    for (std::size_t i = 0; i < out.size() / 3; ++i) {
        const double c = in.scalar(i, 3, 0), eta = in.scalar(i, 3, 1), k = in.scalar(i, 3, 2);
        double cos_t = 0;
        const double reflected = host::fresnel_dielectric(c, eta, &cos_t);
        const std::string where =
            "cosine " + std::to_string(c) + ", eta " + std::to_string(eta) + ", k " + std::to_string(k);
        // The refracted cosine is the root of a difference near one, and the reflectance falls with it from 1.
        const double root = std::min(kEps * (2 + 4 / (eta * eta) / std::max(cos_t, 1e-4)), 2e-3);
        EXPECT_NEAR(out[3 * i + 1], cos_t, root) << where;
        EXPECT_NEAR(out[3 * i], reflected, 10 * root + 2e-6) << where;
        // Metals; the square of k = 1e4 swallows cosines.
        if (k >= 1) {
            EXPECT_NEAR(out[3 * i + 2], host::fresnel_conductor(c, eta, k), k < 10 ? 1e-6 : 2e-4) << where;
        }
        EXPECT_TRUE(out[3 * i] >= 0 && out[3 * i] <= 1.000001 && out[3 * i + 2] >= 0 && out[3 * i + 2] <= 1.000001)
            << where;
    }
    // Closed forms: normal incidence, total reflection.
    double cos_t = 0;
    EXPECT_NEAR(host::fresnel_dielectric(1, 1.5, &cos_t), 0.04, 1e-12);
    EXPECT_NEAR(host::fresnel_conductor(1, 0.2, 3.9), (0.64 + 3.9 * 3.9) / (1.44 + 3.9 * 3.9), 1e-12);
    EXPECT_NEAR(host::fresnel_dielectric(0.2, 0.5, &cos_t), 1, 0);
}

}  // namespace
}  // namespace irradia::test
