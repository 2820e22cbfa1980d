// Directions uniform in the solid angle that a rectangle or a triangle subtends. Next to a light the density of area
// sampling has no lower bound and its estimate no finite variance; in solid angle the estimate is bounded by the light's
// radiance.
#ifndef IR_SOLID_ANGLE_H
#define IR_SOLID_ANGLE_H
#include "arctangent.h"
#include "sampling.h"

// arctan by the polynomial of arctangent.h: relative error 1.6e-8 (built-in arctangents take 43 ns on a CPU device).
IR_FN real arctangent_polynomial(real t) {
    if (fabs(t) <= R(1.0)) return t * arctangent_ratio(t * t);
    const real i = R(1.0) / t;
    return (t > R(0.0) ? R(0.5) * IR_PI : R(-0.5) * IR_PI) - i * arctangent_ratio(i * i);
}

IR_FN real arctangent(real t) {
#if defined(__OPENCL_VERSION__) || defined(__CUDACC__)
    return arctangent_polynomial(t);
#else
    return atan2(t, 1.0);
#endif
}

// sin and cos of an angle in [0, 2 pi].
IR_FN void sincos_angle(real angle, real* s, real* c) { sincos_turns(angle * R(0.15915494309189533577), s, c); }

// ---- rectangles: Urena, Fajardo, King, "An area-preserving parametrization for spherical rectangles" (EGSR 2013) ----

// The rectangle corner + a e1 + b e2 (e1 perpendicular to e2) seen from p, in the frame of its edges with p at the
// origin and z0 <= 0.
typedef struct SphericalRectangle {
    real3 x, y, z;
    real x0, x1, y0, y1, z0;
    real solid_angle;  // sr
} SphericalRectangle;

IR_FN real corner_angle(real x, real y, real z2, real inverse_z) {
    return arctangent(x * y * inverse_z * rsqrt(x * x + y * y + z2));
}

IR_FN SphericalRectangle spherical_rectangle(real3 p, real3 corner, real3 e1, real3 e2) {
    SphericalRectangle q;
    const real length1 = length(e1), length2 = length(e2);
    q.x = e1 * (R(1.0) / length1);
    q.y = e2 * (R(1.0) / length2);
    q.z = cross(q.x, q.y);
    const real3 d = corner - p;
    q.z0 = dot(d, q.z);
    if (q.z0 > R(0.0)) {
        q.z = -q.z;
        q.z0 = -q.z0;
    }
    q.x0 = dot(d, q.x);
    q.y0 = dot(d, q.y);
    q.x1 = q.x0 + length1;
    q.y1 = q.y0 + length2;
    // Four right-angled pieces: well conditioned where the sum of the corners' angles (the paper's) cancels.
    const real z2 = q.z0 * q.z0, inverse_z = R(1.0) / max(-q.z0, R(1e-30));
    q.solid_angle = corner_angle(q.x1, q.y1, z2, inverse_z) - corner_angle(q.x0, q.y1, z2, inverse_z) -
                    corner_angle(q.x1, q.y0, z2, inverse_z) + corner_angle(q.x0, q.y0, z2, inverse_z);
    return q;
}

