// The octree of records on the device. A record is entered into every cell of one level that its support touches, the
// level where a cell's edge lies between one and two support radii; a look-up then asks one cell of every level in use, from
// the root down, and sees every record that can reach the point (octree_walk.h). Cells that hold records are nodes, found by
// hashing their place: none waits for the one above, and a look-up fetches all its nodes at once. Nodes and list entries
// are handed out by atomic counters; when either array is full the host grows it and runs the insertion again (entering
// twice is harmless).
//
// Lists are kept in descending order of record index, whatever the order in which work-items get to run, so that
// look-ups add in the same order on every run and every number of threads: same seed, same bytes.
#ifndef IR_OCTREE_H
#define IR_OCTREE_H
#include "irradia/shared/record_types.h"
#include "portable.h"

// A node is IR_NODE_STRIDE words of a table whose size is a power of two:
//     0, 1       the cell (octree_key); 0: there is no node here
//     2          head of its list, or 0
//     3, 4       the packed part that follows the list (packed.h): first entry, number of entries
//     5 to 7     floats: the cell's lower corner
// Entries: entries[2 e] = record, entries[2 e + 1] = next; an entry's reference is e + 1, 0 ends a list.
#define IR_NODE_STRIDE 8u
#define IR_NODE_HEAD 2u
#define IR_NODE_PACKED 3u
#define IR_NODE_CORNER 5u
#define IR_NO_NODE 0xffffffffu
#ifdef IR_CPU
#define IR_OCTREE_CELLS 32u  // entered at a time by a work-item; most supports touch 27 at most
#else
#define IR_OCTREE_CELLS 1u
#endif
#define IR_PACKED_STEPS 16384.0f

// Integer coordinate of x along one axis at the deepest level, clamped to the root cube.
IR_FN uint octree_coordinate(float x, float origin, float size) {
    const float cells = (float)(1u << IR_OCTREE_MAX_DEPTH);
    const float f = (x - origin) / size * cells;
    return (uint)min(max(f, 0.0f), cells - 1.0f);
}

// Level at which a record of this support is entered: edge = size / 2^level in (support, 2 support].
IR_FN uint octree_level(float support, float size) {
    uint level = 0;
    float edge = size;
    while (level < IR_OCTREE_MAX_DEPTH && edge * 0.5f > support) {
        edge *= 0.5f;
        ++level;
    }
    return level;
}

// The number of the lowest bit of x, which is not 0.
IR_FN uint lowest_bit(uint x) {
#if defined(__OPENCL_VERSION__)
    return (uint)popcount(~x & (x - 1u));
#else
    return (uint)__popc(~x & (x - 1u));
#endif
}

// A cell of a level, coordinates in cells: two words that are not 0.
typedef struct OctreeKey {
    uint a, b;
} OctreeKey;

IR_FN OctreeKey octree_key(uint level, uint x, uint y, uint z) {
    const ulong code = ((((((ulong)1 << level) | z) << level) | y) << level) | x;  // 61 bits; the first set one tells the level
    OctreeKey key;
    key.a = (uint)code | 0x80000000u;
    key.b = (uint)(code >> 31) | 0x80000000u;
    return key;
}

// And back.
typedef struct OctreeCell {
    uint level, x, y, z;
} OctreeCell;

IR_FN OctreeCell octree_cell(uint a, uint b) {
    const ulong code = ((ulong)(b & 0x7fffffffu) << 31) | (a & 0x7fffffffu);
    OctreeCell cell;
    cell.level = 0u;
    while (cell.level < IR_OCTREE_MAX_DEPTH && (code >> (3u * cell.level)) > 1u) ++cell.level;
    const uint all = (1u << cell.level) - 1u;
    cell.x = (uint)code & all;
    cell.y = (uint)(code >> cell.level) & all;
    cell.z = (uint)(code >> (2u * cell.level)) & all;
    return cell;
}

