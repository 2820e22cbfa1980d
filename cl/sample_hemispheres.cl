// Stage 2 of an iteration: one work-group samples the hemisphere over one point of the record stack (1.2, 1.3) and
// reduces it to a record: E, both gradients, the Hessian, the radius.
//   1. Every work-item traces tiles of strata; where a ray hits, the irradiance grid is asked for the indirect light
//      there, or the ray continues as a path; the cells go to local memory. GPUs go on with such paths after a barrier:
//      few of the work-items that run in step would have one, and the others wait for them.
//   2. After a barrier every work-item sums its cells and the two edges each cell owns; the group adds the sums up.
//   3. One work-item makes the record.
// Compile-time: IR_M, IR_N (strata), IR_GROUP (work-items), IR_GRADIENT, IR_RADIUS, IR_GRADIENT_LIMIT, IR_GRID,
// IR_DIRECT_MIS, IR_GLOBAL_CELLS (the cells of a group lie in global memory: local memory is too small for them),
// IR_RADIANCE (the cells are kept, as samples of a radiance record).
#if IR_N % 8 != 0 || IR_GRADIENT == 1
#define IR_SCALAR_LANES 1  // lanes are cells of one ring; Ward and Heckbert's formula takes one cell
#endif
#define IR_SKY_WHOLE 1  // hundreds of rays share a record: samples by what is seen would cost more than they mend
#define IR_COUNTER_GROUPS 1u  // threads sample neighbouring hemispheres at the same time
#include "film.h"
#include "group.h"
#include "indirect.h"
#include "make_record.h"
#include "shading_point.h"
#include "strata.h"
#if IR_RADIANCE
#include "irradia/shared/radiance_types.h"
#endif

// Neighbouring directions, which find the same nodes: 4x4 strata as a packet, or 4x8 as the tiles of 32 work-items that run
// in step.
#if IR_TILE == 16 && IR_M % 4 == 0 && IR_N % 4 == 0
#define IR_BLOCK_SECTORS 4u
#elif IR_TILE == 1 && IR_M % 4 == 0 && IR_N % 8 == 0
#define IR_BLOCK_SECTORS 8u
#else
#define IR_BLOCK_SECTORS 0u
#endif
#define IR_TILES ((IR_CELLS + IR_TILE - 1) / IR_TILE)

#define IR_SCRATCH_SUMS (IR_SUM_FLOATS * IR_GROUP)
#if IR_GLOBAL_CELLS
#define IR_CELL_SPACE IR_GLOBAL
#define IR_CELL_BARRIER IR_GROUP_BARRIER_ALL
#define IR_GROUP_CELLS (global_cells + IR_GROUP_ID * IR_SCRATCH_CELLS)
#define IR_SCRATCH IR_SCRATCH_SUMS
#else
#define IR_CELL_SPACE IR_GROUP_SPACE
#define IR_CELL_BARRIER IR_GROUP_BARRIER
#define IR_GROUP_CELLS scratch
#define IR_SCRATCH (IR_SCRATCH_CELLS > IR_SCRATCH_SUMS ? IR_SCRATCH_CELLS : IR_SCRATCH_SUMS)
#endif
#include "sum_cells.h"

// Cells whose rays go on as paths are put off until the group shares them out (a list of them fits local memory).
#define IR_DEFER_PATHS (IR_GRID && IR_TILE == 1 && IR_CELLS <= 4096)

// Cell of ray i of a tile.
IR_FN uint tile_cell(uint tile, uint i) {
    const uint ray = tile * IR_TILE + i;
#if IR_BLOCK_SECTORS
    const uint in_block = 4u * IR_BLOCK_SECTORS, block = ray / in_block, blocks_k = IR_N / IR_BLOCK_SECTORS;
    return (block / blocks_k * 4u + ray % in_block / IR_BLOCK_SECTORS) * IR_N + block % blocks_k * IR_BLOCK_SECTORS +
           ray % IR_BLOCK_SECTORS;
#else
    return ray;
#endif
}

