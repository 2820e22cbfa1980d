// Triangles and spheres of a scene in double precision, in units of the scene: (position - offset) / scale.
#pragma once
#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "../accel/shapes.h"
#include "../cl/device.h"

namespace irradia::test {
using host::real3;

struct ExactHit {
    double t = 1e30;
    int primitive = -1;
    double margin = 1e30;  ///< how far the ray passes from the nearest edge or silhouette that would change the answer
};

class DoubleScene {
public:
    DoubleScene(const Scene& scene, double scale, double offset) {
        const auto place = [&](float x, float y, float z) {
            return real3{(static_cast<double>(x) - offset) / scale, (static_cast<double>(y) - offset) / scale,
                         (static_cast<double>(z) - offset) / scale};
        };
        for (const shared::Triangle& t : scene.triangles) {
            std::array<real3, 3> p;
            const std::uint32_t corners[3] = {t.v0, t.v1, t.v2};
            for (std::size_t k = 0; k < 3; ++k) {
                const shared::Vertex& v = scene.vertices[corners[k]];
                p[k] = place(v.px, v.py, v.pz);
            }
            const real3 a = p[1] - p[0], b = p[2] - p[0], n = cross(a, b);
            const double longest = std::max({length(a), length(b), length(b - a)});
            triangles_.push_back({p[0], a, b, n, length(n) / longest});
        }
        for (const shared::Analytic& a : scene.analytics)
            spheres_.push_back({place(a.px, a.py, a.pz), static_cast<double>(a.radius) / scale});
    }

    /// Closest hit, t > 0.
    [[nodiscard]] ExactHit closest(const real3& o, const real3& d) const {
        ExactHit best;
        for (std::size_t i = 0; i < triangles_.size(); ++i) {
            const Triangle& t = triangles_[i];
            const real3 p = cross(d, t.b);
            const double det = dot(t.a, p);
            if (det == 0) continue;
            const real3 s = o - t.p, q = cross(s, t.a);
            const double u = dot(s, p) / det, v = dot(d, q) / det, distance = dot(t.b, q) / det;
            const double inside = std::min({u, v, 1 - u - v});
            if (distance <= 0) continue;
            // Edges farther than what is hit do not matter, but the hit is not known yet: a few rays too many are left
            // out.
            best.margin = std::min(best.margin, std::abs(inside) * t.height);
            if (inside >= 0 && distance < best.t) best.t = distance, best.primitive = static_cast<int>(i);
        }
        for (std::size_t i = 0; i < spheres_.size(); ++i) {
            const real3 f = o - spheres_[i].centre;
            const double a = dot(d, d), b = dot(f, d), r = spheres_[i].radius;
            const real3 l = f - (b / a) * d;
            best.margin = std::min(best.margin, std::abs(length(l) - r));
            const double root = r * r - dot(l, l);
            if (root < 0) continue;
            for (const double t : {(-b - std::sqrt(a * root)) / a, (-b + std::sqrt(a * root)) / a})
                if (t > 0 && t < best.t) best.t = t, best.primitive = static_cast<int>(triangles_.size() + i);
        }
        return best;
    }

    /// Distance of p from the plane or the sphere of a primitive, positive on the side of n.
    [[nodiscard]] double distance(int primitive, const real3& p, const real3& n) const {
        const auto i = static_cast<std::size_t>(primitive);
        if (i < triangles_.size()) {
            const real3 own = triangles_[i].n * (1 / length(triangles_[i].n));
            return dot(p - triangles_[i].p, own) * (dot(own, n) < 0 ? -1 : 1);
        }
        const Sphere& s = spheres_.at(i - triangles_.size());
        return (length(p - s.centre) - s.radius) * (dot(p - s.centre, n) < 0 ? -1 : 1);
    }
    /// Can a ray that leaves p on the side of n not meet the primitive again: a plane, or a sphere from outside?
    [[nodiscard]] bool left_for_good(int primitive, const real3& p, const real3& n) const {
        const auto i = static_cast<std::size_t>(primitive);
        return i < triangles_.size() || dot(p - spheres_.at(i - triangles_.size()).centre, n) > 0;
    }

private:
    struct Triangle {
        real3 p, a, b, n;
        double height;  // over the longest edge: barycentrics times this are at most distances from edges
    };
    struct Sphere {
        real3 centre;
        double radius;
    };
    std::vector<Triangle> triangles_;
    std::vector<Sphere> spheres_;
};

/// Scales a scene made by accel/shapes.h, moves it by `offset` along x, y and z, and completes it for kernels that
/// shade.
inline void place_scene(Scene& scene, double scale, double offset) {
    const auto place = [&](float& x) { x = static_cast<float>(static_cast<double>(x) * scale + offset); };
    for (shared::Vertex& v : scene.vertices) place(v.px), place(v.py), place(v.pz);
    for (shared::Analytic& a : scene.analytics) {
        place(a.px), place(a.py), place(a.pz);
        a.radius = static_cast<float>(static_cast<double>(a.radius) * scale);
    }
    for (shared::Triangle& t : scene.triangles) {
        real3 p[3];
        const std::uint32_t corners[3] = {t.v0, t.v1, t.v2};
        for (std::size_t k = 0; k < 3; ++k) {
            const shared::Vertex& v = scene.vertices[corners[k]];
            p[k] = {static_cast<double>(v.px), static_cast<double>(v.py), static_cast<double>(v.pz)};
        }
        const real3 n = cross(p[1] - p[0], p[2] - p[0]);
        const double l = std::max(length(n), 1e-300);
        t.nx = static_cast<float>(n.x / l), t.ny = static_cast<float>(n.y / l), t.nz = static_cast<float>(n.z / l);
    }
    scene.materials.push_back(blank_material());
    finish_scene(scene);
}

}  // namespace irradia::test