// Where in the table a cell's node is looked for first: cells of a block lie together, in an order of the block's own. For
// CPUs those of 8x8x8, in four pages: what lies close in the scene then mostly lies in pages whose addresses a core knows.
// GPUs, which get many cells at once, insert a tenth faster with the eight children of a cell, in four cache lines.
// And where next: an odd step comes through all of the table; a large one for large blocks, which may be full.
#ifdef IR_CPU
#define IR_OCTREE_BLOCK 3u  // bits of a coordinate within one
#define IR_OCTREE_STEP 137u
#else
#define IR_OCTREE_BLOCK 1u
#define IR_OCTREE_STEP 9u
#endif
IR_FN uint octree_home(uint level, uint x, uint y, uint z, uint mask) {
    uint h = (x >> IR_OCTREE_BLOCK) * 0x9e3779b1u + (y >> IR_OCTREE_BLOCK) * 0x85ebca77u +
             (z >> IR_OCTREE_BLOCK) * 0xc2b2ae3du + level * 0x27d4eb2fu;
    h = (h ^ (h >> 15)) * 0x2c1b3c6du;
    h = (h ^ (h >> 12)) * 0x297a2d39u;
    h ^= h >> 15;
    const uint in_block = (1u << IR_OCTREE_BLOCK) - 1u;
    const uint place = (x & in_block) | ((y & in_block) << IR_OCTREE_BLOCK) | ((z & in_block) << (2u * IR_OCTREE_BLOCK));
    return ((h << (3u * IR_OCTREE_BLOCK)) | (place ^ (h >> (32u - 3u * IR_OCTREE_BLOCK)))) & mask;
}
IR_FN uint octree_probe(uint slot, uint mask) { return (slot + IR_OCTREE_STEP) & mask; }

// The node of a cell, or IR_NO_NODE.
IR_FN uint octree_find(IR_GLOBAL const uint* nodes, OctreeKey key, uint home, uint mask) {
    for (uint slot = home;; slot = octree_probe(slot, mask)) {
        IR_GLOBAL const uint* node = nodes + (size_t)IR_NODE_STRIDE * slot;
        if (node[0] == key.a && node[1] == key.b) return slot;
        if (node[0] == 0u) return IR_NO_NODE;
    }
}

IR_FN real3 octree_corner(const CacheParameters* c, float edge, uint x, uint y, uint z) {
    return make_real3(c->origin_x + (float)x * edge, c->origin_y + (float)y * edge, c->origin_z + (float)z * edge);
}
IR_FN float octree_edge(const CacheParameters* c, uint level) { return c->size / (float)(1u << level); }

#ifdef IR_OCTREE_INSERT  // ---------------------------------------------------------------- insertion (kernels only)
typedef struct OctreeMemory {
    volatile IR_GLOBAL uint* nodes;
    volatile IR_GLOBAL uint* entries;
    volatile IR_GLOBAL uint* state;  // OctreeState, as words
    uint mask, node_capacity, entry_capacity;  // node_capacity is less than the table, so that searches end
    uint again;                                // not 0: some of the records may have been entered already
} OctreeMemory;

// The node of a cell with lower corner lo, made if it is not there; IR_NO_NODE if the nodes are used up. Its two words
// are set one after the other: whoever sets the second one has made the node, and any other cell that shares the first
// looks on.
IR_FN uint octree_make(const OctreeMemory* tree, OctreeKey key, uint home, real3 lo) {
    for (uint slot = home;; slot = octree_probe(slot, tree->mask)) {
        volatile IR_GLOBAL uint* node = tree->nodes + (size_t)IR_NODE_STRIDE * slot;
        uint a = node[0];
        if (a == 0u) {
            if (IR_ATOMIC_ADD(&tree->state[0], 1u) >= tree->node_capacity) {
                IR_ATOMIC_ADD(&tree->state[0], 0xffffffffu);
                tree->state[2] = 1u;
                return IR_NO_NODE;
            }
            a = IR_ATOMIC_CAS(node, 0u, key.a);
            if (a != 0u) IR_ATOMIC_ADD(&tree->state[0], 0xffffffffu);  // another was first
            else a = key.a;
        }
        if (a != key.a) continue;
        uint b = node[1];
        if (b == 0u) {
            b = IR_ATOMIC_CAS(node + 1, 0u, key.b);
            if (b == 0u) {
                node[IR_NODE_CORNER] = IR_AS_UINT(lo.x);
                node[IR_NODE_CORNER + 1u] = IR_AS_UINT(lo.y);
                node[IR_NODE_CORNER + 2u] = IR_AS_UINT(lo.z);
                return slot;
            }
        }
        if (b == key.b) return slot;
    }
}