// Random numbers of a cell's first light sample: 4x4 neighbouring cells, whose rays end close together, share out 4x4
// strata of the light among them, turned at random from block to block.
IR_FN void cell_light_numbers(uint cell, uint seed, uint record, Rng* rng, float* u, float* v) {
    const uint j = cell / IR_N, k = cell % IR_N;
    const uint turn = hash_uint(((j >> 2) * IR_N + (k >> 2)) ^ hash_uint(record ^ hash_uint(seed)));
    const uint stratum = ((j & 3u) * 4u + (k & 3u)) ^ (turn & 15u);
    *u = min(((float)(stratum >> 2) + rng_real(rng)) * 0.25f, 0.99999994f);
    *v = min(((float)(stratum & 3u) + rng_real(rng)) * 0.25f, 0.99999994f);
}

// Light that the surfaces hit by a tile's rays reflect back along them; hits that the grid answers share one packet of
// shadow rays. Bit i of the result: ray i's path is put off.
IR_ONCE_FN uint tile_radiance(const SceneData* s, const Grid* grid, const Surface* surfaces, const Hit* hits, uint tile,
                              uint count, uint record, uint edges, uint seed, real3* radiance, RayCount* rays) {
    Rng rngs[IR_TILE];
    for (uint i = 0; i < count; ++i) {
        radiance[i] = black();
        rngs[i] = rng_make(seed ^ 0x68656d69u, record, tile_cell(tile, i));
    }
#if IR_GRID  // the first look-up of path_radiance, so that look-ups overlap and direct light shares a packet
    PathState answered[IR_TILE];
    GridQuery queries[IR_TILE];
    real3 irradiance[IR_TILE];
    float u[IR_TILE], v[IR_TILE];
    uint asking[IR_TILE], from[IR_TILE], indices[IR_TILE], asked = 0u, answers = 0u, known = 0u;
    for (uint i = 0; i < count; ++i) {
        if (hits[i].primitive == IR_NO_PRIMITIVE || !reflects(&surfaces[i]) || !is_diffuse(&surfaces[i])) continue;
        queries[asked] = grid_query(grid->parameters, surfaces[i].p, surfaces[i].ns, hits[i].t, &rngs[i]);
        asking[asked++] = i;
    }
    const uint found = grid_lookup_tile(grid->parameters, grid->cells, queries, asked, irradiance);
    for (uint a = 0; a < asked; ++a) {
        if (!((found >> a) & 1u)) continue;
        const uint i = asking[a], cell = tile_cell(tile, i);
        known |= 1u << i;
        radiance[i] = reflected_grid_irradiance(s, &surfaces[i], irradiance[a]);
        cell_light_numbers(cell, seed, record, &rngs[i], &u[answers], &v[answers]);
        answered[answers] = path_from(surfaces[i], hits[i].t);
        indices[answers] = cell;
        from[answers++] = i;
    }
#else
    const uint known = 0u;
#endif
    uint deferred = 0u;
    for (uint i = 0; i < count; ++i) {  // what a hit emits itself is direct light at the record, computed elsewhere
        if (((known >> i) & 1u) || hits[i].primitive == IR_NO_PRIMITIVE || !reflects(&surfaces[i])) continue;
#if IR_DEFER_PATHS
        deferred |= 1u << i;
#else
        radiance[i] = path_radiance(s, grid, path_from(surfaces[i], hits[i].t), edges, false, &rngs[i], rays);
#endif
    }
#if IR_GRID
    real3 direct[IR_TILE];
    const uint on = direct_tile(s, answered, answers, u, v, seed, record, indices, false, direct, rays);
    for (uint i = 0; i < answers; ++i) {
        radiance[from[i]] += direct[i];
        if (!((on >> i) & 1u)) continue;
        Rng rng = rng_make(seed ^ 0x676c6f73u, record, indices[i]);
        radiance[from[i]] += path_radiance(s, grid, answered[i], edges_left(edges, 1u), true, &rng, rays);
    }
#endif
    return deferred;
}

