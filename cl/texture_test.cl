// For tests: textures looked up as colours and as numbers, and their slopes.
#include "texture.h"

// questions: index of the texture, u, v; three floats each. answers: colour, number, derivatives by u and v; six each.
IR_KERNEL void test_textures(IR_SCENE_ARGS, IR_GLOBAL const float* questions, IR_GLOBAL float* answers, uint count) {
    IR_SCENE_INIT(s);
    const uint i = IR_GLOBAL_ID;
    if (i >= count) return;
    IR_GLOBAL const float* q = questions + 3u * i;
    IR_GLOBAL float* a = answers + 6u * i;
    const int index = (int)q[0];
    const real3 colour = texture_lookup(&s, index, q[1], q[2]);
    a[0] = colour.x;
    a[1] = colour.y;
    a[2] = colour.z;
    a[3] = texture_scalar(&s, index, q[1], q[2]);
    float du, dv;
    texture_gradient(&s, index, q[1], q[2], &du, &dv);
    a[4] = du;
    a[5] = dv;
}
