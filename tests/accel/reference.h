// What the traversals are held against: Embree in robust mode for triangles, brute force in double for everything.
#pragma once
#if __has_include(<embree4/rtcore.h>)
#include <embree4/rtcore.h>
#else
#include <embree3/rtcore.h>
#endif

#include <cmath>
#include <memory>
#include <vector>

#include "traversal.h"

namespace irradia::testing {

class EmbreeScene {
public:
    explicit EmbreeScene(const Scene& scene, bool robust = true) {
        device_.reset(rtcNewDevice("threads=1,set_affinity=0"));
        scene_.reset(rtcNewScene(device_.get()));
        rtcSetSceneFlags(scene_.get(), robust ? RTC_SCENE_FLAG_ROBUST : RTC_SCENE_FLAG_NONE);
        rtcSetSceneBuildQuality(scene_.get(), RTC_BUILD_QUALITY_HIGH);
        RTCGeometry mesh = rtcNewGeometry(device_.get(), RTC_GEOMETRY_TYPE_TRIANGLE);
        auto* v = static_cast<float*>(rtcSetNewGeometryBuffer(mesh, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3,
                                                              3 * sizeof(float), scene.vertices.size()));
        for (const shared::Vertex& p : scene.vertices) *v++ = p.px, *v++ = p.py, *v++ = p.pz;
        auto* t = static_cast<unsigned*>(rtcSetNewGeometryBuffer(mesh, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3,
                                                                 3 * sizeof(unsigned), scene.triangles.size()));
        for (const shared::Triangle& p : scene.triangles) *t++ = p.v0, *t++ = p.v1, *t++ = p.v2;
        rtcCommitGeometry(mesh);
        rtcAttachGeometry(scene_.get(), mesh);
        rtcReleaseGeometry(mesh);
        rtcCommitScene(scene_.get());
    }

    [[nodiscard]] DeviceHit closest(const Ray& ray) const {
        RTCRayHit r{};
        r.ray = to_embree(ray);
        r.hit.geomID = RTC_INVALID_GEOMETRY_ID;
#if RTC_VERSION_MAJOR >= 4
        rtcIntersect1(scene_.get(), &r);
#else
        RTCIntersectContext context;
        rtcInitIntersectContext(&context);
        rtcIntersect1(scene_.get(), &context, &r);
#endif
        if (r.hit.geomID == RTC_INVALID_GEOMETRY_ID) return {1e30f, 0, 0, IR_NO_PRIMITIVE};
        return {r.ray.tfar, r.hit.u, r.hit.v, r.hit.primID};
    }

    [[nodiscard]] bool occluded(const Ray& ray) const {
        RTCRay r = to_embree(ray);
#if RTC_VERSION_MAJOR >= 4
        rtcOccluded1(scene_.get(), &r);
#else
        RTCIntersectContext context;
        rtcInitIntersectContext(&context);
        rtcOccluded1(scene_.get(), &context, &r);
#endif
        return r.tfar < 0;
    }

private:
    static RTCRay to_embree(const Ray& ray) {
        RTCRay r{};
        r.org_x = ray.ox, r.org_y = ray.oy, r.org_z = ray.oz, r.tnear = ray.t_min;
        r.dir_x = ray.dx, r.dir_y = ray.dy, r.dir_z = ray.dz, r.tfar = ray.t_max;
        r.mask = 0xffffffffu;
        return r;
    }

