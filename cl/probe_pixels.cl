// Probes of a finished picture (theory 8): unbiased estimates of what single pixels ought to show, independent of the
// picture, and where the picture shows lamps.
#include "film.h"
#include "path_start.h"

// Item i: batch first_batch + i % batches of probe i / batches: `count` samples of that probe's pixel, on a set of scrambled Sobol
// points of its own, so that batches are independent of each other. Their sums of direct and indirect radiance, RGB
// each, go to sums[6 i]. Numbers depend on (seed, number of the probe, batch): the same pixel drawn twice gets others.
IR_KERNEL void probe_pixels(IR_SCENE_ARGS, IR_GLOBAL const uint* pixels, IR_GLOBAL float* sums,
                            IR_GLOBAL uint* ray_counts, uint items, uint first_probe, uint first_batch, uint batches,
                            uint count, uint edges, uint seed) {
    const uint item = IR_GLOBAL_ID;
    if (item >= items) return;
    IR_SCENE_INIT(s);
    const uint probe = first_probe + item / batches, batch = first_batch + item % batches, pixel = pixels[probe];
    const uint set = hash_uint(batch ^ hash_uint(probe ^ hash_uint(seed ^ 0x70726f62u)));
    real3 direct = make_real3(0.0f, 0.0f, 0.0f), indirect = direct;
    RayCount rays;
    rays.bounce = rays.shadow = 0u;
    for (uint first = 0; first < count; first += IR_TILE) {
        const uint tile_count = min((uint)IR_TILE, count - first);
        CameraTile tile;
        PathNumbers numbers;
        Rng rng = rng_make(set, probe, first);
        path_numbers(first, tile_count, set, &numbers);
        tile_rays(&s, pixel, tile_count, numbers.film_u, numbers.film_v, &rng, &tile);
        trace_camera_tile(&s, tile_count, &rng, &tile);
        for (uint i = 0; i < tile_count; ++i) {
            const real3 direction = tile_direction(&tile, i);
            const Hit hit = tile.hits[i];
            if (hit.primitive == IR_NO_PRIMITIVE) {
                direct += environment_radiance(&s, direction);
                continue;
            }
            const Surface f = surface_at(&s, tile_origin(&tile, i), direction, &hit);
            Rng path_rng = rng_make(set ^ 0x70617468u, probe, first + i);
            seen_radiance(&s, &f, &numbers, i, edges, &path_rng, &rays, &direct, &indirect);
        }
    }
    IR_GLOBAL float* out = sums + 6u * item;
    out[0] = direct.x;
    out[1] = direct.y;
    out[2] = direct.z;
    out[3] = indirect.x;
    out[4] = indirect.y;
    out[5] = indirect.z;
    count_up(ray_counts, IR_RAYS_CAMERA, count);
    count_up(ray_counts, IR_RAYS_BOUNCE, rays.bounce);
    count_up(ray_counts, IR_RAYS_SHADOW, rays.shadow);
}

// shows[i] = 1 where the film position (column + offset, row + offset), in pixels, shows a lamp, else 0; i = row columns +
// column. A work-item looks along IR_TILE neighbouring positions.
IR_KERNEL void find_lamps(IR_SCENE_ARGS, IR_GLOBAL uint* shows, uint columns, uint positions, float offset) {
    const uint first = IR_GLOBAL_ID * IR_TILE;
    if (first >= positions) return;
    IR_SCENE_INIT(s);
    const uint count = min((uint)IR_TILE, positions - first);
    const real3 origin = camera_origin(info);
    float dx[IR_TILE], dy[IR_TILE], dz[IR_TILE], t_max[IR_TILE], t_min = 0.0f;
    Hit hits[IR_TILE];
    for (uint i = 0; i < count; ++i) {
        const uint at = first + i;
        const CameraRay ray = camera_ray_at(info, (float)(at % columns) + offset, (float)(at / columns) + offset);
        dx[i] = ray.direction.x;
        dy[i] = ray.direction.y;
        dz[i] = ray.direction.z;
        t_max[i] = ray.t_max;
        t_min = max(t_min, ray.t_min);
    }
    trace_tile(&s, origin, dx, dy, dz, count, t_min, hits);
    Rng rng = rng_make(0x6c616d70u, first, 0u);
    for (uint i = 0; i < count; ++i) {
        const real3 direction = make_real3(dx[i], dy[i], dz[i]);
        const Hit hit = pass_masks(&s, origin, direction, t_max[i], hits[i], &rng);
        bool lamp = false;
        if (hit.primitive != IR_NO_PRIMITIVE && hit.t < t_max[i]) {
            const Surface f = surface_at(&s, origin, direction, &hit);
            lamp = !is_zero(emitted_radiance(&s, &f));
        }
        shows[first + i] = lamp ? 1u : 0u;
    }
}
