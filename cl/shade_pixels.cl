// Stage 4: every pixel with all its samples: direct light by next-event estimation, indirect light from the cache.
// Samples of a tile that lie on one smooth patch share one look-up at their centroid (-D IR_SHARE_LOOKUPS=1): E is
// linear over a pixel up to its second derivative, and the mean of a linear function is its value at the mean. Where a
// tile is one sample, patches stay open for those that follow (open_patch.h).
// A patch that no record reaches stays without indirect light; the first such place of a pixel is pushed to `points`, and
// the host has a record made there and the pixel shaded anew. What is seen through mirrors and glass, whose curvature
// may scatter a pixel's samples over the scene, takes a sample of its irradiance instead, and so does everything once
// requests are off.
#include "cache.h"
#include "open_patch.h"
#include "point_list.h"
#include "shade.h"
#if IR_LOBES
#include "lobe_patch.h"
#endif

// Flags of shade_pixels.
#define IR_SHADE_REQUESTS 1u      // pixels that miss a record ask for it; otherwise they take samples
#define IR_SHADE_KNOWN_DIRECT 2u  // the film knows their direct light: it is not sampled
#define IR_SHADE_HALVES 4u        // the luminance of the first half of the samples less that of the other is wanted

// Whether anything may take samples: without mirrors and glass nothing does until requests are off (-D IR_NO_REQUESTS=1).
#define IR_TAKES_SAMPLES ((IR_FEATURES & IR_FEATURE_BSDFS) || IR_NO_REQUESTS)

// A patch: the samples of a tile that share a look-up.
typedef struct Patch {
    real3 centroid, weight_sums[IR_SUMS];
} Patch;

// The patch that begins with sample i; marks its samples in *done.
IR_FN Patch take_patch(const TileSample* samples, uint i, uint count, uint second, float pixel_width, uint* done) {
    Patch patch;
    const Surface* first = &samples[i].surface;
    patch.centroid = first->p;
    for (uint k = 0; k < IR_SUMS; ++k) patch.weight_sums[k] = black();
    patch.weight_sums[IR_SUM_OF(i, second)] = samples[i].weight;
#if IR_SHARE_LOOKUPS
    uint members = 1u;
    for (uint j = i + 1u; j < count; ++j) {
        const Surface* other = &samples[j].surface;
        if (((*done >> j) & 1u) || !wants_lookup(&samples[j]) ||
            !on_patch(first->p, first->ns, coat_of(first), pixel_width, other))
            continue;
        patch.weight_sums[IR_SUM_OF(j, second)] += samples[j].weight;
        patch.centroid += other->p;
        ++members;
        *done |= 1u << j;
    }
    patch.centroid = patch.centroid * (1.0f / (float)members);
#endif
    return patch;
}

// Indirect radiance of a tile's samples, added to sums; *uncovered: the first sample whose patch finds no record and ought
// to have one, or `count`.
IR_ONCE_FN void indirect_tile(const SceneData* s, const Cache* cache, const Grid* grid, const TileSample* samples,
                              uint count, uint second, PixelSum* sums, bool requests, uint edges, Rng* rng,
                              uint* uncovered, RayCount* rays) {
    real3 indirect[IR_SUMS];
    for (uint k = 0; k < IR_SUMS; ++k) indirect[k] = black();
    uint done = 0u;
    *uncovered = count;
    for (uint i = 0; i < count; ++i) {
        if (((done >> i) & 1u) || !wants_lookup(&samples[i])) continue;
        const Surface* f = &samples[i].surface;
        const Patch patch = take_patch(samples, i, count, second, s->info->camera.pixel_size * samples[i].depth, &done);
        real3 e;
        const bool found = patch_lookup(cache, patch.centroid, f->p, f->ns, coat_of(f), &e);
#if IR_TAKES_SAMPLES
        if (!found && (samples[i].behind || !requests))
            e = sampled_irradiance(s, grid, f, edges, rng, rays);
        else
#endif
        if (!found && *uncovered == count)
            *uncovered = i;
        for (uint k = 0; k < IR_SUMS; ++k) indirect[k] += patch.weight_sums[k] * e * IR_INV_PI;
    }
    for (uint k = 0; k < IR_SUMS; ++k) sums[k].indirect += indirect[k];
}

#if IR_LOBES
#define IR_LOBE_ARGS IR_RADIANCE_ARGS, IR_GLOBAL ShadingPoint *lobe_points,
#define IR_LOBE_POINTS IR_GLOBAL ShadingPoint *lobe_points,
#define IR_LOBE_POINTS_PASSED lobe_points,
#else
#define IR_LOBE_ARGS
#define IR_LOBE_POINTS
#define IR_LOBE_POINTS_PASSED
#endif

