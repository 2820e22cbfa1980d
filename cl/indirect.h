// What a path carries on beyond the vertex where the caller leaves off: path traced, until the irradiance grid answers
// (-D IR_GRID=1 or 2). A surface whose diffuse part the grid knows goes on with its glossy part alone.
#ifndef IR_INDIRECT_H
#define IR_INDIRECT_H
#include "direct.h"
#include "irradiance_grid.h"

typedef struct Grid {
    const GridParameters* parameters;
    IR_GLOBAL const GridCell* cells;
} Grid;

// The coat's transmittance of the light that the grid's irradiance stands for, taken as coming from everywhere alike: at
// 60 degrees it is that mean, within 1 % for indices of refraction from 1.3 to 1.8. Part of the grid's own error.
#define IR_MEAN_COSINE 0.5f

#if IR_GRID
IR_FN real3 reflected_grid_irradiance(const SceneData* s, const Surface* f, real3 irradiance) {
    return f->albedo * irradiance * (IR_INV_PI * coat_transmittance(s, f, IR_MEAN_COSINE));
}

// Indirect light that the diffuse part of f reflects, if the grid knows it.
IR_FN bool grid_radiance(const SceneData* s, const Grid* grid, const Surface* f, float distance, Rng* rng,
                         real3* radiance) {
    real3 e;
    if (!is_diffuse(f)) return false;
    const GridQuery query = grid_query(grid->parameters, f->p, f->ns, distance, rng);
    if (!grid_lookup(grid->parameters, grid->cells, &query, &e)) return false;
    *radiance = reflected_grid_irradiance(s, f, e);
    return true;
}
#endif

// Light that path->surface reflects to where the path came from, times the path's throughput. `edges`: as in path.h.
// `ask`: the grid may answer for the first surface already. Its ray must be long for the cells. IR_GRID=2: behind a diffuse
// surface any length does. Directions from there go everywhere, and their mean hides most of what a cell smears.
IR_FN real3 path_radiance(const SceneData* s, const Grid* grid, PathState path, uint edges, bool ask, Rng* rng,
                          RayCount* rays) {
    real3 sum = black();
    bool scattered = false;  // by a diffuse surface
    for (uint bounce = 0; bounce < edges && reflects(&path.surface); ++bounce) {
        const bool roulette = bounce >= IR_ROULETTE_START;
#if IR_GRID
        real3 radiance;
        const float distance = IR_GRID == 2 && scattered ? IR_INFINITY : path.distance;
        if (ask && grid_serves(grid->parameters, edges - bounce) &&
            grid_radiance(s, grid, &path.surface, distance, rng, &radiance)) {
            sum += path.throughput * radiance;
            if (!known_vertex(s, &path, roulette, rng, rays, &sum)) break;
            scattered = false;  // what goes on is glossy
            continue;
        }
        ask = true;
#endif
        if (bounce + 1u == edges) {  // nothing but direct light is wanted here: no ray goes on that is not needed for it
            known_vertex(s, &path, roulette, rng, rays, &sum);
            break;
        }
        scattered = is_diffuse(&path.surface);
        if (!path_vertex(s, &path, roulette, rng, rays, &sum)) break;
    }
    return sum;
}

// One sample of the irradiance by indirect light at f (what passes the coat), W·m⁻². Its mean is what a record holds.
IR_ONCE_FN real3 sampled_irradiance(const SceneData* s, const Grid* grid, const Surface* f, uint edges, Rng* rng,
                                    RayCount* rays) {
    const float u = rng_real(rng), v = rng_real(rng);
    const real3 in_frame = cosine_direction(u, v);
    const real3 w = to_world(make_frame(f->ns), in_frame);
    const real3 origin = leave_surface(f, w);
    const Hit hit = trace_visible(s, origin, w, 0.0f, IR_INFINITY, rng);
    ++rays->bounce;
    if (hit.primitive == IR_NO_PRIMITIVE) return black();
    const PathState path = path_from(surface_at(s, origin, w, &hit), hit.t);
    return path_radiance(s, grid, path, edges, true, rng, rays) *
           (IR_PI * bump_visibility(f, w) * coat_transmittance(s, f, in_frame.z));
}
#endif
