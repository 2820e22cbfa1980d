#include "box.h"

#include <algorithm>
#include <cmath>

namespace irradia::accel {

void Box::add(const Box& b) {
    for (int k = 0; k < 3; ++k) {
        lo[k] = std::min(lo[k], b.lo[k]);
        hi[k] = std::max(hi[k], b.hi[k]);
    }
}

Box overlap(const Box& a, const Box& b) {
    Box r;
    for (int k = 0; k < 3; ++k) {
        r.lo[k] = std::max(a.lo[k], b.lo[k]);
        r.hi[k] = std::max(r.lo[k], std::min(a.hi[k], b.hi[k]));
    }
    return r;
}

namespace {

using Point = std::array<float, 3>;

std::array<Point, 3> corners(const Scene& scene, std::uint32_t triangle) {
    const shared::Triangle& t = scene.triangles[triangle];
    std::array<Point, 3> p;
    const std::uint32_t index[3] = {t.v0, t.v1, t.v2};
    for (int i = 0; i < 3; ++i) {
        const shared::Vertex& v = scene.vertices[index[i]];
        p[i] = {v.px, v.py, v.pz};
    }
    return p;
}

Box disk_box(const shared::Analytic& a) {
    // The stored axes are h / |h|^2, so h = axis / |axis|^2; the disk reaches sqrt(hu_k^2 + hv_k^2) along axis k.
    const double u[3] = {a.ux, a.uy, a.uz}, v[3] = {a.vx, a.vy, a.vz};
    const double uu = u[0] * u[0] + u[1] * u[1] + u[2] * u[2], vv = v[0] * v[0] + v[1] * v[1] + v[2] * v[2];
    const float centre[3] = {a.px, a.py, a.pz};
    Box box;
    for (int k = 0; k < 3; ++k) {
        const auto reach = static_cast<float>(std::hypot(u[k] / uu, v[k] / vv) * (1 + 0x1p-22));
        box.lo[k] = centre[k] - reach;
        box.hi[k] = centre[k] + reach;
    }
    return box;
}

Box cylinder_box(const shared::Analytic& a) {
    // Circles of the given radius around both ends; one reaches radius * sqrt(1 - axis_k^2) along axis k.
    const float base[3] = {a.px, a.py, a.pz}, axis[3] = {a.nx, a.ny, a.nz};
    Box box;
    for (int k = 0; k < 3; ++k) {
        const double along = axis[k], end = base[k] + along * a.length;
        const double reach = a.radius * std::sqrt(std::max(1 - along * along, 0.0)) * (1 + 0x1p-20);
        const double slack = (std::abs(base[k]) + a.length + a.radius) * 0x1p-22;  // of a rounded axis
        box.lo[k] = static_cast<float>(std::min(double{base[k]}, end) - reach - slack);
        box.hi[k] = static_cast<float>(std::max(double{base[k]}, end) + reach + slack);
    }
    return box;
}

}  // namespace

Box primitive_box(const Scene& scene, std::uint32_t primitive) {
    Box box;
    if (primitive < scene.triangles.size()) {
        for (const Point& p : corners(scene, primitive)) box.add({p, p});
        return box;
    }
    const shared::Analytic& a = scene.analytics[primitive - scene.triangles.size()];
    if (a.kind == IR_ANALYTIC_DISK) return disk_box(a);
    if (a.kind == IR_ANALYTIC_CYLINDER) return cylinder_box(a);
    return {{a.px - a.radius, a.py - a.radius, a.pz - a.radius}, {a.px + a.radius, a.py + a.radius, a.pz + a.radius}};
}

}  // namespace irradia::accel
