// The octree of records on the device. A record is entered into every node of one level that its support touches, the
// level where a node's edge lies between one and two support radii; a look-up then walks one path from the root and
// sees every record that can reach the point (octree_walk.h). Nodes and list entries are handed out by atomic counters; when either
// array is full the host grows it and runs the insertion again (entering twice is harmless).
//
// Lists are kept in descending order of record index, whatever the order in which work-items get to run, so that
// look-ups add in the same order on every run and every number of threads: same seed, same bytes.
#ifndef IR_OCTREE_H
#define IR_OCTREE_H
#include "irradia/shared/record_types.h"
#include "portable.h"

// A node is IR_NODE_STRIDE words, one cache line:
//     0 to 7     its children, or 0
//     8          head of its list, or 0
//     9, 10      the packed part that follows the list (packed.h): first entry, number of entries
//     12 to 15   floats: its lower corner; IR_PACKED_STEPS / its edge
// Entries: entries[2 e] = record, entries[2 e + 1] = next; an entry's reference is e + 1, 0 ends a list.
#define IR_NODE_STRIDE 16u
#define IR_NODE_HEAD 8u
#define IR_NODE_PACKED 9u
#define IR_NODE_PLACE 12u
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

#ifdef IR_OCTREE_INSERT  // ---------------------------------------------------------------- insertion (kernels only)
typedef struct OctreeMemory {
    volatile IR_GLOBAL uint* nodes;
    volatile IR_GLOBAL uint* entries;
    volatile IR_GLOBAL uint* state;  // OctreeState, as words
    uint node_capacity, entry_capacity;
} OctreeMemory;

// Child c of node, made if it is not there; 0 if the nodes are used up. lo, edge: the child's place.
IR_FN uint octree_child(const OctreeMemory* tree, uint node, uint c, real3 lo, float edge) {
    volatile IR_GLOBAL uint* slot = &tree->nodes[(size_t)IR_NODE_STRIDE * node + c];
    const uint child = *slot;
    if (child != 0u) return child;
    const uint fresh = IR_ATOMIC_ADD(&tree->state[0], 1u);
    if (fresh >= tree->node_capacity) {
        tree->state[2] = 1u;
        return 0u;
    }
    // A node that loses the race stays unused: its words are zero and nothing refers to it.
    const uint winner = IR_ATOMIC_CAS(slot, 0u, fresh);
    if (winner != 0u) return winner;
    volatile IR_GLOBAL uint* place = &tree->nodes[(size_t)IR_NODE_STRIDE * fresh + IR_NODE_PLACE];
    place[0] = IR_AS_UINT(lo.x);
    place[1] = IR_AS_UINT(lo.y);
    place[2] = IR_AS_UINT(lo.z);
    place[3] = IR_AS_UINT(IR_PACKED_STEPS / edge);
    return fresh;
}

// Enters record into node's list at its place; returns 0 if the entries are used up. Lock-free: a lost race retries.
IR_FN uint octree_enter(const OctreeMemory* tree, uint node, uint record) {
    uint entry = 0xffffffffu;
    volatile IR_GLOBAL uint* link = &tree->nodes[(size_t)IR_NODE_STRIDE * node + IR_NODE_HEAD];
    for (;;) {
        uint next = *link;
        while (next != 0u && tree->entries[(size_t)2u * (next - 1u)] > record) {
            link = &tree->entries[(size_t)2u * (next - 1u) + 1u];
            next = *link;
        }
        if (next != 0u && tree->entries[(size_t)2u * (next - 1u)] == record) return 1u;
        if (entry == 0xffffffffu) {
            entry = IR_ATOMIC_ADD(&tree->state[1], 1u);
            if (entry >= tree->entry_capacity) {
                tree->state[2] = 1u;
                return 0u;
            }
            tree->entries[(size_t)2u * entry] = record;
        }
        tree->entries[(size_t)2u * entry + 1u] = next;
        IR_GLOBAL_FENCE();
        if (IR_ATOMIC_CAS(link, next, entry + 1u) == next) return 1u;
    }
}

// Squared distance from p to the cube with lower corner lo.
IR_FN float cube_distance_squared(real3 p, real3 lo, float edge) {
    const float dx = max(max(lo.x - p.x, p.x - lo.x - edge), 0.0f);
    const float dy = max(max(lo.y - p.y, p.y - lo.y - edge), 0.0f);
    const float dz = max(max(lo.z - p.z, p.z - lo.z - edge), 0.0f);
    return dx * dx + dy * dy + dz * dz;
}

// Enters record (position p, normal n, support) into every node of its level that its support reaches. Points far off
// the tangent plane are never covered (weights shrink along the normal as along support1), so that nodes which lie
// entirely farther than `thickness` from it are left out.
IR_FN void octree_insert(const OctreeMemory* tree, CacheParameters cache, uint record, real3 p, real3 n, float support,
                         float thickness) {
    const uint level = octree_level(support, cache.size);
    const uint shift = IR_OCTREE_MAX_DEPTH - level;
    const float edge = cache.size / (float)(1u << level);
    // The bounds are widened by a rounding allowance: a look-up computes its own coordinates of nearby points.
    const float reach = support * 1.0001f + cache.coordinate * 1e-6f;
    const uint x0 = octree_coordinate(p.x - reach, cache.origin_x, cache.size) >> shift;
    const uint y0 = octree_coordinate(p.y - reach, cache.origin_y, cache.size) >> shift;
    const uint z0 = octree_coordinate(p.z - reach, cache.origin_z, cache.size) >> shift;
    const uint x1 = octree_coordinate(p.x + reach, cache.origin_x, cache.size) >> shift;
    const uint y1 = octree_coordinate(p.y + reach, cache.origin_y, cache.size) >> shift;
    const uint z1 = octree_coordinate(p.z + reach, cache.origin_z, cache.size) >> shift;
    const float slab =
        0.5f * edge * (fabs(n.x) + fabs(n.y) + fabs(n.z)) + thickness * 1.0001f + cache.coordinate * 1e-6f;
    for (uint z = z0; z <= z1; ++z)
        for (uint y = y0; y <= y1; ++y)
            for (uint x = x0; x <= x1; ++x) {
                const real3 lo = make_real3(cache.origin_x + (float)x * edge, cache.origin_y + (float)y * edge,
                                            cache.origin_z + (float)z * edge);
                const float half_edge = 0.5f * edge;
                const real3 middle = lo + make_real3(half_edge, half_edge, half_edge);
                if (fabs(dot(middle - p, n)) > slab) continue;
                if (cube_distance_squared(p, lo, edge) > reach * reach) continue;
                uint node = 0u;
                bool room = true;
                for (uint l = level; room && l > 0u; --l) {
                    const uint cx = x >> (l - 1u), cy = y >> (l - 1u), cz = z >> (l - 1u);
                    const float e = edge * (float)(1u << (l - 1u));
                    node = octree_child(tree, node, (cx & 1u) | ((cy & 1u) << 1) | ((cz & 1u) << 2),
                                        make_real3(cache.origin_x + (float)cx * e, cache.origin_y + (float)cy * e,
                                                   cache.origin_z + (float)cz * e),
                                        e);
                    room = node != 0u;
                }
                if (room) octree_enter(tree, node, record);
            }
    IR_ATOMIC_MAX(&tree->state[3], level);
}
#endif
#endif
