// For tests: lobes, their tables, and what radiance records answer.
#include "radiance_irradiance.h"

IR_FN real3 read_vector(IR_GLOBAL const float* at) { return make_real3(at[0], at[1], at[2]); }
IR_FN void write_vector(IR_GLOBAL float* at, real3 v) {
    at[0] = v.x;
    at[1] = v.y;
    at[2] = v.z;
}

// A flat surface of a material. q: material, roughness, position, unit normal, unit direction of the view.
#define IR_QUESTION 11u
IR_FN Surface asked_surface(IR_GLOBAL const Material* materials, IR_GLOBAL const float* q) {
    Surface f;
    f.material_index = (uint)q[0];
    f.material = materials + f.material_index;
    f.kind = f.material->kind;
    f.flags = f.material->flags;
    f.alpha_u = f.alpha_v = q[1];
    if (f.material->alpha_u != f.material->alpha_v) f.alpha_v = f.material->alpha_v;
    f.specular = make_real3(1.0f, 1.0f, 1.0f);
    f.p = read_vector(q + 2);
    f.ns = f.ng = read_vector(q + 5);
    f.view = read_vector(q + 8);
    return f;
}

// directions: x, y, z of eight a question. answers: weight, (1 - c)^5, and facet_reflection's three channels, eight of
// each.
IR_KERNEL void test_lobe_weights(IR_GLOBAL const Material* materials, IR_GLOBAL const float* questions,
                                 IR_GLOBAL const float* directions, IR_GLOBAL float* answers, uint count) {
    const uint i = IR_GLOBAL_ID;
    if (i >= count) return;
    const Surface f = asked_surface(materials, questions + IR_QUESTION * i);
    const Lobe lobe = surface_lobe(&f);
    IR_GLOBAL const float* w = directions + 24u * i;
    IR_GLOBAL float* a = answers + 40u * i;
    for (uint k = 0; k < 8u; k += IR_LANES) {
        LaneVector v;
        v.x = lanes_load(w, k);
        v.y = lanes_load(w, 8u + k);
        v.z = lanes_load(w, 16u + k);
        lanes schlick;
        lanes_store(lobe_weights(&lobe, v, lanes_dot3(v, lobe.n), &schlick), a, k);
        lanes_store(schlick, a, 8u + k);
    }
    const Frame frame = make_frame(f.ns);
    for (uint k = 0; k < 8u; ++k) {
        float density;
        const real3 value = facet_reflection(&f, to_local(frame, f.view),
                                             to_local(frame, make_real3(w[k], w[8u + k], w[16u + k])), &density);
        a[16u + k] = value.x;
        a[24u + k] = value.y;
        a[32u + k] = value.z;
    }
}

// questions: whether the roughness is a texture (1 or 0), roughness, cosine. answers: all values there of the table that
// begins at `offset`.
IR_KERNEL void test_lobe_values(IR_GLOBAL const float* tables, RadianceParameters parameters, uint offset,
                                IR_GLOBAL const float* questions, IR_GLOBAL float* answers, uint count) {
    const uint i = IR_GLOBAL_ID;
    if (i >= count) return;
    IR_GLOBAL const float* q = questions + 3u * i;
    const LobeEntry e = lobe_entry(tables + offset, &parameters, q[0] != 0.0f, q[1], q[2]);
    const uint floats = IR_LOBE_FLOATS(parameters.order);
    for (uint k = 0; k < floats; ++k) answers[floats * i + k] = lobe_value(&e, k);
}

// What all records say at a surface. answers: 1 if the lobe is one that records answer; 1 if any does; the radiance; 1 if
// they suffice; how much they disagree; the least support among them; eight floats.
IR_KERNEL void test_radiance_lookup(IR_RADIANCE_ARGS, IR_GLOBAL const Material* materials,
                                    IR_GLOBAL const float* questions, IR_GLOBAL float* answers, uint count) {
    const uint i = IR_GLOBAL_ID;
    if (i >= count) return;
    IR_RADIANCE_INIT(cache);
    const Surface f = asked_surface(materials, questions + IR_QUESTION * i);
    IR_GLOBAL float* a = answers + 8u * i;
    for (uint k = 0; k < 8u; ++k) a[k] = 0.0f;
    if (!caches_lobe(&cache, &f)) return;
    real3 radiance;
    float least;
    a[0] = 1.0f;
    a[1] = radiance_lookup(&cache, &f, f.p, &radiance) ? 1.0f : 0.0f;
    write_vector(a + 2, radiance);
    a[5] = radiance_covers(&cache, &f) ? 1.0f : 0.0f;
    a[6] = radiance_spread(&cache, &f, &least);
    a[7] = least;
}

// What one record, records[i], says at a surface, whatever its weight. answers: by samples, then by harmonics (if there
// are any): weighted, total, irradiance; nine floats each.
IR_KERNEL void test_record_sums(IR_RADIANCE_ARGS, IR_GLOBAL const Material* materials,
                                IR_GLOBAL const float* questions, IR_GLOBAL const uint* records,
                                IR_GLOBAL float* answers, uint count) {
    const uint i = IR_GLOBAL_ID;
    if (i >= count) return;
    IR_RADIANCE_INIT(cache);
    const Surface f = asked_surface(materials, questions + IR_QUESTION * i);
    const LobeQuery query = lobe_query(&cache, &f, f.p);
    const uint record = records[i];
    const IR_GLOBAL RecordKey* key = &cache.records.octree.keys[record];
    const real3 delta = f.p - make_real3(key->px, key->py, key->pz);
    IR_GLOBAL float* a = answers + 18u * i;
    const LobeSum samples = samples_sum(&cache, record, -delta, &query);
    write_vector(a, samples.weighted);
    write_vector(a + 3, samples.total);
    write_vector(a + 6, samples_irradiance(&cache, record, -delta, f.ns));
    for (uint k = 9u; k < 18u; ++k) a[k] = 0.0f;
    if (cache.parameters.order == 0u) return;
    const LobeSum harmonics = harmonics_sum(&cache, record, key, delta, &query);
    write_vector(a + 9, harmonics.weighted);
    write_vector(a + 12, harmonics.total);
    write_vector(a + 15, harmonics_irradiance(&cache, record, key, delta));
}
