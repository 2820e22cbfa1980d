// Radiance along a ray by path tracing: next-event estimation at every vertex, combined with the BSDF sample that
// happens to hit a light by multiple importance sampling (Veach 1997, balance heuristic). Unbiased: Russian roulette
// starts after IR_ROULETTE_START bounces (theory 8: earlier doubles the variance) and divides by its probability.
#ifndef IR_PATH_H
#define IR_PATH_H
#include "bsdf.h"
#include "light.h"
#include "visibility.h"

// At vertices the indirect light of whose diffuse part is known from elsewhere: 1: direct light by light samples and BSDF
// samples, weighed against each other; 0: that of the diffuse part by light samples alone.
#ifndef IR_DIRECT_MIS
#define IR_DIRECT_MIS 0
#endif

#ifndef IR_ROULETTE_START
#define IR_ROULETTE_START 4u
#endif
// Largest probability of surviving a vertex: where all is reflected a path has to end some time. The mean square of its
// weight grows by albedo^2 / this at every vertex: with .95, variance was unbounded from albedo .975 on (tests/hard, furnace of .99).
#define IR_ROULETTE_MOST 0.99f

// Rays traced, by kind: what RenderStatistics reports.
typedef struct RayCount {
    uint bounce, shadow;
} RayCount;

// Radiance that a surface emits towards the viewer.
IR_FN real3 emitted_radiance(const SceneData* s, const Surface* f) {
    if (!f->emits) return black();
#if IR_FEATURES & IR_FEATURE_TEXTURES
    return area_light_radiance(s, (uint)f->light, f->u, f->v);
#else
    return area_light_radiance(s, (uint)f->light, 0.0f, 0.0f);
#endif
}

// ---- one vertex --------------------------------------------------------------------------------------------------

// What a light sample adds to the radiance reflected at `f` if nothing is in its way, weighed against the BSDF sample that
// may find the same light; `lobe`: one of the glossy part alone, if there is one, which says nothing of the diffuse part.
IR_FN real3 light_sample_radiance(const SceneData* s, const Surface* f, const LightSample* l, const bool lobe) {
    if (!l->valid) return black();
    const BsdfValue v = bsdf_evaluate(s, f, l->direction, lobe);
    const bool weighed = (!lobe || is_glossy(f)) && l->density > 0.0f;
    const float share = weighed ? l->density / (l->density + v.density) : 1.0f;
    if (lobe) return l->radiance * (v.diffuse + v.glossy * share);
    if (!(v.density > 0.0f)) return black();
    return l->radiance * (v.diffuse + v.glossy) * share;
}

// Where shadow rays from `f` end: a little before the light. They start (leave_surface) nearer to it than the surface,
// and have to end as far before it, across its surface, for rounding not to let the light shade itself.
IR_FN float shadow_distance(const Surface* f, const LightSample* l) {
    return max(l->distance * (1.0f - 1e-4f) - 2.0f * f->error / max(l->cosine, 1e-7f), 0.0f);
}

// Next-event estimation at `f` by random numbers u0, u1.
IR_FN real3 next_event(const SceneData* s, const Surface* f, float u0, float u1, const bool lobe, RayCount* rays) {
    const LightSample l = sample_light(s, f->p, f->ns, u0, u1);
    const real3 radiance = light_sample_radiance(s, f, &l, lobe);
    if (is_zero(radiance)) return radiance;
    ++rays->shadow;
    return radiance *
           trace_transmittance(s, leave_surface(f, l.direction), l.direction, 0.0f, shadow_distance(f, &l));
}

// Where a BSDF sample leads.
typedef struct Bounce {
    real3 origin;
    BsdfSample sample;
    Hit hit;
} Bounce;

// Draws a direction at f by the BSDF, or by its glossy part alone (`lobe`); false: there is none.
IR_FN bool bounce_sample(const SceneData* s, const Surface* f, const bool lobe, Rng* rng, Bounce* b) {
#if IR_FEATURES & IR_FEATURE_BSDFS
    const float u0 = rng_real(rng);
#else
    const float u0 = 0.0f;
#endif
    const float u1 = rng_real(rng), u2 = rng_real(rng);
    return bsdf_sample(s, f, u0, u1, u2, lobe, &b->sample);
}

// Finds what lies in that direction.
IR_FN void bounce_trace(const SceneData* s, const Surface* f, Rng* rng, RayCount* rays, Bounce* b) {
    b->origin = leave_surface(f, b->sample.direction);
    b->hit = trace_visible(s, b->origin, b->sample.direction, 0.0f, IR_INFINITY, rng);
    ++rays->bounce;
}

// What a bounce from f that met nothing brings: the sky, weighed against light samples of it at f.
IR_FN real3 bounce_sky(const SceneData* s, const Surface* f, const Bounce* b) {
#if IR_FEATURES & IR_FEATURE_ENVIRONMENT
    const real3 sky = environment_radiance(s, b->sample.direction);
    if (!(b->sample.density > 0.0f)) return sky;
    return sky * (b->sample.density / (b->sample.density + environment_density(s, f->p, f->ns, b->sample.direction)));
#else
    return black();
#endif
}

// What a bounce from f that met surface g brings: what g emits, weighed against light samples at f.
IR_FN real3 bounce_emission(const SceneData* s, const Surface* f, const Bounce* b, const Surface* g) {
    if (!g->emits) return black();
    const real3 radiance = emitted_radiance(s, g);
    if (!(b->sample.density > 0.0f)) return radiance;
    const float density =
        light_density(s, (uint)g->light, f->p, fabs(dot(g->ng, b->sample.direction)), b->hit.t);
    return radiance * (b->sample.density / (b->sample.density + density));
}

// ---- the path ----------------------------------------------------------------------------------------------------

