// For tests: what the BSDFs of a scene's triangles say.
#include "bsdf.h"

IR_FN real3 read_vector(IR_GLOBAL const float* at) { return make_real3(at[0], at[1], at[2]); }
IR_FN void write_vector(IR_GLOBAL float* at, real3 v) {
    at[0] = v.x;
    at[1] = v.y;
    at[2] = v.z;
}

// Flag of a triangle that is asked: for samples of its BSDF's glossy part alone.
#define IR_ASKED_LOBE 0x80000000u

// A quarter into a triangle, seen from direction `view`.
IR_FN Surface surface_seen(const SceneData* s, uint triangle, real3 view) {
    Hit hit;
    hit.t = 1.0f;
    hit.u = hit.v = 0.25f;
    hit.primitive = triangle & ~IR_ASKED_LOBE;
    return surface_at(s, view, -view, &hit);
}

// questions: view, direction; six floats each, of triangle asked[i]. answers: diffuse, glossy, density; seven
// floats each.
IR_KERNEL void test_bsdf_evaluate(IR_SCENE_ARGS, IR_GLOBAL const uint* asked, IR_GLOBAL const float* questions,
                                  IR_GLOBAL float* answers, uint count) {
    IR_SCENE_INIT(s);
    const uint i = IR_GLOBAL_ID;
    if (i >= count) return;
    const Surface f = surface_seen(&s, asked[i], read_vector(questions + 6u * i));
    const BsdfValue v = bsdf_evaluate(&s, &f, read_vector(questions + 6u * i + 3u), (asked[i] & IR_ASKED_LOBE) != 0u);
    write_vector(answers + 7u * i, v.diffuse);
    write_vector(answers + 7u * i + 3u, v.glossy);
    answers[7u * i + 6u] = v.density;
}

// The same of triangle 0 where its barycentrics are u, v. questions: view, direction, u, v; eight floats each.
IR_KERNEL void test_bsdf_at(IR_SCENE_ARGS, IR_GLOBAL const float* questions, IR_GLOBAL float* answers, uint count) {
    IR_SCENE_INIT(s);
    const uint i = IR_GLOBAL_ID;
    if (i >= count) return;
    IR_GLOBAL const float* q = questions + 8u * i;
    const real3 view = read_vector(q);
    Hit hit;
    hit.t = 1.0f;
    hit.u = q[6];
    hit.v = q[7];
    hit.primitive = 0u;
    const Surface f = surface_at(&s, view, -view, &hit);
    const BsdfValue v = bsdf_evaluate(&s, &f, read_vector(q + 3), false);
    write_vector(answers + 7u * i, v.diffuse);
    write_vector(answers + 7u * i + 3u, v.glossy);
    answers[7u * i + 6u] = v.density;
}

// questions: view, u0, u1, u2. answers: valid (1 or 0), direction, diffuse, glossy, density, eta; twelve floats each.
IR_KERNEL void test_bsdf_sample(IR_SCENE_ARGS, IR_GLOBAL const uint* asked, IR_GLOBAL const float* questions,
                                IR_GLOBAL float* answers, uint count) {
    IR_SCENE_INIT(s);
    const uint i = IR_GLOBAL_ID;
    if (i >= count) return;
    IR_GLOBAL const float* q = questions + 6u * i;
    IR_GLOBAL float* a = answers + 12u * i;
    const Surface f = surface_seen(&s, asked[i], read_vector(q));
    BsdfSample b;
    const bool valid = bsdf_sample(&s, &f, q[3], q[4], q[5], (asked[i] & IR_ASKED_LOBE) != 0u, &b);
    for (uint k = 0u; k < 12u; ++k) a[k] = 0.0f;
    if (!valid) return;
    a[0] = 1.0f;
    write_vector(a + 1, b.direction);
    write_vector(a + 4, b.diffuse);
    write_vector(a + 7, b.glossy);
    a[10] = b.density;
    a[11] = b.eta;
}

// questions: alpha_u, alpha_v, 1 for Beckmann or 0, view, u0, u1, a facet's normal; eleven floats each. answers: the
// normal drawn; of the normal asked for, density, share seen, density of being drawn; six floats each.
IR_KERNEL void test_microfacets(IR_GLOBAL const float* questions, IR_GLOBAL float* answers, uint count) {
    const uint i = IR_GLOBAL_ID;
    if (i >= count) return;
    IR_GLOBAL const float* q = questions + 11u * i;
    IR_GLOBAL float* a = answers + 6u * i;
    Microfacets f;
    f.alpha_u = q[0];
    f.alpha_v = q[1];
    f.beckmann = q[2] != 0.0f;
    const real3 v = read_vector(q + 3), m = read_vector(q + 8);
    write_vector(a, sample_visible_normal(&f, v, q[6], q[7]));
    a[3] = microfacet_density(&f, m);
    a[4] = smith_g1(&f, v, m);
    a[5] = visible_normal_density(&f, v, m);
}

// questions: cosine, eta, k; three floats each. answers: reflectance of a dielectric, its refracted cosine, reflectance
// of a conductor; three floats each.
IR_KERNEL void test_fresnel(IR_GLOBAL const float* questions, IR_GLOBAL float* answers, uint count) {
    const uint i = IR_GLOBAL_ID;
    if (i >= count) return;
    IR_GLOBAL const float* q = questions + 3u * i;
    float cos_t;
    answers[3u * i] = fresnel_dielectric(q[0], q[1], &cos_t);
    answers[3u * i + 1u] = cos_t;
    answers[3u * i + 2u] = fresnel_conductor(q[0], q[1], q[2]);
}