// Offset from p to the point of the rectangle for u, v in [0,1). Needs solid_angle > 0.
IR_FN real3 sample_spherical_rectangle(const SphericalRectangle* q, real u, real v) {
    const real z2 = q->z0 * q->z0;
    const real r0 = rsqrt(z2 + q->y0 * q->y0), r2 = rsqrt(z2 + q->y1 * q->y1), r3 = rsqrt(z2 + q->x0 * q->x0);
    const real n0 = -q->y0 * r0, n2 = q->y1 * r2, n3 = -q->x0 * r3;
    // The paper's k = 2 pi - g2 - g3 by its sine and cosine, those of the corners' angles being known: no arc cosine, and
    // no root of 1 - cos^2.
    const real c2 = -n2 * n3, s2 = -q->z0 * sqrt(z2 + q->y1 * q->y1 + q->x0 * q->x0) * r2 * r3;
    const real c3 = -n3 * n0, s3 = -q->z0 * sqrt(z2 + q->y0 * q->y0 + q->x0 * q->x0) * r3 * r0;
    const real sin_k = -(s2 * c3 + c2 * s3), cos_k = c2 * c3 - s2 * s3;
    real sin_u, cos_u;
    sincos_angle(u * q->solid_angle, &sin_u, &cos_u);
    real sin_a = sin_u * cos_k + cos_u * sin_k;
    const real cos_a = cos_u * cos_k - sin_u * sin_k;
    if (fabs(sin_a) < R(1e-7)) sin_a = sin_a < R(0.0) ? R(-1e-7) : R(1e-7);
    const real f = (cos_a * n0 - n2) / sin_a;
    // cu = sign(f) / sqrt(f² + n0²), x = -cu z0 / sqrt(1 - cu²): without the roots of differences
    const real below = max(f * f + n0 * n0 - R(1.0), R(1e-20));
    const real x = clamp((f > R(0.0) ? -q->z0 : q->z0) * rsqrt(below), q->x0, q->x1);
    const real d2 = x * x + z2;
    const real h0 = q->y0 * rsqrt(d2 + q->y0 * q->y0), h1 = q->y1 * rsqrt(d2 + q->y1 * q->y1);
    const real h = h0 + v * (h1 - h0);
    const real y = clamp(h * sqrt(d2) * rsqrt(max(R(1.0) - h * h, R(1e-12))), q->y0, q->y1);
    return q->x * x + q->y * y + q->z * q->z0;
}

// ---- triangles: Peters, "BRDF importance sampling for polygonal lights" (SIGGRAPH 2021) ------------------------------
// Arvo's map (1995) from other terms: no angle of a corner is needed, which loses all its digits near the light's plane.

typedef struct SphericalTriangle {
    real3 a, b, c;     // unit directions to the vertices
    real volume;       // |a . (b x c)|
    real sum, one_ab;  // (a + b) . c, 1 + a . b: tan(half the solid angle) = volume / (sum + one_ab)
    real solid_angle;  // sr
} SphericalTriangle;

IR_FN SphericalTriangle spherical_triangle(real3 p, real3 v0, real3 e1, real3 e2) {
    SphericalTriangle t;
    const real3 da = v0 - p, db = da + e1, dc = da + e2;
    const real ra = rsqrt(dot(da, da)), rb = rsqrt(dot(db, db)), rc = rsqrt(dot(dc, dc));
    t.a = da * ra;
    t.b = db * rb;
    t.c = dc * rc;
    // Van Oosterom and Strackee 1983; the volume from the edges: exact for small triangles and next to the plane.
    t.volume = fabs(dot(t.a, cross(e1 * rb, e2 * rc)));
    const real3 ab = t.a + t.b;  // keeps its digits where a and b are almost opposite: next to the edge
    t.sum = dot(ab, t.c);
    t.one_ab = R(0.5) * dot(ab, ab);
    const real below = t.sum + t.one_ab;
    t.solid_angle = below > t.volume ? R(2.0) * arctangent(t.volume / below)
                                     : IR_PI - R(2.0) * arctangent(below / max(t.volume, R(1e-30)));
    return t;
}

// The part of v across the unit vector n, as a unit vector.
IR_FN real3 unit_across(real3 v, real3 n) {
    const real3 w = v - n * dot(v, n);
    return w * rsqrt(max(dot(w, w), R(1e-30)));
}

// Unit direction for u, v in [0,1). Needs solid_angle > 0.
IR_FN real3 sample_spherical_triangle(const SphericalTriangle* t, real u, real v) {
    real sine, cosine;
    sincos_angle(R(0.5) * u * t->solid_angle, &sine, &cosine);
    // c1 on the side ac, so that a, b, c1 subtend u times the solid angle: a mirrored in the direction half way to it
    const real3 half_way = t->a * (t->volume * cosine - t->sum * sine) + t->c * (t->one_ab * sine);
    const real3 c1 =
        half_way * (R(2.0) * dot(t->a, half_way) / max(dot(half_way, half_way), R(1e-30))) - t->a;
    const real height = v * (R(1.0) - dot(c1, t->b));  // 1 - cos of the angle from b
    return t->b * (R(1.0) - height) + unit_across(c1, t->b) * sqrt(max(height * (R(2.0) - height), R(0.0)));
}
#endif
