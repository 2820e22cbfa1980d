// What a hemisphere's kernel sums over its cells, cell by cell: irradiance and both gradients, the Hessian, the
// distances. Everything in the LOCAL frame of the record (theory 1), so the receiver's normal is z.
//
//   HemisphereSums sums = hemisphere_sums_zero();
//   for each IR_LANES cells of a ring from (j, k): cell_moments(...); cell_edges(...) or cell_edges_ward(...);
//   add up over lanes and work-items; scale irradiance and rx, ry by pi/(m n); gx, gy, gz, hxx, hxy, hyy are complete.
#ifndef IR_HEMISPHERE_REDUCE_H
#define IR_HEMISPHERE_REDUCE_H
#include "crease.h"
#include "flux.h"
#include "gradient.h"
#include "portable.h"
#include "sampling.h"

// A sample, or IR_LANES samples of one ring.
typedef struct HemisphereSample {
    LaneVector direction;  // unit, local frame
    LaneVector normal;     // unit geometric normal of the hit, local frame, either orientation; unused for a miss
    LaneVector radiance;   // RGB, W/(m2 sr)
    lanes distance;        // world units; IR_INFINITY: a miss
} HemisphereSample;

// Sums, lane by lane. Members of type LaneVector are RGB.
typedef struct HemisphereSums {
    LaneVector irradiance;   // sum L: E is pi/(m n) times it (1.2)
    LaneVector rx, ry;       // rotational gradient, local x and y, before the factor pi/(m n)
    LaneVector gx, gy, gz;   // translational gradient, local, complete
    lanes hxx, hxy, hyy;     // Hessian of luminance, tangential block, complete
    lanes inverse_distance;  // sum of inverse distances: R = m n / it (1.14)
    lanes min_distance;      // (1.15), over directions with cos >= min_cosine
} HemisphereSums;

IR_FN HemisphereSums hemisphere_sums_zero(void) {
    HemisphereSums s;
    s.irradiance = s.rx = s.ry = s.gx = s.gy = s.gz =
        make_lane_vector(lanes_of(R(0.0)), lanes_of(R(0.0)), lanes_of(R(0.0)));
    s.hxx = s.hxy = s.hyy = s.inverse_distance = lanes_of(R(0.0));
    s.min_distance = lanes_of(IR_INFINITY);
    return s;
}

// *sum += v * s
IR_FN void lanes_add_scaled(LaneVector* sum, LaneVector v, lanes s) {
    sum->x += v.x * s;
    sum->y += v.y * s;
    sum->z += v.z * s;
}

// Terms of the cells (j, k) alone, k and the IR_LANES - 1 after it (all of ring j). weight_j = ring_rotation_weight(j,
// m); `gradient_radiance` is the radiance for the rotational gradient (the sample's own, or limited against fireflies,
// theory 4.6); `distance` is clamped to [r_min, r_max] (theory 4.4; a miss counts as r_max, so pass IR_INFINITY to leave
// misses out). min_cosine keeps grazing rays, which are near 0 by chance, out of the minimum: .17 (theory 2), 0 for
// (1.15) as printed.
IR_FN void cell_moments(HemisphereSums* sums, uint k, uint n, real weight_j, HemisphereSample own,
                        LaneVector gradient_radiance, real r_min, real r_max, real min_cosine) {
    const LaneVector v = rotational_gradient_term(weight_j, (real)k + lanes_index(), n);
    const lanes r = clamp(own.distance, r_min, r_max);
    lanes_add_scaled(&sums->irradiance, own.radiance, lanes_of(R(1.0)));
    lanes_add_scaled(&sums->rx, gradient_radiance, v.x);
    lanes_add_scaled(&sums->ry, gradient_radiance, v.y);
    sums->inverse_distance += R(1.0) / r;
    sums->min_distance =
        min(sums->min_distance, lanes_select(IR_INFINITY, r, own.direction.z >= min_cosine));
}

// Flux of an edge between corners w0, w1, local frame; zero for that of two misses (edge.centre = 0).
IR_FN EdgeFlux cell_edge_flux(LaneVector w0, LaneVector w1, CellEdge edge) {
    const lanes_mask is_edge = edge.centre > R(0.0);
    const lanes inverse0 = lanes_select(R(1.0), edge.inverse0, is_edge);
    const lanes inverse1 = lanes_select(R(1.0), edge.inverse1, is_edge);
    const lanes inverse_scale = max(inverse0, inverse1);
    return edge_flux_scaled(lanes_scaled(w0, inverse_scale / inverse0), lanes_scaled(w1, inverse_scale / inverse1),
                            make_lane_vector(lanes_of(R(0.0)), lanes_of(R(0.0)), lanes_of(R(1.0))), inverse_scale,
                            is_edge);
}

