// From the sums that paths left in the irradiance grid (fill_grid.cl) to what look-ups read. merge_grid_level adds every
// cell of a level to the one around it, and counts those that may answer; grid_means puts their means into a table of their
// own. No scene is looked at: the program is the same for all.
#define IR_GRID_FILL
#include "irradiance_grid.h"

// Adds the cell in `slot` to the one around it. Returns that one's slot if it was free, else IR_GRID_NONE.
IR_FN uint merge_into_parent(IR_GLOBAL GridSum* sums, const GridParameters* grid, uint slot, IR_GLOBAL uint* overflow) {
    const GridSum own = sums[slot];
    bool fresh;
    const uint around =
        grid_take((volatile IR_GLOBAL uint*)sums, IR_GRID_SUM_WORDS, grid->slots, grid_parent(own.key), &fresh);
    if (around == grid->slots) {
        IR_ATOMIC_MAX(overflow, 1u);
        return IR_GRID_NONE;
    }
    volatile IR_GLOBAL GridSum* parent = &sums[around];
    add_wide(&parent->r[0], own.r[0], own.r[1]);
    add_wide(&parent->g[0], own.g[0], own.g[1]);
    add_wide(&parent->b[0], own.b[0], own.b[1]);
    IR_ATOMIC_ADD(&parent->samples, own.samples);
    return fresh ? around : IR_GRID_NONE;
}

// CPU devices go through the list one by one, and wait for memory: so for what comes later in the list they send early. For
// cells first, then for those around them.
#define IR_GRID_AHEAD 16u
IR_FN void grid_send_for(IR_GLOBAL const GridSum* sums, IR_GLOBAL const uint* list, uint at, uint end) {
    if (at + IR_GRID_AHEAD < end) IR_PREFETCH(&sums[list[at + IR_GRID_AHEAD]]);
}
IR_FN void grid_send_for_parent(IR_GLOBAL const GridSum* sums, const GridParameters* grid, IR_GLOBAL const uint* list,
                                uint at, uint end) {
    if (at + IR_GRID_AHEAD / 2u >= end) return;
    IR_PREFETCH_OWN(&sums[hash_slot(grid_parent(sums[list[at + IR_GRID_AHEAD / 2u]].key), grid->slots)]);
}

// The cells of one level: taken[1 + first] and following, `count` of them. Those around them are listed behind. *answers
// counts up by those that have enough estimates.
IR_KERNEL void merge_grid_level(IR_GLOBAL GridSum* sums, GridParameters grid, IR_GLOBAL uint* taken,
                                IR_GLOBAL uint* overflow, IR_GLOBAL uint* answers, uint first, uint count) {
    IR_LOCAL_ARRAY(uint, fresh, IR_GRID_FRESH_WORDS);
    IR_LOCAL_ARRAY(uint, answering, 1);  // of the group's cells
    if (IR_LOCAL_ID == 0u) answering[0] = 0u;
    grid_fresh_begin(fresh);
    if (IR_GLOBAL_ID < count) {
        IR_GLOBAL const uint* list = taken + 1u + first;
        grid_send_for(sums, list, IR_GLOBAL_ID, count);
        grid_send_for_parent(sums, &grid, list, IR_GLOBAL_ID, count);
        if (sums[list[IR_GLOBAL_ID]].samples >= grid.least) IR_ATOMIC_ADD(&answering[0], 1u);
        const uint slot = merge_into_parent(sums, &grid, list[IR_GLOBAL_ID], overflow);
        if (slot != IR_GRID_NONE) grid_fresh_add(fresh, slot, taken);
    }
    grid_fresh_end(fresh, taken);
    if (IR_LOCAL_ID == 0u && answering[0] > 0u) IR_ATOMIC_ADD(answers, answering[0]);
}

// Means of those of `count` cells that answer, in a table of their own, small enough for a cache; `slots` of it, at least twice as
// many as there are answers, all free. Which slot a cell gets depends on the order of work-items, what it says does not.
IR_KERNEL void grid_means(IR_GLOBAL const GridSum* sums, IR_GLOBAL GridCell* cells, GridParameters grid,
                          IR_GLOBAL const uint* taken, IR_GLOBAL uint* overflow, uint slots, uint count) {
    if (IR_GLOBAL_ID >= count) return;
    grid_send_for(sums, taken + 1u, IR_GLOBAL_ID, count);
    const GridSum sum = sums[taken[1u + IR_GLOBAL_ID]];
    if (sum.samples < grid.least) return;
    bool fresh;
    const uint slot = grid_take((volatile IR_GLOBAL uint*)cells, IR_GRID_CELL_WORDS, slots, sum.key, &fresh);
    if (slot == slots) {
        IR_ATOMIC_MAX(overflow, 1u);
        return;
    }
    const float scale = grid.unit / (float)sum.samples;
    cells[slot].r = scale * wide_value(sum.r[0], sum.r[1]);
    cells[slot].g = scale * wide_value(sum.g[0], sum.g[1]);
    cells[slot].b = scale * wide_value(sum.b[0], sum.b[1]);
}
