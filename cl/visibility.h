// What rays see through partly transparent surfaces (Mitsuba's mask): a surface of opacity a stops a ray with probability
// a, and lets the share 1 - a of a light's radiance through. Nothing else in cl/ knows of masks: a ray that passes one
// goes straight on, and counts as one ray. Without IR_FEATURE_MASKS these are the plain traversals.
#ifndef IR_VISIBILITY_H
#define IR_VISIBILITY_H
#include "random.h"
#include "surface.h"

#if IR_FEATURES & IR_FEATURE_MASKS
IR_FN float hit_opacity(const SceneData* s, real3 origin, real3 direction, const Hit* hit) {
    if (hit->primitive >= s->info->triangle_count) {
        const IR_GLOBAL Analytic* q = &s->analytics[hit->primitive - s->info->triangle_count];
        const IR_GLOBAL Material* m = &s->materials[q->material];
        if (m->opacity_texture == IR_NO_TEXTURE) return m->opacity;
    } else {
        const IR_GLOBAL Material* m = &s->materials[s->triangles[hit->primitive].material];
        if (m->opacity_texture == IR_NO_TEXTURE) return m->opacity;
    }
#if IR_FEATURES & IR_FEATURE_TEXTURES
    Surface f;
    f.p = origin + direction * hit->t;
    const HitGeometry g = hit->primitive < s->info->triangle_count ? triangle_geometry(s, hit, &f)
                                                                   : analytic_geometry(s, hit, &f);
    return clamp(texture_scalar(s, s->materials[g.material].opacity_texture, g.u, g.v), 0.0f, 1.0f);
#else
    return 1.0f;
#endif
}

// `hit` is the closest one beyond t_min; goes on past the surfaces that let the ray through.
IR_FN Hit pass_masks(const SceneData* s, real3 origin, real3 direction, float t_max, Hit hit, Rng* rng) {
    while (hit.primitive != IR_NO_PRIMITIVE && rng_real(rng) >= hit_opacity(s, origin, direction, &hit))
        hit = trace_closest(s, origin, direction, hit.t, t_max);
    return hit;
}

// Share of a light's radiance that gets along a ray.
IR_FN float trace_transmittance(const SceneData* s, real3 origin, real3 direction, float t_min, float t_max) {
    float share = 1.0f;
    while (share > 0.0f) {
        const Hit hit = trace_closest(s, origin, direction, t_min, t_max);
        if (hit.primitive == IR_NO_PRIMITIVE) break;
        share *= 1.0f - hit_opacity(s, origin, direction, &hit);
        t_min = hit.t;
    }
    return share;
}
#else
#define pass_masks(s, origin, direction, t_max, hit, rng) (hit)
IR_FN float trace_transmittance(const SceneData* s, real3 origin, real3 direction, float t_min, float t_max) {
    return trace_occluded(s, origin, direction, t_min, t_max) ? 0.0f : 1.0f;
}
#endif

// The closest surface that stops a ray.
IR_FN Hit trace_visible(const SceneData* s, real3 origin, real3 direction, float t_min, float t_max, Rng* rng) {
    const Hit hit = trace_closest(s, origin, direction, t_min, t_max);
    return pass_masks(s, origin, direction, t_max, hit, rng);
}
#endif
