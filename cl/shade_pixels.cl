// Stage 4: every pixel with all its samples: direct light by next-event estimation, indirect light from the cache.
// Samples of a tile that lie on one smooth patch share one look-up at their centroid (-D IR_SHARE_LOOKUPS=1): E is
// linear over a pixel up to its second derivative, and the mean of a linear function is its value at the mean.
// find_uncovered asks the same questions of the cache without shading: it leaves the first patch of a pixel that no
// record reaches in `points`, and the host has one made there.
#include "cache.h"
#include "shade.h"

IR_FN bool wants_lookup(const TileSample* t) { return max(max(t->albedo.x, t->albedo.y), t->albedo.z) > 0.0f; }

// A patch: the samples of a tile that share a look-up.
typedef struct Patch {
    real3 centroid, albedo_sum;
} Patch;

// The patch that begins with sample i; marks its samples in *done.
IR_FN Patch take_patch(const TileSample* samples, uint i, uint count, float pixel_width, uint* done) {
    Patch patch;
    patch.centroid = samples[i].p;
    patch.albedo_sum = samples[i].albedo;
#if IR_SHARE_LOOKUPS
    // Same normal within a degree, same tangent plane within a twentieth of a pixel, a few pixels apart at most.
    uint members = 1u;
    for (uint j = i + 1u; j < count; ++j) {
        if (((*done >> j) & 1u) || !wants_lookup(&samples[j]) || dot(samples[i].n, samples[j].n) < 0.99985f) continue;
        const real3 apart = samples[j].p - samples[i].p;
        if (fabs(dot(samples[i].n, apart)) > 0.05f * pixel_width || length(apart) > 20.0f * pixel_width) continue;
        patch.albedo_sum += samples[j].albedo;
        patch.centroid += samples[j].p;
        ++members;
        *done |= 1u << j;
    }
    patch.centroid = patch.centroid * (1.0f / (float)members);
#endif
    return patch;
}

// Indirect radiance of a tile's samples, summed.
IR_FN real3 indirect_tile(const Cache* cache, const TileSample* samples, uint count, const Hit* hits, float pixel_size) {
    real3 indirect = make_real3(0.0f, 0.0f, 0.0f);
    uint done = 0u;
    for (uint i = 0; i < count; ++i) {
        if (((done >> i) & 1u) || !wants_lookup(&samples[i])) continue;
        const Patch patch = take_patch(samples, i, count, pixel_size * hits[i].t, &done);
        real3 e;
        // Where the centroid found nothing a record was made at the first sample's own place. Rounding may group the
        // samples of a curved surface otherwise than find_uncovered did: then another of them is covered.
        bool found = cache_lookup(cache, patch.centroid, samples[i].n, &e) ||
                     cache_lookup(cache, samples[i].p, samples[i].n, &e);
        for (uint j = 0; j < count && !found; ++j)
            if (wants_lookup(&samples[j]) && dot(samples[i].n, samples[j].n) > 0.9f)
                found = cache_lookup(cache, samples[j].p, samples[j].n, &e);
        indirect += patch.albedo_sum * e * IR_INV_PI;
    }
    return indirect;
}

// The first sample whose patch finds no record, or `count`.
IR_FN uint uncovered_sample(const Cache* cache, const TileSample* samples, uint count, const Hit* hits, float pixel_size) {
    uint done = 0u;
    for (uint i = 0; i < count; ++i) {
        if (((done >> i) & 1u) || !wants_lookup(&samples[i])) continue;
        const Patch patch = take_patch(samples, i, count, pixel_size * hits[i].t, &done);
        if (!cache_covers(cache, patch.centroid, samples[i].n) && !cache_covers(cache, samples[i].p, samples[i].n))
            return i;
    }
    return count;
}

IR_FN void shade_pixel_tile(const SceneData* s, const Cache* cache, uint pixel, uint first, uint count, uint edges,
                            uint seed, PixelSum* sum, RayCount* rays) {
    TileSample samples[IR_TILE];
    Hit hits[IR_TILE];
    shade_tile(s, pixel, first, count, edges, seed, sum, samples, hits, rays);
    if (edges >= 2u) sum->indirect += indirect_tile(cache, samples, count, hits, s->info->camera.pixel_size);
}

// True if a patch of the tile finds no record; *point then is a place on it.
IR_FN bool uncovered_in_tile(const SceneData* s, const Cache* cache, uint pixel, uint first, uint count, uint seed,
                             ShadingPoint* point) {
    TileSample samples[IR_TILE];
    Hit hits[IR_TILE];
    PixelSum unused;
    pixel_clear(&unused);
    RayCount rays;
    rays.bounce = rays.shadow = 0u;
    shade_tile(s, pixel, first, count, 0u, seed, &unused, samples, hits, &rays);
    const uint i = uncovered_sample(cache, samples, count, hits, s->info->camera.pixel_size);
    if (i == count) return false;
    *point = sample_point(s, pixel, first + i, &hits[i], seed);
    return true;
}

IR_KERNEL void shade_pixels(IR_SCENE_ARGS, IR_CACHE_ARGS, IR_GLOBAL const uint* pixels, IR_GLOBAL float* film,
                            IR_GLOBAL ShadingPoint* points, IR_GLOBAL uint* ray_counts, uint pixel_count,
                            uint first_sample, uint sample_count, uint edges, uint seed) {
    const uint slot = IR_GLOBAL_ID;
    if (slot >= pixel_count) return;
    IR_SCENE_INIT(s);
    IR_CACHE_INIT(cache);
    PixelSum sum;
    pixel_clear(&sum);
    RayCount rays;
    rays.bounce = rays.shadow = 0u;
    for (uint i = 0; i < sample_count; i += IR_TILE)
        shade_pixel_tile(&s, &cache, pixels[slot], first_sample + i, min((uint)IR_TILE, sample_count - i), edges, seed,
                         &sum, &rays);
    pixel_store(&sum, film, slot);
    points[slot].state = IR_POINT_NONE;
    IR_ATOMIC_ADD(&ray_counts[IR_RAYS_CAMERA], sample_count);
    IR_ATOMIC_ADD(&ray_counts[IR_RAYS_BOUNCE], rays.bounce);
    IR_ATOMIC_ADD(&ray_counts[IR_RAYS_SHADOW], rays.shadow);
}

IR_KERNEL void find_uncovered(IR_SCENE_ARGS, IR_CACHE_ARGS, IR_GLOBAL const uint* pixels, IR_GLOBAL float* film,
                              IR_GLOBAL ShadingPoint* points, IR_GLOBAL uint* ray_counts, uint pixel_count,
                              uint first_sample, uint sample_count, uint edges, uint seed) {
    const uint slot = IR_GLOBAL_ID;
    if (slot >= pixel_count) return;
    IR_SCENE_INIT(s);
    IR_CACHE_INIT(cache);
    points[slot].state = IR_POINT_NONE;
    uint traced = 0u;
    for (uint i = 0; i < sample_count; i += IR_TILE) {
        const uint count = min((uint)IR_TILE, sample_count - i);
        traced += count;
        ShadingPoint point;
        if (uncovered_in_tile(&s, &cache, pixels[slot], first_sample + i, count, seed, &point)) {
            points[slot] = point;
            break;
        }
    }
    IR_ATOMIC_ADD(&ray_counts[IR_RAYS_CAMERA], traced);
}
