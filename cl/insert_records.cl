// Stage 3 of an iteration: new records limit and are limited by their neighbours (theory 4.4), then enter the octree.
// Three launches, because each must see all of the previous one's results: so the outcome is the same whatever the order
// of work-items. Both of clamping are one kernel's, which is compiled once.
#define IR_OCTREE_INSERT
#include "cache.h"
#include "radius.h"

// A record that the octree knows and that is near a new one and faces the same way is limited by it.
IR_FN void limit_neighbour(IR_GLOBAL RecordKey* keys, uint j, const RecordKey* own, float slope) {
    const float reach =
        slope * length(make_real3(own->px, own->py, own->pz) - make_real3(keys[j].px, keys[j].py, keys[j].pz));
    // Positive floats order like their bits.
    IR_ATOMIC_MIN((IR_GLOBAL uint*)&keys[j].support1, IR_AS_UINT(own->support1 + reach));
    IR_ATOMIC_MIN((IR_GLOBAL uint*)&keys[j].support2, IR_AS_UINT(own->support2 + reach));
}

// support_i <= support_j + slope |p_i - p_j| for every record j that the octree knows near the new record i and that faces
// the same way: shrinks i. Leaves in `near_i` what i may shrink in turn, with old_slope: their number, and the first
// IR_CLAMP_WORDS - 1 of them.
IR_ONCE_FN void clamp_to_neighbours(const Cache* c, IR_GLOBAL RecordKey* keys, uint i, float slope, float old_slope,
                                    float least, IR_GLOBAL uint* near_i) {
    const RecordKey own = keys[i];
    const real3 p = make_real3(own.px, own.py, own.pz), n = make_real3(own.nx, own.ny, own.nz);
    float s1 = own.support1, s2 = own.support2;
    const float lowest = min(least, own.support1);  // i shrinks no further
    uint j, found = 0u;
    // A record j farther away than support_i / slope cannot shrink i, nor i a record j that reaches less far than
    // support_i + old_slope |p_i - p_j|.
    PackedQuery query = packed_query(p, n, 1.0f / old_slope, -lowest / old_slope, 0.9f);
    query.least = 1.0001f * max(s1, s2) / slope;
    OctreeWalk walk = octree_walk(&c->parameters, query);
#ifdef IR_WALK_AHEAD
    octree_look_ahead(&c->octree, &walk);
#endif
    while (octree_next(&c->octree, &c->parameters, &walk, &j)) {
        if (dot(n, make_real3(keys[j].nx, keys[j].ny, keys[j].nz)) < 0.9f) continue;
        const float distance = length(p - make_real3(keys[j].px, keys[j].py, keys[j].pz));
        s1 = neighbour_clamped_radius(s1, keys[j].support1, slope * distance);
        s2 = neighbour_clamped_radius(s2, keys[j].support2, slope * distance);
        if (lowest + old_slope * distance < max(keys[j].support1, keys[j].support2) && ++found < IR_CLAMP_WORDS)
            near_i[found] = j;
    }
    near_i[0] = found;
    keys[i].support1 = max(s1, lowest);
    keys[i].support2 = max(s2, keys[i].support1);
}

// The same the other way round, once all new records have shrunk: shrinks what clamp_to_neighbours left in `near_i`, or, if
// that was too much, all that the octree knows.
IR_ONCE_FN void limit_neighbours(const Cache* c, IR_GLOBAL RecordKey* keys, uint i, float slope,
                                 IR_GLOBAL const uint* near_i) {
    const RecordKey own = keys[i];
    const uint found = near_i[0];
    uint j;
    if (found < IR_CLAMP_WORDS) {
        for (uint at = 1u; at <= found; ++at) IR_PREFETCH_OWN(&keys[near_i[at]]);
        for (uint at = 1u; at <= found; ++at) limit_neighbour(keys, near_i[at], &own, slope);
        return;
    }
    const real3 n = make_real3(own.nx, own.ny, own.nz);
    OctreeWalk walk = octree_walk(&c->parameters, packed_query(make_real3(own.px, own.py, own.pz), n, 1.0f / slope,
                                                               -own.support1 / slope, 0.9f));
    while (octree_next(&c->octree, &c->parameters, &walk, &j))
        if (!(dot(n, make_real3(keys[j].nx, keys[j].ny, keys[j].nz)) < 0.9f)) limit_neighbour(keys, j, &own, slope);
}

