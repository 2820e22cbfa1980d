// Look-ups of radiance for the samples of a pixel. Samples on one smooth patch share one, at their centroid and for their
// mean normal and view (-D IR_SHARE_LOOKUPS=1), and so do those of later tiles: what a lobe reflects is linear over a pixel
// up to its second derivative.
#ifndef IR_LOBE_PATCH_H
#define IR_LOBE_PATCH_H
#include "shade.h"

#define IR_MEMO 4u
typedef struct LobeMemo {  // patches of a pixel that have been looked up
    Surface surfaces[IR_MEMO];
    real3 radiance[IR_MEMO];
    uint count;
} LobeMemo;

// May samples on both surfaces share a look-up: the same material and roughness, a few pixels apart at most and on one
// sheet, normals and views that differ by little of the lobe's width?
IR_FN bool share_lobe(const Surface* a, const Surface* b, float pixel_width) {
#if IR_SHARE_LOOKUPS
    const real3 apart = b->p - a->p, turn = b->view - a->view, tilt = b->ns - a->ns;
    const float width = 0.2f * a->alpha_u, distance = length(apart);
    return a->material_index == b->material_index && fabs(a->alpha_u - b->alpha_u) <= 0.02f * a->alpha_u &&
           dot(tilt, tilt) < width * width && dot(turn, turn) < width * width && distance <= 20.0f * pixel_width &&
           fabs(dot(a->ns, apart)) <= 0.05f * pixel_width + width * distance;
#else
    return false;
#endif
}

// Surface of sample i with the means of position, normal and view over all samples of the tile that share its look-up.
IR_FN Surface lobe_patch(const TileSample* samples, uint i, uint count, float pixel_width) {
    Surface f = samples[i].surface;
    real3 p = f.p, n = f.ns, view = f.view;
    float members = 1.0f;
    for (uint j = i + 1u; j < count; ++j) {
        if (is_zero(samples[j].throughput) || !share_lobe(&samples[i].surface, &samples[j].surface, pixel_width)) continue;
        p += samples[j].surface.p;
        n += samples[j].surface.ns;
        view += samples[j].surface.view;
        members += 1.0f;
    }
    f.p = p * (1.0f / members);
    f.ns = normalize(n);
    f.view = normalize(view);
    return f;
}

// Radiance of a tile's lobes that records answer, added to sums; *uncovered: the first sample that no record reaches and
// that ought to have one, or `count`.
IR_FN void lobes_tile(const SceneData* s, const Caches* caches, const Grid* grid, const TileSample* samples, uint count,
                      uint second, PixelSum* sums, bool requests, uint edges, Rng* rng, LobeMemo* memo, uint* uncovered,
                      RayCount* rays) {
    real3 indirect[IR_SUMS];
    for (uint k = 0; k < IR_SUMS; ++k) indirect[k] = black();
    *uncovered = count;
    for (uint i = 0; i < count; ++i) {
        if (is_zero(samples[i].throughput)) continue;
        const Surface* f = &samples[i].surface;
        const float pixel_width = s->info->camera.pixel_size * samples[i].depth;
        uint known = 0u;
        while (known < memo->count && !share_lobe(&memo->surfaces[known], f, pixel_width)) ++known;
        real3 radiance;
        if (known < memo->count) {
            radiance = memo->radiance[known];
        } else {
            const Surface patch = lobe_patch(samples, i, count, pixel_width);
            const bool found = radiance_lookup(caches->radiance, &patch, patch.p, &radiance) ||
                               radiance_lookup(caches->radiance, f, f->p, &radiance);
            if (!found && (samples[i].behind || !requests)) {
                indirect[IR_SUM_OF(i, second)] += samples[i].throughput * sampled_lobe(s, grid, caches, f, edges, rng, rays);
                continue;
            }
            if (!found && *uncovered == count) *uncovered = i;
            if (memo->count < IR_MEMO) {
                memo->surfaces[memo->count] = patch;
                memo->radiance[memo->count++] = radiance;
            }
        }
        indirect[IR_SUM_OF(i, second)] += samples[i].throughput * f->specular * radiance;
    }
    for (uint k = 0; k < IR_SUMS; ++k) sums[k].indirect += indirect[k];
}
#endif
