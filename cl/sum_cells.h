// The sampled cells of one hemisphere in memory, and their sums by a work-group. Each work-item takes IR_LANES
// neighbouring cells of a ring at a time.
// Compile-time: IR_M, IR_N, IR_GROUP, IR_GRADIENT, IR_RADIUS, IR_CELL_SPACE (the memory that the cells lie in).
#ifndef IR_SUM_CELLS_H
#define IR_SUM_CELLS_H
#include "hemisphere_reduce.h"

#define IR_CELLS (IR_M * IR_N)
// Structure of arrays: direction x, y, distance, hit normal x, y, z, radiance r, g, b.
#define IR_CELL_FLOATS 9
#define IR_SCRATCH_CELLS (IR_CELL_FLOATS * IR_CELLS)

IR_INLINE_FN real3 load3(const IR_CELL_SPACE float* cells, uint array, uint cell) {
    return make_real3(cells[array * IR_CELLS + cell], cells[(array + 1u) * IR_CELLS + cell],
                      cells[(array + 2u) * IR_CELLS + cell]);
}

IR_INLINE_FN LaneVector load_lanes3(const IR_CELL_SPACE float* cells, uint array, uint cell) {
    return make_lane_vector(lanes_load(cells, array * IR_CELLS + cell), lanes_load(cells, (array + 1u) * IR_CELLS + cell),
                            lanes_load(cells, (array + 2u) * IR_CELLS + cell));
}

IR_FN lanes cell_cosine(lanes x, lanes y) { return sqrt(max(R(1.0) - x * x - y * y, R(6e-8))); }

IR_INLINE_FN real3 cell_direction(const IR_CELL_SPACE float* cells, uint cell) {
    const float x = cells[cell], y = cells[IR_CELLS + cell];
    return make_real3(x, y, sqrt(max(1.0f - x * x - y * y, 6e-8f)));
}

// Radiance as gradients and Hessian take it: a cell far brighter than the mean would turn all of them towards itself
// (theory 4.6). E keeps it whole.
IR_FN LaneVector gradient_radiance(LaneVector radiance, float limit) {
    const lanes y = IR_LUMINANCE(radiance.x, radiance.y, radiance.z);
    const lanes_mask bright = y > limit;
    return lanes_scaled(radiance, lanes_select(1.0f, limit / lanes_select(1.0f, y, bright), bright));
}

IR_INLINE_FN HemisphereSample load_cells(const IR_CELL_SPACE float* cells, uint cell) {
    HemisphereSample sample;
    const lanes x = lanes_load(cells, cell), y = lanes_load(cells, IR_CELLS + cell);
    sample.direction = make_lane_vector(x, y, cell_cosine(x, y));
    sample.distance = fabs(lanes_load(cells, 2 * IR_CELLS + cell));
    sample.normal = load_lanes3(cells, 3u, cell);
    sample.radiance = load_lanes3(cells, 6u, cell);
    return sample;
}

// The neighbours of `own` at azimuth k - 1: the cell `before` and all lanes of `own` but the last.
IR_INLINE_FN HemisphereSample azimuth_neighbours(const IR_CELL_SPACE float* cells, HemisphereSample own, uint before,
                                                 float limit) {
    const real3 d = cell_direction(cells, before), n = load3(cells, 3u, before), r = load3(cells, 6u, before);
    const float y = luminance(r), scale = y > limit ? limit / y : 1.0f;
    HemisphereSample sample;
    sample.direction = make_lane_vector(lanes_shift_in(d.x, own.direction.x), lanes_shift_in(d.y, own.direction.y),
                                        lanes_shift_in(d.z, own.direction.z));
    sample.distance = lanes_shift_in(fabs(cells[2 * IR_CELLS + before]), own.distance);
    sample.normal = make_lane_vector(lanes_shift_in(n.x, own.normal.x), lanes_shift_in(n.y, own.normal.y),
                                     lanes_shift_in(n.z, own.normal.z));
    sample.radiance =
        make_lane_vector(lanes_shift_in(r.x * scale, own.radiance.x), lanes_shift_in(r.y * scale, own.radiance.y),
                         lanes_shift_in(r.z * scale, own.radiance.z));
    return sample;
}

// Mean luminance of a group's cells times `factor`; IR_INFINITY if factor is 0. Every work-item must call it.
IR_INLINE_FN float brightness_limit(const IR_CELL_SPACE float* cells, uint item, float factor, IR_LOCAL float* sums) {
    float sum = 0.0f;
    for (uint cell = item; cell < IR_CELLS; cell += IR_GROUP) sum += luminance(load3(cells, 6u, cell));
    sums[item] = sum;
    IR_BARRIER();
    sum = 0.0f;
    for (uint i = 0; i < IR_GROUP; ++i) sum += sums[i];
    return factor > 0.0f ? factor * sum / (float)IR_CELLS : IR_INFINITY;
}

// Sums the cells of one work-item. `ring_weights`: ring_rotation_weight(j, IR_M); r_min, r_max: see cell_moments.
IR_INLINE_FN HemisphereSums sum_cells(const IR_CELL_SPACE float* cells, uint item, float limit, float r_min, float r_max,
                                      IR_GLOBAL const float* ring_weights) {
    HemisphereSums sums = hemisphere_sums_zero();
    for (uint cell = item * IR_LANES; cell < IR_CELLS; cell += IR_GROUP * IR_LANES) {
        const uint j = cell / IR_N, k = cell % IR_N;
        HemisphereSample own = load_cells(cells, cell);
        const LaneVector limited = gradient_radiance(own.radiance, limit);
        cell_moments(&sums, k, IR_N, ring_weights[j], own, limited, r_min, r_max, 0.17f);
        own.radiance = limited;
#if IR_GRADIENT != 0 || IR_RADIUS == 2
        HemisphereSample ring = load_cells(cells, j > 0u ? cell - IR_N : cell);
        ring.radiance = gradient_radiance(ring.radiance, limit);
        const HemisphereSample azimuth =
            azimuth_neighbours(cells, own, k > 0u ? cell - 1u : cell + IR_N - 1u, limit);
#endif
#if IR_GRADIENT == 1
        cell_edges_ward(&sums, j, k, IR_M, IR_N, own, ring, azimuth, r_min, true);
#endif
#if IR_GRADIENT == 2
        cell_edges(&sums, j, k, IR_M, IR_N, own, ring, azimuth);
#elif IR_RADIUS == 2  // the Hessian alone
        HemisphereSums edges = hemisphere_sums_zero();
        cell_edges(&edges, j, k, IR_M, IR_N, own, ring, azimuth);
        sums.hxx += edges.hxx;
        sums.hxy += edges.hxy;
        sums.hyy += edges.hyy;
#endif
    }
    return sums;
}
#endif