// Of each new record, or of the old ones around it.
IR_KERNEL void clamp_records(IR_OCTREE_ARGS, IR_GLOBAL RecordKey* record_keys, CacheParameters cache_parameters,
                             IR_GLOBAL const ShadingPoint* points, IR_GLOBAL const uint* stack, IR_GLOBAL uint* near_records,
                             float slope, float min_spacing, uint limit_old, uint first_record, uint count) {
    if (IR_GLOBAL_ID >= count) return;
    IR_GLOBAL const RecordValue* const record_values = 0;  // only keys matter
    IR_CACHE_INIT(c);
    IR_GLOBAL const ShadingPoint* q = points + stack[IR_GLOBAL_ID];
    // Of a narrow place its neighbours may cover no more than is as near as what makes it narrow.
    const float old_slope = q->least > 0.0f ? min(slope, 1.0f) : slope;
    IR_GLOBAL uint* near_i = near_records + (size_t)IR_CLAMP_WORDS * IR_GLOBAL_ID;
    if (limit_old != 0u)
        limit_neighbours(&c, record_keys, first_record + IR_GLOBAL_ID, old_slope, near_i);
    else
        clamp_to_neighbours(&c, record_keys, first_record + IR_GLOBAL_ID, slope, old_slope, min_spacing * q->footprint,
                            near_i);
}

// On CPU devices one work-item a record, on GPUs IR_INSERT_LANES.
IR_KERNEL void insert_records(IR_GLOBAL uint* octree_nodes, IR_GLOBAL uint* octree_entries, IR_GLOBAL uint* octree_state,
                              uint octree_mask, IR_GLOBAL const RecordKey* record_keys,
                              CacheParameters cache_parameters, uint node_capacity, uint entry_capacity, uint again,
                              uint first_record, uint count) {
#ifdef IR_CPU
    const uint item = IR_GLOBAL_ID, lane = 0u;
#else
    const uint item = IR_GLOBAL_ID / IR_INSERT_LANES, lane = IR_GLOBAL_ID % IR_INSERT_LANES;
#endif
    if (item >= count) return;
    OctreeMemory tree;
    tree.nodes = octree_nodes;
    tree.entries = octree_entries;
    tree.state = octree_state;
    tree.mask = octree_mask;
    tree.node_capacity = node_capacity;
    tree.entry_capacity = entry_capacity;
    tree.again = again;
    const uint record = first_record + item;
    const RecordKey k = record_keys[record];
    octree_insert(&tree, cache_parameters, record, make_real3(k.px, k.py, k.pz), make_real3(k.nx, k.ny, k.nz), k.support2,
                  k.support1, lane);
}

#ifdef IR_CPU
#define IR_PACK_NODES IR_PACKED_PLACES
#else
#define IR_PACK_NODES 1u
#endif

// The node's list, of `listed` records, then what was packed of it before, to packed[first] and on; the list is empty then.
IR_FN void pack_node(IR_GLOBAL uint* node, uint listed, IR_GLOBAL const uint* octree_entries,
                     IR_GLOBAL const RecordKey* record_keys, const CacheParameters* cache_parameters,
                     IR_GLOBAL const uint* before, IR_GLOBAL uint* packed, uint first) {
    const uint old_first = node[IR_NODE_PACKED], old_count = node[IR_NODE_PACKED + 1u];
    IR_GLOBAL uint* to = packed + (size_t)IR_PACKED_WORDS * first;
    const real3 lo = make_real3(IR_AS_FLOAT(node[IR_NODE_CORNER]), IR_AS_FLOAT(node[IR_NODE_CORNER + 1u]),
                                IR_AS_FLOAT(node[IR_NODE_CORNER + 2u]));
    const float scale = packed_scale(octree_edge(cache_parameters, octree_cell(node[0], node[1]).level));
    for (uint link = node[IR_NODE_HEAD]; link != 0u; to += IR_PACKED_WORDS) {
        IR_GLOBAL const uint* entry = octree_entries + (size_t)2u * (link - 1u);
        const RecordKey key = record_keys[entry[0]];
        pack_entry(to, &key, entry[0], lo, scale);
        link = entry[1];
    }
    IR_GLOBAL const uint* from = before + (size_t)IR_PACKED_WORDS * old_first;
    for (uint i = 0; i < IR_PACKED_WORDS * old_count; ++i) to[i] = from[i];
    node[IR_NODE_HEAD] = 0u;
    node[IR_NODE_PACKED] = first;
    node[IR_NODE_PACKED + 1u] = listed + old_count;
}

