// Radiance along a ray by path tracing: next-event estimation at every vertex, combined with the BSDF sample that
// happens to hit a light by multiple importance sampling (Veach 1997, balance heuristic). Unbiased: Russian roulette
// starts after IR_ROULETTE_START bounces (theory 8: earlier doubles the variance) and divides by its probability.
#ifndef IR_PATH_H
#define IR_PATH_H
#include "light.h"
#include "random.h"

#ifndef IR_ROULETTE_START
#define IR_ROULETTE_START 4u
#endif

// Rays traced, by kind: what RenderStatistics reports.
typedef struct RayCount {
    uint bounce, shadow;
} RayCount;

// Radiance that a surface emits towards the viewer.
IR_FN real3 emitted_radiance(const SceneData* s, const Surface* f) {
    if (!f->emits) return make_real3(0.0f, 0.0f, 0.0f);
    const IR_GLOBAL Light* light = &s->lights[f->light];
    return make_real3(light->r, light->g, light->b);
}

// Radiance of the sky (constant environment).
IR_FN real3 sky_radiance(const SceneData* s) {
#if IR_FEATURES & IR_FEATURE_ENVIRONMENT
    if (s->info->environment_light != IR_NO_LIGHT) {
        const IR_GLOBAL Light* sky = &s->lights[s->info->environment_light];
        return make_real3(sky->r, sky->g, sky->b);
    }
#endif
    return make_real3(0.0f, 0.0f, 0.0f);
}

// ---- one vertex: all radiances here are reflected ones per unit albedo -------------------------------------------

// What a light sample adds at `f` if nothing is in its way; 0 on the wrong side. `mis`: weighed against the BSDF sample
// that may find the same light.
IR_FN real3 light_sample_radiance(const Surface* f, const LightSample* l, const bool mis) {
    const float bsdf = dot(l->direction, f->ns) * IR_INV_PI;  // the BSDF times the cosine, and its density
    if (!l->valid || !(bsdf > 0.0f)) return make_real3(0.0f, 0.0f, 0.0f);
    return l->radiance * (mis && l->density > 0.0f ? bsdf * l->density / (l->density + bsdf) : bsdf);
}

// Where shadow rays from `f` end: a little before the light. They start (leave_surface) nearer to it than the surface,
// and have to end as far before it, across its surface, for rounding not to let the light shade itself.
IR_FN float shadow_distance(const Surface* f, const LightSample* l) {
    return max(l->distance * (1.0f - 1e-4f) - 2.0f * f->error / max(l->cosine, 1e-7f), 0.0f);
}

// Next-event estimation at `f` by random numbers u0, u1.
IR_FN real3 next_event(const SceneData* s, const Surface* f, float u0, float u1, const bool mis, RayCount* rays) {
    const LightSample l = sample_light(s, f->p, f->ns, u0, u1);
    const real3 radiance = light_sample_radiance(f, &l, mis);
    if (is_zero(radiance)) return radiance;
    ++rays->shadow;
    const bool occluded = trace_occluded(s, leave_surface(f, l.direction), l.direction, 0.0f, shadow_distance(f, &l));
    return occluded ? make_real3(0.0f, 0.0f, 0.0f) : radiance;
}

// A BSDF sample: a direction drawn in proportion to the cosine, and what lies there.
typedef struct Bounce {
    real3 origin, direction;
    float density;  // sr⁻¹
    Hit hit;
} Bounce;

IR_FN Bounce bounce_from(const SceneData* s, const Surface* f, float v0, float v1, RayCount* rays) {
    Bounce b;
    const real3 in_frame = cosine_direction(v0, v1);
    b.direction = to_world(make_frame(f->ns), in_frame);
    b.density = in_frame.z * IR_INV_PI;
    b.origin = leave_surface(f, b.direction);
    b.hit = trace_closest(s, b.origin, b.direction, 0.0f, IR_INFINITY);
    ++rays->bounce;
    return b;
}

// What a bounce adds that met nothing: the sky, weighed against light samples of it (both densities are cosines).
IR_FN real3 bounce_sky(const SceneData* s) {
#if IR_FEATURES & IR_FEATURE_ENVIRONMENT
    if (s->info->environment_light != IR_NO_LIGHT)
        return sky_radiance(s) * (1.0f / (1.0f + s->lights[s->info->environment_light].probability));
#endif
    return make_real3(0.0f, 0.0f, 0.0f);
}

// What a bounce from point `from` adds that met surface g: what g emits, weighed against the light samples at `from`.
IR_FN real3 bounce_emission(const SceneData* s, real3 from, const Bounce* b, const Surface* g) {
    if (!g->emits) return make_real3(0.0f, 0.0f, 0.0f);
    const float density = light_density(s, (uint)g->light, from, fabs(dot(g->ng, b->direction)), b->hit.t);
    return emitted_radiance(s, g) * (b->density / (b->density + density));
}

// ---- the path ----------------------------------------------------------------------------------------------------

typedef struct PathState {
    Surface surface;   // where the path is now
    float distance;    // length of the ray that came here
    real3 throughput;  // of everything behind it
} PathState;

// Everything at one vertex: adds the direct light reflected there to *sum and moves on to the next surface; false if the
// path ends.
IR_FN bool path_vertex(const SceneData* s, PathState* path, const bool roulette, Rng* rng, RayCount* rays, real3* sum) {
    Surface f = path->surface;
    if (!reflects(&f)) return false;
    real3 throughput = path->throughput * f.albedo;
    const float u0 = rng_real(rng), u1 = rng_real(rng), v0 = rng_real(rng), v1 = rng_real(rng);
    *sum += throughput * next_event(s, &f, u0, u1, true, rays);
    if (roulette) {
        const float survive = min(largest_channel(throughput), 0.95f);
        if (rng_real(rng) >= survive) return false;
        throughput = throughput * (1.0f / survive);
    }
    const Bounce b = bounce_from(s, &f, v0, v1, rays);
    if (b.hit.primitive == IR_NO_PRIMITIVE) {
        *sum += throughput * bounce_sky(s);
        return false;
    }
    const Surface next = surface_at(s, b.origin, b.direction, &b.hit);
    *sum += throughput * bounce_emission(s, f.p, &b, &next);
    path->surface = next;
    path->distance = b.hit.t;
    path->throughput = throughput;
    return true;
}

IR_FN PathState path_from(Surface f, float distance) {
    PathState path;
    path.surface = f;
    path.distance = distance;
    path.throughput = make_real3(1.0f, 1.0f, 1.0f);
    return path;
}

// Radiance that leaves `f` towards the viewer by reflection: light that arrives at f directly goes to *direct, light
// that arrives after further bounces to *indirect (either may be the same variable's address). `edges` = path edges
// still allowed beyond the viewing ray: 1 = direct light, 2 = one bounce, ...; 0xffffffff = no limit.
IR_FN void reflected_radiance(const SceneData* s, Surface f, uint edges, Rng* rng, RayCount* rays, real3* direct,
                              real3* indirect) {
    PathState path = path_from(f, 0.0f);
    real3 first = make_real3(0.0f, 0.0f, 0.0f), later = first;
    if (edges == 0u) return;
    if (path_vertex(s, &path, false, rng, rays, &first))
        for (uint bounce = 1; bounce < edges; ++bounce)
            if (!path_vertex(s, &path, bounce >= IR_ROULETTE_START, rng, rays, &later)) break;
    *direct += first;
    *indirect += later;
}
#endif
