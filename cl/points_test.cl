// For tests: the points on which pixels and hemispheres are sampled.
#include "strata.h"

// Item i: `count` points, a multiple of IR_LANES, of scramble i; four numbers each.
IR_KERNEL void test_sobol_points(IR_GLOBAL float* out, uint seeds, uint count) {
    const uint seed = IR_GLOBAL_ID;
    if (seed >= seeds) return;
    for (uint i = 0; i < count; i += IR_LANES) {
        lanes x[4];
        float number[4][IR_LANES];
        sobol4_lanes(i, hash_uint(seed), x);
        for (uint d = 0; d < 4u; ++d) lanes_store(x[d], number[d], 0);
        for (uint k = 0; k < IR_LANES; ++k)
            for (uint d = 0; d < 4u; ++d) out[4u * (seed * count + i + k) + d] = number[d][k];
    }
}

// Item i: hemisphere i of m x n strata, a multiple of IR_LANES; xi1, xi2 and direction of each.
IR_KERNEL void test_strata_points(IR_GLOBAL float* out, uint seeds, uint m, uint n) {
    const uint seed = IR_GLOBAL_ID;
    if (seed >= seeds) return;
    for (uint cell = 0; cell < m * n; cell += IR_LANES) {
        const lanes_uint cells = cell + lanes_numbers(), j = cells / n, k = cells % n;
        lanes xi1, xi2;
        float number[5][IR_LANES];
        strata_points(j, k, hash_uint(seed), &xi1, &xi2);
        const LaneVector w = strata_directions(j, k, m, n, hash_uint(seed));
        lanes_store(xi1, number[0], 0);
        lanes_store(xi2, number[1], 0);
        lanes_store(w.x, number[2], 0);
        lanes_store(w.y, number[3], 0);
        lanes_store(w.z, number[4], 0);
        for (uint l = 0; l < IR_LANES; ++l)
            for (uint d = 0; d < 5u; ++d) out[5u * (seed * m * n + cell + l) + d] = number[d][l];
    }
}
