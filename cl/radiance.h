// Radiance caching on glossy surfaces (theory 7): a record holds where the light of its hemisphere comes from, and any
// lobe and view can be answered from it. Two representations:
//   samples    the hemisphere's own samples, moved to the query point by the Jacobian of solid angle and weighed by the
//              lobe: sums over records and samples, normalised by the lobe's albedo. Frame-free, exact in a furnace.
//   harmonics  coefficients, moved by their gradients, against the lobe's tabulated ones.
#ifndef IR_RADIANCE_H
#define IR_RADIANCE_H
#include "cache.h"
#include "harmonics.h"
#include "irradia/shared/radiance_types.h"
#include "lobe.h"
#include "reproject.h"

typedef struct RadianceCache {
    Cache records;
    IR_GLOBAL const float *samples, *harmonics, *tables;
    IR_GLOBAL const uint* lobes;  // where each material's table begins, or IR_NO_LOBE
    RadianceParameters parameters;
} RadianceCache;

#define IR_RADIANCE_ARGS                                                                                               \
    IR_GLOBAL const uint *lobe_nodes, IR_GLOBAL const uint *lobe_entries, IR_GLOBAL const uint *lobe_packed,           \
        uint lobe_mask, IR_GLOBAL const RecordKey *lobe_keys, IR_GLOBAL const RecordValue *lobe_values,                \
        CacheParameters lobe_parameters, IR_GLOBAL const float *lobe_samples,                                          \
        IR_GLOBAL const float *lobe_harmonics, IR_GLOBAL const float *lobe_tables, IR_GLOBAL const uint *lobe_offsets, \
        RadianceParameters radiance_parameters
#define IR_RADIANCE_INIT(c)               \
    RadianceCache c;                      \
    c.records.octree.nodes = lobe_nodes;  \
    c.records.octree.entries = lobe_entries; \
    c.records.octree.packed = lobe_packed; \
    c.records.octree.mask = lobe_mask;    \
    c.records.octree.keys = lobe_keys;    \
    c.records.octree.values = lobe_values; \
    c.records.parameters = lobe_parameters; \
    c.samples = lobe_samples;             \
    c.harmonics = lobe_harmonics;         \
    c.tables = lobe_tables;               \
    c.lobes = lobe_offsets;               \
    c.parameters = radiance_parameters

// The entry of f's lobe in the tables.
IR_FN LobeEntry surface_lobe_entry(const RadianceCache* c, const Surface* f) {
    return lobe_entry(c->tables + c->lobes[f->material_index], &c->parameters,
                      f->material->alpha_texture != IR_NO_TEXTURE, f->alpha_u, dot(f->view, f->ns));
}

// Is the glossy part of f answered by records, rather than traced? Not if it is narrow, nor if it is but a faint coat on a
// surface that reflects more by itself: the noise of a few rays does not show there, and records cost as much as elsewhere.
IR_FN bool caches_lobe(const RadianceCache* c, const Surface* f) {
    if (!has_lobe(f) || c->lobes[f->material_index] == IR_NO_LOBE || !(f->alpha_u >= c->parameters.trace_below))
        return false;
    if (is_zero(f->albedo)) return true;
    const LobeEntry entry = surface_lobe_entry(c, f);
    const float lobe = largest_channel(lobe_values(&entry, 0u) * f->specular);
    return lobe >= c->parameters.share * (lobe + largest_channel(f->albedo));
}

// What records have to say of one lobe, added up: radiance reflected is `weighted` over `total`, channel by channel.
typedef struct LobeSum {
    real3 weighted, total;
} LobeSum;

IR_FN LobeSum lobe_sum_zero(void) {
    LobeSum sum;
    sum.weighted = sum.total = black();
    return sum;
}

// A lobe that asks: what look-ups need of it.
typedef struct LobeQuery {
    real3 p;
    Lobe lobe;
    real3 f0;  // conductors: reflectance at normal incidence; plastics: 1
    LobeEntry entry;
    bool harmonics;
} LobeQuery;