// Sends for the head of a node's list, which is read next. Others may set it meanwhile: then that was in vain.
IR_FN void octree_send_for(const OctreeMemory* tree, uint node) {
    const uint head = tree->nodes[(size_t)IR_NODE_STRIDE * node + IR_NODE_HEAD];
    if (head != 0u) IR_PREFETCH(tree->entries + (size_t)2u * (head - 1u));
}

// Entries of one record that are its own: [first, end).
typedef struct OctreeEntries {
    uint first, end;
} OctreeEntries;

// Enters record into node's list at its place, or tells in the octree's state that the entries are used up. Lock-free: a
// lost race retries. If the record has no entries left `wanted` are taken, all that it is going to need: threads that took
// one each time would wait for one another.
IR_FN void octree_enter(const OctreeMemory* tree, uint node, uint record, OctreeEntries* own, uint wanted) {
    volatile IR_GLOBAL uint* link = &tree->nodes[(size_t)IR_NODE_STRIDE * node + IR_NODE_HEAD];
    for (;;) {
        uint next = *link;
        while (next != 0u && tree->entries[(size_t)2u * (next - 1u)] > record) {
            link = &tree->entries[(size_t)2u * (next - 1u) + 1u];
            next = *link;
        }
        if (next != 0u && tree->entries[(size_t)2u * (next - 1u)] == record) return;
        if (own->first == own->end) {
            own->first = IR_ATOMIC_ADD(&tree->state[1], wanted);
            own->end = own->first + wanted;
        }
        if (own->first >= tree->entry_capacity) {
            tree->state[2] = 1u;
            return;
        }
        tree->entries[(size_t)2u * own->first] = record;
        tree->entries[(size_t)2u * own->first + 1u] = next;
        IR_GLOBAL_FENCE();
        if (IR_ATOMIC_CAS(link, next, own->first + 1u) == next) {
            ++own->first;
            return;
        }
    }
}

// Squared distance from p to the cube with lower corner lo.
IR_FN float cube_distance_squared(real3 p, real3 lo, float edge) {
    const float dx = max(max(lo.x - p.x, p.x - lo.x - edge), 0.0f);
    const float dy = max(max(lo.y - p.y, p.y - lo.y - edge), 0.0f);
    const float dz = max(max(lo.z - p.z, p.z - lo.z - edge), 0.0f);
    return dx * dx + dy * dy + dz * dz;
}

typedef struct OctreePlace {
    uint x, y, z, slot;  // a cell, and where its node is or is looked for first
} OctreePlace;

// Enters record into the nodes of `count` cells of a level. In two rounds, so that memory is waited for once in each: the
// nodes, which have been sent for, and the heads of their lists.
IR_FN void octree_enter_cells(const OctreeMemory* tree, const CacheParameters* cache, uint level, OctreePlace* places,
                              uint count, uint record) {
    const float edge = octree_edge(cache, level);
    uint nodes = 0u;
    for (uint i = 0; i < count; ++i) {
        OctreePlace* c = &places[i];
        c->slot = octree_make(tree, octree_key(level, c->x, c->y, c->z), c->slot,
                              octree_corner(cache, edge, c->x, c->y, c->z));
        if (c->slot == IR_NO_NODE) continue;
        octree_send_for(tree, c->slot);
        ++nodes;
    }
    OctreeEntries own = {0u, 0u};
    for (uint i = 0; i < count; ++i)
        if (places[i].slot != IR_NO_NODE) octree_enter(tree, places[i].slot, record, &own, tree->again != 0u ? 1u : nodes);
}

// The cells of its level that a record's support may touch: [x0, x1] x [y0, y1] x [z0, z1], and what tells which of them do.
typedef struct OctreeReach {
    uint level, x0, y0, z0, x1, y1, z1;
    float edge, reach, slab;
} OctreeReach;

