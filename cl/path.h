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

// Radiance that leaves `f` (seen along `direction`) towards the viewer by reflection: light that arrives at f directly
// goes to *direct, light that arrives after further bounces to *indirect (either may be the same variable's address).
// `edges` = path edges still allowed beyond the viewing ray: 1 = direct light, 2 = one bounce, ...; 0xffffffff = no
// limit.
IR_FN void reflected_radiance(const SceneData* s, Surface f, uint edges, Rng* rng, RayCount* rays, real3* direct,
                              real3* indirect) {
    real3 throughput = make_real3(1.0f, 1.0f, 1.0f);
    real3 first = make_real3(0.0f, 0.0f, 0.0f), later = make_real3(0.0f, 0.0f, 0.0f);
    for (uint bounce = 0; bounce < edges; ++bounce) {
        if (max(max(f.albedo.x, f.albedo.y), f.albedo.z) <= 0.0f) break;
        throughput = throughput * f.albedo;

        // Next-event estimation; the BSDF's density of the same direction is cos / pi.
        const float u0 = rng_real(rng), u1 = rng_real(rng);
        const LightSample l = sample_light(s, f.p, f.ns, u0, u1);
        const float cosine = dot(l.direction, f.ns);
        if (l.valid && cosine > 0.0f) {
            const real3 origin = leave_surface(&f, l.direction);
            ++rays->shadow;
            if (!trace_occluded(s, origin, l.direction, 0.0f, l.distance * (1.0f - 1e-4f))) {
                const float bsdf_density = cosine * IR_INV_PI;
                const float weight = l.density > 0.0f ? l.density / (l.density + bsdf_density) : 1.0f;
                const real3 add = throughput * l.radiance * (bsdf_density * weight);
                if (bounce == 0u)
                    first += add;
                else
                    later += add;
            }
        }

        // Continue in proportion to the cosine: the throughput's factor is the albedo alone.
        const Frame frame = make_frame(f.ns);
        const float v0 = rng_real(rng), v1 = rng_real(rng);
        const real3 in_frame = cosine_direction(v0, v1);
        const real3 w = to_world(frame, in_frame);
        if (bounce >= IR_ROULETTE_START) {
            const float survive = min(max(max(throughput.x, throughput.y), throughput.z), 0.95f);
            if (rng_real(rng) >= survive) break;
            throughput = throughput * (1.0f / survive);
        }
        const real3 origin = leave_surface(&f, w);
        const Hit hit = trace_closest(s, origin, w, 0.0f, IR_INFINITY);
        ++rays->bounce;
        const float bsdf_density = in_frame.z * IR_INV_PI;
        if (hit.primitive == IR_NO_PRIMITIVE) {
#if IR_FEATURES & IR_FEATURE_ENVIRONMENT
            if (s->info->environment_light != IR_NO_LIGHT) {
                const IR_GLOBAL Light* sky = &s->lights[s->info->environment_light];
                const float weight = 1.0f / (1.0f + sky->probability);  // both densities are cosines
                const real3 add = throughput * make_real3(sky->r, sky->g, sky->b) * weight;
                if (bounce == 0u)
                    first += add;
                else
                    later += add;
            }
#endif
            break;
        }
        const real3 from = f.p;
        f = surface_at(s, origin, w, &hit);
        if (f.emits) {
            const IR_GLOBAL Light* light = &s->lights[f.light];
            const float density = light_density(s, (uint)f.light, from, fabs(dot(f.ng, w)), hit.t);
            const real3 add =
                throughput * make_real3(light->r, light->g, light->b) * (bsdf_density / (bsdf_density + density));
            if (bounce == 0u)
                first += add;
            else
                later += add;
        }
    }
    *direct += first;
    *indirect += later;
}

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
#endif
