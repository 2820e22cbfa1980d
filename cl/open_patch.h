// Patches: the samples of a pixel that lie on one smooth surface and share a look-up (shade_pixels.cl). Devices that take one
// sample at a time keep patches open, so that their samples share look-ups too: most pixels ask once or twice, however
// many samples they take.
#ifndef IR_OPEN_PATCH_H
#define IR_OPEN_PATCH_H
#include "cache.h"
#include "film.h"
#include "point_list.h"
#include "shade.h"

// Does f lie on the patch that began at p, with normal n and coat `coat`? Same normal within a degree, same tangent plane
// within a twentieth of a pixel, a few pixels apart at most.
IR_FN bool on_patch(real3 p, real3 n, uint coat, float pixel_width, const Surface* f) {
    const real3 apart = f->p - p;
    return dot(n, f->ns) >= 0.99985f && coat == coat_of(f) && fabs(dot(n, apart)) <= 0.05f * pixel_width &&
           length(apart) <= 20.0f * pixel_width;
}

// Irradiance for a patch that began at p: at its centroid, or where no record reaches that, at p. Records are made at
// samples, not at centroids. false: none reaches p either.
IR_FN bool patch_lookup(const Cache* cache, real3 centroid, real3 p, real3 n, uint coat, real3* irradiance) {
    return cache_lookup(cache, centroid, n, coat, irradiance) || cache_lookup(cache, p, n, coat, irradiance);
}

#if IR_TILE == 1 && IR_SHARE_LOOKUPS
#define IR_OPEN_PATCHES 4u  // an edge lies between two, a corner between three

typedef struct OpenPatch {
    ShadingPoint first;  // as a point that wants a record
    real3 p, n;          // of the first sample
    uint coat;
    float pixel_width, members;
    real3 position_sum, weight_sum;
} OpenPatch;

typedef struct OpenPatches {
    OpenPatch patches[IR_OPEN_PATCHES];
    uint count;
} OpenPatches;

// Puts t on the patch that it lies on, if need be a new one; false if there are as many as may be.
IR_FN bool add_to_patch(OpenPatches* open, const SceneData* s, const TileSample* t, uint pixel) {
    uint i = 0u;
    while (i < open->count && !on_patch(open->patches[i].p, open->patches[i].n, open->patches[i].coat,
                                        open->patches[i].pixel_width, &t->surface))
        ++i;
    if (i == IR_OPEN_PATCHES) return false;
    OpenPatch* patch = &open->patches[i];
    if (i == open->count) {
        ++open->count;
        patch->first = sample_point(s, t, pixel);
        patch->p = t->surface.p;
        patch->n = t->surface.ns;
        patch->coat = coat_of(&t->surface);
        patch->pixel_width = s->info->camera.pixel_size * t->depth;
        patch->members = 0.0f;
        patch->position_sum = patch->weight_sum = black();
    }
    patch->position_sum += t->surface.p;
    patch->weight_sum += t->weight;
    patch->members += 1.0f;
    return true;
}

// Indirect radiance of a patch's samples, summed; *found: did any record apply?
IR_FN real3 patch_radiance(const Cache* cache, const OpenPatch* patch, bool* found) {
    const real3 centroid = patch->position_sum * (1.0f / patch->members);
    real3 e;
    *found = patch_lookup(cache, centroid, patch->p, patch->n, patch->coat, &e);
    return patch->weight_sum * e * IR_INV_PI;
}
#else
#define IR_OPEN_PATCHES 0u
#endif
#endif