// Points far off the tangent plane are never covered (weights shrink along the normal as along support1), so that nodes
// which lie entirely farther than `thickness` from it are left out.
IR_FN OctreeReach octree_reach(const CacheParameters* cache, real3 p, real3 n, float support, float thickness) {
    OctreeReach r;
    r.level = octree_level(support, cache->size);
    r.edge = octree_edge(cache, r.level);
    const uint shift = IR_OCTREE_MAX_DEPTH - r.level;
    // The bounds are widened by a rounding allowance: a look-up computes its own coordinates of nearby points.
    r.reach = support * 1.0001f + cache->coordinate * 1e-6f;
    r.x0 = octree_coordinate(p.x - r.reach, cache->origin_x, cache->size) >> shift;
    r.y0 = octree_coordinate(p.y - r.reach, cache->origin_y, cache->size) >> shift;
    r.z0 = octree_coordinate(p.z - r.reach, cache->origin_z, cache->size) >> shift;
    r.x1 = octree_coordinate(p.x + r.reach, cache->origin_x, cache->size) >> shift;
    r.y1 = octree_coordinate(p.y + r.reach, cache->origin_y, cache->size) >> shift;
    r.z1 = octree_coordinate(p.z + r.reach, cache->origin_z, cache->size) >> shift;
    r.slab = 0.5f * r.edge * (fabs(n.x) + fabs(n.y) + fabs(n.z)) + thickness * 1.0001f + cache->coordinate * 1e-6f;
    return r;
}

IR_FN bool octree_touches(const CacheParameters* cache, const OctreeReach* r, real3 p, real3 n, uint x, uint y, uint z) {
    const real3 lo = octree_corner(cache, r->edge, x, y, z);
    const float half_edge = 0.5f * r->edge;
    const real3 middle = lo + make_real3(half_edge, half_edge, half_edge);
    return fabs(dot(middle - p, n)) <= r->slab && cube_distance_squared(p, lo, r->edge) <= r->reach * r->reach;
}

// A cell joins those that are to be entered, if it is touched.
IR_FN void octree_add_place(const OctreeMemory* tree, const CacheParameters* cache, const OctreeReach* r, real3 p, real3 n,
                            uint record, uint x, uint y, uint z, OctreePlace* places, uint* count) {
    if (!octree_touches(cache, r, p, n, x, y, z)) return;
    if (*count == IR_OCTREE_CELLS) {
        octree_enter_cells(tree, cache, r->level, places, *count, record);
        *count = 0u;
    }
    OctreePlace* c = &places[(*count)++];
    c->x = x, c->y = y, c->z = z;
    c->slot = octree_home(r->level, x, y, z, tree->mask);
    IR_PREFETCH_OWN(tree->nodes + (size_t)IR_NODE_STRIDE * c->slot);
}

// Enters record (position p, normal n, support) into every node of its level that its support reaches. On GPUs every
// work-item `lane` of IR_INSERT_LANES takes some of the cells: their nodes are waited for at the same time.
IR_ONCE_FN void octree_insert(const OctreeMemory* tree, CacheParameters cache, uint record, real3 p, real3 n,
                              float support, float thickness, uint lane) {
    const OctreeReach r = octree_reach(&cache, p, n, support, thickness);
    OctreePlace places[IR_OCTREE_CELLS];
    uint count = 0u;
#ifdef IR_CPU
    for (uint z = r.z0; z <= r.z1; ++z)
        for (uint y = r.y0; y <= r.y1; ++y)
            for (uint x = r.x0; x <= r.x1; ++x)
                octree_add_place(tree, &cache, &r, p, n, record, x, y, z, places, &count);
#else
    const uint wide = r.x1 - r.x0 + 1u, high = r.y1 - r.y0 + 1u, cells = wide * high * (r.z1 - r.z0 + 1u);
    for (uint i = lane; i < cells; i += IR_INSERT_LANES)
        octree_add_place(tree, &cache, &r, p, n, record, r.x0 + i % wide, r.y0 + i / wide % high, r.z0 + i / (wide * high),
                         places, &count);
#endif
    octree_enter_cells(tree, &cache, r.level, places, count, record);
    if (lane == 0u) IR_ATOMIC_OR(&tree->state[3], 1u << r.level);
}
#endif
#endif
