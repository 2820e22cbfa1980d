// A tile of one pixel's paths, whose first vertices take scrambled Sobol points: dimensions 0, 1 the film, 2, 3 the light
// sample; of the same points in another order 0, 1 the direction and 2 the lobe of the BSDF sample. What follows is drawn
// independently.
#ifndef IR_PATH_START_H
#define IR_PATH_START_H
#include "camera_tile.h"
#include "path.h"
#include "sobol.h"

typedef struct PathNumbers {
    float film_u[IR_TILE], film_v[IR_TILE];
    float light_u[IR_TILE], light_v[IR_TILE];
    float bsdf_u[IR_TILE], bsdf_v[IR_TILE], lobe[IR_TILE];
} PathNumbers;

// Of points first .. first + count - 1 of `set`.
IR_FN void path_numbers(uint first, uint count, uint set, PathNumbers* n) {
    for (uint i = 0; i < count; i += IR_LANES) {
        lanes x[4];
        sobol4_lanes(first + i, set, x);
        lanes_store(x[0], n->film_u, i);
        lanes_store(x[1], n->film_v, i);
        lanes_store(x[2], n->light_u, i);
        lanes_store(x[3], n->light_v, i);
        sobol4_shuffled(first + i, set, x);
        lanes_store(x[0], n->bsdf_u, i);
        lanes_store(x[1], n->bsdf_v, i);
        lanes_store(x[2], n->lobe, i);
    }
}

// Radiance that the surface which path i of a tile sees emits and reflects: as reflected_radiance().
IR_FN void seen_radiance(const SceneData* s, const Surface* f, const PathNumbers* n, uint i, uint edges, Rng* rng,
                         RayCount* rays, real3* direct, real3* indirect) {
    *direct += emitted_radiance(s, f);
    if (edges == 0u || !reflects(f)) return;
    PathState path = path_from(*f, 0.0f);
    const bool straight = is_specular(f);
    if (!straight) *direct += next_event(s, f, n->light_u[i], n->light_v[i], false, rays);
    Bounce b;
    if (!bsdf_sample(s, f, n->lobe[i], n->bsdf_u[i], n->bsdf_v[i], false, &b.sample)) return;
    if (!path_follow(s, &path, &b, false, false, rng, rays, direct)) return;
    path_on(s, &path, 1u, edges, straight, rng, rays, direct, indirect);
}
#endif