// The nodes of `places` places of the table. octree_state counts the entries handed out anew.
IR_ONCE_FN void pack_nodes(IR_GLOBAL uint* nodes, uint places, IR_GLOBAL const uint* octree_entries,
                           IR_GLOBAL const RecordKey* record_keys, const CacheParameters* cache_parameters,
                           IR_GLOBAL const uint* before, IR_GLOBAL uint* packed, IR_GLOBAL uint* octree_state) {
    uint node[IR_PACK_NODES], link[IR_PACK_NODES], listed[IR_PACK_NODES], count = 0u, all = 0u;
    for (uint i = 0; i < places; ++i) {
        IR_GLOBAL const uint* n = nodes + (size_t)IR_NODE_STRIDE * i;
        if (n[0] == 0u || (n[IR_NODE_HEAD] == 0u && n[IR_NODE_PACKED + 1u] == 0u)) continue;
        node[count] = i;
        link[count] = n[IR_NODE_HEAD];
        listed[count++] = 0u;
        all += n[IR_NODE_PACKED + 1u];
    }
    // All lists at once, an entry each in turn: their cache misses overlap.
    for (bool more = true; more;) {
        more = false;
        for (uint i = 0; i < count; ++i) {
            if (link[i] == 0u) continue;
            IR_GLOBAL const uint* entry = octree_entries + (size_t)2u * (link[i] - 1u);
            IR_GLOBAL const char* key = (IR_GLOBAL const char*)&record_keys[entry[0]];
            IR_PREFETCH(key);
            IR_PREFETCH(key + sizeof(RecordKey) - 1u);
            link[i] = entry[1];
            if (link[i] != 0u) IR_PREFETCH(octree_entries + (size_t)2u * (link[i] - 1u));
            ++listed[i];
            ++all;
            more = true;
        }
    }
    if (all == 0u) return;
    uint first = IR_ATOMIC_ADD(&octree_state[1], all);
    for (uint i = 0; i < count; ++i) {
        IR_GLOBAL uint* n = nodes + (size_t)IR_NODE_STRIDE * node[i];
        pack_node(n, listed[i], octree_entries, record_keys, cache_parameters, before, packed, first);
        first += n[IR_NODE_PACKED + 1u];
    }
}

// One work-item IR_PACK_NODES places of the table.
IR_KERNEL void pack_records(IR_GLOBAL uint* octree_nodes, IR_GLOBAL const uint* octree_entries, uint octree_mask,
                            IR_GLOBAL const RecordKey* record_keys, CacheParameters cache_parameters,
                            IR_GLOBAL const uint* before, IR_GLOBAL uint* packed, IR_GLOBAL uint* octree_state) {
    const uint first = IR_PACK_NODES * IR_GLOBAL_ID;
    if (first > octree_mask) return;
    pack_nodes(octree_nodes + (size_t)IR_NODE_STRIDE * first, min(IR_PACK_NODES, octree_mask + 1u - first), octree_entries,
               record_keys, &cache_parameters, before, packed, octree_state);
}

// One work-item a place in the old table: its node moves into a larger one, which is empty.
IR_KERNEL void move_nodes(IR_GLOBAL const uint* before, IR_GLOBAL uint* after, uint before_mask, uint after_mask) {
    if (IR_GLOBAL_ID > before_mask) return;
    IR_GLOBAL const uint* from = before + (size_t)IR_NODE_STRIDE * IR_GLOBAL_ID;
    if (from[0] == 0u) return;
    const OctreeCell cell = octree_cell(from[0], from[1]);
    uint slot = octree_home(cell.level, cell.x, cell.y, cell.z, after_mask);
    while (IR_ATOMIC_CAS(after + (size_t)IR_NODE_STRIDE * slot, 0u, from[0]) != 0u) slot = octree_probe(slot, after_mask);
    IR_GLOBAL uint* to = after + (size_t)IR_NODE_STRIDE * slot;
    for (uint i = 1u; i < IR_NODE_STRIDE; ++i) to[i] = from[i];
}
