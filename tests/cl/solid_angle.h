// Rectangles and triangles seen from points that are hard to sample from, and their solid angles by a formula that the
// code under test does not use. Only tests use it.
#pragma once
#include <array>
#include <string>
#include <vector>

#include "polygon.h"

namespace irradia::test {

using Real3L = std::array<long double, 3>;

inline Real3L towards(real3 v, real3 p) {
    const auto at = [](double a, double b) { return static_cast<long double>(a) - static_cast<long double>(b); };
    return {at(v.x, p.x), at(v.y, p.y), at(v.z, p.z)};
}
inline long double dot_l(const Real3L& a, const Real3L& b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }
inline Real3L cross_l(const Real3L& a, const Real3L& b) {
    return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}

/// Solid angle of a convex polygon by Girard: the sum of the angles between the planes through p and its edges, less
/// (n - 2) pi. In 80 bits: what cancels leaves 1e-18 for small polygons, times 1/distance for planes almost parallel.
inline double girard(const std::vector<real3>& vertices, real3 p) {
    const std::size_t n = vertices.size();
    std::vector<Real3L> planes;
    for (std::size_t i = 0; i < n; ++i)
        planes.push_back(cross_l(towards(vertices[i], p), towards(vertices[(i + 1) % n], p)));
    long double sum = -static_cast<long double>(n - 2) * std::acos(-1.0L);
    for (std::size_t i = 0; i < n; ++i) {
        const Real3L &a = planes[i], &b = planes[(i + 1) % n], c = cross_l(a, b);
        sum += std::acos(-1.0L) - std::atan2(std::sqrt(dot_l(c, c)), dot_l(a, b));
    }
    return static_cast<double>(sum);
}

/// A rectangle (or triangle) corner + a e1 + b e2, seen from p by a receiver with normal n.
struct SolidAngleCase {
    std::string name;
    real3 corner, e1, e2, p, n;
    [[nodiscard]] std::vector<real3> rectangle() const { return {corner, corner + e1, corner + e1 + e2, corner + e2}; }
    [[nodiscard]] std::vector<real3> triangle() const { return {corner, corner + e1, corner + e2}; }
    /// Everything times `scale`, turned out of the axes' directions.
    [[nodiscard]] SolidAngleCase turned(double scale) const {
        const host::Frame f = host::make_frame(host::normalize(real3{0.48, -0.6, 0.64}));
        const auto turn = [&](real3 v) { return host::to_world(f, v); };
        return {name, turn(corner) * scale, turn(e1) * scale, turn(e2) * scale, turn(p) * scale, turn(n)};
    }
};

/// Rectangles in the plane z = 0.
inline std::vector<SolidAngleCase> rectangle_cases() {
    const real3 corner{-0.5, -0.5, 0}, x{1, 0, 0}, y{0, 1, 0}, up{0, 0, 1}, down{0, 0, -1}, long_corner{-5, -0.05, 0};
    const real3 tilted = host::normalize(real3{0.8, -0.2, 0.3});
    return {{"on the axis", corner, x, y, {0, 0, 1}, down},
            {"from the other side", corner, x, y, {0.1, 0.2, -1}, up},
            {"beside", corner, x, y, {1.3, -0.9, 0.4}, host::normalize(real3{-1, 0.5, -0.3})},
            {"far", corner, x, y, {2, -5, 8}, down},
            {"1e-5 above", corner, x, y, {0.1, -0.2, 1e-5}, down},
            {"1e-5 above, next to an edge", corner, x, y, {0.499, 0.3, 1e-5}, down},
            {"1e-5 beyond an edge, 1e-5 above", corner, x, y, {0.50001, 0.3, 1e-5}, {-1, 0, 0}},
            {"over an edge", corner, x, y, {0.5, 0.1, 0.3}, down},
            {"over a corner", corner, x, y, {-0.5, 0.5, 0.2}, tilted},
            {"over an edge's extension", corner, x, y, {1.5, 0.5, 0.3}, {-1, 0, 0}},
            {"grazing", corner, x, y, {0.7, 0.1, 0.01}, {-1, 0, 0}},
            {"elongated", long_corner, {10, 0, 0}, {0, 0.1, 0}, {1, 0.02, 0.3}, tilted},
            {"elongated, from its end", long_corner, {10, 0, 0}, {0, 0.1, 0}, {5.05, 0, 0.1}, {-1, 0, 0}},
            {"elongated, 1e-5 above", long_corner, {10, 0, 0}, {0, 0.1, 0}, {-3, 0.01, 1e-4}, down}};
}

/// Triangles in the plane z = 0.
inline std::vector<SolidAngleCase> triangle_cases() {
    const real3 o{0, 0, 0}, x{1, 0, 0}, up{0, 0, 1}, down{0, 0, -1}, apex{0.3, 0.9, 0};
    const real3 tilted = host::normalize(real3{0.8, -0.2, 0.3});
    return {{"plain", o, x, apex, {0.4, 0.3, 0.8}, down},
            {"from the other side", o, x, apex, {0.4, 0.3, -0.8}, up},
            {"beside", o, x, apex, {1.3, -0.9, 0.4}, host::normalize(real3{-1, 0.5, -0.3})},
            {"far", o, x, apex, {1, -3, 4}, down},
            {"1e-5 above", o, x, apex, {0.4, 0.3, 1e-5}, down},
            {"1e-5 above, next to an edge", o, x, apex, {0.4, 1e-3, 1e-5}, down},
            {"1e-5 beyond an edge, 1e-5 above", o, x, apex, {0.4, -1e-5, 1e-5}, {0, 1, 0}},
            {"over an edge", o, x, apex, {0.4, 0, 0.3}, down},
            {"over a corner", o, x, apex, {0, 0, 0.2}, tilted},
            {"over an edge's extension", o, x, apex, {1.5, 0, 0.3}, {-1, 0, 0}},
            {"grazing", o, x, apex, {0.7, -0.2, 0.01}, {0, 1, 0}},
            {"needle", o, {10, 0, 0}, {10, 0.1, 0}, {7, 0.02, 0.3}, tilted},
            {"needle, at its point", o, {10, 0, 0}, {10, 0.4, 0}, {-0.02, 0.005, 0.02}, {1, 0, 0}},
            {"needle, from its short side", o, {10, 0, 0}, {10, 0.1, 0}, {10.05, 0.05, 0.1}, {-1, 0, 0}},
            {"flat needle", o, {10, 0, 0}, {5, 0.1, 0}, {4, 0.05, 0.05}, down}};
}

}  // namespace irradia::test
