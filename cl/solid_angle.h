// Directions uniform in the solid angle that a rectangle or a triangle subtends. Next to a light the density of area
// sampling has no lower bound and its estimate no finite variance; in solid angle the estimate is bounded by the light's
// radiance.
#ifndef IR_SOLID_ANGLE_H
#define IR_SOLID_ANGLE_H
#include "flux.h"
#include "sampling.h"

// arctan by the polynomial of flux.h: relative error 1.6e-8 (built-in arctangents take 43 ns on a CPU device).
IR_FN real arctangent(real t) {
    if (fabs(t) <= R(1.0)) return t * arctangent_ratio(t * t);
    const real i = R(1.0) / t;
    return (t > R(0.0) ? R(0.5) * IR_PI : R(-0.5) * IR_PI) - i * arctangent_ratio(i * i);
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
    const real n0 = -q->y0 * rsqrt(z2 + q->y0 * q->y0), n2 = q->y1 * rsqrt(z2 + q->y1 * q->y1);
    const real n3 = -q->x0 * rsqrt(z2 + q->x0 * q->x0);
    const real k = R(2.0) * IR_PI - acos(clamp(-n2 * n3, R(-1.0), R(1.0))) - acos(clamp(-n3 * n0, R(-1.0), R(1.0)));
    real sin_a, cos_a;
    sincos_angle(clamp(u * q->solid_angle + k, R(0.0), R(2.0) * IR_PI), &sin_a, &cos_a);
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

// ---- triangles: Arvo, "Stratified sampling of spherical triangles" (SIGGRAPH 1995) -----------------------------------

typedef struct SphericalTriangle {
    real3 a, b, c;     // unit directions to the vertices
    real solid_angle;  // sr
} SphericalTriangle;

IR_FN SphericalTriangle spherical_triangle(real3 p, real3 v0, real3 e1, real3 e2) {
    SphericalTriangle t;
    t.a = normalize(v0 - p);
    t.b = normalize(v0 + e1 - p);
    t.c = normalize(v0 + e2 - p);
    // Van Oosterom and Strackee 1983, with the edges' differences: exact for small triangles too.
    const real volume = fabs(dot(t.a, cross(t.b - t.a, t.c - t.a)));
    const real below = R(1.0) + dot(t.a, t.b) + dot(t.b, t.c) + dot(t.c, t.a);
    t.solid_angle = below > volume ? R(2.0) * arctangent(volume / below)
                                   : IR_PI - R(2.0) * arctangent(below / max(volume, R(1e-30)));
    return t;
}

// The part of v across the unit vector n, as a unit vector.
IR_FN real3 unit_across(real3 v, real3 n) {
    const real3 w = v - n * dot(v, n);
    return w * rsqrt(max(dot(w, w), R(1e-30)));
}

// Unit direction for u, v in [0,1). Needs solid_angle > 0.
IR_FN real3 sample_spherical_triangle(const SphericalTriangle* t, real u, real v) {
    const real3 ab = unit_across(t->b, t->a), ac = unit_across(t->c, t->a);
    const real cos_alpha = clamp(dot(ab, ac), R(-1.0), R(1.0));
    const real sin_alpha = length(cross(ab, ac));
    real s, c;
    sincos_angle(u * t->solid_angle, &s, &c);
    const real sin_phi = c * sin_alpha - s * cos_alpha;  // of alpha minus the part of the area taken: Arvo's -s
    const real cos_phi = -(c * cos_alpha + s * sin_alpha);
    const real k1 = cos_phi + cos_alpha, k2 = sin_phi - sin_alpha * dot(t->a, t->b);
    const real below = (k2 * sin_phi + k1 * cos_phi) * sin_alpha;
    const real cos_b =
        fabs(below) > R(1e-30)
            ? clamp((k2 + (k2 * cos_phi - k1 * sin_phi) * cos_alpha) / below, R(-1.0), R(1.0))
            : R(1.0);
    const real3 c1 = t->a * cos_b + ac * sqrt(max(R(1.0) - cos_b * cos_b, R(0.0)));
    const real height = v * (R(1.0) - dot(c1, t->b));  // 1 - cos of the angle from b
    return t->b * (R(1.0) - height) + unit_across(c1, t->b) * sqrt(max(height * (R(2.0) - height), R(0.0)));
}
#endif
