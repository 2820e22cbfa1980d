// Translational gradient and Hessian of irradiance, edge by edge ("cell-edge flux form", theory 5). Radiance is
// constant on cells; across a boundary edge it steps by dL = L_B - L_A. The edge is a rigid segment ra -> rb relative
// to the receiver; moving the receiver sweeps it over projected solid angle. No mesh, no sorting, no term at the
// horizon.
#ifndef IR_FLUX_H
#define IR_FLUX_H
#include "portable.h"

// arctan(t)/t as a function of u = t^2 in [0, 1], minimax: relative error 1.6e-8. Built-in arctangents cost 43 ns on a
// CPU device.
IR_FN real arctangent_ratio(real u) {
    const real u2 = u * u, u4 = u2 * u2;  // by Estrin's scheme: the short dependence chain is what counts
    const real p01 = R(0.9999999847785279) - R(0.3333307339991898) * u;
    const real p23 = R(0.1999262007937009) - R(0.14203648303962996) * u;
    const real p45 = R(0.10640945228575731) - R(0.07504312744460741) * u;
    const real p67 = R(0.042691683346117094) - R(0.016068704442945118) * u;
    return (p01 + p23 * u2) + u4 * ((p45 + p67 * u2) + R(0.0028499030753929276) * u4);
}

// atan2(sqrt D, x)/sqrt D, the angle of an edge over |ra x rb|; D > 0. In float32 arithmetic below 4e-7.
IR_FN real angle_over_sine_polynomial(real D, real x) {
    if (x > R(0.0) && D <= x * x) {  // below 45 degrees: no root needed. Cells are.
        const real inv_x = R(1.0) / x;
        return arctangent_ratio(D * inv_x * inv_x) * inv_x;
    }
    const real inv_y = rsqrt(D);
    const real t = x * inv_y;
    const real complement = t * arctangent_ratio(min(t * t, R(1.0)));  // of the angle to 90 degrees, if within 45
    const real inv_x = R(1.0) / min(x, R(-1e-30));
    const real beyond = IR_PI * inv_y + arctangent_ratio(min(D * inv_x * inv_x, R(1.0))) * inv_x;  // above 135 degrees
    return fabs(t) <= R(1.0) ? (R(0.5) * IR_PI - complement) * inv_y : beyond;
}

IR_FN real angle_over_sine(real D, real x) {
#if defined(__OPENCL_VERSION__) || defined(__CUDACC__)
    return angle_over_sine_polynomial(D, x);
#else
    return atan2(sqrt(D), x) / sqrt(D);
#endif
}

// One edge, for dL = 1: the gradient g, and the symmetrised Hessian (c v^T + v c^T)/2. (The antisymmetric term -Q nJ of
// theory 5 cancels when symmetrised, and with it the closing segments at depth jumps.)
typedef struct EdgeFlux {
    real3 g, c, v;
} EdgeFlux;

// Edge ra -> rb (relative to the receiver with unit normal n) with B on the side of ra x rb; swap the ends otherwise.
// All zero for an edge that is seen as a point. The ends come in units of the nearer one's distance, the results are
// multiplied by inverse_scale = 1/that: clear of underflow and overflow at any scene scale.
IR_FN EdgeFlux edge_flux_scaled(real3 ra, real3 rb, real3 n, real inverse_scale) {
    EdgeFlux flux;
    flux.g = flux.c = flux.v = make_real3(R(0.0), R(0.0), R(0.0));
    const real3 e = rb - ra;
    const real3 c = cross(ra, e);
    const real A = dot(e, e), a2 = dot(ra, ra), b2 = dot(rb, rb), D = dot(c, c);
    if (!(D > R(1e-12) * a2 * b2)) return flux;

    const real d = dot(ra, e), d1 = dot(rb, e);
    const real inv_a2 = R(1.0) / a2, inv_b2 = R(1.0) / b2, inv_D = R(1.0) / D, inv_A = R(1.0) / A;
    // I_m = int_0^1 |ra + t e|^(-2m) dt, T_m and U_m its first and second moments in t
    const real I1 = angle_over_sine(D, dot(ra, rb));
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

// The same in world units.
IR_FN EdgeFlux edge_flux(real3 ra, real3 rb, real3 n) {
    const real inverse_scale = rsqrt(min(dot(ra, ra), dot(rb, rb)));
    return edge_flux_scaled(ra * inverse_scale, rb * inverse_scale, n, inverse_scale);
}
#endif
