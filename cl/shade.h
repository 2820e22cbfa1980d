// A tile of a pixel's samples: camera rays as one packet, direct light by next-event estimation on scrambled Sobol
// points (dimensions 0, 1: film; 2, 3: light), so that a pixel's samples are stratified over its area and the light's.
#ifndef IR_SHADE_H
#define IR_SHADE_H
#include "camera.h"
#include "direct.h"
#include "film.h"
#include "shading_point.h"
#include "sobol.h"

// What remains to be done for a sample: its surface, waiting for irradiance.
typedef struct TileSample {
    real3 p, n, albedo;  // albedo 0: nothing to look up
} TileSample;

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
    Surface lit[IR_TILE];  // those that reflect, with their light samples' random numbers moved down beside them
    uint indices[IR_TILE], lit_count = 0u;
    for (uint i = 0; i < count; ++i) {
        samples[i].albedo = make_real3(0.0f, 0.0f, 0.0f);
        if (hits[i].primitive == IR_NO_PRIMITIVE || hits[i].t >= ray.t_max) {
            pixel_add_miss(sum, sky_radiance(s));
            continue;
        }
        const Surface f = surface_at(s, origin, make_real3(dx[i], dy[i], dz[i]), &hits[i]);
        pixel_add(sum, &f, hits[i].t, emitted_radiance(s, &f), make_real3(0.0f, 0.0f, 0.0f));
        if (!reflects(&f)) continue;
        samples[i].p = f.p;
        samples[i].n = f.ns;
        samples[i].albedo = f.albedo;
        lit[lit_count] = f;
        light_u[lit_count] = light_u[i];
        light_v[lit_count] = light_v[i];
        indices[lit_count++] = first + i;
    }
    if (edges == 0u) return;
    real3 direct[IR_TILE];
    direct_tile(s, lit, lit_count, light_u, light_v, seed, pixel, indices, direct, rays);
    for (uint i = 0; i < lit_count; ++i) sum->direct += lit[i].albedo * direct[i];
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
