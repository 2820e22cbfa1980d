// For tests: deposits into the irradiance grid, its keys, its answers.
#define IR_GRID_FILL
#include "sampling.h"
// after what it needs
#include "irradiance_grid.h"

// deposits: position, normal, irradiance; nine floats each.
IR_KERNEL void test_grid_deposit(IR_GLOBAL GridSum* sums, GridParameters grid, IR_GLOBAL uint* taken,
                                 IR_GLOBAL uint* overflow, IR_GLOBAL const float* deposits, uint count) {
    const uint i = IR_GLOBAL_ID;
    IR_LOCAL_ARRAY(uint, fresh, IR_GRID_FRESH_WORDS);
    grid_fresh_begin(fresh);
    if (i < count) {
        IR_GLOBAL const float* d = deposits + 9u * i;
        const uint slot = grid_deposit(&grid, sums, make_real3(d[0], d[1], d[2]), make_real3(d[3], d[4], d[5]),
                                       make_real3(d[6], d[7], d[8]), overflow);
        if (slot != IR_GRID_NONE) grid_fresh_add(fresh, slot, taken);
    }
    grid_fresh_end(fresh, taken);
}

// points: position, normal; six floats each. keys: the keys of all levels by position, then the same by grid_parent.
IR_KERNEL void test_grid_keys(IR_GLOBAL uint* keys, GridParameters grid, IR_GLOBAL const float* points, uint count) {
    const uint i = IR_GLOBAL_ID;
    if (i >= count) return;
    IR_GLOBAL const float* q = points + 6u * i;
    const real3 p = make_real3(q[0], q[1], q[2]), n = make_real3(q[3], q[4], q[5]);
    keys += 2u * IR_GRID_LEVELS * i;
    uint key = grid_key(&grid, 0u, p, n);
    for (uint level = 0; level < IR_GRID_LEVELS; ++level) {
        keys[level] = grid_key(&grid, level, p, n);
        keys[IR_GRID_LEVELS + level] = key;
        key = grid_parent(key);
    }
}

// points: position, normal, distance; seven floats each. out: 1 if the grid answers, and its answer.
IR_KERNEL void test_grid_lookup(IR_GLOBAL const GridCell* cells, GridParameters grid, IR_GLOBAL const float* points,
                                IR_GLOBAL float* out, uint count, uint seed) {
    const uint i = IR_GLOBAL_ID;
    if (i >= count) return;
    IR_GLOBAL const float* q = points + 7u * i;
    Rng rng = rng_make(seed, i, 0u);
    real3 irradiance = make_real3(0.0f, 0.0f, 0.0f);
    const GridQuery query =
        grid_query(&grid, make_real3(q[0], q[1], q[2]), make_real3(q[3], q[4], q[5]), q[6], &rng);
    const bool found = grid_lookup(&grid, cells, &query, &irradiance);
    out[4u * i] = found ? 1.0f : 0.0f;
    out[4u * i + 1u] = irradiance.x;
    out[4u * i + 2u] = irradiance.y;
    out[4u * i + 3u] = irradiance.z;
}