// How much of the light from w counts at q: what the coat lets through, and a bump map hides. 1 on most surfaces.
IR_FN float arriving_share(const SceneData* s, const ShadingPoint* q, real3 w, float cosine) {
    float share = 1.0f;
#if IR_FEATURES & IR_FEATURE_BUMPS
    if (q->state & IR_POINT_BUMPED)
        share = visibility_over_bump(make_real3(q->nx, q->ny, q->nz), make_real3(q->gx, q->gy, q->gz), w);
#endif
#if IR_FEATURES & IR_FEATURE_BSDFS
    const uint coated = q->state >> 8;
    if (coated != 0u) share *= coat_transmission(s, s->materials + (coated - 1u), cosine);
#endif
    return share;
}

// Where hemisphere rays start: above the surface, or below it those over the shading normal's horizon but under the
// surface.
typedef struct RayStart {
    Frame frame;
    real3 g, above, below;
} RayStart;

IR_FN RayStart ray_start(const ShadingPoint* q) {
    RayStart start;
    start.frame = make_frame(make_real3(q->nx, q->ny, q->nz));
    start.g = make_real3(q->gx, q->gy, q->gz);
    const real3 p = make_real3(q->px + q->step_x, q->py + q->step_y, q->pz + q->step_z);
    start.above = p + start.g * q->offset;
    start.below = p - start.g * q->offset;
    return start;
}

IR_FN bool starts_below(const RayStart* start, real3 w) {
#if IR_FEATURES & IR_FEATURE_SMOOTH_NORMALS
    return dot(w, start->g) < 0.0f;
#else
    return false;
#endif
}

// Directions of cells' rays, in the record's frame, one a lane.
IR_FN LaneVector rays_in_frame(uint record, lanes_uint cell, uint seed) {
    return strata_directions(cell / IR_N, cell % IR_N, IR_M, IR_N, hash_uint(record ^ hash_uint(seed)));
}

// The cells of a tile, laid out like those of a hemisphere (sum_cells.h).
typedef struct TileCells {
    float cell[IR_CELL_FLOATS][IR_TILE];
} TileCells;

