// Looking records up: (1.6) over the records whose weight is positive (1.9), each extrapolated by its gradients (1.7).
#ifndef IR_CACHE_H
#define IR_CACHE_H
#include "octree_walk.h"
#include "weight.h"

#ifndef IR_WEIGHT
#define IR_WEIGHT 0  // IR_WEIGHT_*, as a plain number
#endif

typedef struct Cache {
    Octree octree;
    CacheParameters parameters;
} Cache;

#define IR_OCTREE_ARGS                                                                                             \
    IR_GLOBAL const uint *octree_nodes, IR_GLOBAL const uint *octree_entries, IR_GLOBAL const uint *octree_packed, \
        uint octree_mask
#define IR_CACHE_ARGS                                                                                                    \
    IR_OCTREE_ARGS, IR_GLOBAL const RecordKey *record_keys, IR_GLOBAL const RecordValue *record_values, CacheParameters \
        cache_parameters
#define IR_CACHE_INIT(c)               \
    Cache c;                           \
    c.octree.nodes = octree_nodes;     \
    c.octree.entries = octree_entries; \
    c.octree.packed = octree_packed;   \
    c.octree.mask = octree_mask;       \
    c.octree.keys = record_keys;       \
    c.octree.values = record_values;   \
    c.parameters = cache_parameters

// Weight of a record at (p, n) of a surface with coat `coat`, 0 if it does not apply. Without branches: of several records
// the roots and divisions go on at once.
IR_FN float record_weight(const CacheParameters* c, const IR_GLOBAL RecordKey* k, real3 p, real3 n, uint coat) {
    const real3 pi = make_real3(k->px, k->py, k->pz), ni = make_real3(k->nx, k->ny, k->nz);
    const float distance =
        elliptic_error(p - pi, make_real3(k->t2x, k->t2y, k->t2z), k->support1, k->support2) * c->stretch;
    const float angle = normal_error(n, ni) * c->inverse_angle * c->stretch;
#if IR_WEIGHT == 1  // Tabellion: support and angle are already in units of 1/kappa
    const float w = 1.0f - max(distance, angle);
#elif IR_WEIGHT == 2
    const float w = cubic_weight_normalised(distance + angle);
#else
    const float w = ward_weight_normalised(distance + angle);
#endif
    bool applies = (k->coat == coat) & (distance < 1.0f) & (w > 0.0f);
    if (c->in_front > 0.0f)
        applies = applies & !(is_in_front(p, n, pi, ni, c->in_front, c->coordinate) | is_below(p, n, pi, ni));
    return applies ? w : 0.0f;
}

#ifdef IR_WALK_AHEAD
#include "cache_cpu.h"
#endif

// The records whose weight is positive at (p, n) of a surface with coat `coat`:
//     RecordWalk walk = record_walk(&parameters, p, n, coat);
//     record_look_ahead(&octree, &walk);  (if mostly all of them are wanted)
//     while (record_next(&octree, &parameters, &walk)) if (walk.weight > 0) ... walk.record, walk.weight
typedef struct RecordWalk {
    OctreeWalk octree;
    real3 p, n;
    uint coat, record;
    float weight;
#ifdef IR_WALK_AHEAD
    float weights[IR_WALK_AHEAD + 8u];  // of octree.met
#endif
} RecordWalk;

IR_FN RecordWalk record_walk(const CacheParameters* c, real3 p, real3 n, uint coat) {
    RecordWalk walk;
    const float near = 1.0f / c->stretch, angle = near / c->inverse_angle;
    PackedQuery query = packed_query(p, n, near, 0.0f, 1.0f - angle * angle);
    query.coat = coat << 24;
    query.coat_mask = 0xff000000u;
    walk.octree = octree_walk(c, query);
    walk.p = p;
    walk.n = n;
    walk.coat = coat;
    return walk;
}

IR_FN void record_look_ahead(const Octree* tree, RecordWalk* walk) {
#ifdef IR_WALK_AHEAD
    octree_look_ahead(tree, &walk->octree);
#endif
}

IR_FN bool record_next(const Octree* tree, const CacheParameters* c, RecordWalk* walk) {
#ifdef IR_WALK_AHEAD
    OctreeWalk* o = &walk->octree;
    while (o->taken == o->count) {
        octree_collect(tree, c, o);
        if (o->count == 0u) return false;
        uint count = 0u;
        if (o->count == 1u)
            walk->weights[0] = record_weight(c, &tree->keys[o->met[0]], walk->p, walk->n, walk->coat);
        for (uint i = 0; o->count > 1u && i < o->count; i += IR_LANES) {
            for (uint j = o->count; j < i + IR_LANES; ++j) o->met[j] = o->met[i];
            vstore8(record_weights(c, tree->keys, o->met + i, walk->p, walk->n, walk->coat), 0, walk->weights + i);
        }
        for (uint i = 0; i < o->count; ++i) {
            const float w = walk->weights[i];
            o->met[count] = o->met[i];
            walk->weights[count] = w;
            count += w > 0.0f ? 1u : 0u;
        }
        for (uint i = 0; i < count; ++i) {
            IR_GLOBAL const char* value = (IR_GLOBAL const char*)&tree->values[o->met[i]];
            IR_PREFETCH(value);
            IR_PREFETCH(value + sizeof(RecordValue) - 1u);
        }
        o->count = count;
    }
    walk->record = o->met[o->taken];
    walk->weight = walk->weights[o->taken++];
    return true;
#else
    if (!octree_step(tree, c, &walk->octree, &walk->record)) return false;
    walk->weight = walk->record == IR_NO_RECORD
                       ? 0.0f
                       : record_weight(c, &tree->keys[walk->record], walk->p, walk->n, walk->coat);
    return true;
#endif
}

