// Plain gathering: a hemisphere at every sample of every pixel, no cache. What the cache's time is compared with.
// gather_points shades one sample of each pixel but for its indirect light and leaves the point; the host has
// sample_hemispheres run over all of them; gather_irradiance adds what they found.
#include "irradia/shared/record_types.h"
#include "shade.h"

IR_KERNEL void gather_points(IR_SCENE_ARGS, IR_GLOBAL float* film, IR_GLOBAL ShadingPoint* points,
                             IR_GLOBAL float* albedos, IR_GLOBAL uint* ray_counts, uint first_pixel, uint pixel_count,
                             uint sample, uint edges, uint seed) {
    const uint slot = IR_GLOBAL_ID;
    if (slot >= pixel_count) return;
    IR_SCENE_INIT(s);
    const uint pixel = first_pixel + slot;
    PixelSum sum;
    pixel_clear(&sum);
    RayCount rays;
    rays.bounce = rays.shadow = 0u;
    TileSample samples[IR_TILE];
    Grid grid;
    grid.parameters = 0;
    grid.cells = 0;
    shade_tile(&s, &grid, 0, pixel, sample, 1u, edges, seed, false, 1u, &sum, samples, &rays);
    pixel_store(&sum, film, slot);
    const real3 albedo = samples[0].weight;
    points[slot].state = IR_POINT_NONE;
    if (edges >= 2u && !is_zero(albedo)) {
        points[slot] = sample_point(&s, &samples[0], pixel);
        albedos[3u * slot] = albedo.x;
        albedos[3u * slot + 1u] = albedo.y;
        albedos[3u * slot + 2u] = albedo.z;
    }
    count_up(ray_counts, IR_RAYS_CAMERA, 1u);
    count_up(ray_counts, IR_RAYS_BOUNCE, rays.bounce);
    count_up(ray_counts, IR_RAYS_SHADOW, rays.shadow);
}

IR_KERNEL void gather_irradiance(IR_GLOBAL float* film, IR_GLOBAL const float* albedos, IR_GLOBAL const uint* stack,
                                 IR_GLOBAL const RecordValue* values, uint channels, uint count) {
    if (IR_GLOBAL_ID >= count) return;
    const uint slot = stack[IR_GLOBAL_ID];
    for (uint c = 0; c < 3u; ++c)
        film[slot * channels + 3u + c] += albedos[3u * slot + c] * values[IR_GLOBAL_ID].e[c] * IR_INV_PI;
}
