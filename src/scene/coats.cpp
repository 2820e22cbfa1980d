// What the dielectric coat of plastics lets through, as Mitsuba 3 computes it, so that both render the same surface.
#include <cmath>
#include <numbers>

#include "scene/build.h"

#include "cl/portable.h"
namespace irradia::host {
#include "cl/fresnel.h"
#include "cl/microfacet.h"
}  // namespace irradia::host

namespace irradia::loader {
namespace {

constexpr int nodes = 64;  // of the quadrature, in either random number

struct Quadrature {
    std::vector<double> x, weight;
};

/// Gauss and Legendre's rule on [0, 1].
Quadrature gauss_legendre(int n) {
    Quadrature q;
    for (int i = 0; i < n; ++i) {
        double x = std::cos(std::numbers::pi * (i + 0.75) / (n + 0.5)), slope = 1.0;
        for (int step = 0; step < 20; ++step) {
            double p = 1.0, before = 0.0;  // Legendre's polynomials by their recurrence
            for (int k = 1; k <= n; ++k) {
                const double next = ((2 * k - 1) * x * p - (k - 1) * before) / k;
                before = p;
                p = next;
            }
            slope = n * (x * p - before) / (x * x - 1.0);
            const double dx = p / slope;
            x -= dx;
            if (std::abs(dx) < 1e-15) break;
        }
        q.x.push_back(0.5 * (1.0 - x));
        q.weight.push_back(1.0 / ((1.0 - x * x) * slope * slope));
    }
    return q;
}

/// Share of light at cosine `c` that a rough interface reflects, or transmits, by single scattering.
double through_facets(const host::Microfacets& facets, double c, double eta, bool transmitted, const Quadrature& q) {
    const host::real3 wi = {std::sqrt(std::max(1.0 - c * c, 0.0)), 0.0, c};
    double sum = 0.0;
    for (int i = 0; i < nodes; ++i)
        for (int j = 0; j < nodes; ++j) {
            const auto a = static_cast<std::size_t>(i), b = static_cast<std::size_t>(j);
            const host::real3 m = host::sample_visible_normal(&facets, wi, q.x[a], q.x[b]);
            const double cos_i = host::dot(wi, m);
            double cos_t = 0.0;
            if (!(cos_i > 0.0)) continue;
            const double f = host::fresnel_dielectric(cos_i, eta, &cos_t);
            const host::real3 wo = transmitted ? m * (cos_i / eta - cos_t) - wi * (1.0 / eta) : m * (2.0 * cos_i) - wi;
            if ((wo.z > 0.0) == transmitted || (transmitted && f >= 1.0)) continue;
            sum += q.weight[a] * q.weight[b] * host::smith_g1(&facets, wo, m) * (transmitted ? 1.0 - f : f);
        }
    return sum;
}

double table_cosine(std::size_t i) { return std::max(1e-6, static_cast<double>(i) / (IR_COAT_TABLE - 1)); }

}  // namespace

double smooth_internal_reflectance(double eta) {
    // Of diffuse light from inside. Fits of Egan and Hilgeman (1973), for 1/eta < 1, and of d'Eon and Irving (2011).
    const double e = 1.0 / eta, i = eta;
    if (e < 1.0) return 0.0636 * i + 0.6681 + e * (0.7099 - 1.4399 * e);
    return 0.919317 + i * (-3.4793 + i * (6.75335 + i * (-7.80989 + i * (4.98554 - 1.36881 * i))));
}

RoughCoat rough_coat(double eta, double alpha, bool beckmann) {
    const host::Microfacets facets{alpha, alpha, beckmann};
    const Quadrature q = gauss_legendre(nodes);
    RoughCoat coat;
    double sum = 0.0;
    for (std::size_t i = 0; i < IR_COAT_TABLE; ++i) {
        const double c = table_cosine(i);
        coat.transmittance.push_back(static_cast<float>(std::min(through_facets(facets, c, eta, true, q), 1.0)));
        sum += c * through_facets(facets, c, 1.0 / eta, false, q);
    }
    coat.internal_reflectance = 2.0 * sum / IR_COAT_TABLE;  // Mitsuba's mean over the table
    return coat;
}

}  // namespace irradia::loader
