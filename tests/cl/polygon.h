// Exact irradiance of constant polygons, the oracle of the cells' formulas: Lambert's formula and its derivatives in
// Stokes form (theory 5), in double. Only tests use it.
#pragma once
#include <array>
#include <vector>

#include "formulas.h"

namespace irradia::test {

using host::real3;
using Matrix3 = std::array<std::array<double, 3>, 3>;

inline double component(real3 v, int i) { return i == 0 ? v.x : i == 1 ? v.y : v.z; }

/// Irradiance (per unit radiance) with its gradient and Hessian for the receiver's position.
struct Irradiance {
    double value = 0;
    real3 gradient{0, 0, 0};
    Matrix3 hessian{};
    real3 vector{0, 0, 0};  ///< vector irradiance: value = n . vector

    void add(const Irradiance& o, double factor = 1) {
        value += factor * o.value;
        gradient += factor * o.gradient;
        vector += factor * o.vector;
        for (int i = 0; i < 3; ++i)
            for (int j = 0; j < 3; ++j) hessian[i][j] += factor * o.hessian[i][j];
    }
};

/// One edge's share, ra -> rb relative to a receiver with normal n.
inline Irradiance stokes_edge(real3 ra, real3 rb, real3 n) {
    Irradiance out;
    const real3 e = rb - ra, c = host::cross(ra, rb);
    const double A = dot(e, e), a2 = dot(ra, ra), b2 = dot(rb, rb), d = dot(ra, e), d1 = dot(rb, e), D = dot(c, c);
    if (D <= 1e-28 * a2 * b2) return out;
    const double I1 = std::atan2(std::sqrt(D), dot(ra, rb)) / std::sqrt(D);
    const double I2 = (d1 / b2 - d / a2 + A * I1) / (2 * D);
    const double T2 = ((1 / a2 - 1 / b2) / 2 - d * I2) / A;
    const double I3 = (d1 / (b2 * b2) - d / (a2 * a2) + 3 * A * I2) / (4 * D);
    const double T3 = ((1 / (a2 * a2) - 1 / (b2 * b2)) / 4 - d * I3) / A;
    const double U3 = (I2 - 2 * d * T3 - a2 * I3) / A;
    const real3 J = I2 * ra + T2 * e, ne = host::cross(n, e);
    const double nc = dot(n, c);
    out.value = 0.5 * nc * I1;
    out.vector = 0.5 * I1 * c;
    out.gradient = 0.5 * (I1 * ne + 2 * nc * J);
    for (int i = 0; i < 3; ++i)
        for (int j = 0; j < 3; ++j) {
            const auto v = component;
            const double K =
                I3 * v(ra, i) * v(ra, j) + T3 * (v(ra, i) * v(e, j) + v(e, i) * v(ra, j)) + U3 * v(e, i) * v(e, j);
            out.hessian[i][j] =
                0.5 * (2 * (v(ne, i) * v(J, j) + v(J, i) * v(ne, j)) + nc * (8 * K - (i == j ? 2 * I2 : 0.0)));
        }
    return out;
}

/// A polygon that lies wholly above the horizon; vertices in world space, either orientation.
inline Irradiance polygon_irradiance(const std::vector<real3>& vertices, real3 p, real3 n) {
    Irradiance sum, out;
    for (std::size_t i = 0; i < vertices.size(); ++i)
        sum.add(stokes_edge(vertices[i] - p, vertices[(i + 1) % vertices.size()] - p, n));
    out.add(sum, sum.value < 0 ? -1 : 1);
    return out;
}

/// The part of a polygon above the horizon of a receiver (Sutherland-Hodgman).
inline std::vector<real3> clip_to_horizon(const std::vector<real3>& vertices, real3 p, real3 n) {
    std::vector<real3> out;
    for (std::size_t i = 0; i < vertices.size(); ++i) {
        const real3 a = vertices[i], b = vertices[(i + 1) % vertices.size()];
        const double ha = dot(n, a - p), hb = dot(n, b - p);
        if (ha >= 0) out.push_back(a);
        if ((ha >= 0) != (hb >= 0)) out.push_back(a + (ha / (ha - hb)) * (b - a));
    }
    return out;
}

/// A rectangle corner + s e1 + t e2 of constant radiance.
struct Rectangle {
    real3 corner, e1, e2, normal;
    double radiance = 0;
    [[nodiscard]] std::vector<real3> vertices() const { return {corner, corner + e1, corner + e1 + e2, corner + e2}; }
};

/// Nearest rectangle along a unit direction: index (-1: a miss) and distance.
struct RectangleHit {
    int index = -1;
    double distance = kMiss;
};

inline RectangleHit trace(const std::vector<Rectangle>& scene, real3 origin, real3 direction) {
    RectangleHit hit;
    for (std::size_t i = 0; i < scene.size(); ++i) {
        const Rectangle& q = scene[i];
        const double cosine = dot(direction, q.normal);
        if (cosine == 0) continue;
        const double t = dot(q.corner - origin, q.normal) / cosine;
        if (!(t > 1e-9) || t >= hit.distance) continue;
        const real3 x = origin + t * direction - q.corner;
        const double s = dot(x, q.e1) / dot(q.e1, q.e1), u = dot(x, q.e2) / dot(q.e2, q.e2);
        if (s >= 0 && s <= 1 && u >= 0 && u <= 1) hit = {static_cast<int>(i), t};
    }
    return hit;
}

/// The rectangles of one case of hemisphere_cells.json.
inline std::vector<Rectangle> rectangles_of(const json& j) {
    std::vector<Rectangle> scene;
    for (std::size_t i = 0; i < j.at("rects").size(); ++i) {
        const json& q = j["rects"][i];
        scene.push_back({vec3(q[0]), vec3(q[1]), vec3(q[2]), vec3(j["rect_normal"][i]), j["rect_radiance"][i]});
    }
    return scene;
}

/// Exact irradiance in a convex room (nothing occludes anything).
inline Irradiance room_irradiance(const std::vector<Rectangle>& scene, real3 p, real3 n) {
    Irradiance sum;
    for (const Rectangle& q : scene)
        if (std::abs(dot(q.normal, p - q.corner)) > 1e-12)  // not the plane the receiver lies on
            sum.add(polygon_irradiance(clip_to_horizon(q.vertices(), p, n), p, n), q.radiance);
    return sum;
}

}  // namespace irradia::test
