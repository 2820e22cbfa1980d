// Stage 4: every pixel with all its samples: direct light by next-event estimation, indirect light from the cache.
// Samples of a tile that lie on one smooth patch share one look-up at their centroid (-D IR_SHARE_LOOKUPS=1): E is
// linear over a pixel up to its second derivative, and the mean of a linear function is its value at the mean.
// A patch that no record reaches stays without indirect light; the first such place of a pixel is left in `points`, and
// the host has a record made there and the pixel shaded anew.
#include "cache.h"
#include "shade.h"

IR_FN bool wants_lookup(const TileSample* t) { return !is_zero(t->albedo); }

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

// Indirect radiance of a tile's samples, summed; *uncovered: the first sample whose patch finds no record, or `count`.
IR_FN real3 indirect_tile(const Cache* cache, const TileSample* samples, uint count, const Hit* hits, float pixel_size,
                          uint* uncovered) {
    real3 indirect = make_real3(0.0f, 0.0f, 0.0f);
    uint done = 0u;
    *uncovered = count;
    for (uint i = 0; i < count; ++i) {
        if (((done >> i) & 1u) || !wants_lookup(&samples[i])) continue;
        const Patch patch = take_patch(samples, i, count, pixel_size * hits[i].t, &done);
        real3 e;
        // Records are made at samples, not at centroids.
        const bool found = cache_lookup(cache, patch.centroid, samples[i].n, &e) ||
                           cache_lookup(cache, samples[i].p, samples[i].n, &e);
        indirect += patch.albedo_sum * e * IR_INV_PI;
        if (!found && *uncovered == count) *uncovered = i;
    }
    return indirect;
}

IR_KERNEL void shade_pixels(IR_SCENE_ARGS, IR_CACHE_ARGS, IR_GLOBAL const uint* pixels, IR_GLOBAL float* film,
                            IR_GLOBAL ShadingPoint* points, IR_GLOBAL uint* ray_counts, uint pixel_count,
                            uint first_sample, uint sample_count, uint edges, uint seed) {
    const uint slot = IR_GLOBAL_ID;
    if (slot >= pixel_count) return;
    IR_SCENE_INIT(s);
    IR_CACHE_INIT(cache);
    const uint pixel = pixels[slot];
    PixelSum sum;
    pixel_clear(&sum);
    RayCount rays;
    rays.bounce = rays.shadow = 0u;
    points[slot].state = IR_POINT_NONE;
    bool missed = false;
    for (uint i = 0; i < sample_count; i += IR_TILE) {
        TileSample samples[IR_TILE];
        Hit hits[IR_TILE];
        const uint first = first_sample + i, count = min((uint)IR_TILE, sample_count - i);
        shade_tile(&s, pixel, first, count, edges, seed, &sum, samples, hits, &rays);
        if (edges < 2u) continue;
        uint uncovered;
        sum.indirect += indirect_tile(&cache, samples, count, hits, info->camera.pixel_size, &uncovered);
        if (uncovered < count && !missed) {
            points[slot] = sample_point(&s, pixel, first + uncovered, &hits[uncovered], seed);
            missed = true;
        }
    }
    pixel_store(&sum, film, slot);
    IR_ATOMIC_ADD(&ray_counts[IR_RAYS_CAMERA], sample_count);
    IR_ATOMIC_ADD(&ray_counts[IR_RAYS_BOUNCE], rays.bounce);
    IR_ATOMIC_ADD(&ray_counts[IR_RAYS_SHADOW], rays.shadow);
}
