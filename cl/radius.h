// How far a record reaches: harmonic mean or minimal distance (theory 4.4), or the ellipse of the Hessian (theory 6),
// and the limits that follow, in this order: gradient_limited_radius, neighbour_clamped_radius, clamp to pixels,
// gradient_scale.
#ifndef IR_RADIUS_H
#define IR_RADIUS_H
#include "portable.h"

// 1/r for (1.14), r clamped so that neither r = 0 nor a miss (r_max) makes R 0 or infinite. r_min = 1e-6 and r_max = 10
// times the scene's diagonal.
IR_FN real inverse_distance(real r, real r_min, real r_max) { return R(1.0) / clamp(r, r_min, r_max); }

IR_FN real harmonic_mean_distance(uint samples, real sum_of_inverses) { return (real)samples / sum_of_inverses; }

// R <= E/|grad_t E|, one channel at a time: then E(1-a) > 0 anywhere in the record's support (theory 4.5).
IR_FN real gradient_limited_radius(real radius, real E, real gradient) {
    return E > R(0.0) && gradient * radius > E ? E / gradient : radius;
}

// R_i <= R_j + |p_i - p_j|, for the new record first, then for its neighbours.
IR_FN real neighbour_clamped_radius(real radius_i, real radius_j, real distance) {
    return min(radius_i, radius_j + distance);
}

// Factor to a channel's translational gradient that brings it down to E/radius: the clamp to [R_lo, R_hi] comes last
// and may have raised R above the gradient's limit.
IR_FN real gradient_scale(real radius, real E, real gradient) {
    return gradient * radius > E ? max(E, R(0.0)) / (gradient * radius) : R(1.0);
}

// Is a record too dark for every rule that divides by E (theory 4.7)? R is min(R_HMD, R_hi) then.
IR_FN bool is_black(real E, real reference) { return !(E > R(1e-20) * reference); }

// Eigenvalues of a symmetric 2x2 matrix, |l1| >= |l2|, and the unit eigenvector (x1, y1) of l1; that of l2 is
// (-y1, x1).
typedef struct Eigen2 {
    real l1, l2, x1, y1;
} Eigen2;

IR_FN Eigen2 eigen_symmetric(real xx, real xy, real yy) {
    Eigen2 e;
    e.l1 = e.l2 = e.y1 = R(0.0);
    e.x1 = R(1.0);
    const real scale = max(fabs(xy), max(fabs(xx), fabs(yy)));
    if (!(scale > R(1e-36))) return e;  // zero, or not a number: 1 over it is finite
    const real inverse_scale = R(1.0) / scale;
    const real mean = R(0.5) * (xx + yy) * inverse_scale, difference = R(0.5) * (xx - yy) * inverse_scale;
    const real off = xy * inverse_scale;
    const real root = sqrt(difference * difference + off * off);
    const bool positive = mean >= R(0.0);  // the larger eigenvalue is mean + root, else mean - root
    e.l1 = (positive ? mean + root : mean - root) * scale;
    e.l2 = (positive ? mean - root : mean + root) * scale;
    // Eigenvector of mean + root, by the form that adds instead of subtracting.
    const real vx = difference >= R(0.0) ? root + difference : off;
    const real vy = difference >= R(0.0) ? off : root - difference;
    const real square = vx * vx + vy * vy;
    if (!(square > R(1e-30))) return e;  // a multiple of the identity: any axis
    const real inverse = rsqrt(square);
    e.x1 = (positive ? vx : -vy) * inverse;
    e.y1 = (positive ? vy : vx) * inverse;
    return e;
}

// Least |eigenvalue| taken seriously, D the scene's diagonal.
IR_FN real hessian_floor(real E, real diagonal) { return R(0.02) * E / (diagonal * diagonal); }

// R_i = (4 tau area E / (pi |l|))^(1/4): tau = allowed relative error, area = world area of a pixel at the record.
// |l| is at least `floor_l`, which must be > 0 (theory 4.7: not for black records).
IR_FN real hessian_radius(real l, real E, real floor_l, real tau, real area) {
    return sqrt(sqrt(R(4.0) * tau * area * E / (IR_PI * max(fabs(l), floor_l))));
}

// Semi-axes of a record's support: r1 along t1 (strongest curvature) and along the normal, r2 along t2.
typedef struct EllipseRadii {
    real r1, r2;
} EllipseRadii;

// Both within [lo, hi] and r1 <= r2 <= aspect r1 (theory 6: aspect 2..4).
IR_FN EllipseRadii clamp_ellipse(real r1, real r2, real lo, real hi, real aspect) {
    EllipseRadii e;
    e.r1 = clamp(r1, lo, hi);
    e.r2 = clamp(clamp(r2, lo, hi), e.r1, aspect * e.r1);
    return e;
}

IR_FN EllipseRadii hessian_ellipse(Eigen2 h, real E, real diagonal, real tau, real area, real lo, real hi,
                                   real aspect) {
    const real floor_l = hessian_floor(E, diagonal);
    return clamp_ellipse(hessian_radius(h.l1, E, floor_l, tau, area), hessian_radius(h.l2, E, floor_l, tau, area), lo,
                         hi, aspect);
}
#endif