// Does the lobe of f ask records' harmonics, rather than their samples?
IR_FN bool asks_harmonics(const RadianceCache* c, const Surface* f) {
    return c->parameters.order > 0u && f->alpha_u >= c->parameters.harmonics_from;
}

IR_FN LobeQuery lobe_query(const RadianceCache* c, const Surface* f, real3 p) {
    LobeQuery q;
    q.p = p;
    q.lobe = surface_lobe(f);
    q.f0 = make_real3(1.0f, 1.0f, 1.0f);
    if (f->kind == IR_MATERIAL_ROUGH_CONDUCTOR) {
        const IR_GLOBAL Material* m = f->material;
        q.f0 = make_real3(fresnel_conductor(1.0f, m->eta_r, m->k_r), fresnel_conductor(1.0f, m->eta_g, m->k_g),
                          fresnel_conductor(1.0f, m->eta_b, m->k_b));
    }
    q.entry = surface_lobe_entry(c, f);
    q.harmonics = asks_harmonics(c, f);
    return q;
}

// Samples of a record as seen from a query point: reproject_sample of reproject.h with everything that depends on the
// record alone taken out, several at once.
typedef struct SampleLanes {
    LaneVector w;         // unit directions
    lanes cosine, solid;  // of the angle to the normal there; proportional to the solid angle
    lanes r, g, b;        // radiance
} SampleLanes;

// Samples i, i + 1, ... of the record whose samples begin at s; n: the query's normal. Those whose cosine is at most
// IR_LEAST_COSINE do not count.
#define IR_LEAST_COSINE 1e-4f
IR_FN SampleLanes load_samples(IR_GLOBAL const float* s, uint stride, uint i, real3 to_record, real3 n) {
    SampleLanes q;
    LaneVector v, hit_normal;
    v.x = lanes_load(s, i);
    v.y = lanes_load(s, stride + i);
    v.z = lanes_load(s, 2u * stride + i);
    const lanes least2 = lanes_dot(v, v) * IR_NEAREST2;
    v.x += to_record.x;
    v.y += to_record.y;
    v.z += to_record.z;
    hit_normal.x = lanes_load(s, 3u * stride + i);
    hit_normal.y = lanes_load(s, 4u * stride + i);
    hit_normal.z = lanes_load(s, 5u * stride + i);
    const lanes square = lanes_dot(v, v), inverse = 1.0f / sqrt(max(square, 1e-30f));
    q.w.x = v.x * inverse;
    q.w.y = v.y * inverse;
    q.w.z = v.z * inverse;
    q.cosine = lanes_dot3(q.w, n);
    q.solid = lanes_load(s, 6u * stride + i) * fabs(lanes_dot(hit_normal, q.w)) / max(square, least2);
    q.r = lanes_load(s, 7u * stride + i);
    q.g = lanes_load(s, 8u * stride + i);
    q.b = lanes_load(s, 9u * stride + i);
    return q;
}

// The sums of a record's samples at the query point.
IR_FN LobeSum samples_sum(const RadianceCache* c, uint record, real3 to_record, const LobeQuery* q) {
    const uint stride = c->parameters.stride;
    IR_GLOBAL const float* s = c->samples + (size_t)record * (IR_SAMPLE_FLOATS * stride);
    lanes a = lanes_of(0.0f), b = a, ar = a, ag = a, ab = a, br = a, bg = a, bb = a;
    for (uint i = 0; i < stride; i += IR_LANES) {
        const SampleLanes at = load_samples(s, stride, i, to_record, q->lobe.n);
        lanes schlick;
        const lanes above = max(at.cosine, IR_LEAST_COSINE);
        const lanes f = lanes_select(0.0f, at.solid * lobe_weights(&q->lobe, at.w, above, &schlick),
                                     at.cosine > IR_LEAST_COSINE);
        a += f;
        ar += f * at.r;
        ag += f * at.g;
        ab += f * at.b;
        if (q->lobe.eta == 0.0f) {
            const lanes k = f * schlick;
            b += k;
            br += k * at.r;
            bg += k * at.g;
            bb += k * at.b;
        }
    }
    const float sa = lanes_sum(a), sb = lanes_sum(b);
    const real3 one = make_real3(1.0f, 1.0f, 1.0f);
    LobeSum sum;
    sum.total = q->f0 * sa + (one - q->f0) * sb;
    sum.weighted = q->f0 * make_real3(lanes_sum(ar), lanes_sum(ag), lanes_sum(ab)) +
                   (one - q->f0) * make_real3(lanes_sum(br), lanes_sum(bg), lanes_sum(bb));
    return sum;
}

