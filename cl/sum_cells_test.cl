// For tests: the sums of one hemisphere's cells as sample_hemispheres makes them. Compile-time: as sum_cells.h.
#if IR_N % 8 != 0
#define IR_SCALAR_LANES 1
#endif
#define IR_CELL_SPACE IR_GLOBAL
#include "sum_cells.h"

// out: 23 floats an item, HemisphereSums in the order of its members, lanes added up.
IR_KERNEL void test_sum_cells(IR_GLOBAL const float* cells, IR_GLOBAL const float* ring_weights, IR_GLOBAL float* out,
                              float limit) {
    const HemisphereSums s = sum_cells(cells, IR_LOCAL_ID, limit, 1e-10f, IR_INFINITY, ring_weights);
    const LaneVector vectors[6] = {s.irradiance, s.rx, s.ry, s.gx, s.gy, s.gz};
    out += 23u * IR_LOCAL_ID;
    for (uint i = 0; i < 6u; ++i) {
        out[3u * i] = lanes_sum(vectors[i].x);
        out[3u * i + 1u] = lanes_sum(vectors[i].y);
        out[3u * i + 2u] = lanes_sum(vectors[i].z);
    }
    out[18] = lanes_sum(s.hxx);
    out[19] = lanes_sum(s.hxy);
    out[20] = lanes_sum(s.hyy);
    out[21] = lanes_sum(s.inverse_distance);
    out[22] = lanes_min(s.min_distance);
}
