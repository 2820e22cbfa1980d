// A tile of a pixel's samples: camera rays as one packet, direct light by next-event estimation on scrambled Sobol
// points (dimensions 0, 1: film; 2, 3: light), so that a pixel's samples are stratified over its area and the light's.
#ifndef IR_SHADE_H
#define IR_SHADE_H
#include "camera.h"
#include "film.h"
#include "path.h"
#include "shading_point.h"
#include "sobol.h"

// What remains to be done for a sample: its surface, waiting for irradiance.
typedef struct TileSample {
    real3 p, n, albedo;  // albedo 0: nothing to look up
} TileSample;

// Direct light at surface f: one light sample, and where -D IR_DIRECT_MIS=1 one BSDF sample too, weighed against each
// other by the balance heuristic. Light samples alone have unbounded variance on surfaces that meet an emitter.
IR_FN real3 direct_radiance(const SceneData* s, const Surface* f, float u0, float u1, Rng* rng, RayCount* rays) {
    real3 radiance = make_real3(0.0f, 0.0f, 0.0f);
    const LightSample l = sample_light(s, f->p, f->ns, u0, u1);
    const float cosine = dot(l.direction, f->ns);
    if (l.valid && cosine > 0.0f) {
        ++rays->shadow;
        if (!trace_occluded(s, leave_surface(f, l.direction), l.direction, 0.0f, l.distance * (1.0f - 1e-4f))) {
            float weight = cosine * IR_INV_PI;
#if IR_DIRECT_MIS
            if (l.density > 0.0f) weight *= l.density / (l.density + cosine * IR_INV_PI);
#endif
            radiance += f->albedo * l.radiance * weight;
        }
    }
#if IR_DIRECT_MIS
    const float v0 = rng_real(rng), v1 = rng_real(rng);
    const real3 in_frame = cosine_direction(v0, v1);
    const real3 w = to_world(make_frame(f->ns), in_frame);
    const real3 origin = leave_surface(f, w);
    const Hit hit = trace_closest(s, origin, w, 0.0f, IR_INFINITY);
    ++rays->bounce;
    if (hit.primitive == IR_NO_PRIMITIVE) {
#if IR_FEATURES & IR_FEATURE_ENVIRONMENT
        if (s->info->environment_light != IR_NO_LIGHT)  // both densities are cosines
            radiance +=
                f->albedo * sky_radiance(s) * (1.0f / (1.0f + s->lights[s->info->environment_light].probability));
#endif
        return radiance;
    }
    const Surface g = surface_at(s, origin, w, &hit);
    if (g.emits) {
        const float density = light_density(s, (uint)g.light, f->p, fabs(dot(g.ng, w)), hit.t);
        const float own = in_frame.z * IR_INV_PI;
        radiance += f->albedo * emitted_radiance(s, &g) * (own / (own + density));
    }
#endif
    return radiance;
}

// Traces samples first .. first + count - 1 of a pixel; adds what is known without the cache to `sum` and leaves the
// surfaces that want irradiance in `samples`, with all hits in `hits`. edges = max_depth - 1: 0 = emitters only, 1 = +
// direct light.
IR_FN void shade_tile(const SceneData* s, uint pixel, uint first, uint count, uint edges, uint seed, PixelSum* sum,
                      TileSample* samples, Hit* hits, RayCount* rays) {
    const uint x = pixel % s->info->width, y = pixel / s->info->width;
    const uint pixel_seed = hash_uint(pixel ^ hash_uint(seed));
    float dx[IR_TILE], dy[IR_TILE], dz[IR_TILE], light_u[IR_TILE], light_v[IR_TILE];
    CameraRay ray;
    for (uint i = 0; i < count; ++i) {
        float u[4];
        sobol4(first + i, pixel_seed, u);
        ray = camera_ray(s->info, x, y, u[0], u[1]);
        dx[i] = ray.direction.x;
        dy[i] = ray.direction.y;
        dz[i] = ray.direction.z;
        light_u[i] = u[2];
        light_v[i] = u[3];
    }
    const real3 origin = camera_origin(s->info);
    trace_tile(s, origin, dx, dy, dz, count, ray.t_min, hits);
    for (uint i = 0; i < count; ++i) {
        samples[i].albedo = make_real3(0.0f, 0.0f, 0.0f);
        if (hits[i].primitive == IR_NO_PRIMITIVE || hits[i].t >= ray.t_max) {
            pixel_add_miss(sum, sky_radiance(s));
            continue;
        }
        const real3 direction = make_real3(dx[i], dy[i], dz[i]);
        const Surface f = surface_at(s, origin, direction, &hits[i]);
        real3 direct = emitted_radiance(s, &f);
        const bool reflects = wants_irradiance(&f);
        if (reflects && edges > 0u) {
            Rng rng = rng_make(seed ^ 0x6469726du, pixel, first + i);
            direct += direct_radiance(s, &f, light_u[i], light_v[i], &rng, rays);
        }
        pixel_add(sum, &f, hits[i].t, direct, make_real3(0.0f, 0.0f, 0.0f));
        if (reflects) {
            samples[i].p = f.p;
            samples[i].n = f.ns;
            samples[i].albedo = f.albedo;
        }
    }
}
// The surface that sample `index` of a pixel saw (`hit`, from shade_tile: a ray through an edge must not be asked
// twice, since a packet and a single ray may answer with different triangles), as a point that wants a record.
IR_FN ShadingPoint sample_point(const SceneData* s, uint pixel, uint index, const Hit* hit, uint seed) {
    float u[4];
    sobol4(index, hash_uint(pixel ^ hash_uint(seed)), u);
    const CameraRay ray = camera_ray(s->info, pixel % s->info->width, pixel / s->info->width, u[0], u[1]);
    const Surface f = surface_at(s, camera_origin(s->info), ray.direction, hit);
    return make_shading_point(s->info, &f, ray.direction, hit->t, pixel);
}
#endif
