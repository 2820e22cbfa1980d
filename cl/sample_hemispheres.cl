// Stage 2 of an iteration: one work-group samples the hemisphere over one point of the record stack (1.2, 1.3) and
// reduces it to a record: E, both gradients, the Hessian, the radius.
//   1. Every work-item traces tiles of strata and continues each ray as a path; the cells go to local memory.
//   2. After a barrier every work-item sums its cells and the two edges each cell owns; the group adds the sums up.
//   3. One work-item makes the record.
// Compile-time: IR_M, IR_N (strata), IR_GROUP (work-items), IR_GRADIENT, IR_RADIUS, IR_GRADIENT_LIMIT.
#include "film.h"
#include "make_record.h"
#include "path.h"
#include "shading_point.h"

#define IR_CELLS (IR_M * IR_N)
#if IR_TILE == 16 && IR_M % 4 == 0 && IR_N % 4 == 0
#define IR_TILE_RINGS 4u  // a 4x4 tile of strata: neighbouring directions, which make a coherent packet
#else
#define IR_TILE_RINGS 1u
#endif
#define IR_TILES ((IR_CELLS + IR_TILE - 1) / IR_TILE)

// A cell in local memory, as structure of arrays: direction x, y, distance, hit normal x, y, z, radiance r, g, b.
#define IR_CELL_FLOATS 9
#define IR_SCRATCH_CELLS (IR_CELL_FLOATS * IR_CELLS)
#define IR_SCRATCH_SUMS (IR_SUM_FLOATS * IR_GROUP)
#define IR_SCRATCH (IR_SCRATCH_CELLS > IR_SCRATCH_SUMS ? IR_SCRATCH_CELLS : IR_SCRATCH_SUMS)

IR_FN uint tile_cell(uint tile, uint i) {
#if IR_TILE_RINGS == 4
    const uint tiles_k = IR_N / 4u;
    return (tile / tiles_k * 4u + i / 4u) * IR_N + tile % tiles_k * 4u + i % 4u;
#else
    return tile * IR_TILE + i;
#endif
}

// Traces one tile of strata from q and stores its cells.
IR_FN void sample_tile(const SceneData* s, const ShadingPoint* q, uint record, uint tile, uint edges, uint seed,
                       IR_LOCAL float* cells, RayCount* rays) {
    const Frame frame = make_frame(make_real3(q->nx, q->ny, q->nz));
    const real3 g = make_real3(q->gx, q->gy, q->gz);
    const real3 p = make_real3(q->px, q->py, q->pz);
    const real3 origin = p + g * q->offset;
    const uint count = min((uint)IR_TILE, (uint)IR_CELLS - tile * IR_TILE);
    float dx[IR_TILE], dy[IR_TILE], dz[IR_TILE];
    Hit hits[IR_TILE];
    for (uint i = 0; i < count; ++i) {
        const uint cell = tile_cell(tile, i);
        Rng rng = rng_make(seed, record, cell);
        const float xi1 = rng_real(&rng), xi2 = rng_real(&rng);
        const real3 in_frame = stratum_direction(cell / IR_N, cell % IR_N, IR_M, IR_N, xi1, xi2);
        const real3 w = to_world(frame, in_frame);
        dx[i] = w.x;
        dy[i] = w.y;
        dz[i] = w.z;
        cells[0 * IR_CELLS + cell] = in_frame.x;
        cells[1 * IR_CELLS + cell] = in_frame.y;
    }
    trace_tile(s, origin, dx, dy, dz, count, 0.0f, hits);
    for (uint i = 0; i < count; ++i) {
        const uint cell = tile_cell(tile, i);
        const real3 w = make_real3(dx[i], dy[i], dz[i]);
        real3 start = origin;
#if IR_FEATURES & IR_FEATURE_SMOOTH_NORMALS
        if (dot(w, g) < 0.0f) {  // over the shading normal's horizon but under the surface: such rays start below it
            start = p - g * q->offset;
            hits[i] = trace_closest(s, start, w, 0.0f, IR_INFINITY);
        }
#endif
        real3 radiance = make_real3(0.0f, 0.0f, 0.0f), normal = make_real3(0.0f, 0.0f, 1.0f);
        float distance = IR_INFINITY;
        if (hits[i].primitive != IR_NO_PRIMITIVE) {
            const Surface f = surface_at(s, start, w, &hits[i]);
            distance = hits[i].t;
            normal = to_local(frame, f.ng);
            Rng rng = rng_make(seed ^ 0x68656d69u, record, cell);
            // What the hit emits itself is direct light at q, which is computed elsewhere.
            reflected_radiance(s, f, edges, &rng, rays, &radiance, &radiance);
        }
        cells[2 * IR_CELLS + cell] = distance;
        cells[3 * IR_CELLS + cell] = normal.x;
        cells[4 * IR_CELLS + cell] = normal.y;
        cells[5 * IR_CELLS + cell] = normal.z;
        cells[6 * IR_CELLS + cell] = radiance.x;
        cells[7 * IR_CELLS + cell] = radiance.y;
        cells[8 * IR_CELLS + cell] = radiance.z;
    }
}

