// A walk over the cells that hold a point, from the root down, and the records entered in them that a question may be about:
//     OctreeWalk walk = octree_walk(&parameters, query);
//     while (octree_next(&octree, &parameters, &walk, &record)) ...
// A node's list, which holds what came since the octree was packed, is met whole; then come those of its packed part that
// answer yes. So records come in the order that all lists would give: of a node the newest first.
#ifndef IR_OCTREE_WALK_H
#define IR_OCTREE_WALK_H
#include "packed.h"

typedef struct Octree {
    IR_GLOBAL const uint *nodes, *entries, *packed;
    uint mask;  // number of nodes in the table, less one
    IR_GLOBAL const RecordKey* keys;
    IR_GLOBAL const RecordValue* values;
} Octree;

// CPU devices collect some records before they are looked at, so that memory is waited for once for many.
#if IR_LANES == 8u
#define IR_WALK_AHEAD 16u
#endif

typedef struct OctreeWalk {
    PackedQuery query;
    NodeQuery place;  // the query in the node's steps
    uint link, at, end;  // of the node's list; of its packed part
    uint x, y, z;  // of p, at the deepest level
    uint levels;   // still to be asked
#ifdef IR_WALK_AHEAD
    uint node, node_count, nodes[IR_OCTREE_MAX_DEPTH + 1u], node_levels[IR_OCTREE_MAX_DEPTH + 1u];  // found already
    uint ahead;  // records to collect at a time
    uint count, taken, met[IR_WALK_AHEAD + 8u];
#endif
} OctreeWalk;

// The cell of a level that holds the point, at the deepest level (x, y, z): where its node is looked for first, and its key.
IR_FN uint octree_home_at(uint level, uint x, uint y, uint z, uint mask, OctreeKey* key) {
    const uint shift = IR_OCTREE_MAX_DEPTH - level;
    *key = octree_key(level, x >> shift, y >> shift, z >> shift);
    return octree_home(level, x >> shift, y >> shift, z >> shift, mask);
}

IR_FN void octree_enter_node(const Octree* tree, const CacheParameters* cache, OctreeWalk* walk, uint node, uint level) {
    IR_GLOBAL const uint* n = tree->nodes + (size_t)IR_NODE_STRIDE * node;
    walk->link = n[IR_NODE_HEAD];
    walk->at = n[IR_NODE_PACKED];
    walk->end = walk->at + n[IR_NODE_PACKED + 1u];
    const real3 lo = make_real3(IR_AS_FLOAT(n[IR_NODE_CORNER]), IR_AS_FLOAT(n[IR_NODE_CORNER + 1u]),
                                IR_AS_FLOAT(n[IR_NODE_CORNER + 2u]));
    walk->place = node_query(&walk->query, lo, packed_scale(octree_edge(cache, level)));
}

IR_FN OctreeWalk octree_walk(const CacheParameters* cache, PackedQuery query) {
    OctreeWalk walk;
    walk.query = query;
    walk.x = octree_coordinate(query.p.x, cache->origin_x, cache->size);
    walk.y = octree_coordinate(query.p.y, cache->origin_y, cache->size);
    walk.z = octree_coordinate(query.p.z, cache->origin_z, cache->size);
    walk.link = walk.at = walk.end = 0u;
    walk.levels = cache->levels;
#ifdef IR_WALK_AHEAD
    walk.node = walk.node_count = walk.count = walk.taken = 0u;
    walk.ahead = 1u;
#endif
    return walk;
}

// On to the next level in use; false if there is none.
IR_FN bool octree_descend(const Octree* tree, const CacheParameters* cache, OctreeWalk* walk) {
    if (walk->levels == 0u) return false;
    const uint level = lowest_bit(walk->levels);
    walk->levels &= walk->levels - 1u;
    OctreeKey key;
    const uint home = octree_home_at(level, walk->x, walk->y, walk->z, tree->mask, &key);
    const uint node = octree_find(tree->nodes, key, home, tree->mask);
    if (node != IR_NO_NODE) octree_enter_node(tree, cache, walk, node, level);
    return true;
}

