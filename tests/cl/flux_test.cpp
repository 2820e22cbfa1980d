// The flux form against edges.json, and summed over closed polygons against polygon_irradiance.json.
#include <random>

#include "polygon.h"

namespace irradia::test {
namespace {
using namespace irradia::host;

Matrix3 hessian_of(const EdgeFlux& f) {
    Matrix3 h{};
    for (int i = 0; i < 3; ++i)
        for (int j = 0; j < 3; ++j)
            h[i][j] = 0.5 * (component(f.c, i) * component(f.v, j) + component(f.v, i) * component(f.c, j));
    return h;
}

double norm(const Matrix3& m) {
    double s = 0;
    for (const auto& row : m)
        for (const double x : row) s += x * x;
    return std::sqrt(s);
}

double difference(const Matrix3& a, const json& b) {
    Matrix3 d{};
    for (int i = 0; i < 3; ++i)
        for (int j = 0; j < 3; ++j) d[i][j] = a[i][j] - b[i][j].get<double>();
    return norm(d);
}

TEST(Flux, SingleEdgesMatchVectors) {
    for (const json& c : load_vectors("edges", "cases")) {
        const real3 ra = vec3(c["ra"]), rb = vec3(c["rb"]), n = vec3(c["n"]);
        const double dL = c["dL"];
        const bool forward = dot(cross(ra, rb), vec3(c["omegaAB"])) > 0;
        const EdgeFlux f = forward ? edge_flux(ra, rb, n) : edge_flux(rb, ra, n);
        expect_relative(dL * f.g, vec3(c["flux_grad"]), 1e-9, "g");
        Matrix3 h = hessian_of(f);
        for (auto& row : h)
            for (double& x : row) x *= dL;
        EXPECT_LE(difference(h, c["flux_hess_sym"]), 1e-9 * norm(h)) << c.dump();
        const Irradiance s = stokes_edge(ra, rb, n);  // the oracle itself
        expect_relative(s.value, c["stokes_value"], 1e-9, "stokes value");
        expect_relative(s.gradient, vec3(c["stokes_grad"]), 1e-9, "stokes gradient");
        EXPECT_LE(difference(s.hessian, c["stokes_hess"]), 1e-9 * norm(s.hessian)) << c.dump();
    }
}

// The sum over a closed polygon, inside minus outside.
EdgeFlux polygon_flux(const std::vector<real3>& vertices, real3 p, real3 n, Matrix3& hessian) {
    EdgeFlux sum{{0, 0, 0}, {0, 0, 0}, {0, 0, 0}};
    real3 centre{0, 0, 0}, around{0, 0, 0};
    for (const real3 v : vertices) centre += v - p;
    for (std::size_t i = 0; i < vertices.size(); ++i)
        around += cross(vertices[i] - p, vertices[(i + 1) % vertices.size()] - p);
    const bool forward = dot(around, centre) > 0;
    hessian = {};
    for (std::size_t i = 0; i < vertices.size(); ++i) {
        const real3 a = vertices[i] - p, b = vertices[(i + 1) % vertices.size()] - p;
        const EdgeFlux f = forward ? edge_flux(a, b, n) : edge_flux(b, a, n);
        sum.g += f.g;
        const Matrix3 h = hessian_of(f);
        for (int r = 0; r < 3; ++r)
            for (int c = 0; c < 3; ++c) hessian[r][c] += h[r][c];
    }
    return sum;
}

TEST(Flux, ClosedPolygonsGiveExactDerivatives) {
    for (const json& c : load_vectors("polygon_irradiance", "cases")) {
        std::vector<real3> vertices;
        for (const json& v : c["vertices"]) vertices.push_back(vec3(v));
        const real3 p = vec3(c["p"]), n = vec3(c["n"]);
        const double L = c["radiance"];
        const Irradiance exact = polygon_irradiance(vertices, p, n);
        expect_relative(L * exact.value, c["E"], 1e-10, "E");
        expect_relative(L * exact.gradient, vec3(c["grad"]), 1e-10, "Stokes gradient");
        expect_relative(L * cross(n, exact.vector), vec3(c["grad_rot"]), 1e-10, "rotational gradient");
        Matrix3 h{};
        const EdgeFlux f = polygon_flux(vertices, p, n, h);
        expect_relative(L * f.g, vec3(c["grad"]), 1e-10, "flux gradient");
        for (auto& row : h)
            for (double& x : row) x *= L;
        EXPECT_LE(difference(h, c["hess"]), 1e-10 * norm(h)) << c.dump();
    }
}

// Below the horizon nothing arrives; the edge along the horizon contributes to E but not to the flux form. The file's
// gradients are finite differences good to 1e-7 (theory 9).
TEST(Flux, HorizonNeedsNoTerm) {
    for (const json& c : load_vectors("polygon_irradiance", "clipped")) {
        std::vector<real3> vertices;
        for (const json& v : c["vertices"]) vertices.push_back(vec3(v));
        const real3 p = vec3(c["p"]), n = vec3(c["n"]);
        const double L = c["radiance"];
        const std::vector<real3> clipped = clip_to_horizon(vertices, p, n);
        const Irradiance exact = polygon_irradiance(clipped, p, n);
        expect_relative(L * exact.value, c["E"], 1e-10, "E");
        expect_relative(L * cross(n, exact.vector), vec3(c["grad_rot"]), 1e-7, "rotational gradient");
        Matrix3 h{};
        const real3 g = L * polygon_flux(clipped, p, n, h).g;
        expect_relative(g - dot(g, n) * n, vec3(c["grad_tangential"]), 1e-7, "tangential gradient");
    }
}

TEST(Flux, ScalesAsLengthsDo) {  // g ~ 1/length, H ~ 1/length^2: no absolute epsilon (theory 4.8)
    const real3 ra{.3, -.2, .9}, rb{.5, .1, 1.4}, n{0, 0, 1};
    const EdgeFlux one = edge_flux(ra, rb, n);
    for (const double s : {1e-4, 1e-2, 1e3, 1e6}) {
        const EdgeFlux f = edge_flux(ra * s, rb * s, n);
        expect_relative(f.g * s, one.g, 1e-12, "g");
        expect_relative(f.v * (s * s), one.v, 1e-12, "v");
    }
}

TEST(Flux, EdgeSeenAsAPointIsNothing) {
    const EdgeFlux f = edge_flux(make_real3(.1, .2, .3), make_real3(.2, .4, .6), make_real3(0, 0, 1));
    EXPECT_EQ(length(f.g) + length(f.c) + length(f.v), 0);
    const EdgeFlux same = edge_flux(make_real3(.1, .2, .3), make_real3(.1, .2, .3), make_real3(0, 0, 1));
    EXPECT_EQ(length(same.g), 0);
}

TEST(Flux, AnglePolynomialIsGoodForFloat32) {  // stated in flux.h: relative error 1.6e-8 before rounding
    double worst = 0;
    for (int i = 1; i <= 200000; ++i) {
        const double angle = kPi * i / 200001, s = std::sin(angle);
        const double found = angle_over_sine_polynomial(s * s, std::cos(angle)) * s;
        worst = std::max(worst, std::abs(found - angle) / angle);
    }
    EXPECT_LE(worst, 1.6e-8);
    EXPECT_GE(worst, 1e-9) << "atan2 itself was tested, not the polynomial";
    EXPECT_NEAR(angle_over_sine_polynomial(1, 0), kPi / 2, 1e-15);
    EXPECT_NEAR(angle_over_sine_polynomial(1e-20, 1), 1, 2e-8);
}

}  // namespace
}  // namespace irradia::test
