// Where in its stratum each of a hemisphere's M x N rays lies.
#ifndef IR_STRATA_H
#define IR_STRATA_H
#include "sampling.h"
#include "sobol.h"

IR_HASH_FN(lanes_uint, hash_lanes)

// Points (xi1, xi2) of [0, 1) x [0, 1) for strata (j, k) of one hemisphere, whose `seed` is a hash; one a lane. Each is uniform,
// so that a stratum's estimate is unbiased whatever the others are. But those of a ring are van der Corput's points in
// xi1, and those of a sector in xi2, each ring and sector scrambled by itself (Owen). Where M and N are powers of two
// all rays together are then a scrambled (0, m, 2)-net: not only each of the M x N strata holds one, but also each of as
// many that are twice, four times, ... as fine in one direction and as coarse in the other. For rays in a stratum 2^c times
// as fine in xi1 are of one ring, and of 2^c sectors whose numbers differ in their last c bits alone, which van der
// Corput makes the first c of xi1. Other M and N have this for blocks of rings and sectors whose sizes are powers of two.
IR_FN void strata_points(lanes_uint j, lanes_uint k, uint seed, lanes* xi1, lanes* xi2) {
    *xi1 = scrambled_by(k, hash_lanes(seed + j));
    *xi2 = scrambled_by(j, hash_lanes((seed ^ 0x5bd1e995u) + k));
}

// (1.3): directions of the rays of strata (j, k), in the local frame, as stratum_direction() has them.
IR_FN LaneVector strata_directions(lanes_uint j, lanes_uint k, uint m, uint n, uint seed) {
    lanes xi1, xi2, sine, cosine;
    strata_points(j, k, seed, &xi1, &xi2);
    const lanes s2 = (lanes_of_uint(j) + xi1) / (real)m, turns = (lanes_of_uint(k) + xi2) / (real)n, s = sqrt(s2);
    lanes_sincos_turns(turns, &sine, &cosine);
    return make_lane_vector(s * cosine, s * sine, sqrt(max(R(1.0) - s2, R(6e-8))));
}
#endif
