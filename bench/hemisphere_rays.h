// Hemispheres over random points of a scene's surfaces, and their rays as sample_hemispheres traces them.
#pragma once
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <random>
#include <vector>

#include "irradia/Scene.h"
#include "reference.h"
#include "traversal.h"

namespace irradia::bench {

using testing::Double3;
using testing::Ray;

constexpr int rings = 16, sectors = 64, rays_a_hemisphere = rings * sectors;

struct SurfacePoint {
    Double3 p, n;
};

inline Double3 edge(const Scene& scene, std::uint32_t a, std::uint32_t b) {
    const shared::Vertex &p = scene.vertices[a], &q = scene.vertices[b];
    return {double{q.px} - p.px, double{q.py} - p.py, double{q.pz} - p.pz};
}

/// Points equally spread over the area of the triangles, on both of their sides.
inline std::vector<SurfacePoint> surface_points(const Scene& scene, int count) {
    std::mt19937 random(1);
    std::uniform_real_distribution<double> unit(0, 1);
    std::vector<double> area;
    for (const shared::Triangle& t : scene.triangles) {
        const Double3 n = testing::cross(edge(scene, t.v0, t.v1), edge(scene, t.v0, t.v2));
        area.push_back(std::sqrt(testing::dot(n, n)));
    }
    std::discrete_distribution<std::size_t> pick(area.begin(), area.end());
    std::vector<SurfacePoint> points;
    for (int h = 0; h < count; ++h) {
        const shared::Triangle& t = scene.triangles[pick(random)];
        const Double3 e1 = edge(scene, t.v0, t.v1), e2 = edge(scene, t.v0, t.v2), n = testing::cross(e1, e2);
        const double l = (h % 2 ? -1 : 1) * std::sqrt(testing::dot(n, n));
        const double s = std::sqrt(unit(random)), b1 = s * (1 - unit(random)), b2 = s - b1;
        const shared::Vertex& p = scene.vertices[t.v0];
        points.push_back({{p.px + b1 * e1.x + b2 * e2.x, p.py + b1 * e1.y + b2 * e2.y, p.pz + b1 * e1.z + b2 * e2.z},
                          {n.x / l, n.y / l, n.z / l}});
    }
    return points;
}

/// One jittered cosine-distributed ray a stratum. Sixteen consecutive rays are a 4x4 tile of neighbouring strata.
inline std::vector<Ray> hemisphere_rays(const std::vector<SurfacePoint>& points) {
    std::mt19937 random(3);
    std::uniform_real_distribution<double> unit(0, 1);
    std::vector<Ray> rays;
    for (const auto& [o, n] : points) {
        Double3 x = std::abs(n.x) < 0.5 ? Double3{0, n.z, -n.y} : Double3{-n.z, 0, n.x};
        const double lx = std::sqrt(testing::dot(x, x));
        x = {x.x / lx, x.y / lx, x.z / lx};
        const Double3 y = testing::cross(n, x);
        for (int tile = 0; tile < rays_a_hemisphere / 16; ++tile)
            for (int i = 0; i < 16; ++i) {
                const int ring = tile % (rings / 4) * 4 + i % 4, sector = tile / (rings / 4) * 4 + i / 4;
                const double sin2 = (ring + unit(random)) / rings,
                             phi = 2 * std::numbers::pi * (sector + unit(random)) / sectors;
                const double a = std::sqrt(sin2) * std::cos(phi), b = std::sqrt(sin2) * std::sin(phi),
                             c = std::sqrt(1 - sin2);
                rays.push_back({static_cast<float>(o.x), static_cast<float>(o.y), static_cast<float>(o.z), 1e-4f,
                                static_cast<float>(a * x.x + b * y.x + c * n.x),
                                static_cast<float>(a * x.y + b * y.y + c * n.y),
                                static_cast<float>(a * x.z + b * y.z + c * n.z), 1e30f});
            }
    }
    return rays;
}

/// A parallelogram that emits.
struct Lamp {
    float px, py, pz, ux, uy, uz, vx, vy, vz;
};

/// From where the rays hit to random points of the lamp: the shadow rays of next-event estimation. Rays that hit
/// nothing have none.
template <class Hit>
std::vector<Ray> shadow_rays(const std::vector<Ray>& rays, const std::vector<Hit>& hits, const Lamp& lamp) {
    std::mt19937 random(2);
    std::uniform_real_distribution<float> unit(0, 1);
    std::vector<Ray> shadows;
    for (std::size_t i = 0; i < rays.size(); ++i) {
        const float t = hits[i].primitive == IR_NO_PRIMITIVE ? 0.0f : hits[i].t * 0.9999f;
        const float a = unit(random), b = unit(random);
        Ray r = rays[i];
        r.ox += t * r.dx, r.oy += t * r.dy, r.oz += t * r.dz;
        r.dx = lamp.px + a * lamp.ux + b * lamp.vx - r.ox;
        r.dy = lamp.py + a * lamp.uy + b * lamp.vy - r.oy;
        r.dz = lamp.pz + a * lamp.uz + b * lamp.vz - r.oz;
        const float l = std::hypot(r.dx, r.dy, r.dz);
        r.dx /= l, r.dy /= l, r.dz /= l;
        r.t_max = l * 0.9999f;  // the lamp itself is no occluder
        shadows.push_back(r);
    }
    return shadows;
}

}  // namespace irradia::bench
