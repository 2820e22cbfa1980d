// For tests: light samples, their densities, the environment.
#include "light.h"

IR_FN real3 read_vector(IR_GLOBAL const float* at) { return make_real3(at[0], at[1], at[2]); }
IR_FN void write_vector(IR_GLOBAL float* at, real3 v) {
    at[0] = v.x;
    at[1] = v.y;
    at[2] = v.z;
}

// questions: position, normal, u0, u1; eight floats each. answers: direction, distance, radiance, density, cosine,
// valid (1 or 0), and what light_density() and environment_density() say of the direction; twelve floats each.
IR_KERNEL void test_light_samples(IR_SCENE_ARGS, IR_GLOBAL const float* questions, IR_GLOBAL float* answers,
                                  uint count) {
    IR_SCENE_INIT(s);
    const uint i = IR_GLOBAL_ID;
    if (i >= count) return;
    IR_GLOBAL const float* q = questions + 8u * i;
    IR_GLOBAL float* a = answers + 12u * i;
    const real3 p = read_vector(q), n = read_vector(q + 3);
    const LightSample l = sample_light(&s, p, n, q[6], q[7]);
    write_vector(a, l.direction);
    a[3] = l.distance;
    write_vector(a + 4, l.radiance);
    a[7] = l.density;
    a[8] = l.valid ? l.cosine : 0.0f;
    a[9] = l.valid ? 1.0f : 0.0f;
    a[10] = l.valid ? light_density(&s, 0u, p, l.cosine, l.distance) : 0.0f;  // of light 0, whichever was chosen
    a[11] = environment_density(&s, p, n, l.direction);
}

// questions: direction, position, normal; nine floats each. answers: radiance, density; four floats each.
IR_KERNEL void test_environment(IR_SCENE_ARGS, IR_GLOBAL const float* questions, IR_GLOBAL float* answers, uint count) {
    IR_SCENE_INIT(s);
    const uint i = IR_GLOBAL_ID;
    if (i >= count) return;
    IR_GLOBAL const float* q = questions + 9u * i;
    const real3 direction = read_vector(q), p = read_vector(q + 3), n = read_vector(q + 6);
    write_vector(answers + 4u * i, environment_radiance(&s, direction));
    answers[4u * i + 3u] = environment_density(&s, p, n, direction);
}

// questions: position, cosine, distance, u, v; seven floats each. answers: light_density() and area_light_radiance() of
// light 0; four floats each.
IR_KERNEL void test_area_light(IR_SCENE_ARGS, IR_GLOBAL const float* questions, IR_GLOBAL float* answers, uint count) {
    IR_SCENE_INIT(s);
    const uint i = IR_GLOBAL_ID;
    if (i >= count) return;
    IR_GLOBAL const float* q = questions + 7u * i;
    answers[4u * i] = light_density(&s, 0u, read_vector(q), q[3], q[4]);
    write_vector(answers + 4u * i + 1u, area_light_radiance(&s, 0u, q[5], q[6]));
}
