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

struct Facets {
    host::Microfacets facets;
    double tolerance;
};

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
    double worst[4] = {};
    for (std::size_t i = 0; i < out.size() / 6; ++i) {
        const host::Microfacets f{in.scalar(i, 11, 0), in.scalar(i, 11, 1), in.scalar(i, 11, 2) != 0};
        const host::real3 v = in.vector(i, 11, 3), m = in.vector(i, 11, 8);
        const host::real3 n = host::sample_visible_normal(&f, v, in.scalar(i, 11, 6), in.scalar(i, 11, 7));
        const host::real3 found = vector_at(out, 6 * i);
        const auto where = [&] {
            std::ostringstream text;
            for (std::size_t k = 0; k < 11; ++k) text << in.scalar(i, 11, k) << " ";
            return text.str();
        };
        // In slopes over the roughness.
        const double du = (found.x / found.z - n.x / n.z) / f.alpha_u, dv = (found.y / found.z - n.y / n.z) / f.alpha_v;
        const double scale = 1 + std::hypot(n.x / n.z / f.alpha_u, n.y / n.z / f.alpha_v);
        const double slope = std::hypot(du, dv) / (scale * scale);
        if (slope > worst[0]) {
            worst[0] = slope;
            std::cout << "slope " << slope << " at " << where() << " found " << found.x << " " << found.y << " "
                      << found.z << " wanted " << n.x << " " << n.y << " " << n.z << "\n";
        }
        const double wanted[3] = {host::microfacet_density(&f, m), host::smith_g1(&f, v, m),
                                  host::visible_normal_density(&f, v, m)};
        for (std::size_t k = 0; k < 3; ++k) {
            const double error = std::abs(out[6 * i + 3 + k] - wanted[k]) / std::max(wanted[k], 1e-30);
            if (error > worst[k + 1] && wanted[k] > 1e-6) {
                worst[k + 1] = error;
                std::cout << k << " " << error << " at " << where() << " found " << out[6 * i + 3 + k] << " wanted "
                          << wanted[k] << "\n";
            }
        }
    }
}

}  // namespace
}  // namespace irradia::test
