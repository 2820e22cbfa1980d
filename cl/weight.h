// How much a record counts at a point (theory 4.1 - 4.3, 6), in forms that float32 cannot turn into NaN.
#ifndef IR_WEIGHT_H
#define IR_WEIGHT_H
#include "portable.h"

// length() without the care that OpenCL takes of squares beyond float32's range: it costs more than the root.
IR_FN real plain_length(real3 v) { return sqrt(dot(v, v)); }

// sqrt(1 - n.n_i) of unit normals, as |n - n_i|/sqrt 2: the printed form is the root of a negative number in float32
// for one pair of equal normals in twenty.
IR_FN real normal_error(real3 n, real3 ni) { return R(0.70710678118654752440) * plain_length(n - ni); }

// e of (1.8). Distances: subtract first, then square; never expand.
IR_FN real ward_error(real3 p, real3 n, real3 pi, real3 ni, real radius) {
    return length(p - pi) / radius + normal_error(n, ni);
}

// (1.8) times a, as a function of x = e/a: 1/x - 1, capped at ~100 where x < .01, 0 where x >= 1.
IR_FN real ward_weight_normalised(real x) { return x < R(1.0) ? (R(1.0) - x) / max(x, R(0.01)) : R(0.0); }

// The same support with a bell: (1 - x)²(1 + 2x). Under (1.8) the nearest record outweighs all others, so each shows as a
// spot of its own noise; here several are averaged everywhere, and the sum has no kinks (theory 6: the shape of the weight
// hardly matters to the interpolation itself).
IR_FN real cubic_weight_normalised(real x) {
    const real y = max(R(1.0) - x, R(0.0));
    return y * y * (R(1.0) + R(2.0) * x);
}

IR_FN real ward_weight(real e, real a) { return ward_weight_normalised(e / a) / a; }

// (1.11)-(1.13), clamped at 0 (1.9). kappa = 1/(2a) gives the distance the same support a R as (1.8).
// 0.123257.. = sqrt(1 - cos 10 deg).
IR_FN real tabellion_weight(real distance, real radius, real normal_err, real kappa) {
    return max(R(0.0), R(1.0) - kappa * max(R(2.0) * distance / radius, normal_err / R(0.12325683343243877)));
}

// e_t of theory 6: distance in the ellipse with semi-axis r2 along the unit tangent t2, and r1 across it, along the
// normal too.
IR_FN real elliptic_error(real3 dp, real3 t2, real r1, real r2) {
    const real along = dot(dp, t2);
    const real across2 = max(dot(dp, dp) - along * along, R(0.0));
    return sqrt(across2 / (r1 * r1) + along * along / (r2 * r2));
}

// The weight of theory 6; normal_support = a_n.
IR_FN real elliptic_weight(real tangential_error, real normal_err, real normal_support) {
    return max(R(0.0), R(1.0) - tangential_error - normal_err / normal_support);
}

// ---- records that p must not see
// -------------------------------------------------------------------------------------

// d of (1.10): how far p lies over the mean tangent plane of the record. 0 for two points of one sphere.
IR_FN real height_over_record(real3 p, real3 n, real3 pi, real3 ni) { return R(0.5) * dot(p - pi, n + ni); }

// The rounding of d in float32, for coordinates of size `coordinate`.
IR_FN real in_front_tolerance(real distance, real slope, real coordinate) {
    return slope * distance + R(4.76837158203125e-7) * coordinate;  // 4 * 2^-23
}

IR_FN real largest_coordinate(real3 p) { return max(fabs(p.x), max(fabs(p.y), fabs(p.z))); }

// Is the record in front of p (theory 4.3)? slope .05 rejects steps but no smooth curvature.
IR_FN bool is_in_front(real3 p, real3 n, real3 pi, real3 ni, real slope, real coordinate) {
    return height_over_record(p, n, pi, ni) < -in_front_tolerance(plain_length(p - pi), slope, coordinate);
}

// Is the record a step below p (p on a box's top, record on the floor)? Asked of nearly equal normals only.
IR_FN bool is_below(real3 p, real3 n, real3 pi, real3 ni) {
    return (dot(n, ni) > R(0.95)) & (height_over_record(p, n, pi, ni) > R(0.3) * plain_length(p - pi));
}
#endif
