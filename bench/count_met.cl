// For the benchmark of the octree: what a look-up meets.
#include "cache.h"

// How many records a look-up meets in the octree, and how many of them it uses.
IR_KERNEL void count_met(IR_CACHE_ARGS, IR_GLOBAL const float* points, IR_GLOBAL uint* out, uint count) {
    const uint item = IR_GLOBAL_ID;
    if (item >= count) return;
    IR_CACHE_INIT(cache);
    const real3 p = make_real3(points[6u * item], points[6u * item + 1u], points[6u * item + 2u]);
    const real3 n = make_real3(points[6u * item + 3u], points[6u * item + 4u], points[6u * item + 5u]);
    uint met = 0u, used = 0u, record;
    RecordWalk walk = record_walk(&cache.parameters, p, n, 0u);
    while (octree_next(&cache.octree, &cache.parameters, &walk.octree, &record)) {
        ++met;
        used += record_weight(&cache.parameters, &record_keys[record], p, n, 0u) > 0.0f ? 1u : 0u;
    }
    out[2u * item] = met;
    out[2u * item + 1u] = used;
}
