// The etalon: unbiased path tracing. One work-item a pixel; a launch adds `count` samples to each pixel's sum, which
// the host accumulates in double, so that 100 000 samples a pixel lose no precision.
#include "camera.h"
#include "path.h"
#include "film.h"

// A tile of IR_TILE samples of one pixel: camera rays as one packet, then a path each.
IR_FN void trace_path_tile(const SceneData* s, uint pixel, uint first, uint count, uint edges, uint seed,
                           PixelSum* sum, RayCount* rays) {
    const uint x = pixel % s->info->width, y = pixel / s->info->width;
    float dx[IR_TILE], dy[IR_TILE], dz[IR_TILE];
    Hit hits[IR_TILE];
    CameraRay ray;
    for (uint i = 0; i < count; ++i) {
        Rng rng = rng_make(seed, pixel, first + i);
        const float u = rng_real(&rng), v = rng_real(&rng);
        ray = camera_ray(s->info, x, y, u, v);
        dx[i] = ray.direction.x;
        dy[i] = ray.direction.y;
        dz[i] = ray.direction.z;
    }
    const real3 origin = camera_origin(s->info);
    trace_tile(s, origin, dx, dy, dz, count, ray.t_min, hits);
    for (uint i = 0; i < count; ++i) {
        const real3 direction = make_real3(dx[i], dy[i], dz[i]);
        Rng rng = rng_make(seed, pixel, (first + i) ^ 0x80000000u);
        const Hit hit = pass_masks(s, origin, direction, ray.t_max, hits[i], &rng);
        if (hit.primitive == IR_NO_PRIMITIVE || hit.t >= ray.t_max) {
            pixel_add_miss(sum, environment_radiance(s, direction));
            continue;
        }
        const Surface f = surface_at(s, origin, direction, &hit);
        real3 direct = emitted_radiance(s, &f), indirect = make_real3(0.0f, 0.0f, 0.0f);
        reflected_radiance(s, f, edges, &rng, rays, &direct, &indirect);
        pixel_add(sum, &f, hit.t, direct, indirect);
    }
}

IR_KERNEL void trace_paths(IR_SCENE_ARGS, IR_GLOBAL float* film, IR_GLOBAL uint* ray_counts, uint first_pixel,
                           uint pixel_count, uint first_sample, uint sample_count, uint edges, uint seed) {
    const uint item = IR_GLOBAL_ID;
    if (item >= pixel_count) return;
    IR_SCENE_INIT(s);
    PixelSum sum;
    pixel_clear(&sum);
    RayCount rays;
    rays.bounce = rays.shadow = 0u;
    for (uint i = 0; i < sample_count; i += IR_TILE)
        trace_path_tile(&s, first_pixel + item, first_sample + i, min((uint)IR_TILE, sample_count - i), edges, seed, &sum,
                        &rays);
    pixel_store(&sum, film, item);
    IR_ATOMIC_ADD(&ray_counts[IR_RAYS_CAMERA], sample_count);
    IR_ATOMIC_ADD(&ray_counts[IR_RAYS_BOUNCE], rays.bounce);
    IR_ATOMIC_ADD(&ray_counts[IR_RAYS_SHADOW], rays.shadow);
}
