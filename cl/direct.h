// Direct light of up to IR_TILE surfaces at once: a light sample each, their shadow rays as one packet, and where
// -D IR_DIRECT_MIS=1 a BSDF sample too, weighed against each other by the balance heuristic. Light samples alone do where
// the one light can be sampled in solid angle; of several lights, chosen by power, the nearest may be chosen too rarely.
// Glossy surfaces always take a BSDF sample, otherwise of their lobe alone, which goes on with the indirect light that the
// lobe reflects.
#ifndef IR_DIRECT_H
#define IR_DIRECT_H
#include "path.h"
#if IR_LANES == 8u
#include "light_cpu.h"
#endif

#if IR_DIRECT_MIS
#define wants_bsdf_sample(f) true
#else
#define wants_bsdf_sample(f) is_glossy(f)
#endif

// One vertex of a path, the indirect light of whose diffuse part is known from elsewhere: adds its direct light to *sum;
// true if its glossy part goes on.
IR_FN bool known_vertex(const SceneData* s, PathState* path, const bool roulette, Rng* rng, RayCount* rays, real3* sum) {
    const float u0 = rng_real(rng), u1 = rng_real(rng);
    *sum += path->throughput * next_event(s, &path->surface, u0, u1, !IR_DIRECT_MIS, rays);
    return wants_bsdf_sample(&path->surface) && path_bounce(s, path, true, roulette, rng, rays, sum);
}

// A light sample for each of the surfaces of paths[i], i < count, by random numbers u[i], v[i].
IR_FN void sample_light_tile(const SceneData* s, const PathState* paths, uint count, const float* u, const float* v,
                             LightSample* samples) {
#if IR_LANES == 8u && !(IR_FEATURES & IR_FEATURE_TEXTURED_LIGHTS)
    if (s->info->light_count == 1u && s->lights[0].kind == IR_LIGHT_QUAD) {
        const RectangleLight light = rectangle_light(&s->lights[0]);
        for (uint i = 0; i < count; i += IR_LANES) {
            float x[IR_LANES], y[IR_LANES], z[IR_LANES], a[IR_LANES], b[IR_LANES];
            for (uint j = 0; j < IR_LANES; ++j) {
                const uint k = min(i + j, count - 1u);
                const real3 p = paths[k].surface.p;
                x[j] = p.x;
                y[j] = p.y;
                z[j] = p.z;
                a[j] = u[k];
                b[j] = v[k];
            }
            sample_rectangle(&light, x, y, z, a, b, min(IR_LANES, count - i), samples + i);
        }
        return;
    }
#endif
#if IR_LANES == 8u && (IR_FEATURES & IR_FEATURE_ENVMAP)
    if (s->info->light_count == 1u && s->lights[0].kind == IR_LIGHT_ENVMAP) {
        const Light map = s->lights[0];
        sample_picture_tile(s, &map, paths, count, u, v, samples);
        return;
    }
#endif
    for (uint i = 0; i < count; ++i) samples[i] = sample_light(s, paths[i].surface.p, paths[i].surface.ns, u[i], v[i]);
}

// The same for paths[i], i < count, whose light samples take random numbers u[i], v[i] and whose BSDF samples the random
// numbers (seed, stream, indices[i]). direct[i]: the direct light; bit i of the result: its glossy part goes on. `known`:
// direct light is known already, and only the glossy parts' way is wanted.
IR_ONCE_FN uint direct_tile(const SceneData* s, PathState* paths, uint count, const float* u, const float* v, uint seed,
                            uint stream, const uint* indices, const bool known, real3* direct, RayCount* rays) {
    float ox[IR_TILE], oy[IR_TILE], oz[IR_TILE], dx[IR_TILE], dy[IR_TILE], dz[IR_TILE], t_max[IR_TILE];
    uint lane[IR_TILE], used = 0u, on = 0u;
    LightSample lights[IR_TILE];
    if (!known) sample_light_tile(s, paths, count, u, v, lights);
    for (uint i = 0; i < count; ++i) {
        const Surface* f = &paths[i].surface;
        direct[i] = black();
        if (known) continue;
        const LightSample l = lights[i];
        direct[i] = paths[i].throughput * light_sample_radiance(s, f, &l, !IR_DIRECT_MIS);
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