// Samples of a pixel; what they sum up to goes to its slot of the film, to *halves by how much their halves differ.
IR_ONCE_FN void shade_pixel(const SceneData* s, const Cache* cache, const Caches* caches, const Grid* grid, uint pixel,
                            uint slot, IR_GLOBAL float* film, IR_GLOBAL float* halves, IR_GLOBAL ShadingPoint* points,
                            IR_LOBE_POINTS IR_GLOBAL uint* ray_counts, uint first_sample, uint sample_count, uint edges,
                            uint flags, uint seed) {
    const bool requests = (flags & IR_SHADE_REQUESTS) != 0u;
    PixelSum sums[IR_SUMS];
    for (uint k = 0; k < IR_SUMS; ++k) pixel_clear(&sums[k]);
    RayCount rays;
    rays.bounce = rays.shadow = 0u;
    bool missed = false, lobe_missed = false;
#if IR_LOBES
    LobeMemo memo;
    memo.count = 0u;
#endif
#if IR_OPEN_PATCHES
    OpenPatches open;
    open.count = 0u;
#endif
    for (uint i = 0; i < sample_count; i += IR_TILE) {
        TileSample samples[IR_TILE];
        const uint first = first_sample + i, count = min((uint)IR_TILE, sample_count - i);
        const uint second = (flags & IR_SHADE_HALVES) != 0u ? max(sample_count / 2u, i) - i : count;
        shade_tile(s, grid, caches, pixel, first, count, edges, seed, (flags & IR_SHADE_KNOWN_DIRECT) != 0u, second, sums,
                   samples, &rays);
        if (edges < 2u) continue;
#if IR_OPEN_PATCHES
        // What is seen through mirrors and glass, or takes samples, asks at once.
        if (wants_lookup(&samples[0]) && requests && !samples[0].behind && add_to_patch(&open, s, &samples[0], pixel))
            samples[0].weight = black();
#endif
        Rng rng = rng_make(seed ^ 0x6c6f6f6bu, pixel, first);
        uint uncovered;
        indirect_tile(s, cache, grid, samples, count, second, sums, requests, edges_left(edges, 1u), &rng, &uncovered, &rays);
        if (uncovered < count && !missed) {
            const ShadingPoint q = sample_point(s, &samples[uncovered], pixel);
            push_point(points, &q);
            missed = true;
        }
#if IR_LOBES
        lobes_tile(s, caches, grid, samples, count, second, sums, requests, edges_left(edges, 1u), &rng, &memo, &uncovered,
                   &rays);
        if (uncovered < count && !lobe_missed) {
            const ShadingPoint q = make_shading_point(s->info, &samples[uncovered].surface, samples[uncovered].direction,
                                                      samples[uncovered].depth, pixel, true);
            push_point(lobe_points, &q);
            lobe_missed = true;
        }
#endif
    }
#if IR_OPEN_PATCHES
    for (uint i = 0; i < open.count; ++i) {
        bool found;
        sums[0].indirect += patch_radiance(cache, &open.patches[i], &found);
        if (found || missed) continue;
        push_point(points, &open.patches[i].first);
        missed = true;
    }
#endif
    if (missed || lobe_missed) count_up(ray_counts, IR_REQUESTS, 1u);
    const PixelSum whole = pixel_whole(sums);
    pixel_store(&whole, film, slot);
#if IR_TILE > 1
    if ((flags & IR_SHADE_HALVES) != 0u)
        *halves = luminance(sums[0].direct + sums[0].indirect) - luminance(sums[1].direct + sums[1].indirect);
#endif
    count_up(ray_counts, IR_RAYS_CAMERA, sample_count);
    count_up(ray_counts, IR_RAYS_BOUNCE, rays.bounce);
    count_up(ray_counts, IR_RAYS_SHADOW, rays.shadow);
}

IR_KERNEL void shade_pixels(IR_SCENE_ARGS, IR_CACHE_ARGS, IR_LOBE_ARGS IR_GLOBAL const GridCell* grid_cells,
                            GridParameters grid_parameters, IR_GLOBAL const uint* pixels, IR_GLOBAL float* film,
                            IR_GLOBAL ShadingPoint* points, IR_GLOBAL uint* ray_counts, uint pixel_count,
                            uint first_sample, uint sample_count, uint share, uint edges, uint flags, uint seed) {
    // Work-items share out a pixel's samples, `share` for each; slots of those of the first shares of all pixels come first.
    const uint slot = IR_GLOBAL_ID, before = slot / pixel_count * share;
    if (before >= sample_count) return;
    IR_SCENE_INIT(s);
    IR_CACHE_INIT(cache);
    Grid grid;
    grid.parameters = &grid_parameters;
    grid.cells = grid_cells;
    Caches caches;
#if IR_LOBES
    IR_RADIANCE_INIT(radiance);
    caches.irradiance = &cache;
    caches.radiance = &radiance;
#else
    caches.none = 0u;
#endif
    shade_pixel(&s, &cache, &caches, &grid, pixels[slot % pixel_count], slot, film,
                film + IR_FILM_CHANNELS * pixel_count + slot, points, IR_LOBE_POINTS_PASSED ray_counts,
                first_sample + before, min(share, sample_count - before), edges, flags, seed);
}
