// Irradiance from a radiance record, by either representation: what an irradiance record would say at the same point.
// The cosine is a lobe that both know exactly, so the two caches can be held to each other.
#ifndef IR_RADIANCE_IRRADIANCE_H
#define IR_RADIANCE_IRRADIANCE_H
#include "radiance.h"

// By the samples, at a point of normal n (theory 7 with f = 1, whose albedo is pi): moved with their parallax, and exact
// in a furnace.
IR_FN real3 samples_irradiance(const RadianceCache* c, uint record, real3 to_record, real3 n) {
    const uint stride = c->parameters.stride;
    IR_GLOBAL const float* s = c->samples + (size_t)record * (IR_SAMPLE_FLOATS * stride);
    lanes total = lanes_of(0.0f), r = total, g = total, b = total;
    for (uint i = 0; i < stride; i += IR_LANES) {
        const SampleLanes at = load_samples(s, stride, i, to_record, n);
        const lanes f = lanes_select(0.0f, at.solid * at.cosine, at.cosine > IR_LEAST_COSINE);
        total += f;
        r += f * at.r;
        g += f * at.g;
        b += f * at.b;
    }
    const float sum = lanes_sum(total);
    if (!(sum > 0.0f)) return black();
    return make_real3(lanes_sum(r), lanes_sum(g), lanes_sum(b)) * (IR_PI / sum);
}

// By the harmonics, `delta` from the record, for the record's own normal. The cosine lies in the span of two functions,
//   Y_00 = 1 / sqrt(2 pi),  Y_10 = sqrt(3 / (2 pi)) (2 cos - 1):  cos = sqrt(pi / 2) Y_00 + sqrt(pi / 6) Y_10,
// which are orthonormal over the hemisphere: irradiance is pi times the mean plus the coefficients' dot product with
// these two numbers, whatever the order. At the record that product vanishes, since the mean is weighted by the cosine;
// elsewhere it is the translational gradient (each edge counts with cos / cos). One band alone does not hold the cosine:
// there the record's irradiance stays as it is.
IR_FN real3 harmonics_irradiance(const RadianceCache* c, uint record, const IR_GLOBAL RecordKey* k, real3 delta) {
    const uint count = c->parameters.order * c->parameters.order;
    const IR_GLOBAL RecordValue* v = &c->records.octree.values[record];
    const real3 e = make_real3(v->e[0], v->e[1], v->e[2]);
    if (c->parameters.order < 2u) return e;
    IR_GLOBAL const float* s = c->harmonics + (size_t)record * (IR_HARMONIC_SETS * count);
    const Frame frame = make_frame(make_real3(k->nx, k->ny, k->nz));
    const float dx = dot(delta, frame.t), dy = dot(delta, frame.b);
    float sum[3];
    for (uint i = 0; i < 3u; ++i) {
        IR_GLOBAL const float *at = s + i * count, *x = at + 3u * count, *y = at + 6u * count;
        sum[i] = 1.25331414f * (at[0] + dx * x[0] + dy * y[0]) + 0.72360125f * (at[2] + dx * x[2] + dy * y[2]);
    }
    return make_real3(max(e.x + sum[0], 0.0f), max(e.y + sum[1], 0.0f), max(e.z + sum[2], 0.0f));
}
#endif
