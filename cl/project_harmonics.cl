// Second half of sampling a radiance record that harmonics answer: its samples are projected onto hemispherical
// harmonics of the record's frame, and the same cell edges that move irradiance move each coefficient (theory 7):
//   c = pi / (M N) sum Y(w) (L - E/pi) / cos,   grad c = sum over edges Y(w_mid) / cos_mid g_edge.
// One work-group a record: each item adds up its share of the cells, then the items share out the coefficients.
// Compile-time: IR_M, IR_N, IR_GROUP, IR_ORDER.
#define IR_SCALAR_LANES 1
#include "harmonics.h"
#include "hemisphere_reduce.h"
#include "irradia/shared/radiance_types.h"
#include "irradia/shared/record_types.h"

#define IR_CELLS (IR_M * IR_N)
#define IR_COEFFICIENTS (IR_ORDER * IR_ORDER)
#define IR_SUMS (IR_HARMONIC_SETS * IR_COEFFICIENTS)

// A sample in the record's frame, as sample_hemispheres had it (its ray's start is the record's position, but for the
// offset that keeps rays off the surface).
IR_FN HemisphereSample kept_sample(IR_GLOBAL const float* samples, uint stride, Frame frame, float far, uint cell) {
    const real3 p = make_real3(samples[cell], samples[stride + cell], samples[2u * stride + cell]);
    HemisphereSample s;
    const float r = length(p);
    s.direction = to_local(frame, p * (1.0f / r));
    s.direction.z = max(s.direction.z, 2.5e-4f);
    s.distance = r < far ? r : IR_INFINITY;
    s.normal = to_local(frame, make_real3(samples[3u * stride + cell], samples[4u * stride + cell],
                                          samples[5u * stride + cell]));
    s.radiance = make_real3(samples[7u * stride + cell], samples[8u * stride + cell], samples[9u * stride + cell]);
    return s;
}

// Adds v times a step in radiance to coefficient arrays of three channels.
IR_FN void add_terms(float* sums, const float* basis, real3 v) {
    for (uint i = 0; i < IR_COEFFICIENTS; ++i) {
        sums[i] += basis[i] * v.x;
        sums[IR_COEFFICIENTS + i] += basis[i] * v.y;
        sums[2u * IR_COEFFICIENTS + i] += basis[i] * v.z;
    }
}

// One edge's share of the derivatives.
IR_FN void add_harmonic_edge(float* sums, real3 w0, real3 w1, CellEdge edge, real3 dL) {
    if (!(edge.centre > 0.0f) || (dL.x == 0.0f && dL.y == 0.0f && dL.z == 0.0f)) return;
    const EdgeFlux flux = cell_edge_flux(w0, w1, edge);
    const real3 middle = normalize(w0 + w1);
    float basis[IR_COEFFICIENTS];
    hsh_basis(middle, IR_ORDER, basis);
    const float scale = 1.0f / max(middle.z, 0.02f);
    add_terms(sums + 3u * IR_COEFFICIENTS, basis, dL * (flux.g.x * scale));
    add_terms(sums + 6u * IR_COEFFICIENTS, basis, dL * (flux.g.y * scale));
}

// The cells first, first + IR_GROUP, ... of one record.
IR_FN void project_cells(IR_GLOBAL const float* samples, uint stride, Frame frame, real3 mean, float far, uint first,
                         IR_GLOBAL float* out) {
    float sums[IR_SUMS], basis[IR_COEFFICIENTS];
    for (uint i = 0; i < IR_SUMS; ++i) sums[i] = 0.0f;
    for (uint cell = first; cell < IR_CELLS; cell += IR_GROUP) {
        const uint j = cell / IR_N, k = cell % IR_N;
        const HemisphereSample own = kept_sample(samples, stride, frame, far, cell);
        hsh_basis(own.direction, IR_ORDER, basis);
        add_terms(sums, basis, (own.radiance - mean) * (IR_PI / (float)IR_CELLS * inverse_cosine(own.direction.z)));
        const CellCorners c = cell_corners(j, k, IR_M, IR_N);
        const HemisphereSample azimuth =
            kept_sample(samples, stride, frame, far, k > 0u ? cell - 1u : cell + IR_N - 1u);
        add_harmonic_edge(sums, c.inner, c.outer,
                          crease_edge(azimuth.direction, azimuth.distance, azimuth.normal, own.direction, own.distance,
                                      own.normal, c.inner, c.outer),
                          own.radiance - azimuth.radiance);
        if (j == 0u) continue;
        const HemisphereSample ring = kept_sample(samples, stride, frame, far, cell - IR_N);
        add_harmonic_edge(sums, c.next, c.inner,
                          crease_edge(ring.direction, ring.distance, ring.normal, own.direction, own.distance,
                                      own.normal, c.next, c.inner),
                          own.radiance - ring.radiance);
    }
    for (uint i = 0; i < IR_SUMS; ++i) out[i] = sums[i];
}

// Records first_record + group; their samples begin at those of record `first_kept`. `partial`: IR_GROUP * IR_SUMS
// floats a group. far: distances from there on are misses.
IR_KERNEL void project_harmonics(IR_GLOBAL const RecordKey* keys, IR_GLOBAL const RecordValue* values,
                                 IR_GLOBAL const float* samples, IR_GLOBAL float* harmonics, IR_GLOBAL float* partial,
                                 float far, uint stride, uint first_kept, uint first_record) {
    const uint record = first_record + IR_GROUP_ID, item = IR_LOCAL_ID;
    const Frame frame = make_frame(make_real3(keys[record].nx, keys[record].ny, keys[record].nz));
    const real3 mean =
        make_real3(values[record].e[0], values[record].e[1], values[record].e[2]) * IR_INV_PI;
    IR_GLOBAL float* sums = partial + (size_t)IR_GROUP_ID * (IR_GROUP * IR_SUMS);
    project_cells(samples + (size_t)(record - first_kept) * (IR_SAMPLE_FLOATS * stride), stride, frame, mean, far, item,
                  sums + item * IR_SUMS);
    IR_BARRIER_ALL();
    IR_GLOBAL float* out = harmonics + (size_t)record * IR_SUMS;
    for (uint i = item; i < IR_SUMS; i += IR_GROUP) {
        float sum = 0.0f;
        for (uint slice = 0; slice < IR_GROUP; ++slice) sum += sums[slice * IR_SUMS + i];
        out[i] = sum;
    }
}
