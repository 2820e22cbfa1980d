// Rays from a buffer through the traversal interface: for the tests and the benchmark.
#ifndef IR_FEATURES
#define IR_FEATURES IR_FEATURE_ANALYTIC
#endif
#include "trace.h"

// Ray i: (ox, oy, oz, t_min, dx, dy, dz, t_max). One work-item a ray; result: t, u, v, primitive.
IR_KERNEL void test_closest(IR_SCENE_ARGS, IR_GLOBAL const float* rays, uint count, IR_GLOBAL Hit* hits) {
    IR_SCENE_INIT(s);
    const uint i = IR_GLOBAL_ID;
    if (i >= count) return;
    IR_GLOBAL const float* r = rays + 8 * i;
    hits[i] = trace_closest(&s, make_real3(r[0], r[1], r[2]), make_real3(r[4], r[5], r[6]), r[3], r[7]);
}

IR_KERNEL void test_occluded(IR_SCENE_ARGS, IR_GLOBAL const float* rays, uint count, IR_GLOBAL uint* occluded) {
    IR_SCENE_INIT(s);
    const uint i = IR_GLOBAL_ID;
    if (i >= count) return;
    IR_GLOBAL const float* r = rays + 8 * i;
    occluded[i] = trace_occluded(&s, make_real3(r[0], r[1], r[2]), make_real3(r[4], r[5], r[6]), r[3], r[7]) ? 1u : 0u;
}

// One work-item a tile of `tile` <= IR_TILE rays that share origin and t_min. Tile i of `tiles`, 64 floats: 16 times
// dx, 16 dy, 16 dz, then ox, oy, oz, t_min. Results: those of `tile` rays after another.
IR_KERNEL void test_tile(IR_SCENE_ARGS, IR_GLOBAL const float* tiles, uint count, uint tile, IR_GLOBAL Hit* hits) {
    IR_SCENE_INIT(s);
    const uint first = IR_GLOBAL_ID * tile;
    if (first >= count) return;
    const uint n = min(tile, count - first);
    IR_GLOBAL const float* in = tiles + 64 * IR_GLOBAL_ID;
    float d[48];
    for (uint i = 0; i < 48; ++i) d[i] = in[i];
    Hit found[16];
    for (uint i = 0; i < n; i += IR_TILE)
        trace_tile(&s, make_real3(in[48], in[49], in[50]), d + i, d + 16 + i, d + 32 + i, min(n - i, (uint)IR_TILE),
                   in[51], found + i);
    for (uint i = 0; i < n; ++i) hits[first + i] = found[i];
}

// Tiles of `tile` <= IR_TILE rays with origins (and t_max) of their own; layout: 8 times 16 floats: ox, oy, oz, dx, dy,
// dz, t_max, and t_min in the first of the last 16.
IR_KERNEL void test_tile_occluded(IR_SCENE_ARGS, IR_GLOBAL const float* tiles, uint count, uint tile,
                                  IR_GLOBAL uint* occluded) {
    IR_SCENE_INIT(s);
    const uint first = IR_GLOBAL_ID * tile;
    if (first >= count) return;
    const uint n = min(tile, count - first);
    IR_GLOBAL const float* in = tiles + 128 * IR_GLOBAL_ID;
    float d[112];
    for (uint i = 0; i < 112; ++i) d[i] = in[i];
    for (uint i = 0; i < n; i += IR_TILE) {
        const uint m = min(n - i, (uint)IR_TILE);
        uint mask;
        trace_tile_occluded(&s, d + i, d + 16 + i, d + 32 + i, d + 48 + i, d + 64 + i, d + 80 + i, m, in[112],
                            d + 96 + i, &mask);
        for (uint k = 0; k < m; ++k) occluded[first + i + k] = mask >> k & 1u;
    }
}
