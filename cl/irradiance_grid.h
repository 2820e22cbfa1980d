// The irradiance grid: irradiance by indirect light at the places that paths visit, averaged over cells in space and
// over six directions of the normal. It answers the second bounce: a hemisphere's ray that hits a surface takes the
// surface's direct light by next-event estimation and its indirect light from here, instead of going on as a path.
// All records then share the paths that filled the grid, so their noise is that of many more paths, and a ray costs one
// look-up instead of the rest of a path.
//
// What it errs by: cells average over their extent. So cells are small where many paths came by (the finest level with
// enough samples answers), look-ups are spread over the neighbouring cells at random, and rays that are shorter than a
// few cells go on as paths for one more bounce, behind which drafts take any length (IR_GRID=2). The values themselves
// come from complete paths: nothing compounds. Where paths have a limited length, those that fill the grid are as long as
// may follow a hemisphere's ray, and it answers there alone; farther on only where IR_GRID_DEEP edges are left: what is
// wrong then is light that so many surfaces have reflected.
#ifndef IR_IRRADIANCE_GRID_H
#define IR_IRRADIANCE_GRID_H
#include "grid_parent.h"
#include "irradia/shared/grid_types.h"
#include "portable.h"
#include "random.h"
#include "sampling.h"

#define IR_GRID_PROBES 64u  // slots looked at before the table counts as full

// Key of the cell of `level` that holds p, facing along one of six axes: coordinates of 9 bits, axis of 3, level of 2.
// Never 0, since coordinates begin at 1.
IR_FN uint grid_key(const GridParameters* g, uint level, real3 p, real3 n) {
    const float scale = 1.0f / (g->cell * (float)(1u << level));
    const uint x = 1u + (uint)clamp((p.x - g->origin_x) * scale, 0.0f, 509.0f);
    const uint y = 1u + (uint)clamp((p.y - g->origin_y) * scale, 0.0f, 509.0f);
    const uint z = 1u + (uint)clamp((p.z - g->origin_z) * scale, 0.0f, 509.0f);
    const float ax = fabs(n.x), ay = fabs(n.y), az = fabs(n.z);
    const uint axis = ax >= ay && ax >= az ? (n.x < 0.0f ? 1u : 0u)
                                           : (ay >= az ? (n.y < 0.0f ? 3u : 2u) : (n.z < 0.0f ? 5u : 4u));
    return x | (y << 9) | (z << 18) | (axis << 27) | (level << 30);
}

// Slot of `key`, or the number of slots if it is not there.
IR_FN uint grid_find(const GridParameters* g, IR_GLOBAL const GridCell* cells, uint key) {
    uint slot = hash_slot(key, g->slots);
    for (uint i = 0; i < IR_GRID_PROBES; ++i, slot = (slot + 1u) & (g->slots - 1u)) {
        const uint found = cells[slot].key;
        if (found == key) return slot;
        if (found == 0u) break;
    }
    return g->slots;
}

// A look-up around (p, n) for a ray of length `distance`, spread at random over the cells beside it.
typedef struct GridQuery {
    real3 p, n, spread;  // spread: in finest cells
    float distance;
} GridQuery;

IR_FN GridQuery grid_query(const GridParameters* g, real3 p, real3 n, float distance, Rng* rng) {
    const Frame frame = make_frame(n);
    const float u = rng_real(rng) - 0.5f, v = rng_real(rng) - 0.5f;
    GridQuery q;
    q.p = p;
    q.n = n;
    q.spread = (frame.t * u + frame.b * v) * g->cell;
    q.distance = distance;
    return q;
}

// May the grid answer where `edges` path edges may follow, direct light among them?
IR_FN bool grid_serves(const GridParameters* g, uint edges) { return edges == g->edges || edges >= IR_GRID_DEEP; }

// Is the ray long enough for cells of `level`?
IR_FN bool grid_reaches(const GridParameters* g, const GridQuery* q, uint level) {
    return q->distance >= g->shortest * (float)(1u << level) * g->cell;
}

IR_FN uint grid_query_key(const GridParameters* g, const GridQuery* q, uint level) {
    return grid_key(g, level, q->p + q->spread * (float)(1u << level), q->n);
}

IR_FN real3 grid_cell_irradiance(IR_GLOBAL const GridCell* cells, uint slot) {
    return make_real3(cells[slot].r, cells[slot].g, cells[slot].b);
}

// Irradiance by indirect light, W·m⁻²; false where too few paths came by or the ray is short for cells of the size that
// would answer.
IR_FN bool grid_lookup(const GridParameters* g, IR_GLOBAL const GridCell* cells, const GridQuery* q, real3* irradiance) {
    for (uint level = 0; level < IR_GRID_LEVELS && grid_reaches(g, q, level); ++level) {
        const uint slot = grid_find(g, cells, grid_query_key(g, q, level));
        if (slot == g->slots) continue;
        *irradiance = grid_cell_irradiance(cells, slot);
        return true;
    }
    return false;
}

// The same for `count` queries, at most 32. Their slots are asked for together before any is read, so that the table's
// cache misses overlap: one by one they were a quarter of a hemisphere's time. Bit i of the result: query i has an answer.
IR_FN uint grid_lookup_tile(const GridParameters* g, IR_GLOBAL const GridCell* cells, const GridQuery* q, uint count,
                            real3* irradiance) {
    uint keys[32], pending[32], left = count, answered = 0u;
    for (uint i = 0; i < count; ++i) pending[i] = i;
    for (uint level = 0; level < IR_GRID_LEVELS && left > 0u; ++level) {
        uint asked = 0u;
        for (uint i = 0; i < left; ++i) {
            const uint k = pending[i];
            if (!grid_reaches(g, &q[k], level)) continue;
            keys[asked] = grid_query_key(g, &q[k], level);
            IR_PREFETCH(&cells[hash_slot(keys[asked], g->slots)]);
            pending[asked++] = k;
        }
        left = 0u;
        for (uint i = 0; i < asked; ++i) {
            const uint k = pending[i], slot = grid_find(g, cells, keys[i]);
            if (slot == g->slots) {
                pending[left++] = k;
            } else {
                irradiance[k] = grid_cell_irradiance(cells, slot);
                answered |= 1u << k;
            }
        }
    }
    return answered;
}

