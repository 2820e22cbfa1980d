// Translational gradient and Hessian of irradiance, edge by edge ("cell-edge flux form", theory 5). Radiance is
// constant on cells; across a boundary edge it steps by dL = L_B - L_A. The edge is a rigid segment ra -> rb relative
// to the receiver; moving the receiver sweeps it over projected solid angle. No mesh, no sorting, no term at the
// horizon.
#ifndef IR_FLUX_H
#define IR_FLUX_H
#include "arctangent.h"

// atan2(sqrt D, x)/sqrt D, the angle of an edge over |ra x rb|; D > 0. In float32 arithmetic below 4e-7.
IR_FN lanes angle_over_sine_polynomial(lanes D, lanes x) {
    const lanes_mask narrow = x > R(0.0) && D <= x * x;  // below 45 degrees: no root needed. Cells are.
    const lanes inv_narrow = R(1.0) / lanes_select(R(1.0), x, narrow);
    const lanes below = lanes_arctangent_ratio(min(D * inv_narrow * inv_narrow, R(1.0))) * inv_narrow;
    if (lanes_all(narrow)) return below;
    const lanes inv_y = rsqrt(D);
    const lanes t = x * inv_y;
    const lanes complement = t * lanes_arctangent_ratio(min(t * t, R(1.0)));  // of the angle to 90 degrees, if within 45
    const lanes inv_x = R(1.0) / min(x, R(-1e-30));
    const lanes beyond = IR_PI * inv_y + lanes_arctangent_ratio(min(D * inv_x * inv_x, R(1.0))) * inv_x;  // above 135 degrees
    const lanes above = lanes_select(beyond, (R(0.5) * IR_PI - complement) * inv_y, fabs(t) <= R(1.0));
    return lanes_select(above, below, narrow);
}

IR_FN lanes angle_over_sine(lanes D, lanes x) {
#if defined(__OPENCL_VERSION__) || defined(__CUDACC__)
    return angle_over_sine_polynomial(D, x);
#else
    return atan2(sqrt(D), x) / sqrt(D);
#endif
}

// One edge, for dL = 1: the gradient g, and the symmetrised Hessian (c v^T + v c^T)/2. (The antisymmetric term -Q nJ of
// theory 5 cancels when symmetrised, and with it the closing segments at depth jumps.)
typedef struct EdgeFlux {
    LaneVector g, c, v;
} EdgeFlux;

// Edge ra -> rb (relative to the receiver with unit normal n) with B on the side of ra x rb; swap the ends otherwise.
// All zero for an edge that is seen as a point, and where `real_edge` does not hold. The ends come in units of the nearer
// one's distance, the results are multiplied by inverse_scale = 1/that: clear of underflow and overflow at any scene scale.
IR_FN EdgeFlux edge_flux_scaled(LaneVector ra, LaneVector rb, LaneVector n, lanes inverse_scale, lanes_mask real_edge) {
    const LaneVector e = lanes_difference(rb, ra), c = lanes_cross(ra, e);
    const lanes a2 = lanes_dot(ra, ra), b2 = lanes_dot(rb, rb), cross2 = lanes_dot(c, c);
    const lanes_mask seen = real_edge && cross2 > R(1e-12) * a2 * b2;
    // Lanes without an edge compute with ones; what comes out is not taken.
    const lanes D = lanes_select(R(1.0), cross2, seen), A = lanes_select(R(1.0), lanes_dot(e, e), seen);
    const lanes d = lanes_dot(ra, e), d1 = lanes_dot(rb, e);
    const lanes inv_a2 = R(1.0) / lanes_select(R(1.0), a2, seen), inv_b2 = R(1.0) / lanes_select(R(1.0), b2, seen);
    const lanes inv_D = R(1.0) / D, inv_A = R(1.0) / A;
    // I_m = int_0^1 |ra + t e|^(-2m) dt, T_m and U_m its first and second moments in t
    const lanes I1 = angle_over_sine(D, lanes_select(R(1.0), lanes_dot(ra, rb), seen));
    const lanes I2 = R(0.5) * inv_D * (d1 * inv_b2 - d * inv_a2 + A * I1);
    const lanes I3 = R(0.25) * inv_D * (d1 * inv_b2 * inv_b2 - d * inv_a2 * inv_a2 + R(3.0) * A * I2);
    const lanes T2 = inv_A * (R(0.5) * (inv_a2 - inv_b2) - d * I2);
    const lanes T3 = inv_A * (R(0.25) * (inv_a2 * inv_a2 - inv_b2 * inv_b2) - d * I3);
    const lanes U3 = inv_A * (I2 - R(2.0) * d * T3 - a2 * I3);
    const lanes na = lanes_dot(n, ra), ne = lanes_dot(n, e);
    const lanes nJ = I2 * na + T2 * ne;
    const lanes k1 = R(4.0) * (I3 * na + T3 * ne);
    const lanes k2 = R(4.0) * (T3 * na + U3 * ne);
    const LaneVector g = lanes_scaled(c, nJ * inverse_scale);
    const lanes s2 = inverse_scale * inverse_scale;
    const LaneVector v =
        make_lane_vector((ra.x * k1 + e.x * k2 - n.x * I2) * s2, (ra.y * k1 + e.y * k2 - n.y * I2) * s2,
                         (ra.z * k1 + e.z * k2 - n.z * I2) * s2);
    const LaneVector zero = make_lane_vector(lanes_of(R(0.0)), lanes_of(R(0.0)), lanes_of(R(0.0)));
    EdgeFlux flux;
    flux.g = lanes_select3(zero, g, seen);
    flux.c = lanes_select3(zero, c, seen);
    flux.v = lanes_select3(zero, v, seen);
    return flux;
}

#if IR_LANES == 1
// The same in world units.
IR_FN EdgeFlux edge_flux(real3 ra, real3 rb, real3 n) {
    const real inverse_scale = rsqrt(min(dot(ra, ra), dot(rb, rb)));
    return edge_flux_scaled(ra * inverse_scale, rb * inverse_scale, n, inverse_scale, true);
}
#endif
#endif