// One channel of (1.7), within [0, 2 E_i] (theory 4.5).
IR_FN float extrapolate(float e, real3 turn, real3 rotation, real3 delta, real3 translation) {
    return clamp(e + dot(turn, rotation) + dot(delta, translation), 0.0f, 2.0f * e);
}

// Irradiance of record i extrapolated to (p, n) (1.7); each channel within [0, 2 E_i] (theory 4.5).
IR_FN real3 record_irradiance(const IR_GLOBAL RecordValue* v, const IR_GLOBAL RecordKey* k, real3 p, real3 n) {
    const real3 delta = p - make_real3(k->px, k->py, k->pz);
    const real3 turn = cross(make_real3(k->nx, k->ny, k->nz), n);
    real3 e;
    e.x = extrapolate(v->e[0], turn, make_real3(v->rotation[0], v->rotation[1], v->rotation[2]), delta,
                      make_real3(v->translation[0], v->translation[1], v->translation[2]));
    e.y = extrapolate(v->e[1], turn, make_real3(v->rotation[3], v->rotation[4], v->rotation[5]), delta,
                      make_real3(v->translation[3], v->translation[4], v->translation[5]));
    e.z = extrapolate(v->e[2], turn, make_real3(v->rotation[6], v->rotation[7], v->rotation[8]), delta,
                      make_real3(v->translation[6], v->translation[7], v->translation[8]));
    return e;
}

// Walks the octree to p. Adds w E_i to *sum for every record with w > 0 and returns the sum of the weights.
IR_ONCE_FN float cache_gather(const Cache* c, real3 p, real3 n, uint coat, real3* sum) {
    const CacheParameters q = c->parameters;
    float weights = 0.0f;
    RecordWalk walk = record_walk(&q, p, n, coat);
    record_look_ahead(&c->octree, &walk);
    while (record_next(&c->octree, &q, &walk)) {
        if (!(walk.weight > 0.0f)) continue;
        weights += walk.weight;
        *sum += record_irradiance(&c->octree.values[walk.record], &c->octree.keys[walk.record], p, n) * walk.weight;
    }
    return weights;
}

// True if the records suffice at (p, n) of a surface with coat `coat` (0: none). `reach`: support that a record made there
// could have at most. Records that it would shrink (insert_records.cl) do not count: they have not seen what is so near
// here. IR_INFINITY: all count.
IR_FN bool cache_covers(const Cache* c, real3 p, real3 n, uint coat, float reach) {
    const CacheParameters q = c->parameters;
    float weights = 0.0f;
    RecordWalk walk = record_walk(&q, p, n, coat);  // the first few mostly suffice
    while (record_next(&c->octree, &q, &walk)) {
        if (!(walk.weight > 0.0f)) continue;
        const IR_GLOBAL RecordKey* key = &c->octree.keys[walk.record];
        if (key->support1 > 1.001f * (reach + length(p - make_real3(key->px, key->py, key->pz)))) continue;
        weights += walk.weight;
        if (weights > q.minimum_weight) return true;
    }
    return false;
}

// Do the records that apply at (p, n) know what light does there? One of them at least has seen a surface within `near`, and
// the brightest answer is at most twice the darkest: noise of a few rays, and gradients that overshoot, make less.
IR_FN bool cache_agrees(const Cache* c, real3 p, real3 n, uint coat, float near) {
    const CacheParameters q = c->parameters;
    float least = IR_INFINITY, most = 0.0f;
    bool seen = false;
    RecordWalk walk = record_walk(&q, p, n, coat);
    while (record_next(&c->octree, &q, &walk)) {
        if (!(walk.weight > 0.0f)) continue;
        const IR_GLOBAL RecordValue* value = &c->octree.values[walk.record];
        const float y = luminance(record_irradiance(value, &c->octree.keys[walk.record], p, n));
        least = min(least, y);
        most = max(most, y);
        seen = seen || value->minimum <= near;
    }
    return seen && most <= 2.0f * least;
}

// Interpolated irradiance (1.6) in W·m⁻²; false (and zero) where no record applies.
IR_FN bool cache_lookup(const Cache* c, real3 p, real3 n, uint coat, real3* irradiance) {
    real3 sum = make_real3(0.0f, 0.0f, 0.0f);
    const float weights = cache_gather(c, p, n, coat, &sum);
    const bool found = weights > 0.0f;
    *irradiance = found ? sum * (1.0f / weights) : make_real3(0.0f, 0.0f, 0.0f);
    return found;
}
#endif