    std::unique_ptr<RTCDeviceTy, decltype(&rtcReleaseDevice)> device_{nullptr, rtcReleaseDevice};
    std::unique_ptr<RTCSceneTy, decltype(&rtcReleaseScene)> scene_{nullptr, rtcReleaseScene};
};

struct Double3 {
    double x, y, z;
    friend Double3 operator-(const Double3& a, const Double3& b) { return {a.x - b.x, a.y - b.y, a.z - b.z}; }
};
inline double dot(const Double3& a, const Double3& b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
inline Double3 cross(const Double3& a, const Double3& b) {
    return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}

struct ExactHit {
    double t = 1e30;
    std::uint32_t primitive = IR_NO_PRIMITIVE;
    double margin =
        1e30;  ///< how clearly the ray hits or misses: distance in relative units to the nearest change of mind
};

/// Closest hit with t_min < t < t_max of any primitive, all tested, in double.
inline ExactHit brute_force(const Scene& scene, const Ray& ray) {
    ExactHit best;
    best.t = ray.t_max;
    const Double3 o{ray.ox, ray.oy, ray.oz}, d{ray.dx, ray.dy, ray.dz};
    const auto accept = [&](double t, std::size_t primitive) {
        if (t > ray.t_min && t < best.t) best.t = t, best.primitive = static_cast<std::uint32_t>(primitive);
    };
    const auto graze = [&](double margin) { best.margin = std::min(best.margin, std::abs(margin)); };
    const auto vertex = [&](std::uint32_t i) {
        const shared::Vertex& v = scene.vertices[i];
        return Double3{v.px, v.py, v.pz};
    };
    for (std::size_t i = 0; i < scene.triangles.size(); ++i) {
        const shared::Triangle& tri = scene.triangles[i];
        const Double3 a = vertex(tri.v0), e1 = vertex(tri.v1) - a, e2 = vertex(tri.v2) - a, p = cross(d, e2);
        const double det = dot(e1, p);
        if (det == 0) continue;
        const Double3 s = o - a, q = cross(s, e1);
        const double u = dot(s, p) / det, v = dot(d, q) / det, t = dot(e2, q) / det;
        const double inside = std::min({u, v, 1 - u - v});
        if (t > ray.t_min && t < ray.t_max) graze(inside);
        if (inside >= -1e-4) graze((t - ray.t_min) / (1 + std::abs(t))), graze((t - ray.t_max) / (1 + std::abs(t)));
        if (inside >= 0) accept(t, i);
    }
    for (std::size_t i = 0; i < scene.analytics.size(); ++i) {
        const shared::Analytic& g = scene.analytics[i];
        const std::size_t primitive = scene.triangles.size() + i;
        const Double3 f = o - Double3{g.px, g.py, g.pz}, n{g.nx, g.ny, g.nz};
        if (g.kind == IR_ANALYTIC_SPHERE) {
            const double a = dot(d, d), b = dot(f, d), c = dot(f, f) - double{g.radius} * g.radius,
                         root = b * b - a * c;
            graze(root / (a * (dot(f, f) + double{g.radius} * g.radius)));
            if (root < 0) continue;
            for (const double t : {(-b - std::sqrt(root)) / a, (-b + std::sqrt(root)) / a}) {
                graze((t - ray.t_min) / (1 + std::abs(t))), graze((t - ray.t_max) / (1 + std::abs(t)));
                accept(t, primitive);
            }
        } else if (g.kind == IR_ANALYTIC_CYLINDER) {
            // |f + t d|^2 across the axis equals r^2; the stored axis is a unit vector up to rounding.
            const double nn = dot(n, n), fn = dot(f, n) / nn, dn = dot(d, n) / nn;
            const Double3 across{f.x - fn * n.x, f.y - fn * n.y, f.z - fn * n.z};
            const Double3 turn{d.x - dn * n.x, d.y - dn * n.y, d.z - dn * n.z};
            const double r2 = double{g.radius} * g.radius, a = dot(turn, turn), b = dot(across, turn),
                         c = dot(across, across) - r2, root = b * b - a * c, height = g.length;
            graze(root / (a * (dot(across, across) + r2)));
            graze(a);  // along the axis the ends decide, and what is left of a by rounding
            if (root < 0) continue;
            for (const double t : {(-b - std::sqrt(root)) / a, (-b + std::sqrt(root)) / a}) {
                const double z = fn + t * dn, end = std::min(z, height - z) / (1 + std::abs(t));
                if (t > ray.t_min && t < ray.t_max) graze(end);
                if (end >= -1e-4)
                    graze((t - ray.t_min) / (1 + std::abs(t))), graze((t - ray.t_max) / (1 + std::abs(t)));
                if (end >= 0) accept(t, primitive);
            }
        } else {
            const double t = -dot(f, n) / dot(d, n);
            const Double3 p{f.x + t * d.x, f.y + t * d.y, f.z + t * d.z};
            const double x = dot(p, {g.ux, g.uy, g.uz}), y = dot(p, {g.vx, g.vy, g.vz}), r = x * x + y * y;
            graze(r - 1);
            if (r < 1.01) graze((t - ray.t_min) / (1 + std::abs(t))), graze((t - ray.t_max) / (1 + std::abs(t)));
            if (r <= 1) accept(t, primitive);
        }
    }
    if (best.primitive == IR_NO_PRIMITIVE) best.t = 1e30;
    return best;
}

}  // namespace irradia::testing