// The same from a record's harmonics, divided by the lobe's albedo. The lobe is turned so that its mirror direction is
// right, which counts most, in the record's frame instead of the surface's.
IR_FN LobeSum harmonics_sum(const RadianceCache* c, uint record, const IR_GLOBAL RecordKey* k, real3 delta, const LobeQuery* q) {
    const uint order = c->parameters.order, count = order * order;
    IR_GLOBAL const float* s = c->harmonics + (size_t)record * (IR_HARMONIC_SETS * count);
    const Frame frame = make_frame(make_real3(k->nx, k->ny, k->nz));
    const real3 mirror = q->lobe.n * (2.0f * dot(q->lobe.n, q->lobe.o)) - q->lobe.o;
    const real3 view = frame.n * (2.0f * dot(frame.n, mirror)) - mirror;
    const float x = dot(view, frame.t), y = dot(view, frame.b), dx = dot(delta, frame.t), dy = dot(delta, frame.b);
    const float flat = x * x + y * y;
    const float cos1 = flat > 1e-12f ? x * rsqrt(flat) : 1.0f, sin1 = flat > 1e-12f ? y * rsqrt(flat) : 0.0f;
    real3 sum = black();
    float cos_m = 1.0f, sin_m = 0.0f;
    for (uint m = 0; m < order; ++m) {
        for (uint l = m; l < order; ++l) {
            const uint up = l * l + l + m, down = l * l + l - m;
            real3 value = make_real3(s[up] + dx * s[3u * count + up] + dy * s[6u * count + up],
                                     s[count + up] + dx * s[4u * count + up] + dy * s[7u * count + up],
                                     s[2u * count + up] + dx * s[5u * count + up] + dy * s[8u * count + up]) *
                          cos_m;
            if (m > 0u)
                value += make_real3(s[down] + dx * s[3u * count + down] + dy * s[6u * count + down],
                                    s[count + down] + dx * s[4u * count + down] + dy * s[7u * count + down],
                                    s[2u * count + down] + dx * s[5u * count + down] + dy * s[8u * count + down]) *
                         sin_m;
            sum += value * lobe_values(&q->entry, 1u + lobe_coefficient(l, m));
        }
        const float next = cos_m * cos1 - sin_m * sin1;
        sin_m = cos_m * sin1 + sin_m * cos1;
        cos_m = next;
    }
    const IR_GLOBAL RecordValue* v = &c->records.octree.values[record];
    const real3 mean = make_real3(v->e[0], v->e[1], v->e[2]) * IR_INV_PI;
    const real3 albedo = lobe_values(&q->entry, 0u);
    LobeSum lobe;
    lobe.total = make_real3(1.0f, 1.0f, 1.0f);
    lobe.weighted = make_real3(max(mean.x + sum.x / max(albedo.x, 1e-6f), 0.0f),
                               max(mean.y + sum.y / max(albedo.y, 1e-6f), 0.0f),
                               max(mean.z + sum.z / max(albedo.z, 1e-6f), 0.0f));
    return lobe;
}

#define IR_SPREAD_RECORDS 16u

// Narrow lobes see parallax, and edges in what they reflect, sharper. Gradients of harmonics cannot follow that, so those
// records are used less far by narrow lobes; samples are seen from where they lie, and are not (measured: at roughness .2,
// a third fewer records and no more error than with it).
IR_FN CacheParameters lobe_cache_parameters(const RadianceCache* c, const Surface* f) {
    CacheParameters q = c->records.parameters;
    if (asks_harmonics(c, f)) q.stretch *= max(sqrt(c->parameters.full_reach / f->alpha_u), 1.0f);
    return q;
}

