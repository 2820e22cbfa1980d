// Filling the irradiance grid: one work-item traces one path from the camera and leaves, at each of its vertices, the
// irradiance by indirect light that the rest of the path estimates there, or as many of the next vertices as paths may have
// behind a look-up. The table is mostly empty: slots that are taken are listed, and what comes later (merge_grid.cl) goes
// through the list.
#define IR_GRID_FILL
#include "camera.h"
#include "film.h"
#include "irradiance_grid.h"
#include "path.h"

#define IR_GRID_VERTICES 8  // vertices of a path that leave an estimate; beyond them it goes on unseen

typedef struct GridVertex {
    real3 p, n, weight;  // weight: of the radiance that comes from behind the vertex in what leaves it
    real3 direct;        // direct light that leaves it
    float cosine;        // its irradiance is that radiance times this; < 0: it wants none
} GridVertex;

// Traces a path from surface f; returns the number of its vertices that are kept. In the estimate of vertex k counts what
// the next `most` vertices reflect. tails[i]: what reaches the last one that is kept from behind it and counts for vertices
// i and on. The vertices' cells are sent for on the way: waiting for them took a third of a deposit.
IR_ONCE_FN uint grid_path(const SceneData* s, IR_GLOBAL const GridSum* sums, const GridParameters* grid, Surface f,
                          uint most, Rng* rng, GridVertex* vertices, real3* tails, RayCount* rays) {
    for (uint i = 0; i < IR_GRID_VERTICES; ++i) tails[i] = black();
    PathState path = path_from(f, 0.0f);
    for (uint k = 0; reflects(&path.surface); ++k) {
        if (k == IR_GRID_VERTICES) {
            for (uint bounce = 0; bounce < most; ++bounce) {
                real3* tail = &tails[k + bounce <= most ? 0u : k + bounce - most];
                if (!path_vertex(s, &path, bounce >= IR_ROULETTE_START, rng, rays, tail)) break;
            }
            return k;
        }
        f = path.surface;
        GridVertex* v = &vertices[k];
        v->p = f.p;
        v->n = f.ns;
        v->direct = v->weight = black();
        v->cosine = is_diffuse(&f) ? 0.0f : -1.0f;
        if (is_diffuse(&f)) grid_expect(grid, sums, f.p, f.ns);
        if (!is_specular(&f)) {
            const float u0 = rng_real(rng), u1 = rng_real(rng);
            v->direct = next_event(s, &f, u0, u1, false, rays);
        }
        Bounce b;
        if (!bounce_sample(s, &f, false, rng, &b)) return k + 1u;
        v->weight = b.sample.diffuse + b.sample.glossy;
        const float c = dot(b.sample.direction, f.ns);
        if (is_diffuse(&f) && b.sample.density > 0.0f && c > 0.0f) v->cosine = c / b.sample.density;
        if (k >= 2u) {  // roulette by what the vertex reflects
            const float survive = clamp(largest_channel(v->weight) * b.sample.eta * b.sample.eta, 0.05f, IR_ROULETTE_MOST);
            if (rng_real(rng) >= survive) {
                v->weight = black();
                v->cosine = min(v->cosine, 0.0f);
                return k + 1u;
            }
            v->weight = v->weight * (1.0f / survive);
            v->cosine *= 1.0f / survive;
        }
        bounce_trace(s, &f, rng, rays, &b);
        if (b.hit.primitive == IR_NO_PRIMITIVE) {
            v->direct += v->weight * bounce_sky(s, &f, &b);
            return k + 1u;
        }
        path = path_from(surface_at(s, b.origin, b.sample.direction, &b.hit), b.hit.t);
        v->direct += v->weight * bounce_emission(s, &f, &b, &path.surface);
        if (!reflects(&path.surface)) return k + 1u;
    }
    return 0u;
}

// The index-th of all_paths. Returns how many slots it has taken, which go to `fresh`. (Rays are counted by the kernel:
// PoCL puts functions that ask for the group into it, three times.)
IR_ONCE_FN uint fill_by_path(const SceneData* s, IR_GLOBAL GridSum* sums, const GridParameters* grid,
                             IR_GLOBAL uint* overflow, uint index, uint all_paths, uint seed, uint* fresh,
                             RayCount* rays) {
    const IR_GLOBAL SceneInfo* info = s->info;
    Rng rng = rng_make(seed ^ 0x67726964u, index, 0u);
    const CameraRay ray = camera_ray_of_part(info, index, all_paths, &rng);
    const real3 origin = camera_origin(info);
    const Hit hit = trace_visible(s, origin, ray.direction, ray.t_min, ray.t_max, &rng);
    if (hit.primitive == IR_NO_PRIMITIVE) return 0u;
    const Surface f = surface_at(s, origin, ray.direction, &hit);
    GridVertex path[IR_GRID_VERTICES];
    real3 tails[IR_GRID_VERTICES];
    const uint most = edges_left(grid->edges, 1u);  // vertices behind one that count there: direct light takes an edge
    const uint count = grid_path(s, sums, grid, f, most, &rng, path, tails, rays);
    uint taken = 0u;
    for (uint k = count; k-- > 0u;) {
        if (path[k].cosine < 0.0f) continue;
        const uint behind = count - 1u - k;
        real3 arrives = black();  // at vertex k from those behind it
        for (uint i = 0; i <= k && behind < most; ++i) arrives += tails[i];
        for (uint j = k + min(behind, most); j > k; --j) arrives = path[j].direct + path[j].weight * arrives;
        const uint slot = grid_deposit(grid, sums, path[k].p, path[k].n, arrives * path[k].cosine, overflow);
        if (slot != IR_GRID_NONE) fresh[taken++] = slot;
    }
    return taken;
}

// The same, and its slots go to the group's.
IR_INLINE_FN void fill_and_list(const SceneData* s, IR_GLOBAL GridSum* sums, const GridParameters* grid,
                                volatile IR_LOCAL uint* fresh, IR_GLOBAL uint* taken, IR_GLOBAL uint* overflow,
                                IR_GLOBAL uint* ray_counts, uint index, uint all_paths, uint seed) {
    uint own[IR_GRID_VERTICES];
    RayCount rays;
    rays.bounce = rays.shadow = 0u;
    const uint count = fill_by_path(s, sums, grid, overflow, index, all_paths, seed, own, &rays);
    count_up(ray_counts, IR_RAYS_CAMERA, 1u);
    count_up(ray_counts, IR_RAYS_BOUNCE, rays.bounce);
    count_up(ray_counts, IR_RAYS_SHADOW, rays.shadow);
    for (uint i = 0; i < count; ++i) grid_fresh_add(fresh, own[i], taken);
}

IR_KERNEL void trace_grid_paths(IR_SCENE_ARGS, IR_GLOBAL GridSum* sums, GridParameters grid, IR_GLOBAL uint* taken,
                                IR_GLOBAL uint* overflow, IR_GLOBAL uint* ray_counts, uint first_path, uint path_count,
                                uint all_paths, uint seed) {
    IR_LOCAL_ARRAY(uint, fresh, IR_GRID_FRESH_WORDS);
    IR_SCENE_INIT(s);
    grid_fresh_begin(fresh);
    if (IR_GLOBAL_ID < path_count)
        fill_and_list(&s, sums, &grid, fresh, taken, overflow, ray_counts, first_path + IR_GLOBAL_ID, all_paths, seed);
    grid_fresh_end(fresh, taken);
}
