// For tests: the cache's answers at given points, by the octree and by asking every record.
#include "cache.h"

IR_KERNEL void look_up(IR_CACHE_ARGS, IR_GLOBAL const float* points, IR_GLOBAL float* out, uint record_count,
                       uint brute_force, uint count) {
    const uint item = IR_GLOBAL_ID;
    if (item >= count) return;
    IR_CACHE_INIT(cache);
    const real3 p = make_real3(points[6u * item], points[6u * item + 1u], points[6u * item + 2u]);
    const real3 n = make_real3(points[6u * item + 3u], points[6u * item + 4u], points[6u * item + 5u]);
    real3 sum = make_real3(0.0f, 0.0f, 0.0f);
    float weights = 0.0f;
    if (brute_force) {
        for (uint i = 0; i < record_count; ++i) {
            const float w = record_weight(&cache.parameters, &record_keys[i], p, n, 0u);
            weights += w;
            if (w > 0.0f) sum += record_irradiance(&record_values[i], &record_keys[i], p, n) * w;
        }
    } else {
        weights = cache_gather(&cache, p, n, 0u, &sum);
    }
    out[4u * item] = sum.x;
    out[4u * item + 1u] = sum.y;
    out[4u * item + 2u] = sum.z;
    out[4u * item + 3u] = weights;
}
