// Gradients of irradiance from the cells of one hemisphere, each function one cell's term for L = 1 or dL = 1, local
// frame. To world: g = gx T + gy B.
#ifndef IR_GRADIENT_H
#define IR_GRADIENT_H
#include "lanes.h"
#include "sampling.h"

// Rotation (1.4), with the sign and the exact ring weights of theory 3.1: a cell's term is w_j v_k, where v_k is the
// azimuth of its centre turned by +90 degrees; gradient = pi/(m n) sum L_jk w_j v_k, w_j = ring_rotation_weight(j, m).
IR_FN LaneVector rotational_gradient_term(real weight_j, lanes k, uint n) {
    lanes s, c;
    lanes_sincos_turns((k + R(0.5)) / (real)n, &s, &c);
    return make_lane_vector(-s * weight_j, c * weight_j, lanes_of(R(0.0)));
}

// Inverse distance of the edge between two cells that Ward and Heckbert take: that of the nearer hit. Misses are at
// inverse distance 0, so two misses contribute nothing.
IR_FN real ward_inverse_distance(real inverse_a, real inverse_b) { return max(inverse_a, inverse_b); }

// The same, but a surface is taken to go on (mean) where the distances differ by less than 1.5 (theory 3.2).
IR_FN real ward_inverse_distance_ratio(real inverse_a, real inverse_b) {
    const real hi = max(inverse_a, inverse_b), lo = min(inverse_a, inverse_b);
    return hi <= R(1.5) * lo ? R(0.5) * (hi + lo) : hi;
}

// Translation (1.5) in Ward and Heckbert's form (theory 3.2), the two edges of cell (j, k), for
// i = inverse distance of the edge and dL = L_jk - L_neighbour = 1:
// to ring j-1, along the azimuth of the cell's centre; zero for j = 0, which has no such edge;
IR_FN real3 ward_ring_term(uint j, uint k, uint m, uint n, real i) {
    real s, c;
    sincos_turns(((real)k + R(0.5)) / (real)n, &s, &c);
    const real w = R(2.0) * IR_PI / (real)n * ring_edge_weight(j, m) * i;
    return make_real3(c * w, s * w, R(0.0));
}

// to azimuth k-1 (modulo n), along the edge's azimuth turned by +90 degrees.
IR_FN real3 ward_azimuth_term(uint j, uint k, uint m, uint n, real i) {
    real s, c;
    sincos_turns((real)k / (real)n, &s, &c);
    const real w = azimuth_edge_weight(j, m) * i;
    return make_real3(-s * w, c * w, R(0.0));
}

// (1.7) for one channel: E + (n_i x n).grad_r + (p - p_i).grad_t, the factor to E limited to [0, 2] (theory 4.5).
IR_FN real extrapolate(real E, real change) {
    return E > R(1e-20) ? E * clamp(R(1.0) + change / E, R(0.0), R(2.0)) : R(0.0);
}
#endif