// Adds one edge with step dL between corners w0, w1, B on the side of w0 x w1.
IR_FN void add_edge(HemisphereSums* sums, LaneVector w0, LaneVector w1, CellEdge edge, LaneVector dL) {
    const EdgeFlux f = cell_edge_flux(w0, w1, edge);
    const lanes dY = IR_LUMINANCE(dL.x, dL.y, dL.z);
    lanes_add_scaled(&sums->gx, dL, f.g.x);
    lanes_add_scaled(&sums->gy, dL, f.g.y);
    lanes_add_scaled(&sums->gz, dL, f.g.z);
    sums->hxx += dY * f.c.x * f.v.x;
    sums->hxy += dY * R(0.5) * (f.c.x * f.v.y + f.c.y * f.v.x);
    sums->hyy += dY * f.c.y * f.v.y;
}

// Corners of the cells (j, k ..), unit, local frame: a cell's edge to azimuth k-1 runs from `inner` to `outer`, its edge
// to ring j-1 from `next` to `inner`.
typedef struct CellCorners {
    LaneVector inner, outer, next;
} CellCorners;

IR_FN CellCorners cell_corners(uint j, uint k, uint m, uint n) {
    const real s0 = ring_sin(j, m), z0 = ring_cos(j, m), s1 = ring_sin(j + 1, m), z1 = ring_cos(j + 1, m);
    const lanes turns = ((real)k + lanes_index()) / (real)n;
    lanes sin0, cos0, sin1, cos1;  // of phi_k- and phi_k+
    lanes_sincos_turns(turns, &sin0, &cos0);
    lanes_sincos_turns(turns + R(1.0) / (real)n, &sin1, &cos1);
    CellCorners c;
    c.inner = make_lane_vector(s0 * cos0, s0 * sin0, lanes_of(z0));
    c.outer = make_lane_vector(s1 * cos0, s1 * sin0, lanes_of(z1));
    c.next = make_lane_vector(s0 * cos1, s0 * sin1, lanes_of(z0));
    return c;
}

// The two edges that each of the cells (j, k ..) owns, to ring j-1 and to azimuth k-1 (modulo n), by the crease rule and
// the flux form. `ring` is the sample of (j-1, k ..) and is not looked at for j = 0; `azimuth` that of (j, k-1 ..).
IR_FN void cell_edges(HemisphereSums* sums, uint j, uint k, uint m, uint n, HemisphereSample own, HemisphereSample ring,
                      HemisphereSample azimuth) {
    const CellCorners c = cell_corners(j, k, m, n);
    // inner x outer points along +v_k-, from cell k-1 to cell k
    add_edge(sums, c.inner, c.outer,
             crease_edge(azimuth.direction, azimuth.distance, azimuth.normal, own.direction, own.distance, own.normal,
                         c.inner, c.outer),
             lanes_difference(own.radiance, azimuth.radiance));
    if (j == 0) return;
    // next x inner points away from the pole, from ring j-1 to ring j
    add_edge(sums, c.next, c.inner,
             crease_edge(ring.direction, ring.distance, ring.normal, own.direction, own.distance, own.normal, c.next,
                         c.inner),
             lanes_difference(own.radiance, ring.radiance));
}

#if IR_LANES == 1
// The same two edges by Ward and Heckbert (gradient only, tangential): needs no normals. ratio: the mean of the inverse
// distances where they differ by less than 1.5 (theory 3.2). r_min as in cell_moments.
IR_FN void cell_edges_ward(HemisphereSums* sums, uint j, uint k, uint m, uint n, HemisphereSample own,
                           HemisphereSample ring, HemisphereSample azimuth, real r_min, bool ratio) {
    const real i = R(1.0) / max(own.distance, r_min);
    const real i_azimuth = R(1.0) / max(azimuth.distance, r_min);
    const real3 a = ward_azimuth_term(
        j, k, m, n, ratio ? ward_inverse_distance_ratio(i, i_azimuth) : ward_inverse_distance(i, i_azimuth));
    real3 dL = own.radiance - azimuth.radiance;
    sums->gx += dL * a.x;
    sums->gy += dL * a.y;
    if (j == 0) return;
    const real i_ring = R(1.0) / max(ring.distance, r_min);
    const real3 b =
        ward_ring_term(j, k, m, n, ratio ? ward_inverse_distance_ratio(i, i_ring) : ward_inverse_distance(i, i_ring));
    dL = own.radiance - ring.radiance;
    sums->gx += dL * b.x;
    sums->gy += dL * b.y;
}
#endif
#endif
