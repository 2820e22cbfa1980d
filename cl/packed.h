// The packed part of the octree: of every node's list a copy that look-ups read without following links, and without
// the records themselves. 16 bytes an entry hold as much of a record as tells, on the safe side, that it cannot apply;
// what is left over, few of those met, is for the exact test to decide (record_weight). Entries of a node follow each
// other, in the order of its list.
//     word 0   x | y << 16   position in steps of the node's edge / IR_PACKED_STEPS, IR_PACKED_ZERO at its lower corner
//     word 1   z | support << 16   the larger one in steps, rounded up; IR_PACKED_WIDE: too large, or x, y, z out of range
//     word 2   normal, 3 x 8 bits, signed, in units of 1/127 | coat << 24, its low 8 bits
//     word 3   record
// Supports that clamp_records shrinks later stay here as they were: a looser bound is a bound.
#ifndef IR_PACKED_H
#define IR_PACKED_H
#include "irradia/shared/record_types.h"
#include "lanes.h"
#include "octree.h"

#define IR_PACKED_WORDS 4u
#define IR_PACKED_ZERO 24576.0f  // lists hold records within an edge of the node, up to rounding
#define IR_PACKED_WIDE 65535u
// What rounding may take from a distance, in steps: half a step along each axis, and float32's part of it.
#define IR_PACKED_SLACK 1.5f
// And from a cosine: half of 1/127 in each component of a unit vector is .0068; stored normals are unit to 1e-3.
#define IR_PACKED_COSINE_SLACK 0.0125f

// A question to packed entries: which records lie nearer to p than share * support + more or than `least`, have normals with
// a cosine of more than `cosine` to n, and that coat? Answers err to the side of yes.
typedef struct PackedQuery {
    real3 p, n;  // n in units of 1/127
    float share, more, least, cosine;
    uint coat, coat_mask;  // in the place of word 2; mask 0: any coat
} PackedQuery;

IR_FN PackedQuery packed_query(real3 p, real3 n, float share, float more, float cosine) {
    PackedQuery q;
    q.p = p;
    q.n = n * (1.0f / 127.0f);
    q.share = share * 1.0001f;
    q.more = more;
    q.least = 0.0f;
    q.cosine = cosine - IR_PACKED_COSINE_SLACK;
    q.coat = q.coat_mask = 0u;
    return q;
}

// A coordinate in steps; *wide if it is out of range.
IR_FN uint packed_coordinate(float x, float lo, float scale, bool* wide) {
    const float steps = (x - lo) * scale + IR_PACKED_ZERO;
    const bool within = steps >= 0.0f && steps <= 65535.0f;
    if (!within) *wide = true;
    return within ? (uint)(steps + 0.5f) & 0xffffu : 0u;
}

IR_FN uint packed_cosine(float x) { return (uint)((int)floor(clamp(x, -1.0f, 1.0f) * 127.0f + 0.5f) & 0xff); }

// Steps a world unit.
IR_FN float packed_scale(float edge) { return IR_PACKED_STEPS / edge; }

// The entry of record k in the list of a node with lower corner lo.
IR_FN void pack_entry(IR_GLOBAL uint* entry, const RecordKey* k, uint record, real3 lo, float scale) {
    bool wide = false;
    const uint x = packed_coordinate(k->px, lo.x, scale, &wide), y = packed_coordinate(k->py, lo.y, scale, &wide),
               z = packed_coordinate(k->pz, lo.z, scale, &wide);
    const float support = max(k->support1, k->support2) * scale + 1.0f;
    if (!(support < 65535.0f)) wide = true;
    entry[0] = x | (y << 16);
    entry[1] = z | ((wide ? IR_PACKED_WIDE : (uint)support) << 16);
    entry[2] = packed_cosine(k->nx) | (packed_cosine(k->ny) << 8) | (packed_cosine(k->nz) << 16) | (k->coat << 24);
    entry[3] = record;
}

// A query in the steps of one node.
typedef struct NodeQuery {
    real3 p;
    float more, least;
} NodeQuery;

IR_FN NodeQuery node_query(const PackedQuery* q, real3 lo, float scale) {
    NodeQuery s;
    s.p = (q->p - lo) * scale + make_real3(IR_PACKED_ZERO, IR_PACKED_ZERO, IR_PACKED_ZERO);
    s.more = q->more * scale + IR_PACKED_SLACK;
    s.least = q->least > 0.0f ? q->least * scale + IR_PACKED_SLACK : 0.0f;
    return s;
}

#if IR_LANES == 8u
#include "packed_cpu.h"
#else
typedef struct IR_ALIGNED_16 PackedEntry {
    uint w0, w1, w2, record;
} PackedEntry;

IR_FN bool packed_test(const PackedEntry* entry, const PackedQuery* q, const NodeQuery* s) {
    const uint w0 = entry->w0, w1 = entry->w1, w2 = entry->w2;
    if (((w2 ^ q->coat) & q->coat_mask) != 0u) return false;
    const float dx = (float)(w0 & 0xffffu) - s->p.x, dy = (float)(w0 >> 16) - s->p.y;
    const float dz = (float)(w1 & 0xffffu) - s->p.z, reach = max((float)(w1 >> 16) * q->share + s->more, s->least);
    const bool near = dx * dx + dy * dy + dz * dz < reach * reach;
    if (!near && (w1 >> 16) != IR_PACKED_WIDE) return false;
    const float cosine = (float)((int)(w2 << 24) >> 24) * q->n.x + (float)((int)(w2 << 16) >> 24) * q->n.y +
                         (float)((int)(w2 << 8) >> 24) * q->n.z;
    return cosine > q->cosine;
}
#endif
#endif
