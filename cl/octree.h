// The octree of records on the device. A record is entered into every node of one level that its support touches, the
// level where a node's edge lies between one and two support radii; a look-up then walks one path from the root and
// sees every record that can reach the point. Nodes and list entries are handed out by atomic counters; when either
// array is full the host grows it and runs the insertion again (entering twice is harmless).
//
// Lists are kept in descending order of record index, whatever the order in which work-items get to run, so that
// look-ups add in the same order on every run and every number of threads: same seed, same bytes.
#ifndef IR_OCTREE_H
#define IR_OCTREE_H
#include "irradia/shared/record_types.h"
#include "portable.h"

// Nodes: nodes[9 i + c], c < 8 = child node or 0; nodes[9 i + 8] = head of the node's list or 0.
// Entries: entries[2 e] = record, entries[2 e + 1] = next; an entry's reference is e + 1, 0 ends a list.
#define IR_NODE_STRIDE 9u
#define IR_NODE_HEAD 8u

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

// A walk down the one path of nodes that hold p, over all records entered in them:
//     OctreeWalk walk = octree_walk(nodes, &parameters, p);
//     while (octree_next(nodes, entries, &walk, &record)) ...
typedef struct OctreeWalk {
    uint x, y, z;  // of p, at the deepest level
    uint node, level, link;
} OctreeWalk;

IR_FN OctreeWalk octree_walk(IR_GLOBAL const uint* nodes, const CacheParameters* cache, real3 p) {
    OctreeWalk walk;
    walk.x = octree_coordinate(p.x, cache->origin_x, cache->size);
    walk.y = octree_coordinate(p.y, cache->origin_y, cache->size);
    walk.z = octree_coordinate(p.z, cache->origin_z, cache->size);
    walk.node = walk.level = 0u;
    walk.link = nodes[IR_NODE_HEAD];
    return walk;
}

IR_FN bool octree_next(IR_GLOBAL const uint* nodes, IR_GLOBAL const uint* entries, OctreeWalk* walk, uint* record) {
    while (walk->link == 0u) {
        if (walk->level == IR_OCTREE_MAX_DEPTH) return false;
        const uint shift = IR_OCTREE_MAX_DEPTH - 1u - walk->level++;
        const uint child =
            ((walk->x >> shift) & 1u) | (((walk->y >> shift) & 1u) << 1) | (((walk->z >> shift) & 1u) << 2);
        walk->node = nodes[IR_NODE_STRIDE * walk->node + child];
        if (walk->node == 0u) return false;
        walk->link = nodes[IR_NODE_STRIDE * walk->node + IR_NODE_HEAD];
    }
    *record = entries[2u * (walk->link - 1u)];
    walk->link = entries[2u * (walk->link - 1u) + 1u];
    return true;
}

#ifdef IR_OCTREE_INSERT  // ---------------------------------------------------------------- insertion (kernels only)
typedef struct OctreeMemory {
    volatile IR_GLOBAL uint* nodes;
    volatile IR_GLOBAL uint* entries;
    volatile IR_GLOBAL uint* state;  // OctreeState, as words
    uint node_capacity, entry_capacity;
} OctreeMemory;

// Child c of node, made if it is not there; 0 if the nodes are used up.
IR_FN uint octree_child(const OctreeMemory* tree, uint node, uint c) {
    volatile IR_GLOBAL uint* slot = &tree->nodes[IR_NODE_STRIDE * node + c];
    const uint child = *slot;
    if (child != 0u) return child;
    const uint fresh = IR_ATOMIC_ADD(&tree->state[0], 1u);
    if (fresh >= tree->node_capacity) {
        tree->state[2] = 1u;
        return 0u;
    }
    // A node that loses the race stays unused: its words are zero and nothing refers to it.
    const uint winner = IR_ATOMIC_CAS(slot, 0u, fresh);
    return winner == 0u ? fresh : winner;
}

// Enters record into node's list at its place; returns 0 if the entries are used up. Lock-free: a lost race retries.
IR_FN uint octree_enter(const OctreeMemory* tree, uint node, uint record) {
    uint entry = 0xffffffffu;
    volatile IR_GLOBAL uint* link = &tree->nodes[IR_NODE_STRIDE * node + IR_NODE_HEAD];
    for (;;) {
        uint next = *link;
        while (next != 0u && tree->entries[2u * (next - 1u)] > record) {
            link = &tree->entries[2u * (next - 1u) + 1u];
            next = *link;
        }
        if (next != 0u && tree->entries[2u * (next - 1u)] == record) return 1u;
        if (entry == 0xffffffffu) {
            entry = IR_ATOMIC_ADD(&tree->state[1], 1u);
            if (entry >= tree->entry_capacity) {
                tree->state[2] = 1u;
                return 0u;
            }
            tree->entries[2u * entry] = record;
        }
        tree->entries[2u * entry + 1u] = next;
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
IR_ONCE_FN void octree_insert(const OctreeMemory* tree, CacheParameters cache, uint record, real3 p, real3 n,
                              float support, float thickness) {
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
                    const uint c =
                        ((x >> (l - 1u)) & 1u) | (((y >> (l - 1u)) & 1u) << 1) | (((z >> (l - 1u)) & 1u) << 2);
                    node = octree_child(tree, node, c);
                    room = node != 0u;
                }
                if (room) octree_enter(tree, node, record);
            }
    IR_ATOMIC_MAX(&tree->state[3], level);
}
#endif
#endif
