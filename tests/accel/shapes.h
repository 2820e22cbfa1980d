// Geometry made in code, for the traversal tests and the benchmark.
#pragma once
#include <array>
#include <cmath>
#include <cstdint>
#include <functional>
#include <numbers>
#include <random>

#include "irradia/Scene.h"

namespace irradia::shapes {

using Point = std::array<float, 3>;

inline void add_triangle(Scene& scene, std::uint32_t a, std::uint32_t b, std::uint32_t c) {
    shared::Triangle t{};
    t.v0 = a, t.v1 = b, t.v2 = c;
    t.flags = IR_TRIANGLE_FLAT;
    t.light = IR_NO_LIGHT;
    scene.triangles.push_back(t);
    scene.info.triangle_count = static_cast<std::uint32_t>(scene.triangles.size());
}

inline std::uint32_t add_vertex(Scene& scene, const Point& p) {
    scene.vertices.push_back({p[0], p[1], p[2], 0, 0, 0, 0, 0});
    return static_cast<std::uint32_t>(scene.vertices.size()) - 1;
}

inline void add_triangle(Scene& scene, const Point& a, const Point& b, const Point& c) {
    const std::uint32_t i = add_vertex(scene, a);
    add_vertex(scene, b), add_vertex(scene, c);
    add_triangle(scene, i, i + 1, i + 2);
}

/// Parallelogram of corner p and edges u, v.
inline void add_quad(Scene& scene, const Point& p, const Point& u, const Point& v) {
    const std::uint32_t i = add_vertex(scene, p);
    add_vertex(scene, {p[0] + u[0], p[1] + u[1], p[2] + u[2]});
    add_vertex(scene, {p[0] + u[0] + v[0], p[1] + u[1] + v[1], p[2] + u[2] + v[2]});
    add_vertex(scene, {p[0] + v[0], p[1] + v[1], p[2] + v[2]});
    add_triangle(scene, i, i + 1, i + 2);
    add_triangle(scene, i, i + 2, i + 3);
}

/// Box of the given centre and half extents, turned by `angle` (radians) about y: 12 triangles.
inline void add_box(Scene& scene, const Point& centre, const Point& half, float angle = 0) {
    const float c = std::cos(angle), s = std::sin(angle);
    const Point x{2 * half[0] * c, 0, -2 * half[0] * s}, y{0, 2 * half[1], 0}, z{2 * half[2] * s, 0, 2 * half[2] * c};
    Point p, q;
    for (int k = 0; k < 3; ++k) {
        p[k] = centre[k] - 0.5f * (x[k] + y[k] + z[k]);
        q[k] = centre[k] + 0.5f * (x[k] + y[k] + z[k]);
    }
    const auto minus = [](const Point& v) { return Point{-v[0], -v[1], -v[2]}; };
    add_quad(scene, p, x, y), add_quad(scene, p, y, z), add_quad(scene, p, z, x);
    add_quad(scene, q, minus(x), minus(y)), add_quad(scene, q, minus(y), minus(z)),
        add_quad(scene, q, minus(z), minus(x));
}

/// A grid of nu x nv cells, closed in u (and in v if `close_v`), of points f(u, v), u and v in [0, 1).
inline void add_surface(Scene& scene, std::uint32_t nu, std::uint32_t nv, bool close_v,
                        const std::function<Point(double, double)>& f) {
    const auto first = static_cast<std::uint32_t>(scene.vertices.size());
    const std::uint32_t rows = close_v ? nv : nv + 1;
    for (std::uint32_t j = 0; j < rows; ++j)
        for (std::uint32_t i = 0; i < nu; ++i) add_vertex(scene, f(double{i * 1.0} / nu, double{j * 1.0} / nv));
    for (std::uint32_t j = 0; j < nv; ++j)
        for (std::uint32_t i = 0; i < nu; ++i) {
            const std::uint32_t i1 = (i + 1) % nu, j1 = (j + 1) % rows;
            const std::uint32_t a = first + j * nu + i, b = first + j * nu + i1, c = first + j1 * nu + i1,
                                d = first + j1 * nu + i;
            add_triangle(scene, a, b, c);
            add_triangle(scene, a, c, d);
        }
}

/// Sphere of 2 nu nv triangles with bumps of relative height `bump`; the poles are rings of tiny radius.
inline void add_bumpy_sphere(Scene& scene, const Point& centre, float radius, std::uint32_t nu, std::uint32_t nv,
                             float bump) {
    add_surface(scene, nu, nv, false, [&](double u, double v) {
        const double phi = 2 * std::numbers::pi * u, theta = std::numbers::pi * std::min(std::max(v, 1e-4), 1 - 1e-4);
        const double r = radius * (1 + bump * std::sin(11 * phi) * std::sin(9 * theta) * std::sin(theta));
        return Point{static_cast<float>(centre[0] + r * std::sin(theta) * std::cos(phi)),
                     static_cast<float>(centre[1] + r * std::cos(theta)),
                     static_cast<float>(centre[2] + r * std::sin(theta) * std::sin(phi))};
    });
}

/// Torus of 2 nu nv triangles about an axis in the xz plane's normal, tilted by `tilt` (radians) about x.
inline void add_torus(Scene& scene, const Point& centre, float major, float minor, std::uint32_t nu, std::uint32_t nv,
                      float tilt) {
    const double ct = std::cos(tilt), st = std::sin(tilt);
    add_surface(scene, nu, nv, true, [&](double u, double v) {
        const double a = 2 * std::numbers::pi * u, b = 2 * std::numbers::pi * v;
        const double r = major + minor * std::cos(b), x = r * std::cos(a), y = minor * std::sin(b), z = r * std::sin(a);
        return Point{static_cast<float>(centre[0] + x), static_cast<float>(centre[1] + y * ct - z * st),
                     static_cast<float>(centre[2] + y * st + z * ct)};
    });
}

/// The Cornell box of peers/cornell-a.xml: 36 triangles in [-1, 1]^3, the front open.
inline Scene cornell_box() {
    Scene scene;
    add_quad(scene, {-0.23f, 0.99f, -0.18f}, {0.46f, 0, 0}, {0, 0, 0.38f});  // light
    add_quad(scene, {-1, -1, -1}, {2, 0, 0}, {0, 0, 2});
    add_quad(scene, {-1, 1, -1}, {2, 0, 0}, {0, 0, 2});
    add_quad(scene, {-1, -1, -1}, {2, 0, 0}, {0, 2, 0});
    add_quad(scene, {1, -1, -1}, {0, 2, 0}, {0, 0, 2});
    add_quad(scene, {-1, -1, -1}, {0, 2, 0}, {0, 0, 2});
    add_box(scene, {0.335f, -0.7f, 0.38f}, {0.3f, 0.3f, 0.3f}, -0.2967f);
    add_box(scene, {-0.33f, -0.4f, -0.28f}, {0.3f, 0.61f, 0.3f}, 0.3185f);
    return scene;
}

/// A closed room with bumpy spheres and tori in it, of about `triangles` triangles.
inline Scene mesh_room(std::uint32_t triangles) {
    Scene scene;
    add_box(scene, {0, 0, 0}, {2, 1.25f, 2});
    add_box(scene, {0.9f, -0.95f, -0.8f}, {0.4f, 0.3f, 0.5f}, 0.4f);
    constexpr std::uint32_t kSpheres = 6, kTori = 6;
    const auto cells = triangles / (2 * (kSpheres + kTori));
    const auto nv = static_cast<std::uint32_t>(std::sqrt(cells / 2.0)), nu = cells / nv;
    std::mt19937 random(7);
    std::uniform_real_distribution<float> unit(0, 1);
    const auto place = [&] {
        return Point{3 * unit(random) - 1.5f, 1.8f * unit(random) - 0.95f, 3 * unit(random) - 1.5f};
    };
    for (std::uint32_t i = 0; i < kSpheres; ++i) {
        const Point p = place();
        add_bumpy_sphere(scene, p, 0.2f + 0.25f * unit(random), nu, nv, 0.08f);
    }
    for (std::uint32_t i = 0; i < kTori; ++i) {
        const Point p = place();
        add_torus(scene, p, 0.3f + 0.2f * unit(random), 0.06f + 0.08f * unit(random), nu, nv, 3 * unit(random));
    }
    return scene;
}

/// `count` random triangles of edge about `size` in [-1, 1]^3.
inline Scene triangle_soup(std::uint32_t count, float size, std::uint32_t seed) {
    Scene scene;
    std::mt19937 random(seed);
    std::uniform_real_distribution<float> s(-1, 1);
    for (std::uint32_t i = 0; i < count; ++i) {
        const Point p{s(random), s(random), s(random)};
        const auto near = [&] {
            return Point{p[0] + size * s(random), p[1] + size * s(random), p[2] + size * s(random)};
        };
        const Point b = near(), c = near();
        add_triangle(scene, p, b, c);
    }
    return scene;
}

inline void add_sphere(Scene& scene, const Point& centre, float radius) {
    shared::Analytic a{};
    a.kind = IR_ANALYTIC_SPHERE;
    a.px = centre[0], a.py = centre[1], a.pz = centre[2];
    a.radius = radius;
    a.ux = 1, a.vz = 1, a.sign = 1;
    a.light = IR_NO_LIGHT;
    scene.analytics.push_back(a);
    scene.info.analytic_count = static_cast<std::uint32_t>(scene.analytics.size());
}

/// Disk of half axes u and v (perpendicular to each other).
inline void add_disk(Scene& scene, const Point& centre, const Point& u, const Point& v) {
    shared::Analytic a{};
    a.kind = IR_ANALYTIC_DISK;
    const float uu = u[0] * u[0] + u[1] * u[1] + u[2] * u[2], vv = v[0] * v[0] + v[1] * v[1] + v[2] * v[2];
    const Point n{u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]};
    const float l = std::hypot(n[0], n[1], n[2]);
    a.px = centre[0], a.py = centre[1], a.pz = centre[2];
    a.nx = n[0] / l, a.ny = n[1] / l, a.nz = n[2] / l;
    a.ux = u[0] / uu, a.uy = u[1] / uu, a.uz = u[2] / uu;
    a.vx = v[0] / vv, a.vy = v[1] / vv, a.vz = v[2] / vv;
    a.light = IR_NO_LIGHT;
    scene.analytics.push_back(a);
    scene.info.analytic_count = static_cast<std::uint32_t>(scene.analytics.size());
}

/// Cylinder from p along a unit axis.
inline void add_cylinder(Scene& scene, const Point& p, const Point& axis, float radius, float length) {
    shared::Analytic a{};
    a.kind = IR_ANALYTIC_CYLINDER;
    a.px = p[0], a.py = p[1], a.pz = p[2];
    a.nx = axis[0], a.ny = axis[1], a.nz = axis[2];
    a.radius = radius, a.length = length;
    a.sign = 1;
    a.light = IR_NO_LIGHT;
    scene.analytics.push_back(a);
    scene.info.analytic_count = static_cast<std::uint32_t>(scene.analytics.size());
}

}  // namespace irradia::shapes
