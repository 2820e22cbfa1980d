// A tile of a pixel's samples: camera rays as one packet, direct light by next-event estimation on scrambled Sobol
// points (dimensions 0, 1: film; 2, 3: light), so that a pixel's samples are stratified over its area and the light's.
// Mirrors and glass are followed; what is left is diffuse and wants irradiance, or glossy. Glossy parts are path traced or,
// with radiance caching (-D IR_LOBES=1), wait for radiance where records are to answer them.
#ifndef IR_SHADE_H
#define IR_SHADE_H
#include "camera_tile.h"
#include "film.h"
#include "indirect.h"
#include "shading_point.h"
#include "sobol.h"
#if IR_LOBES
#include "traced_lobe.h"
#else
typedef struct Caches {
    uint none;
} Caches;
#endif

// What remains to be done for a sample: a surface that waits for irradiance.
typedef struct TileSample {
    Surface surface;
    real3 weight;     // radiance is weight / pi times irradiance; 0: nothing to look up
    real3 direction;  // of the ray that found the surface
    float depth;      // of its image, along the view axis
    bool behind;      // mirrors or glass are in between
#if IR_LOBES
    real3 throughput;  // factor of what its lobe reflects, if records are to answer that; 0: nothing to look up
#endif
} TileSample;

IR_FN bool wants_lookup(const TileSample* t) { return !is_zero(t->weight); }

// The sample's surface as a point that wants a record.
IR_FN ShadingPoint sample_point(const SceneData* s, const TileSample* t, uint pixel) {
    return make_shading_point(s->info, &t->surface, t->direction, t->depth, pixel, false);
}

// Camera rays of samples first .. first + count - 1, and the random numbers of their light samples.
IR_FN void tile_samples(const SceneData* s, uint pixel, uint first, uint count, uint seed, CameraTile* tile,
                        float* light_u, float* light_v) {
    const uint pixel_seed = hash_uint(pixel ^ hash_uint(seed));
    Rng rng = rng_make(seed ^ 0x6c656e73u, pixel, first);
    float u[IR_TILE], v[IR_TILE];
    for (uint i = 0; i < count; i += IR_LANES) {
        lanes x[4];
        sobol4_lanes(first + i, pixel_seed, x);
        lanes_store(x[0], u, i);
        lanes_store(x[1], v, i);
        lanes_store(x[2], light_u, i);
        lanes_store(x[3], light_v, i);
    }
    tile_rays(s, pixel, count, u, v, &rng, tile);
    trace_camera_tile(s, count, &rng, tile);
}

// From the first surface that a sample sees to the one that it shades: through mirrors and glass. false: there is none.
IR_FN bool reach_shaded_surface(const SceneData* s, const Grid* grid, PathState* path, uint edges, uint* used, Rng* rng,
                                PixelSum* sum, TileSample* t, RayCount* rays) {
    *used = 0u;
#if IR_FEATURES & IR_FEATURE_BSDFS
    const float first = path->distance;
    float length;
    if (!follow_specular(s, path, edges, used, &length, rng, rays, &sum->direct)) return false;
    t->behind = *used > 0u;
    if (t->behind) {
        t->depth *= length / first;
        t->direction = -path->surface.view;
    }
    if (is_specular(&path->surface)) {  // a hall of mirrors
        sum->indirect += path_radiance(s, grid, *path, edges_left(edges, *used), true, rng, rays);
        return false;
    }
#endif
    return reflects(&path->surface);
}

// Traces samples first .. first + count - 1 of a pixel; adds what is known without the cache to sums[0], of samples from
// first + second on to sums[1], and leaves the surfaces that want irradiance in `samples`. edges = max_depth - 1: 0 =
// emitters only, 1 = + direct light. `known`: direct light is known, what the sums' `direct` gets is not all of it.
IR_ONCE_FN void shade_tile(const SceneData* s, const Grid* grid, const Caches* caches, uint pixel, uint first,
                           uint count, uint edges, uint seed, const bool known, uint second, PixelSum* sums,
                           TileSample* samples, RayCount* rays) {
    CameraTile tile;
    float light_u[IR_TILE], light_v[IR_TILE];
    PathState paths[IR_TILE];  // those that reflect, with their light samples' random numbers moved down beside them
    uint indices[IR_TILE], used[IR_TILE], lit = 0u;
    tile_samples(s, pixel, first, count, seed, &tile, light_u, light_v);
    for (uint i = 0; i < count; ++i) {
        TileSample* t = &samples[i];
        PixelSum* sum = &sums[IR_SUM_OF(i, second)];
        t->weight = black();
#if IR_LOBES
        t->throughput = black();
#endif
        t->direction = tile_direction(&tile, i);
        t->behind = false;
        Rng rng = rng_make(seed ^ 0x73686164u, pixel, first + i);
        const Hit hit = tile.hits[i];
        if (hit.primitive == IR_NO_PRIMITIVE) {
            pixel_add_miss(sum, environment_radiance(s, t->direction));
            continue;
        }
        PathState path = path_from(surface_at(s, tile_origin(&tile, i), t->direction, &hit), hit.t);
        pixel_add(sum, &path.surface, hit.t, emitted_radiance(s, &path.surface), black());
        t->depth = view_depth(s->info, t->direction, hit.t);
        if (edges == 0u || !reach_shaded_surface(s, grid, &path, edges, &used[lit], &rng, sum, t, rays)) continue;
        if (used[lit] == edges) continue;
        t->surface = path.surface;
        t->weight = path.throughput * path.surface.albedo;
#if IR_LOBES
        if (caches_lobe(caches->radiance, &path.surface)) t->throughput = path.throughput;
#endif
        paths[lit] = path;
        light_u[lit] = light_u[i];
        light_v[lit] = light_v[i];
        indices[lit++] = first + i;
    }
    real3 direct[IR_TILE];
    const uint on = direct_tile(s, paths, lit, light_u, light_v, seed, pixel, indices, known, direct, rays);
    for (uint i = 0; i < lit; ++i) {
        PixelSum* sum = &sums[IR_SUM_OF(indices[i] - first, second)];
        sum->direct += direct[i];
        if (!((on >> i) & 1u)) continue;
        Rng rng = rng_make(seed ^ 0x676c6f73u, pixel, indices[i]);
#if IR_LOBES
        if (!is_zero(samples[indices[i] - first].throughput)) continue;
        sum->indirect += lobe_radiance(s, grid, caches, paths[i], edges_left(edges, used[i] + 1u), &rng, rays);
#else
        sum->indirect += path_radiance(s, grid, paths[i], edges_left(edges, used[i] + 1u), true, &rng, rays);
#endif
    }
}
#endif