// Traces one tile of strata from q. Bit i of the result: ray i is put off; what it has hit lies in place of its radiance.
IR_ONCE_FN uint trace_cells(const SceneData* s, const Grid* grid, const ShadingPoint* q, uint record, uint tile,
                            uint edges, uint seed, TileCells* cells, RayCount* rays) {
    const RayStart start = ray_start(q);
    const uint count = min((uint)IR_TILE, (uint)IR_CELLS - tile * IR_TILE);
    float dx[IR_TILE], dy[IR_TILE], dz[IR_TILE];
    Hit hits[IR_TILE];
    Surface surfaces[IR_TILE];
    real3 radiance[IR_TILE];
    uint cell[IR_TILE];
    for (uint i = 0; i < IR_TILE; ++i) cell[i] = tile_cell(tile, i);
    for (uint i = 0; i < IR_TILE; i += IR_LANES) {
        const LaneVector w = rays_in_frame(record, lanes_load_uint(cell, i), seed);
        const real3 t = start.frame.t, b = start.frame.b, n = start.frame.n;
        lanes_store(w.x, cells->cell[0], i);
        lanes_store(w.y, cells->cell[1], i);
        lanes_store(w.x * t.x + w.y * b.x + w.z * n.x, dx, i);
        lanes_store(w.x * t.y + w.y * b.y + w.z * n.y, dy, i);
        lanes_store(w.x * t.z + w.y * b.z + w.z * n.z, dz, i);
    }
    trace_tile(s, start.above, dx, dy, dz, count, 0.0f, hits);
    for (uint i = 0; i < count; ++i) {
        const real3 w = make_real3(dx[i], dy[i], dz[i]);
        const bool below = starts_below(&start, w);
        const real3 origin = below ? start.below : start.above;
        if (below) hits[i] = trace_closest(s, origin, w, 0.0f, IR_INFINITY);
#if IR_FEATURES & IR_FEATURE_MASKS
        Rng rng = rng_make(seed ^ 0x6d61736bu, record, tile_cell(tile, i));
        hits[i] = pass_masks(s, origin, w, IR_INFINITY, hits[i], &rng);
#endif
        if (hits[i].primitive != IR_NO_PRIMITIVE) surfaces[i] = surface_at(s, origin, w, &hits[i]);
    }
    const uint deferred = tile_radiance(s, grid, surfaces, hits, tile, count, record, edges, seed, radiance, rays);
    for (uint i = 0; i < count; ++i) {
        const bool hit = hits[i].primitive != IR_NO_PRIMITIVE;
        const real3 normal = hit ? to_local(start.frame, surfaces[i].ng) : make_real3(0.0f, 0.0f, 1.0f);
        const real3 w = make_real3(dx[i], dy[i], dz[i]);
        cells->cell[2][i] = hit ? hits[i].t : IR_INFINITY;
#if IR_RADIANCE
        if (hit && !is_diffuse(&surfaces[i]) && is_glossy(&surfaces[i])) cells->cell[2][i] = -hits[i].t;
#endif
        cells->cell[3][i] = normal.x;
        cells->cell[4][i] = normal.y;
        cells->cell[5][i] = normal.z;
        radiance[i] = radiance[i] * arriving_share(s, q, w, max(dot(w, start.frame.n), 0.0f));
#if IR_DEFER_PATHS
        if ((deferred >> i) & 1u) radiance[i] = make_real3(hits[i].u, hits[i].v, IR_AS_FLOAT(hits[i].primitive));
#endif
        cells->cell[6][i] = radiance[i].x;
        cells->cell[7][i] = radiance[i].y;
        cells->cell[8][i] = radiance[i].z;
    }
    return deferred;
}

// Traces one tile of strata from q and stores its cells; those put off go to `deferred`, whose first entry is their number.
IR_INLINE_FN void sample_tile(const SceneData* s, const Grid* grid, const ShadingPoint* q, uint record, uint tile,
                              uint edges, uint seed, IR_CELL_SPACE float* cells, volatile IR_GROUP_SPACE uint* deferred,
                              RayCount* rays) {
    TileCells own;
    const uint off = trace_cells(s, grid, q, record, tile, edges, seed, &own, rays);
    const uint count = min((uint)IR_TILE, (uint)IR_CELLS - tile * IR_TILE);
    for (uint i = 0; i < count; ++i)
        for (uint k = 0; k < IR_CELL_FLOATS; ++k) cells[k * IR_CELLS + tile_cell(tile, i)] = own.cell[k][i];
#if IR_DEFER_PATHS
    if (off != 0u) deferred[1u + IR_ATOMIC_ADD(deferred, 1u)] = tile_cell(tile, 0u);
#endif
}

#if IR_DEFER_PATHS
// The path of a cell that was put off: the same that it would have taken at once.
IR_INLINE_FN void continue_cell(const SceneData* s, const Grid* grid, const ShadingPoint* q, uint record, uint cell,
                                uint edges, uint seed, IR_CELL_SPACE float* cells, RayCount* rays) {
    const RayStart start = ray_start(q);
    const real3 w = to_world(start.frame, rays_in_frame(record, cell, seed));
    const real3 origin = starts_below(&start, w) ? start.below : start.above;
    Hit hit;
    hit.t = fabs(cells[2 * IR_CELLS + cell]);
    hit.u = cells[6 * IR_CELLS + cell];
    hit.v = cells[7 * IR_CELLS + cell];
    hit.primitive = IR_AS_UINT(cells[8 * IR_CELLS + cell]);
    const Surface f = surface_at(s, origin, w, &hit);
    Rng rng = rng_make(seed ^ 0x68656d69u, record, cell);
    if (is_diffuse(&f)) {  // the grid was asked
        rng_real(&rng);
        rng_real(&rng);
    }
    const real3 radiance = path_radiance(s, grid, path_from(f, hit.t), edges, false, &rng, rays);
    const real3 arriving = radiance * arriving_share(s, q, w, max(dot(w, start.frame.n), 0.0f));
    cells[6 * IR_CELLS + cell] = arriving.x;
    cells[7 * IR_CELLS + cell] = arriving.y;
    cells[8 * IR_CELLS + cell] = arriving.z;
}
#endif

