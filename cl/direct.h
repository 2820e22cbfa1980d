// Direct light of up to IR_TILE surfaces at once: a light sample each, their shadow rays as one packet, and where
// -D IR_DIRECT_MIS=1 a BSDF sample too, weighed against each other by the balance heuristic. Light samples alone do where
// the one light can be sampled in solid angle; of several lights, chosen by power, the nearest may be chosen too rarely.
// Glossy surfaces always take a BSDF sample, which then goes on with what their glossy part reflects of indirect light.
#ifndef IR_DIRECT_H
#define IR_DIRECT_H
#include "path.h"

#ifndef IR_DIRECT_MIS
#define IR_DIRECT_MIS 0
#endif
#if IR_DIRECT_MIS
#define wants_bsdf_sample(f) true
#else
#define wants_bsdf_sample(f) is_glossy(f)
#endif

// One vertex of a path, the indirect light of whose diffuse part is known from elsewhere: adds its direct light to *sum;
// true if its glossy part goes on.
IR_FN bool known_vertex(const SceneData* s, PathState* path, const bool roulette, Rng* rng, RayCount* rays, real3* sum) {
    const bool mis = wants_bsdf_sample(&path->surface);
    const float u0 = rng_real(rng), u1 = rng_real(rng);
    *sum += path->throughput * next_event(s, &path->surface, u0, u1, mis, rays);
    return mis && path_bounce(s, path, true, roulette, rng, rays, sum);
}

// The same for paths[i], i < count, whose light samples take random numbers u[i], v[i] and whose BSDF samples the random
// numbers (seed, stream, indices[i]). direct[i]: the direct light; bit i of the result: its glossy part goes on. `known`:
// direct light is known already, and only the glossy parts' way is wanted.
IR_ONCE_FN uint direct_tile(const SceneData* s, PathState* paths, uint count, const float* u, const float* v, uint seed,
                            uint stream, const uint* indices, const bool known, real3* direct, RayCount* rays) {
    float ox[IR_TILE], oy[IR_TILE], oz[IR_TILE], dx[IR_TILE], dy[IR_TILE], dz[IR_TILE], t_max[IR_TILE];
    uint lane[IR_TILE], used = 0u, on = 0u;
    for (uint i = 0; i < count; ++i) {
        const Surface* f = &paths[i].surface;
        direct[i] = black();
        if (known) continue;
        const LightSample l = sample_light(s, f->p, f->ns, u[i], v[i]);
        direct[i] = paths[i].throughput * light_sample_radiance(s, f, &l, wants_bsdf_sample(f));
        if (is_zero(direct[i])) continue;
        const real3 origin = leave_surface(f, l.direction);
        ox[used] = origin.x;
        oy[used] = origin.y;
        oz[used] = origin.z;
        dx[used] = l.direction.x;
        dy[used] = l.direction.y;
        dz[used] = l.direction.z;
        t_max[used] = shadow_distance(f, &l);
        lane[used++] = i;
    }
    rays->shadow += used;
#if IR_FEATURES & IR_FEATURE_MASKS
    for (uint i = 0; i < used; ++i)
        direct[lane[i]] = direct[lane[i]] * trace_transmittance(s, make_real3(ox[i], oy[i], oz[i]),
                                                                make_real3(dx[i], dy[i], dz[i]), 0.0f, t_max[i]);
#else
    uint occluded = 0u;
    if (used > 0u) trace_tile_occluded(s, ox, oy, oz, dx, dy, dz, used, 0.0f, t_max, &occluded);
    for (uint i = 0; i < used; ++i)
        if ((occluded >> i) & 1u) direct[lane[i]] = black();
#endif
    for (uint i = 0; i < count; ++i) {
        if (!(known ? is_glossy(&paths[i].surface) : wants_bsdf_sample(&paths[i].surface))) continue;
        Rng rng = rng_make(seed ^ 0x6469726du, stream, indices[i]);
        if (path_bounce(s, &paths[i], true, false, &rng, rays, &direct[i])) on |= 1u << i;
    }
    return on;
}
#endif
