// Stage 3 of an iteration: new records limit and are limited by their neighbours (theory 4.4), then enter the octree.
// Three kernels, because each must see all of the previous one's results: so the outcome is the same whatever the order
// of work-items.
#define IR_OCTREE_INSERT
#include "cache.h"
#include "radius.h"

// support_i <= support_j + slope |p_i - p_j| for every record j that the octree knows near record i and that faces the
// same way. `limit_old` false: shrinks the new record i (reads old ones only). True: shrinks the old ones, by an atomic
// minimum (positive floats order like their bits).
IR_ONCE_FN void clamp_to_neighbours(const Cache* c, IR_GLOBAL RecordKey* keys, uint i, float slope, float least,
                                    bool limit_old) {
    const RecordKey own = keys[i];
    const real3 p = make_real3(own.px, own.py, own.pz), n = make_real3(own.nx, own.ny, own.nz);
    float s1 = own.support1, s2 = own.support2;
    uint j;
    OctreeWalk walk = octree_walk(c->nodes, &c->parameters, p);
    while (octree_next(c->nodes, c->entries, &walk, &j)) {
        if (dot(n, make_real3(keys[j].nx, keys[j].ny, keys[j].nz)) < 0.9f) continue;
        const float reach = slope * length(p - make_real3(keys[j].px, keys[j].py, keys[j].pz));
        if (limit_old) {
            IR_ATOMIC_MIN((IR_GLOBAL uint*)&keys[j].support1, IR_AS_UINT(own.support1 + reach));
            IR_ATOMIC_MIN((IR_GLOBAL uint*)&keys[j].support2, IR_AS_UINT(own.support2 + reach));
        } else {
            s1 = neighbour_clamped_radius(s1, keys[j].support1, reach);
            s2 = neighbour_clamped_radius(s2, keys[j].support2, reach);
        }
    }
    if (!limit_old) {
        keys[i].support1 = max(s1, min(least, own.support1));
        keys[i].support2 = max(s2, keys[i].support1);
    }
}

IR_KERNEL void clamp_new_records(IR_GLOBAL const uint* octree_nodes, IR_GLOBAL const uint* octree_entries,
                                 IR_GLOBAL RecordKey* record_keys, CacheParameters cache_parameters,
                                 IR_GLOBAL const ShadingPoint* points, IR_GLOBAL const uint* stack, float slope,
                                 float min_spacing, uint first_record, uint count) {
    if (IR_GLOBAL_ID >= count) return;
    Cache c;
    c.nodes = octree_nodes;
    c.entries = octree_entries;
    c.parameters = cache_parameters;
    clamp_to_neighbours(&c, record_keys, first_record + IR_GLOBAL_ID, slope,
                        min_spacing * points[stack[IR_GLOBAL_ID]].footprint, false);
}

IR_KERNEL void clamp_old_records(IR_GLOBAL const uint* octree_nodes, IR_GLOBAL const uint* octree_entries,
                                 IR_GLOBAL RecordKey* record_keys, CacheParameters cache_parameters,
                                 IR_GLOBAL const ShadingPoint* points, IR_GLOBAL const uint* stack, float slope,
                                 uint first_record, uint count) {
    if (IR_GLOBAL_ID >= count) return;
    Cache c;
    c.nodes = octree_nodes;
    c.entries = octree_entries;
    c.parameters = cache_parameters;
    // Of a narrow place its neighbours may cover no more than is as near as what makes it narrow.
    const bool narrow = points[stack[IR_GLOBAL_ID]].least > 0.0f;
    clamp_to_neighbours(&c, record_keys, first_record + IR_GLOBAL_ID, narrow ? min(slope, 1.0f) : slope, 0.0f, true);
}

IR_KERNEL void insert_records(IR_GLOBAL uint* octree_nodes, IR_GLOBAL uint* octree_entries, IR_GLOBAL uint* octree_state,
                              IR_GLOBAL const RecordKey* record_keys, CacheParameters cache_parameters,
                              uint node_capacity, uint entry_capacity, uint first_record, uint count) {
    if (IR_GLOBAL_ID >= count) return;
    OctreeMemory tree;
    tree.nodes = octree_nodes;
    tree.entries = octree_entries;
    tree.state = octree_state;
    tree.node_capacity = node_capacity;
    tree.entry_capacity = entry_capacity;
    const uint record = first_record + IR_GLOBAL_ID;
    const RecordKey k = record_keys[record];
    octree_insert(&tree, cache_parameters, record, make_real3(k.px, k.py, k.pz), make_real3(k.nx, k.ny, k.nz), k.support2,
                  k.support1);
}