typedef struct PathState {
    Surface surface;   // where the path is now
    float distance;    // length of the ray that came here
    real3 throughput;  // of everything behind it
    float eta2;        // by which refractions on the way have scaled it: not an absorption, roulette leaves it out
} PathState;

IR_FN PathState path_from(Surface f, float distance) {
    PathState path;
    path.surface = f;
    path.distance = distance;
    path.throughput = make_real3(1.0f, 1.0f, 1.0f);
    path.eta2 = 1.0f;
    return path;
}

// A sample of the BSDF at a vertex (path_follow: drawn already): adds the light that it happens to find to *sum and moves
// on; false if the path ends.
// `known`: the indirect light of the surface's diffuse part comes from elsewhere, and only its glossy part goes on.
// `roulette`: the path may end by chance, more likely the less it still carries.
IR_FN bool path_follow(const SceneData* s, PathState* path, Bounce* b, const bool known, const bool roulette, Rng* rng,
                       RayCount* rays, real3* sum) {
    const real3 all = path->throughput * (b->sample.diffuse + b->sample.glossy);
    const float survive = roulette ? min(largest_channel(all) * path->eta2, IR_ROULETTE_MOST) : 1.0f;
    if (roulette && rng_real(rng) >= survive) return false;
    bounce_trace(s, &path->surface, rng, rays, b);
    const float scale = 1.0f / survive;
    if (b->hit.primitive == IR_NO_PRIMITIVE) {
        *sum += all * bounce_sky(s, &path->surface, b) * scale;
        return false;
    }
    const Surface next = surface_at(s, b->origin, b->sample.direction, &b->hit);
    *sum += all * bounce_emission(s, &path->surface, b, &next) * scale;
#if !(IR_FEATURES & IR_FEATURE_BSDFS)
    if (known) {  // there is no glossy part, and compilers need not make what would follow it
        rng_real(rng);
        return false;
    }
#endif
    const real3 glossy = path->throughput * b->sample.glossy * scale;
    path->throughput = all * scale;
    if (known) {  // the ray goes on with the probability that it came by the glossy part
        const float share = min(largest_channel(glossy) / max(largest_channel(path->throughput), 1e-30f), 1.0f);
        if (!(rng_real(rng) < share)) return false;
        path->throughput = glossy * (1.0f / share);
    }
    path->eta2 *= b->sample.eta * b->sample.eta;
    path->surface = next;
    path->distance = b->hit.t;
    return true;
}

IR_FN bool path_bounce(const SceneData* s, PathState* path, const bool known, const bool roulette, Rng* rng,
                       RayCount* rays, real3* sum) {
    Bounce b;
    return bounce_sample(s, &path->surface, known && !IR_DIRECT_MIS, rng, &b) &&
           path_follow(s, path, &b, known, roulette, rng, rays, sum);
}

// Everything at one vertex: adds the direct light reflected there to *sum and moves on to the next surface; false if the
// path ends. `roulette`: it may end by chance.
IR_FN bool path_vertex(const SceneData* s, PathState* path, const bool roulette, Rng* rng, RayCount* rays, real3* sum) {
    if (!reflects(&path->surface)) return false;
    if (!is_specular(&path->surface)) {
        const float u0 = rng_real(rng), u1 = rng_real(rng);
        *sum += path->throughput * next_event(s, &path->surface, u0, u1, false, rays);
    }
    return path_bounce(s, path, false, roulette, rng, rays, sum);
}

// Follows a path through mirrors and glass to a surface that is neither, at most `edges` of them (and IR_SPECULAR_CHAIN):
// *used tells how many, *length how long their way is. Adds what they show of lights to *sum; false if the path ends.
#define IR_SPECULAR_CHAIN 12u
IR_FN bool follow_specular(const SceneData* s, PathState* path, uint edges, uint* used, float* length, Rng* rng,
                           RayCount* rays, real3* sum) {
    *used = 0u;
    *length = path->distance;
    while (is_specular(&path->surface) && *used < min(edges, IR_SPECULAR_CHAIN)) {
        if (!path_bounce(s, path, false, false, rng, rays, sum)) return false;
        *length += path->distance;
        ++*used;
    }
    return true;
}

// Path edges left of `edges` after `used` of them; 0xffffffff stays no limit.
IR_FN uint edges_left(uint edges, uint used) {
    return edges == 0xffffffffu ? edges : edges - min(edges, used);
}

// Radiance that a path finds from its present vertex on, the `bounce`-th, towards the viewer: light that arrives directly,
// at its first surface or at the first one behind mirrors and glass (`straight`: it has met nothing else so far), goes to
// *direct, light that arrives after further bounces to *indirect (either may be the same variable's address). `edges` =
// path edges allowed beyond the viewing ray: 1 = direct light, 2 = one bounce, ...; 0xffffffff = no limit.
IR_FN void path_on(const SceneData* s, PathState* path, uint bounce, uint edges, bool straight, Rng* rng, RayCount* rays,
                   real3* direct, real3* indirect) {
    real3 first = black(), later = first;
    for (; bounce < edges; ++bounce) {
        real3* sum = straight ? &first : &later;
        if (!is_specular(&path->surface)) straight = false;
        if (!path_vertex(s, path, bounce >= IR_ROULETTE_START, rng, rays, sum)) break;
    }
    *direct += first;
    *indirect += later;
}

// The same for all that surface `f` reflects towards the viewer.
IR_FN void reflected_radiance(const SceneData* s, Surface f, uint edges, Rng* rng, RayCount* rays, real3* direct,
                              real3* indirect) {
    PathState path = path_from(f, 0.0f);
    path_on(s, &path, 0u, edges, true, rng, rays, direct, indirect);
}
#endif
