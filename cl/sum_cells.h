// The sampled cells of one hemisphere in memory, and their sums by a work-group. Each work-item takes IR_LANES
// neighbouring cells of a ring at a time.
// Compile-time: IR_M, IR_N, IR_GROUP, IR_GRADIENT, IR_RADIUS, IR_CELL_SPACE (the memory that the cells lie in).
#ifndef IR_SUM_CELLS_H
#define IR_SUM_CELLS_H
#include "group.h"
#include "hemisphere_reduce.h"

#define IR_CELLS (IR_M * IR_N)
// Structure of arrays: direction x, y, distance, hit normal x, y, z, radiance r, g, b.
#define IR_CELL_FLOATS 9
#define IR_SCRATCH_CELLS (IR_CELL_FLOATS * IR_CELLS)

IR_INLINE_FN real3 load3(const IR_CELL_SPACE float* cells, uint array, uint cell) {
    return make_real3(cells[array * IR_CELLS + cell], cells[(array + 1u) * IR_CELLS + cell],
                      cells[(array + 2u) * IR_CELLS + cell]);
}

// IR_LANES cells of a ring as they lie in memory.
typedef struct LoadedCells {
    lanes values[IR_CELL_FLOATS];
} LoadedCells;

IR_INLINE_FN void load_cells(const IR_CELL_SPACE float* cells, uint cell, LoadedCells* loaded) {
    for (uint i = 0; i < IR_CELL_FLOATS; ++i) loaded->values[i] = lanes_load(cells, i * IR_CELLS + cell);
}

IR_INLINE_FN void load_cell(const IR_CELL_SPACE float* cells, uint cell, float* values) {
    for (uint i = 0; i < IR_CELL_FLOATS; ++i) values[i] = cells[i * IR_CELLS + cell];
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

IR_FN HemisphereSample samples_of(const LoadedCells* cells) {
    const lanes* v = cells->values;
    HemisphereSample sample;
    sample.direction = make_lane_vector(v[0], v[1], cell_cosine(v[0], v[1]));
    sample.distance = fabs(v[2]);
    sample.normal = make_lane_vector(v[3], v[4], v[5]);
    sample.radiance = make_lane_vector(v[6], v[7], v[8]);
    return sample;
}

// The neighbours of `own` at azimuth k - 1: the cell `before` and all lanes of `own` but the last.
IR_FN HemisphereSample azimuth_neighbours(HemisphereSample own, const float* before, float limit) {
    const float x = before[0], y = before[1], z = sqrt(max(1.0f - x * x - y * y, 6e-8f));
    const real3 r = make_real3(before[6], before[7], before[8]);
    const float l = luminance(r), scale = l > limit ? limit / l : 1.0f;
    HemisphereSample sample;
    sample.direction = make_lane_vector(lanes_shift_in(x, own.direction.x), lanes_shift_in(y, own.direction.y),
                                        lanes_shift_in(z, own.direction.z));
    sample.distance = lanes_shift_in(fabs(before[2]), own.distance);
    sample.normal = make_lane_vector(lanes_shift_in(before[3], own.normal.x), lanes_shift_in(before[4], own.normal.y),
                                     lanes_shift_in(before[5], own.normal.z));
    sample.radiance =
        make_lane_vector(lanes_shift_in(r.x * scale, own.radiance.x), lanes_shift_in(r.y * scale, own.radiance.y),
                         lanes_shift_in(r.z * scale, own.radiance.z));
    return sample;
}

// Mean luminance of a group's cells times `factor`; IR_INFINITY if factor is 0. Every work-item must call it.
IR_INLINE_FN float brightness_limit(const IR_CELL_SPACE float* cells, uint item, float factor,
                                    IR_GROUP_SPACE float* sums) {
    lanes luminances = lanes_of(0.0f);
    for (uint cell = item * IR_LANES; cell < IR_CELLS; cell += IR_GROUP * IR_LANES)
        luminances += IR_LUMINANCE(lanes_load(cells, 6u * IR_CELLS + cell), lanes_load(cells, 7u * IR_CELLS + cell),
                                   lanes_load(cells, 8u * IR_CELLS + cell));
    sums[item] = lanes_sum(luminances);
    IR_GROUP_BARRIER();
    float sum = 0.0f;
    for (uint i = 0; i < IR_GROUP; ++i) sum += sums[i];
    return factor > 0.0f ? factor * sum / (float)IR_CELLS : IR_INFINITY;
}

// Adds the cells (j, k ..). ring_weight: ring_rotation_weight(j, IR_M); r_min, r_max: see cell_moments. `ring_cells`: those
// at (j-1, k ..), not looked at for j = 0; `before`: the cell (j, k-1).
IR_ONCE_FN void add_cells(HemisphereSums* sums, uint j, uint k, const LoadedCells* own_cells,
                          const LoadedCells* ring_cells, const float* before, float limit, float r_min, float r_max,
                          float ring_weight) {
    HemisphereSample own = samples_of(own_cells);
    const LaneVector limited = gradient_radiance(own.radiance, limit);
    cell_moments(sums, k, IR_N, ring_weight, own, limited, r_min, r_max, 0.17f);
    own.radiance = limited;
#if IR_GRADIENT != 0 || IR_RADIUS == 2
    HemisphereSample ring = samples_of(ring_cells);
    ring.radiance = gradient_radiance(ring.radiance, limit);
    const HemisphereSample azimuth = azimuth_neighbours(own, before, limit);
#endif
#if IR_GRADIENT == 1
    cell_edges_ward(sums, j, k, IR_M, IR_N, own, ring, azimuth, r_min, true);
#endif
#if IR_GRADIENT == 2
    cell_edges(sums, j, k, IR_M, IR_N, own, ring, azimuth);
#elif IR_RADIUS == 2  // the Hessian alone
    HemisphereSums edges = hemisphere_sums_zero();
    cell_edges(&edges, j, k, IR_M, IR_N, own, ring, azimuth);
    sums->hxx += edges.hxx;
    sums->hxy += edges.hxy;
    sums->hyy += edges.hyy;
#endif
}

// Sums the cells of one work-item.
IR_INLINE_FN HemisphereSums sum_cells(const IR_CELL_SPACE float* cells, uint item, float limit, float r_min, float r_max,
                                      IR_GLOBAL const float* ring_weights) {
    HemisphereSums sums = hemisphere_sums_zero();
    for (uint cell = item * IR_LANES; cell < IR_CELLS; cell += IR_GROUP * IR_LANES) {
        const uint j = cell / IR_N, k = cell % IR_N;
        LoadedCells own, ring;
        float before[IR_CELL_FLOATS];
        load_cells(cells, cell, &own);
        load_cells(cells, j > 0u ? cell - IR_N : cell, &ring);
        load_cell(cells, k > 0u ? cell - 1u : cell + IR_N - 1u, before);
        add_cells(&sums, j, k, &own, &ring, before, limit, r_min, r_max, ring_weights[j]);
    }
    return sums;
}
#endif
