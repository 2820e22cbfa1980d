// Filling the irradiance grid. trace_grid_paths: one work-item traces one path from the camera and leaves, at each of
// its vertices, the irradiance by indirect light that the rest of the path estimates there. merge_grid_level adds every
// cell of a level to the one around it; grid_means makes of the sums what look-ups read.
#define IR_GRID_FILL
#include "camera.h"
#include "film.h"
#include "irradiance_grid.h"
#include "path.h"

#define IR_GRID_VERTICES 8  // vertices of a path that leave an estimate; beyond them it goes on unseen

typedef struct GridVertex {
    real3 p, n, albedo;
    real3 direct;     // reflected direct radiance per unit albedo
    float survival;   // probability with which the path went on from here
} GridVertex;

// Traces a path from surface f; returns the number of its vertices. *tail: radiance that the surface behind the last
// vertex reflects to it.
IR_FN uint grid_path(const SceneData* s, Surface f, Rng* rng, GridVertex* path, real3* tail, RayCount* rays) {
    *tail = make_real3(0.0f, 0.0f, 0.0f);
    for (uint k = 0; reflects(&f); ++k) {
        if (k == IR_GRID_VERTICES) {
            reflected_radiance(s, f, 0xffffffffu, rng, rays, tail, tail);
            return k;
        }
        const float u0 = rng_real(rng), u1 = rng_real(rng), v0 = rng_real(rng), v1 = rng_real(rng);
        GridVertex* v = &path[k];
        v->p = f.p;
        v->n = f.ns;
        v->albedo = f.albedo;
        v->direct = next_event(s, &f, u0, u1, true, rays);
        v->survival = 1.0f;
        const Bounce b = bounce_from(s, &f, v0, v1, rays);
        if (b.hit.primitive == IR_NO_PRIMITIVE) {
            v->direct += bounce_sky(s);
            return k + 1u;
        }
        f = surface_at(s, b.origin, b.direction, &b.hit);
        v->direct += bounce_emission(s, v->p, &b, &f);
        if (k >= 2u) {  // roulette by the albedo of what was hit: its direct light was not looked for yet
            v->survival = min(max(largest_channel(f.albedo), 0.05f), 0.95f);
            if (rng_real(rng) >= v->survival) return k + 1u;
        }
        if (!reflects(&f)) return k + 1u;
    }
    return 0u;
}

IR_KERNEL void trace_grid_paths(IR_SCENE_ARGS, IR_GLOBAL GridSum* sums, GridParameters grid, IR_GLOBAL uint* overflow,
                                IR_GLOBAL uint* ray_counts, uint first_path, uint path_count, uint all_paths, uint seed) {
    if (IR_GLOBAL_ID >= path_count) return;
    IR_SCENE_INIT(s);
    const uint index = first_path + IR_GLOBAL_ID;
    const uint pixels = info->width * info->height;
    Rng rng = rng_make(seed ^ 0x67726964u, index, 0u);
    // Spread over the picture: the pixel in which the index-th of all_paths equal parts begins.
    const uint pixel = min((uint)(((float)index + rng_real(&rng)) / (float)all_paths * (float)pixels), pixels - 1u);
    const float fx = (float)(pixel % info->width) + rng_real(&rng), fy = (float)(pixel / info->width) + rng_real(&rng);
    const CameraRay ray = camera_ray_at(info, fx, fy);
    const real3 origin = camera_origin(info);
    const Hit hit = trace_closest(&s, origin, ray.direction, ray.t_min, ray.t_max);
    IR_ATOMIC_ADD(&ray_counts[IR_RAYS_CAMERA], 1u);
    if (hit.primitive == IR_NO_PRIMITIVE) return;
    const Surface f = surface_at(&s, origin, ray.direction, &hit);
    GridVertex path[IR_GRID_VERTICES];
    real3 arrives;  // at vertex k from what lies behind it: irradiance by indirect light is pi times it
    RayCount rays;
    rays.bounce = rays.shadow = 0u;
    const uint count = grid_path(&s, f, &rng, path, &arrives, &rays);
    for (uint k = count; k-- > 0u;) {
        const GridVertex v = path[k];
        arrives = arrives * (1.0f / v.survival);
        grid_deposit(&grid, sums, v.p, v.n, arrives * IR_PI, overflow);
        arrives = v.albedo * (v.direct + arrives);
    }
    IR_ATOMIC_ADD(&ray_counts[IR_RAYS_BOUNCE], rays.bounce);
    IR_ATOMIC_ADD(&ray_counts[IR_RAYS_SHADOW], rays.shadow);
}

IR_KERNEL void merge_grid_level(IR_GLOBAL GridSum* sums, GridParameters grid, IR_GLOBAL uint* overflow, uint level) {
    if (IR_GLOBAL_ID >= grid.slots) return;
    // Others take free slots meanwhile: their keys, of another level, must be read as they are set, atomically.
    const uint key = IR_ATOMIC_ADD(&sums[IR_GLOBAL_ID].key, 0u);
    if (key == 0u || key >> 30 != level) return;
    const GridSum own = sums[IR_GLOBAL_ID];
    const uint slot = grid_take((volatile IR_GLOBAL uint*)sums, IR_GRID_SUM_WORDS, grid.slots, grid_parent(own.key));
    if (slot == grid.slots) {
        IR_ATOMIC_MAX(overflow, 1u);
        return;
    }
    volatile IR_GLOBAL GridSum* parent = &sums[slot];
    add_wide(&parent->r[0], own.r[0], own.r[1]);
    add_wide(&parent->g[0], own.g[0], own.g[1]);
    add_wide(&parent->b[0], own.b[0], own.b[1]);
    IR_ATOMIC_ADD(&parent->samples, own.samples);
}

IR_FN bool grid_answers(const GridParameters* grid, const GridSum* sum) {
    return sum->key != 0u && sum->samples >= grid->least;
}

// How many cells have enough estimates to answer.
IR_KERNEL void count_grid_answers(IR_GLOBAL const GridSum* sums, GridParameters grid, IR_GLOBAL uint* answers) {
    if (IR_GLOBAL_ID >= grid.slots) return;
    const GridSum sum = sums[IR_GLOBAL_ID];
    if (grid_answers(&grid, &sum)) IR_ATOMIC_ADD(answers, 1u);
}

// Means of the cells that answer, in a table of their own, small enough for a cache; `slots` of it, at least twice as
// many as there are answers, all free. Which slot a cell gets depends on the order of work-items, what it says does not.
IR_KERNEL void grid_means(IR_GLOBAL const GridSum* sums, IR_GLOBAL GridCell* cells, GridParameters grid, uint slots,
                          IR_GLOBAL uint* overflow) {
    if (IR_GLOBAL_ID >= grid.slots) return;
    const GridSum sum = sums[IR_GLOBAL_ID];
    if (!grid_answers(&grid, &sum)) return;
    const uint slot = grid_take((volatile IR_GLOBAL uint*)cells, IR_GRID_CELL_WORDS, slots, sum.key);
    if (slot == slots) {
        IR_ATOMIC_MAX(overflow, 1u);
        return;
    }
    const float scale = grid.unit / (float)sum.samples;
    cells[slot].r = scale * wide_value(sum.r[0], sum.r[1]);
    cells[slot].g = scale * wide_value(sum.g[0], sum.g[1]);
    cells[slot].b = scale * wide_value(sum.b[0], sum.b[1]);
}