#ifdef IR_GRID_FILL  // ---------------------------------------------------------------------- filling (kernels only)

#define IR_GRID_SUM_WORDS (sizeof(GridSum) / sizeof(uint))
#define IR_GRID_CELL_WORDS (sizeof(GridCell) / sizeof(uint))

// Slot of `key` in a table of either struct, whose first word is the key; taken if it is not there yet, which *fresh tells;
// `slots` if the table is full.
IR_FN uint grid_take(volatile IR_GLOBAL uint* table, uint words, uint slots, uint key, bool* fresh) {
    uint slot = hash_slot(key, slots);
    for (uint i = 0; i < IR_GRID_PROBES; ++i, slot = (slot + 1u) & (slots - 1u)) {
        const uint found = IR_ATOMIC_CAS(&table[slot * words], 0u, key);
        *fresh = found == 0u;
        if (found == 0u || found == key) return slot;
    }
    *fresh = false;
    return slots;
}

// Adds to a 64-bit number in two words: integers, so that the sum does not depend on the order of work-items.
IR_FN void add_wide(volatile IR_GLOBAL uint* word, uint low, uint high) {
    const uint before = IR_ATOMIC_ADD(&word[0], low);
    const uint carry = before + low < before ? 1u : 0u;
    if (high + carry != 0u) IR_ATOMIC_ADD(&word[1], high + carry);
}

// The same for a number of units >= 0; above 2^62 it counts as that.
IR_FN void add_units(volatile IR_GLOBAL uint* word, float units) {
    const float x = floor(min(units + 0.5f, 4.6e18f));
    const uint high = (uint)(x * 2.3283064365386963e-10f);  // 2^-32; exact: the low part is what float32 still holds
    add_wide(word, (uint)(x - (float)high * 4294967296.0f), high);
}

IR_FN float wide_value(uint low, uint high) { return (float)high * 4294967296.0f + (float)low; }

// Sends for the slot that an estimate at (p, n) will most likely be added to.
IR_FN void grid_expect(const GridParameters* g, IR_GLOBAL const GridSum* sums, real3 p, real3 n) {
    IR_PREFETCH_OWN(&sums[hash_slot(grid_key(g, 0u, p, n), g->slots)]);
}

#define IR_GRID_NONE 0xffffffffu  // no slot

// One estimate of irradiance at (p, n). Sets *overflow if the table is full. Returns the slot if it was free, else
// IR_GRID_NONE.
IR_ONCE_FN uint grid_deposit(const GridParameters* g, volatile IR_GLOBAL GridSum* sums, real3 p, real3 n,
                             real3 irradiance, volatile IR_GLOBAL uint* overflow) {
    bool fresh;
    const uint slot =
        grid_take((volatile IR_GLOBAL uint*)sums, IR_GRID_SUM_WORDS, g->slots, grid_key(g, 0u, p, n), &fresh);
    if (slot == g->slots) {
        IR_ATOMIC_MAX(overflow, 1u);
        return IR_GRID_NONE;
    }
    const real3 units = irradiance * (1.0f / g->unit);
    add_units(&sums[slot].r[0], units.x);
    add_units(&sums[slot].g[0], units.y);
    add_units(&sums[slot].b[0], units.z);
    IR_ATOMIC_ADD(&sums[slot].samples, 1u);
    return fresh ? slot : IR_GRID_NONE;
}

// Slots that a group has taken: they are collected here, and listed in taken[1] and following all at once. So taken[0],
// their number, is counted up once a group: when every slot counted by itself, threads waited for each other there.
#ifndef IR_GRID_FRESH
#define IR_GRID_FRESH 512u  // so many; a group's further ones are listed one by one
#endif
#define IR_GRID_FRESH_WORDS (2u + IR_GRID_FRESH)  // number, where they are listed, slots

IR_INLINE_FN void grid_fresh_begin(volatile IR_LOCAL uint* fresh) {
    if (IR_LOCAL_ID == 0u) fresh[0] = 0u;
    IR_BARRIER();
}

IR_INLINE_FN void grid_fresh_add(volatile IR_LOCAL uint* fresh, uint slot, volatile IR_GLOBAL uint* taken) {
    const uint at = IR_ATOMIC_ADD(&fresh[0], 1u);
    if (at < IR_GRID_FRESH)
        fresh[2u + at] = slot;
    else
        taken[1u + IR_ATOMIC_ADD(&taken[0], 1u)] = slot;
}

IR_INLINE_FN void grid_fresh_end(volatile IR_LOCAL uint* fresh, volatile IR_GLOBAL uint* taken) {
    IR_BARRIER();
    if (IR_LOCAL_ID == 0u && fresh[0] > 0u) fresh[1] = IR_ATOMIC_ADD(&taken[0], min(fresh[0], IR_GRID_FRESH));
    IR_BARRIER();
    const uint count = min(fresh[0], IR_GRID_FRESH);
    for (uint i = IR_LOCAL_ID; i < count; i += IR_LOCAL_SIZE) taken[1u + fresh[1] + i] = fresh[2u + i];
}
#endif
#endif
