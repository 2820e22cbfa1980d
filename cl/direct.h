// Direct light of up to IR_TILE surfaces at once: a light sample each, their shadow rays as one packet, and where
// -D IR_DIRECT_MIS=1 a BSDF sample too, weighed against each other by the balance heuristic. Light samples alone do where
// the one light can be sampled in solid angle; of several lights, chosen by power, the nearest may be chosen too rarely.
#ifndef IR_DIRECT_H
#define IR_DIRECT_H
#include "path.h"

#ifndef IR_DIRECT_MIS
#define IR_DIRECT_MIS 0
#endif

// What the BSDF sample of numbers v0, v1 adds to direct light at f, per unit albedo.
IR_FN real3 direct_bounce(const SceneData* s, const Surface* f, float v0, float v1, RayCount* rays) {
    const Bounce b = bounce_from(s, f, v0, v1, rays);
    if (b.hit.primitive == IR_NO_PRIMITIVE) return bounce_sky(s);
    const Surface g = surface_at(s, b.origin, b.direction, &b.hit);
    return bounce_emission(s, f->p, &b, &g);
}

// Direct light reflected at one surface, per unit albedo.
IR_FN real3 direct_radiance(const SceneData* s, const Surface* f, Rng* rng, RayCount* rays) {
    const float u0 = rng_real(rng), u1 = rng_real(rng);
    real3 radiance = next_event(s, f, u0, u1, IR_DIRECT_MIS, rays);
#if IR_DIRECT_MIS
    const float v0 = rng_real(rng), v1 = rng_real(rng);
    radiance += direct_bounce(s, f, v0, v1, rays);
#endif
    return radiance;
}

// Reflected radiance per unit albedo at surfaces[i], i < count, by the light samples of random numbers u[i], v[i] and
// BSDF samples of the random numbers (seed, stream, indices[i]).
IR_FN void direct_tile(const SceneData* s, const Surface* surfaces, uint count, const float* u, const float* v,
                       uint seed, uint stream, const uint* indices, real3* radiance, RayCount* rays) {
    float ox[IR_TILE], oy[IR_TILE], oz[IR_TILE], dx[IR_TILE], dy[IR_TILE], dz[IR_TILE], t_max[IR_TILE];
    uint lane[IR_TILE], used = 0u, occluded = 0u;
    for (uint i = 0; i < count; ++i) {
        const Surface f = surfaces[i];
        const LightSample l = sample_light(s, f.p, f.ns, u[i], v[i]);
        radiance[i] = light_sample_radiance(&f, &l, IR_DIRECT_MIS);
        if (is_zero(radiance[i])) continue;
        const real3 origin = leave_surface(&f, l.direction);
        ox[used] = origin.x;
        oy[used] = origin.y;
        oz[used] = origin.z;
        dx[used] = l.direction.x;
        dy[used] = l.direction.y;
        dz[used] = l.direction.z;
        t_max[used] = shadow_distance(&f, &l);
        lane[used++] = i;
    }
    rays->shadow += used;
    if (used > 0u) trace_tile_occluded(s, ox, oy, oz, dx, dy, dz, used, 0.0f, t_max, &occluded);
    for (uint i = 0; i < used; ++i)
        if ((occluded >> i) & 1u) radiance[lane[i]] = make_real3(0.0f, 0.0f, 0.0f);
#if IR_DIRECT_MIS
    for (uint i = 0; i < count; ++i) {
        Rng rng = rng_make(seed ^ 0x6469726du, stream, indices[i]);
        const float v0 = rng_real(&rng), v1 = rng_real(&rng);
        radiance[i] += direct_bounce(s, &surfaces[i], v0, v1, rays);
    }
#endif
}
#endif
