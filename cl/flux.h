// Translational gradient and Hessian of irradiance, edge by edge ("cell-edge flux form", theory 5). Radiance is
// constant on cells; across a boundary edge it steps by dL = L_B - L_A. The edge is a rigid segment ra -> rb relative
// to the receiver; moving the receiver sweeps it over projected solid angle. No mesh, no sorting, no term at the
// horizon.
#ifndef IR_FLUX_H
#define IR_FLUX_H
#include "portable.h"

// Angle in [0, pi] whose tangent is y/x, y >= 0, by a minimax polynomial: relative error 1.6e-8, in float32 arithmetic
// below 3e-7. Without branches: the built-in costs 43 ns on a CPU device, this 1 ns.
IR_FN real arctangent_polynomial(real y, real x) {
    const real ax = fabs(x);
    const real t = min(y, ax) / max(max(y, ax), R(1e-30));
    const real u = t * t;
    real p = R(0.0028499030753929276);
    p = p * u - R(0.016068704442945118);
    p = p * u + R(0.042691683346117094);
    p = p * u - R(0.07504312744460741);
    p = p * u + R(0.10640945228575731);
    p = p * u - R(0.14203648303962996);
    p = p * u + R(0.1999262007937009);
    p = p * u - R(0.3333307339991898);
    p = p * u + R(0.9999999847785279);
    const real a = p * t;
    const real b = y > ax ? R(0.5) * IR_PI - a : a;
    return x < R(0.0) ? IR_PI - b : b;
}

IR_FN real arctangent(real y, real x) {
#if defined(__OPENCL_VERSION__) || defined(__CUDACC__)
    return arctangent_polynomial(y, x);
#else
    return atan2(y, x);
#endif
}

// One edge, for dL = 1: the gradient g, and the symmetrised Hessian (c v^T + v c^T)/2. (The antisymmetric term -Q nJ of
// theory 5 cancels when symmetrised, and with it the closing segments at depth jumps.)
typedef struct EdgeFlux {
    real3 g, c, v;
} EdgeFlux;

// Edge ra -> rb (relative to the receiver with unit normal n) with B on the side of ra x rb; swap the ends otherwise.
// All zero for an edge that is seen as a point.
IR_FN EdgeFlux edge_flux(real3 ra, real3 rb, real3 n) {
    EdgeFlux flux;
    flux.g = flux.c = flux.v = make_real3(R(0.0), R(0.0), R(0.0));
    // In units of the nearer end: stays clear of underflow and overflow at any scene scale.
    const real inverse_scale = rsqrt(min(dot(ra, ra), dot(rb, rb)));
    ra = ra * inverse_scale;
    rb = rb * inverse_scale;
    const real3 e = rb - ra;
    const real3 c = cross(ra, e);
    const real A = dot(e, e), a2 = dot(ra, ra), b2 = dot(rb, rb), D = dot(c, c);
    if (!(D > R(1e-12) * a2 * b2)) return flux;

    const real d = dot(ra, e), d1 = dot(rb, e);
    const real inv_a2 = R(1.0) / a2, inv_b2 = R(1.0) / b2, inv_D = R(1.0) / D, inv_A = R(1.0) / A;
    const real root_D = sqrt(D);
    const real theta = arctangent(root_D, dot(ra, rb));
    // I_m = int_0^1 |ra + t e|^(-2m) dt, T_m and U_m its first and second moments in t
    const real I1 = theta / root_D;
    const real I2 = R(0.5) * inv_D * (d1 * inv_b2 - d * inv_a2 + A * I1);
    const real I3 = R(0.25) * inv_D * (d1 * inv_b2 * inv_b2 - d * inv_a2 * inv_a2 + R(3.0) * A * I2);
    const real T2 = inv_A * (R(0.5) * (inv_a2 - inv_b2) - d * I2);
    const real T3 = inv_A * (R(0.25) * (inv_a2 * inv_a2 - inv_b2 * inv_b2) - d * I3);
    const real U3 = inv_A * (I2 - R(2.0) * d * T3 - a2 * I3);
    const real na = dot(n, ra), ne = dot(n, e);
    const real nJ = I2 * na + T2 * ne;
    const real k1 = R(4.0) * (I3 * na + T3 * ne);
    const real k2 = R(4.0) * (T3 * na + U3 * ne);
    flux.g = c * (nJ * inverse_scale);
    flux.c = c;
    flux.v = (ra * k1 + e * k2 - n * I2) * (inverse_scale * inverse_scale);
    return flux;
}
#endif
