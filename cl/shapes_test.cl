// Cylinders and lens rays, for the tests: no renderer launches these.
#ifndef IR_FEATURES
#define IR_FEATURES (IR_FEATURE_ANALYTIC | IR_FEATURE_THIN_LENS)
#endif
#include "camera.h"
#include "cylinder.h"
#include "trace_analytic.h"

// Ray i: origin, direction. Results, 9 floats: t, p, normal, u, v of the hit; t = IR_INFINITY: none.
IR_KERNEL void test_cylinder(IR_GLOBAL const Analytic* cylinder, IR_GLOBAL const float* rays, uint count,
                             IR_GLOBAL float* out) {
    const uint i = IR_GLOBAL_ID;
    if (i >= count) return;
    IR_GLOBAL const float* r = rays + 6 * i;
    const real3 origin = make_real3(r[0], r[1], r[2]), direction = make_real3(r[3], r[4], r[5]);
    const float t = intersect_analytic(cylinder, origin, direction, 0.0f, IR_INFINITY);
    IR_GLOBAL float* o = out + 9 * i;
    o[0] = t;
    for (uint k = 1; k < 9; ++k) o[k] = 0.0f;
    if (t >= IR_INFINITY) return;
    const Analytic q = *cylinder;
    real3 p = origin + t * direction, n;
    float u, v;
    cylinder_surface(&q, &p, &n, &u, &v);
    o[1] = p.x;
    o[2] = p.y;
    o[3] = p.z;
    o[4] = n.x;
    o[5] = n.y;
    o[6] = n.z;
    o[7] = u;
    o[8] = v;
}

// Sample i: film position in pixels, point of the lens's square. Results, 8 floats: origin, direction, t_min, t_max.
IR_KERNEL void test_lens_ray(IR_GLOBAL const SceneInfo* info, IR_GLOBAL const float* samples, uint count,
                             IR_GLOBAL float* out) {
    const uint i = IR_GLOBAL_ID;
    if (i >= count) return;
    IR_GLOBAL const float* s = samples + 4 * i;
    real3 origin;
    const CameraRay ray = lens_ray_at(info, s[0], s[1], s[2], s[3], &origin);
    IR_GLOBAL float* o = out + 8 * i;
    o[0] = origin.x;
    o[1] = origin.y;
    o[2] = origin.z;
    o[3] = ray.direction.x;
    o[4] = ray.direction.y;
    o[5] = ray.direction.z;
    o[6] = ray.t_min;
    o[7] = ray.t_max;
}

// Pixel i of the film, at u = v = (lens_u, lens_v) = (1/2, 1/2). Results, 8 floats: those of camera_ray() minus those
// of lens_ray(): origin, direction, t_min, t_max.
IR_KERNEL void test_lens_centre(IR_GLOBAL const SceneInfo* info, uint count, IR_GLOBAL float* out) {
    const uint i = IR_GLOBAL_ID;
    if (i >= count) return;
    const uint x = i % info->width, y = i / info->width;
    real3 origin;
    const CameraRay lens = lens_ray(info, x, y, 0.5f, 0.5f, 0.5f, 0.5f, &origin);
    const CameraRay pinhole = camera_ray(info, x, y, 0.5f, 0.5f);
    const real3 o = camera_origin(info) - origin, d = pinhole.direction - lens.direction;
    IR_GLOBAL float* to = out + 8 * i;
    to[0] = o.x;
    to[1] = o.y;
    to[2] = o.z;
    to[3] = d.x;
    to[4] = d.y;
    to[5] = d.z;
    to[6] = pinhole.t_min - lens.t_min;
    to[7] = pinhole.t_max - lens.t_max;
}
