// Directions of hemisphere strata, tables of their rings, orthonormal frames, and samples of simple shapes.
// Angles come as turns (1 = 2 pi): they are then exact in float32 up to the last step.
#ifndef IR_SAMPLING_H
#define IR_SAMPLING_H
#include "portable.h"

// sin and cos of 2 pi turns, turns in [0, 1]. Evaluated at 2 pi turns - pi: the fast sine of GPUs keeps its absolute
// error (4e-7) in [-pi, pi] only.
IR_FN void sincos_turns(real turns, real* s, real* c) {
    real s_minus, c_minus;
    real_sincos(R(6.28318530717958647692) * turns - IR_PI, &s_minus, &c_minus);
    *s = -s_minus;
    *c = -c_minus;
}

// The right-handed local frame (T, B, n), T x B = n: deterministic and without a branch (Duff et al. 2017).
typedef struct Frame {
    real3 t, b, n;
} Frame;

IR_FN Frame make_frame(real3 n) {
    const real sign = n.z >= R(0.0) ? R(1.0) : R(-1.0);
    const real a = R(-1.0) / (sign + n.z);
    const real b = n.x * n.y * a;
    Frame f;
    f.t = make_real3(R(1.0) + sign * n.x * n.x * a, sign * b, -sign * n.x);
    f.b = make_real3(b, sign + n.y * n.y * a, -n.y);
    f.n = n;
    return f;
}

IR_FN real3 to_world(Frame f, real3 v) { return f.t * v.x + f.b * v.y + f.n * v.z; }
IR_FN real3 to_local(Frame f, real3 v) { return make_real3(dot(f.t, v), dot(f.b, v), dot(f.n, v)); }

// ---- hemisphere strata (theory 1): ring j = 0..m-1 from the pole, azimuth k = 0..n-1, index j*n+k
// --------------------

// Unit direction, local frame, with density cos/pi in its hemisphere; never normalised afterwards. The floor keeps rays
// off the tangent plane: 1 - s2 of float32 is a multiple of 2^-24.
IR_FN real3 cosine_direction(real s2, real turns) {
    const real s = sqrt(s2);
    real sin_phi, cos_phi;
    sincos_turns(turns, &sin_phi, &cos_phi);
    return make_real3(s * cos_phi, s * sin_phi, sqrt(max(R(1.0) - s2, R(6e-8))));
}

// (1.3): a point of stratum (j, k), xi1 and xi2 in [0, 1).
IR_FN real3 stratum_direction(uint j, uint k, uint m, uint n, real xi1, real xi2) {
    return cosine_direction(((real)j + xi1) / (real)m, ((real)k + xi2) / (real)n);
}

// sin and cos of th_j-, the inner edge of ring j; th_j+ is ring_sin(j + 1, m).
IR_FN real ring_sin(uint j, uint m) { return sqrt((real)j / (real)m); }
IR_FN real ring_cos(uint j, uint m) { return sqrt((real)(m - j) / (real)m); }

// Exact mean of tan over ring j in projected solid angle (theory 3.1). Made on the host, in double, into a table.
IR_FN real ring_rotation_weight(uint j, uint m) {
    const real sa = ring_sin(j, m), ca = ring_cos(j, m), sb = ring_sin(j + 1, m), cb = ring_cos(j + 1, m);
    return (real)m * ((asin(sb) - asin(sa)) - (sb * cb - sa * ca));
}

// Ward-Heckbert's weights (theory 3.2): of the edge to ring j-1 (times 2 pi / n), and of the edge to azimuth k-1.
IR_FN real ring_edge_weight(uint j, uint m) { return ring_sin(j, m) * ((real)(m - j) / (real)m); }
IR_FN real azimuth_edge_weight(uint j, uint m) {  // sin th_j+ - sin th_j-, without the subtraction
    return R(1.0) / ((real)m * (ring_sin(j + 1, m) + ring_sin(j, m)));
}

// ---- samples of shapes, u and v in [0, 1)
// ----------------------------------------------------------------------------

// Density 1/area over a triangle: x, y are the barycentrics of its second and third vertex, z that of the first.
IR_FN real3 sample_triangle(real u, real v) {
    const real s = sqrt(u);
    return make_real3(s * (R(1.0) - v), s * v, R(1.0) - s);
}

// Density 1/pi over the unit disk (z = 0).
IR_FN real3 sample_disk(real u, real v) {
    const real r = sqrt(u);
    real s, c;
    sincos_turns(v, &s, &c);
    return make_real3(r * c, r * s, R(0.0));
}

// Density 1/(4 pi) over the unit sphere.
IR_FN real3 sample_sphere(real u, real v) {
    const real z = R(1.0) - R(2.0) * u;
    const real r = R(2.0) * sqrt(u * (R(1.0) - u));
    real s, c;
    sincos_turns(v, &s, &c);
    return make_real3(r * c, r * s, z);
}
#endif