IR_FN float positive_ratio(float a, float b) { return b > 0.0f ? a / b : 0.0f; }

// Radiance that f's lobe reflects of indirect light, without the material's specular factor, p taken as where f lies;
// false where no record applies.
IR_FN bool radiance_lookup(const RadianceCache* c, const Surface* f, real3 p, real3* radiance) {
    const LobeQuery q = lobe_query(c, f, p);
    const CacheParameters parameters = lobe_cache_parameters(c, f);
    LobeSum sum = lobe_sum_zero();
    bool found = false;
    RecordWalk walk = record_walk(&parameters, p, f->ns, 0u);
    record_look_ahead(&c->records.octree, &walk);
    while (record_next(&c->records.octree, &parameters, &walk)) {
        if (!(walk.weight > 0.0f)) continue;
        const IR_GLOBAL RecordKey* key = &c->records.octree.keys[walk.record];
        const float w = walk.weight;
        const real3 delta = p - make_real3(key->px, key->py, key->pz);
        const LobeSum one =
            q.harmonics ? harmonics_sum(c, walk.record, key, delta, &q) : samples_sum(c, walk.record, -delta, &q);
        sum.weighted += one.weighted * w;
        sum.total += one.total * w;
        found = true;
    }
    const real3 albedo = lobe_values(&q.entry, 0u);
    *radiance = make_real3(albedo.x * positive_ratio(sum.weighted.x, sum.total.x),
                           albedo.y * positive_ratio(sum.weighted.y, sum.total.y),
                           albedo.z * positive_ratio(sum.weighted.z, sum.total.z));
    return found;
}

// True if the records suffice for f's lobe.
IR_FN bool radiance_covers(const RadianceCache* c, const Surface* f) {
    Cache cache = c->records;
    cache.parameters = lobe_cache_parameters(c, f);
    return cache_covers(&cache, f->p, f->ns, 0u, IR_INFINITY);
}

// By how much the records that answer f's lobe disagree: the weighted mean of |L_i - L| / L, in luminance. *least: the
// smallest support among them.
IR_FN float radiance_spread(const RadianceCache* c, const Surface* f, float* least) {
    const LobeQuery q = lobe_query(c, f, f->p);
    const CacheParameters parameters = lobe_cache_parameters(c, f);
    // The mean, then the deviations from it; of more records than fit, the first.
    float weights[IR_SPREAD_RECORDS], values[IR_SPREAD_RECORDS], total = 0.0f, mean = 0.0f;
    uint count = 0u;
    *least = IR_INFINITY;
    RecordWalk walk = record_walk(&parameters, f->p, f->ns, 0u);
    record_look_ahead(&c->records.octree, &walk);
    while (count < IR_SPREAD_RECORDS && record_next(&c->records.octree, &parameters, &walk)) {
        if (!(walk.weight > 0.0f)) continue;
        const IR_GLOBAL RecordKey* key = &c->records.octree.keys[walk.record];
        const float w = walk.weight;
        const real3 delta = f->p - make_real3(key->px, key->py, key->pz);
        const LobeSum one =
            q.harmonics ? harmonics_sum(c, walk.record, key, delta, &q) : samples_sum(c, walk.record, -delta, &q);
        weights[count] = w;
        values[count] = 0.2126f * positive_ratio(one.weighted.x, one.total.x) +
                        0.7152f * positive_ratio(one.weighted.y, one.total.y) +
                        0.0722f * positive_ratio(one.weighted.z, one.total.z);
        total += w;
        mean += w * values[count++];
        *least = min(*least, key->support1);
    }
    if (!(mean > 0.0f)) return 0.0f;
    mean /= total;
    float spread = 0.0f;
    for (uint i = 0; i < count; ++i) spread += weights[i] * fabs(values[i] - mean);
    return spread / (total * mean);
}
#endif
