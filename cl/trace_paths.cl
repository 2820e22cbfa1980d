// The etalon: unbiased path tracing. One work-item a pixel; a launch adds `count` samples to each pixel's sum, which
// the host accumulates in double, so that 100 000 samples a pixel lose no precision.
#include "film.h"
#include "path_start.h"

// A tile of IR_TILE samples of one pixel: camera rays as one packet, then a path each.
IR_ONCE_FN void trace_path_tile(const SceneData* s, uint pixel, uint first, uint count, uint edges, uint seed,
                                PixelSum* sum, RayCount* rays) {
    CameraTile tile;
    Rng tile_rng = rng_make(seed ^ 0x6c656e73u, pixel, first);
    PathNumbers numbers;
    // Points of its own: a picture by the cache, of the same seed, must not share the noise of the etalon that judges it.
    path_numbers(first, count, hash_uint(pixel ^ hash_uint(seed ^ 0x65746c6eu)), &numbers);
    tile_rays(s, pixel, count, numbers.film_u, numbers.film_v, &tile_rng, &tile);
    trace_camera_tile(s, count, &tile_rng, &tile);
    for (uint i = 0; i < count; ++i) {
        const real3 direction = tile_direction(&tile, i);
        const Hit hit = tile.hits[i];
        if (hit.primitive == IR_NO_PRIMITIVE) {
            pixel_add_miss(sum, environment_radiance(s, direction));
            continue;
        }
        Rng rng = rng_make(seed, pixel, first + i);
        const Surface f = surface_at(s, tile_origin(&tile, i), direction, &hit);
        real3 direct = make_real3(0.0f, 0.0f, 0.0f), indirect = direct;
        seen_radiance(s, &f, &numbers, i, edges, &rng, rays, &direct, &indirect);
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
    count_up(ray_counts, IR_RAYS_CAMERA, sample_count);
    count_up(ray_counts, IR_RAYS_BOUNCE, rays.bounce);
    count_up(ray_counts, IR_RAYS_SHADOW, rays.shadow);
}
