// A walk down the one path of nodes that hold a point, over the records entered in them that a question may be about:
//     OctreeWalk walk = octree_walk(&octree, &parameters, query);
//     while (octree_next(&octree, &walk, &record)) ...
// A node's list, which holds what came since the octree was packed, is met whole; then come those of its packed part that
// answer yes. They are met in the order of today's and all former lists: from the root down, of a node the newest first.
#ifndef IR_OCTREE_WALK_H
#define IR_OCTREE_WALK_H
#include "packed.h"

typedef struct Octree {
    IR_GLOBAL const uint *nodes, *entries, *packed;
    IR_GLOBAL const RecordKey* keys;
    IR_GLOBAL const RecordValue* values;  // fetched ahead for those met; 0: not
} Octree;

// CPU devices collect some records before they are looked at, so that all of them are on their way from memory at once.
#if IR_LANES == 8u
#define IR_WALK_AHEAD 16u
#endif

typedef struct OctreeWalk {
    PackedQuery query;
    NodeQuery place;  // the query in the node's steps
    uint x, y, z;     // of p, at the deepest level
    uint node, level, link;
    uint at, end;  // of the node's packed part
#ifdef IR_WALK_AHEAD
    uint count, taken, met[IR_WALK_AHEAD + 8u];
#endif
} OctreeWalk;

IR_FN void octree_visit(const Octree* tree, OctreeWalk* walk) {
    IR_GLOBAL const uint* node = tree->nodes + (size_t)IR_NODE_STRIDE * walk->node;
    walk->link = node[IR_NODE_HEAD];
    walk->at = node[IR_NODE_PACKED];
    walk->end = walk->at + node[IR_NODE_PACKED + 1u];
    // The child is on its way while this node's records are looked at.
    walk->node = 0u;
    if (walk->level < IR_OCTREE_MAX_DEPTH) {
        const uint shift = IR_OCTREE_MAX_DEPTH - 1u - walk->level++;
        const uint child =
            ((walk->x >> shift) & 1u) | (((walk->y >> shift) & 1u) << 1) | (((walk->z >> shift) & 1u) << 2);
        walk->node = node[child];
        if (walk->node != 0u) IR_PREFETCH(tree->nodes + (size_t)IR_NODE_STRIDE * walk->node);
    }
    if (walk->at == walk->end) return;
    const real3 lo = make_real3(IR_AS_FLOAT(node[IR_NODE_PLACE]), IR_AS_FLOAT(node[IR_NODE_PLACE + 1u]),
                                IR_AS_FLOAT(node[IR_NODE_PLACE + 2u]));
    walk->place = node_query(&walk->query, lo, IR_AS_FLOAT(node[IR_NODE_PLACE + 3u]));
}

IR_FN OctreeWalk octree_walk(const Octree* tree, const CacheParameters* cache, PackedQuery query) {
    OctreeWalk walk;
    walk.query = query;
    walk.x = octree_coordinate(query.p.x, cache->origin_x, cache->size);
    walk.y = octree_coordinate(query.p.y, cache->origin_y, cache->size);
    walk.z = octree_coordinate(query.p.z, cache->origin_z, cache->size);
    walk.node = walk.level = 0u;
#ifdef IR_WALK_AHEAD
    walk.count = walk.taken = 0u;
#endif
    octree_visit(tree, &walk);
    return walk;
}

#ifdef IR_WALK_AHEAD
IR_FN void octree_meet(const Octree* tree, OctreeWalk* walk, uint record) {
    IR_GLOBAL const char* key = (IR_GLOBAL const char*)&tree->keys[record];
    IR_PREFETCH(key);
    IR_PREFETCH(key + sizeof(RecordKey) - 1u);
    if (tree->values) {
        IR_GLOBAL const char* value = (IR_GLOBAL const char*)&tree->values[record];
        IR_PREFETCH(value);
        IR_PREFETCH(value + sizeof(RecordValue) - 1u);
    }
    walk->met[walk->count++] = record;
}

// The next records, at least IR_WALK_AHEAD of them if there are as many; none at the walk's end.
IR_FN void octree_collect(const Octree* tree, OctreeWalk* walk) {
    walk->count = walk->taken = 0u;
    for (;;) {
        while (walk->link != 0u) {
            if (walk->count >= IR_WALK_AHEAD) return;
            IR_GLOBAL const uint* entry = tree->entries + (size_t)2u * (walk->link - 1u);
            octree_meet(tree, walk, entry[0]);
            walk->link = entry[1];
        }
        while (walk->at < walk->end) {
            if (walk->count >= IR_WALK_AHEAD) return;
            IR_GLOBAL const uint* entry = tree->packed + (size_t)IR_PACKED_WORDS * walk->at;
            ulong yes = packed_test(entry, &walk->query, &walk->place);
            const uint left = walk->end - walk->at;
            if (left < 8u) yes &= (1ul << (8u * left)) - 1ul;
            for (; yes; yes &= yes - 1ul)
                octree_meet(tree, walk, entry[IR_PACKED_WORDS * packed_first(yes) + 3u]);
            walk->at += 8u;
        }
        if (walk->node == 0u) return;
        octree_visit(tree, walk);
    }
}

IR_FN bool octree_next(const Octree* tree, OctreeWalk* walk, uint* record) {
    if (walk->taken == walk->count) {
        octree_collect(tree, walk);
        if (walk->count == 0u) return false;
    }
    *record = walk->met[walk->taken++];
    return true;
}
#else
IR_FN bool octree_next(const Octree* tree, OctreeWalk* walk, uint* record) {
    for (;;) {
        if (walk->link != 0u) {
            IR_GLOBAL const uint* entry = tree->entries + (size_t)2u * (walk->link - 1u);
            *record = entry[0];
            walk->link = entry[1];
            return true;
        }
        while (walk->at < walk->end) {
            IR_GLOBAL const uint* entry = tree->packed + (size_t)IR_PACKED_WORDS * walk->at++;
            if (!packed_test(entry, &walk->query, &walk->place)) continue;
            *record = entry[3];
            return true;
        }
        if (walk->node == 0u) return false;
        octree_visit(tree, walk);
    }
}
#endif
#endif