#ifdef IR_WALK_AHEAD
// All nodes at once, and their records in numbers: for walks that mostly go on to their end.
IR_FN void octree_look_ahead(const Octree* tree, OctreeWalk* walk) {
    OctreeKey keys[IR_OCTREE_MAX_DEPTH + 1u];
    uint homes[IR_OCTREE_MAX_DEPTH + 1u], count = 0u;
    for (; walk->levels != 0u; walk->levels &= walk->levels - 1u) {
        const uint level = lowest_bit(walk->levels);
        walk->node_levels[count] = level;
        homes[count] = octree_home_at(level, walk->x, walk->y, walk->z, tree->mask, &keys[count]);
        IR_PREFETCH(tree->nodes + (size_t)IR_NODE_STRIDE * homes[count]);
        ++count;
    }
    for (uint i = 0; i < count; ++i) {
        const uint node = octree_find(tree->nodes, keys[i], homes[i], tree->mask);
        if (node == IR_NO_NODE) continue;
        IR_GLOBAL const uint* n = tree->nodes + (size_t)IR_NODE_STRIDE * node;
        IR_GLOBAL const uint* first = tree->packed + (size_t)IR_PACKED_WORDS * n[IR_NODE_PACKED];
        const uint words = min(IR_PACKED_WORDS * n[IR_NODE_PACKED + 1u], 8u * 16u);  // what comes later is fetched in time
        for (uint at = 0; at < words; at += 16u) IR_PREFETCH(first + at);
        walk->nodes[walk->node_count] = node;
        walk->node_levels[walk->node_count++] = walk->node_levels[i];
    }
    walk->ahead = IR_WALK_AHEAD;
}

IR_FN void octree_meet(const Octree* tree, OctreeWalk* walk, uint record) {
    IR_GLOBAL const char* key = (IR_GLOBAL const char*)&tree->keys[record];
    IR_PREFETCH(key);
    IR_PREFETCH(key + sizeof(RecordKey) - 1u);
    walk->met[walk->count++] = record;
}

// The next records, at least `ahead` of them if there are as many; none at the walk's end.
IR_FN void octree_collect(const Octree* tree, const CacheParameters* cache, OctreeWalk* walk) {
    walk->count = walk->taken = 0u;
    for (;;) {
        while (walk->link != 0u) {
            if (walk->count >= walk->ahead) return;
            IR_GLOBAL const uint* entry = tree->entries + (size_t)2u * (walk->link - 1u);
            octree_meet(tree, walk, entry[0]);
            walk->link = entry[1];
        }
        while (walk->at < walk->end) {
            if (walk->count >= walk->ahead) return;
            IR_GLOBAL const uint* entry = tree->packed + (size_t)IR_PACKED_WORDS * walk->at;
            ulong yes = packed_test(entry, &walk->query, &walk->place);
            const uint left = walk->end - walk->at;
            if (left < 8u) yes &= (1ul << (8u * left)) - 1ul;
            for (; yes; yes &= yes - 1ul)
                octree_meet(tree, walk, entry[IR_PACKED_WORDS * packed_first(yes) + 3u]);
            walk->at += 8u;
        }
        if (walk->node < walk->node_count) {
            octree_enter_node(tree, cache, walk, walk->nodes[walk->node], walk->node_levels[walk->node]);
            ++walk->node;
        } else if (!octree_descend(tree, cache, walk)) {
            return;
        }
    }
}

IR_FN bool octree_next(const Octree* tree, const CacheParameters* cache, OctreeWalk* walk, uint* record) {
    if (walk->taken == walk->count) {
        octree_collect(tree, cache, walk);
        if (walk->count == 0u) return false;
    }
    *record = walk->met[walk->taken++];
    return true;
}
#else
#define IR_NO_RECORD 0xffffffffu

// One entry further, or one node; *record: what is to be looked at, or IR_NO_RECORD. False at the end. GPUs look records up
// by such steps: neighbouring work-items mostly ask the same nodes and meet their entries together. If each went on to
// its own next record, all would wait every time for the one that has to go farthest.
IR_FN bool octree_step(const Octree* tree, const CacheParameters* cache, OctreeWalk* walk, uint* record) {
    *record = IR_NO_RECORD;
    if (walk->link != 0u) {
        IR_GLOBAL const uint* entry = tree->entries + (size_t)2u * (walk->link - 1u);
        *record = entry[0];
        walk->link = entry[1];
        return true;
    }
    if (walk->at < walk->end) {
        const PackedEntry entry = ((IR_GLOBAL const PackedEntry*)tree->packed)[walk->at++];
        if (packed_test(&entry, &walk->query, &walk->place)) *record = entry.record;
        return true;
    }
    return octree_descend(tree, cache, walk);
}

IR_FN bool octree_next(const Octree* tree, const CacheParameters* cache, OctreeWalk* walk, uint* record) {
    while (octree_step(tree, cache, walk, record))
        if (*record != IR_NO_RECORD) return true;
    return false;
}
#endif
#endif