IR_FN HemisphereSample load_cell(const IR_LOCAL float* cells, uint cell) {
    HemisphereSample sample;
    const float x = cells[cell], y = cells[IR_CELLS + cell];
    sample.direction = make_real3(x, y, sqrt(max(1.0f - x * x - y * y, 6e-8f)));
    sample.distance = cells[2 * IR_CELLS + cell];
    sample.normal = make_real3(cells[3 * IR_CELLS + cell], cells[4 * IR_CELLS + cell], cells[5 * IR_CELLS + cell]);
    sample.radiance = make_real3(cells[6 * IR_CELLS + cell], cells[7 * IR_CELLS + cell], cells[8 * IR_CELLS + cell]);
    return sample;
}

// Sums the cells of one work-item.
IR_FN HemisphereSums sum_cells(const IR_LOCAL float* cells, uint first, RecordParameters parameters,
                               IR_GLOBAL const float* ring_weights) {
    HemisphereSums sums = hemisphere_sums_zero();
    for (uint cell = first; cell < IR_CELLS; cell += IR_GROUP) {
        const uint j = cell / IR_N, k = cell % IR_N;
        const HemisphereSample own = load_cell(cells, cell);
        cell_moments(&sums, k, IR_N, ring_weights[j], own, own.radiance, parameters.r_min, parameters.r_max, 0.17f);
#if IR_GRADIENT != 0 || IR_RADIUS == 2
        const HemisphereSample ring = load_cell(cells, j > 0u ? cell - IR_N : cell);
        const HemisphereSample azimuth = load_cell(cells, k > 0u ? cell - 1u : cell + IR_N - 1u);
#endif
#if IR_GRADIENT == 1
        cell_edges_ward(&sums, j, k, IR_M, IR_N, own, ring, azimuth, parameters.r_min, true);
#endif
#if IR_GRADIENT == 2
        cell_edges(&sums, j, k, IR_M, IR_N, own, ring, azimuth);
#elif IR_RADIUS == 2  // the Hessian alone
        HemisphereSums edges = hemisphere_sums_zero();
        cell_edges(&edges, j, k, IR_M, IR_N, own, ring, azimuth);
        sums.hxx += edges.hxx;
        sums.hxy += edges.hxy;
        sums.hyy += edges.hyy;
#endif
    }
    return sums;
}

IR_KERNEL void sample_hemispheres(IR_SCENE_ARGS, IR_GLOBAL const ShadingPoint* points, IR_GLOBAL const uint* stack,
                                  IR_GLOBAL const float* ring_weights, IR_GLOBAL RecordKey* record_keys,
                                  IR_GLOBAL RecordValue* record_values, IR_GLOBAL uint* ray_counts,
                                  RecordParameters parameters, uint first_record, uint first_index, uint edges,
                                  uint seed) {
    IR_LOCAL_ARRAY(float, scratch, IR_SCRATCH);
    const uint item = IR_LOCAL_ID;
    const uint record = first_record + IR_GROUP_ID;  // where the record is stored
    const uint index = first_index + IR_GROUP_ID;    // what its random numbers are a function of
    IR_SCENE_INIT(s);
    const ShadingPoint q = points[stack[IR_GROUP_ID]];
    RayCount rays;
    rays.bounce = rays.shadow = 0u;
    for (uint tile = item; tile < IR_TILES; tile += IR_GROUP)
        sample_tile(&s, &q, index, tile, edges, seed, scratch, &rays);
    IR_ATOMIC_ADD(&ray_counts[IR_RAYS_BOUNCE], rays.bounce);
    IR_ATOMIC_ADD(&ray_counts[IR_RAYS_SHADOW], rays.shadow);
    if (item == 0u) IR_ATOMIC_ADD(&ray_counts[IR_RAYS_HEMISPHERE], (uint)IR_CELLS);
    IR_BARRIER();
    const HemisphereSums own = sum_cells(scratch, item, parameters, ring_weights);
    IR_BARRIER();  // everyone has read the cells: their memory now holds the sums
    store_sums(scratch, item, &own);
    IR_BARRIER();
    for (uint half_size = IR_GROUP / 2u; half_size > 0u; half_size >>= 1) {
        if (item < half_size) add_sums(scratch, item, item + half_size);
        IR_BARRIER();
    }
    if (item == 0u) {
        const HemisphereSums sums = load_sums(scratch);
        make_record(&q, &sums, parameters, &record_keys[record], &record_values[record]);
    }
}
