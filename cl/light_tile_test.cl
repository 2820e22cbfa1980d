// For tests: light samples of several receivers at once.
#include "direct.h"

// questions: position, normal, u, v; eight floats each, IR_TILE of them a work-item. answers: of sample_light_tile(), then of
// sample_light(): direction, distance, radiance, density, cosine, valid (1 or 0); twice ten floats each.
IR_KERNEL void test_light_tile(IR_SCENE_ARGS, IR_GLOBAL const float* questions, IR_GLOBAL float* answers, uint count) {
    IR_SCENE_INIT(s);
    const uint first = IR_TILE * IR_GLOBAL_ID;
    if (first >= count) return;
    const uint n = min((uint)IR_TILE, count - first);
    PathState paths[IR_TILE];
    LightSample samples[2][IR_TILE];
    float u[IR_TILE], v[IR_TILE];
    for (uint i = 0; i < n; ++i) {
        IR_GLOBAL const float* q = questions + 8u * (first + i);
        paths[i].surface.p = make_real3(q[0], q[1], q[2]);
        paths[i].surface.ns = make_real3(q[3], q[4], q[5]);
        u[i] = q[6];
        v[i] = q[7];
        samples[1][i] = sample_light(&s, paths[i].surface.p, paths[i].surface.ns, u[i], v[i]);
    }
    sample_light_tile(&s, paths, n, u, v, samples[0]);
    for (uint i = 0; i < n; ++i)
        for (uint k = 0; k < 2u; ++k) {
            const LightSample* l = &samples[k][i];
            IR_GLOBAL float* a = answers + 20u * (first + i) + 10u * k;
            a[0] = l->direction.x;
            a[1] = l->direction.y;
            a[2] = l->direction.z;
            a[3] = l->distance;
            a[4] = l->radiance.x;
            a[5] = l->radiance.y;
            a[6] = l->radiance.z;
            a[7] = l->density;
            a[8] = l->cosine;
            a[9] = l->valid ? 1.0f : 0.0f;
        }
}