#if IR_RADIANCE
// The cells of one work-item as samples of a radiance record: what re-projection (theory 7) needs of them, in world
// space and with all that does not depend on the query taken together. Entries beyond the last cell are cleared.
IR_INLINE_FN void keep_samples(const IR_CELL_SPACE float* cells, uint first, const ShadingPoint* q, float diagonal,
                               uint stride, IR_GLOBAL float* samples) {
    const Frame frame = make_frame(make_real3(q->nx, q->ny, q->nz));
    const real3 g = make_real3(q->gx, q->gy, q->gz);
    const real3 start = make_real3(q->step_x, q->step_y, q->step_z) + g * q->offset;
    for (uint cell = first; cell < IR_CELLS; cell += IR_GROUP) {
        const real3 direction = cell_direction(cells, cell);
        const float distance = cells[2 * IR_CELLS + cell];
        const bool miss = distance >= IR_INFINITY || distance < 0.0f;
        const float r = miss ? IR_FAR_DIAGONALS * diagonal : distance;
        const real3 w = to_world(frame, direction), p = start + w * r;
        const real3 n = miss ? -w : to_world(frame, load3(cells, 3u, cell));
        samples[cell] = p.x;
        samples[stride + cell] = p.y;
        samples[2u * stride + cell] = p.z;
        samples[3u * stride + cell] = n.x;
        samples[4u * stride + cell] = n.y;
        samples[5u * stride + cell] = n.z;
        samples[6u * stride + cell] = r * r / (max(fabs(dot(n, w)), 1e-4f) * max(direction.z, 1e-3f));
        for (uint k = 0; k < 3u; ++k) samples[(7u + k) * stride + cell] = cells[(6u + k) * IR_CELLS + cell];
    }
    for (uint cell = IR_CELLS + first; cell < stride; cell += IR_GROUP)
        for (uint k = 0; k < IR_SAMPLE_FLOATS; ++k) samples[k * stride + cell] = k == 2u ? 1.0f : 0.0f;
}
#define IR_RADIANCE_SAMPLES IR_GLOBAL float *samples, uint stride, uint first_kept,
#else
#define IR_RADIANCE_SAMPLES
#endif

// What a group has to sample one hemisphere.
typedef struct HemisphereTask {
    IR_CELL_SPACE float* cells;
    IR_GROUP_SPACE float *scratch, *partial;
    volatile IR_GROUP_SPACE uint* deferred;  // the number of cells put off, then which
    IR_GLOBAL const float* ring_weights;
    uint index;  // what the random numbers are a function of
    uint edges, seed;
} HemisphereTask;

// Steps 1 and 2: the sums over the hemisphere at q, complete for item 0. `samples`: see keep_samples.
IR_GROUP_FN HemisphereTotals hemisphere_totals(const SceneData* s, const Grid* grid, const ShadingPoint* q,
                                               const HemisphereTask* task, const RecordParameters* parameters, uint item,
                                               IR_GLOBAL float* samples, uint stride, RayCount* rays) {
    IR_CELL_SPACE float* const cells = task->cells;
    IR_GROUP_SPACE float* const scratch = task->scratch;
#if IR_DEFER_PATHS
    if (item == 0u) task->deferred[0] = 0u;
    IR_GROUP_BARRIER();
#endif
    for (uint tile = item; tile < IR_TILES; tile += IR_GROUP)
        sample_tile(s, grid, q, task->index, tile, task->edges, task->seed, cells, task->deferred, rays);
#if IR_DEFER_PATHS
    IR_CELL_BARRIER();
    for (uint i = item; i < task->deferred[0]; i += IR_GROUP)
        continue_cell(s, grid, q, task->index, task->deferred[1u + i], task->edges, task->seed, cells, rays);
#endif
    IR_CELL_BARRIER();
#if IR_RADIANCE
    keep_samples(cells, item, q, s->info->diagonal, stride, samples);
#endif
    const float limit = brightness_limit(cells, item, parameters->firefly, task->partial);
    float own[IR_SUM_FLOATS];
    const HemisphereSums sums =
        sum_cells(cells, item, limit, parameters->r_min, parameters->r_max, task->ring_weights);
    lane_totals(&sums, own);
    IR_GROUP_BARRIER();  // everyone has read the cells: their memory now holds the sums
    store_sums(scratch, item, own);
    IR_GROUP_BARRIER();
    for (uint half_size = IR_GROUP / 2u; half_size > 0u; half_size >>= 1) {
        if (item < half_size) add_sums(scratch, item, item + half_size);
        IR_GROUP_BARRIER();
    }
    return load_totals(scratch);
}

IR_KERNEL void sample_hemispheres(IR_SCENE_ARGS, IR_GLOBAL const ShadingPoint* points, IR_GLOBAL const uint* stack,
                                  IR_GLOBAL const float* ring_weights, IR_GLOBAL RecordKey* record_keys,
                                  IR_GLOBAL RecordValue* record_values, IR_GLOBAL uint* ray_counts,
                                  IR_GLOBAL const GridCell* grid_cells, GridParameters grid,
                                  RecordParameters parameters, IR_GLOBAL float* global_cells,
                                  IR_RADIANCE_SAMPLES uint first, uint first_record, uint salt, uint edges,
                                  uint seed) {
    IR_GROUP_ARRAY(float, scratch, IR_SCRATCH);
    IR_GROUP_ARRAY(float, partial, IR_GROUP);
    IR_GROUP_ARRAY(uint, deferred, IR_DEFER_PATHS ? 1 + IR_CELLS : 1);
    const uint record = first_record + first + IR_GROUP_ID;  // where the record is stored
    IR_SCENE_INIT(s);
    const ShadingPoint q = points[stack[first + IR_GROUP_ID]];
    HemisphereTask task;
    task.cells = IR_GROUP_CELLS;
    task.scratch = scratch;
    task.partial = partial;
    task.deferred = deferred;
    task.ring_weights = ring_weights;
    // The pixel, so that records elsewhere do not change them. (`salt` tells records of one pixel apart.)
    task.index = q.pixel ^ hash_uint(salt);
    task.edges = edges;
    task.seed = seed;
    Grid view;
    view.parameters = &grid;
    view.cells = grid_cells;
    RayCount rays;
    rays.bounce = rays.shadow = 0u;
#if IR_RADIANCE
    IR_GLOBAL float* const kept = samples + (size_t)(record - first_kept) * (IR_SAMPLE_FLOATS * stride);
#else
    IR_GLOBAL float* const kept = 0;
    const uint stride = 0u;
#endif
    const HemisphereTotals totals =
        hemisphere_totals(&s, &view, &q, &task, &parameters, IR_LOCAL_ID, kept, stride, &rays);
    count_up(ray_counts, IR_RAYS_BOUNCE, rays.bounce);
    count_up(ray_counts, IR_RAYS_SHADOW, rays.shadow);
    if (IR_LOCAL_ID == 0u) {
        count_up(ray_counts, IR_RAYS_HEMISPHERE, (uint)IR_CELLS);
        const uint coated = q.state >> 8;
        const uint coat = coated == 0u ? 0u : materials[coated - 1u].coat;
        make_record(&q, coat, &totals, parameters, &record_keys[record], &record_values[record]);
    }
}
