// A tile of one pixel's camera rays: where each starts and what it sees. Through a pinhole they are one packet.
#ifndef IR_CAMERA_TILE_H
#define IR_CAMERA_TILE_H
#include "camera.h"
#include "visibility.h"

typedef struct CameraTile {
    float dx[IR_TILE], dy[IR_TILE], dz[IR_TILE];  // unit directions
    float t_min, t_max[IR_TILE];                  // clip planes, along the rays
#if IR_FEATURES & IR_FEATURE_THIN_LENS
    float ox[IR_TILE], oy[IR_TILE], oz[IR_TILE];
#else
    real3 origin;
#endif
    Hit hits[IR_TILE];
} CameraTile;

IR_FN real3 tile_direction(const CameraTile* t, uint i) { return make_real3(t->dx[i], t->dy[i], t->dz[i]); }

#if IR_FEATURES & IR_FEATURE_THIN_LENS
IR_FN real3 tile_origin(const CameraTile* t, uint i) { return make_real3(t->ox[i], t->oy[i], t->oz[i]); }
#else
IR_FN real3 tile_origin(const CameraTile* t, uint i) { return t->origin; }
#endif

// The tile's first `count` rays, of film numbers u[i], v[i] in [0, 1); the lens's come from rng. u and v hold IR_TILE
// numbers: those beyond count, which lanes load too, become the first's, so that t_min is that of the rays alone.
IR_FN void tile_rays(const SceneData* s, uint pixel, uint count, float* u, float* v, Rng* rng, CameraTile* t) {
    const IR_GLOBAL SceneInfo* info = s->info;
    const uint px = pixel % info->width, py = pixel / info->width;
    t->t_min = 0.0f;
#if IR_FEATURES & IR_FEATURE_THIN_LENS
    for (uint i = 0; i < count; ++i) {
        real3 origin;
        const float lens_u = rng_real(rng), lens_v = rng_real(rng);
        const CameraRay ray = lens_ray(info, px, py, u[i], v[i], lens_u, lens_v, &origin);
        t->ox[i] = origin.x;
        t->oy[i] = origin.y;
        t->oz[i] = origin.z;
        t->dx[i] = ray.direction.x;
        t->dy[i] = ray.direction.y;
        t->dz[i] = ray.direction.z;
        t->t_max[i] = ray.t_max;
        t->t_min = max(t->t_min, ray.t_min);
    }
#else
    t->origin = camera_origin(info);
    for (uint i = count; i < IR_TILE; ++i) {
        u[i] = u[0];
        v[i] = v[0];
    }
    for (uint i = 0; i < count; i += IR_LANES) {
        const CameraRays rays = camera_rays_at(info, film_positions(info, px, info->width, lanes_load(u, i)),
                                               film_positions(info, py, info->height, lanes_load(v, i)));
        lanes_store(rays.direction.x, t->dx, i);
        lanes_store(rays.direction.y, t->dy, i);
        lanes_store(rays.direction.z, t->dz, i);
        lanes_store(rays.t_max, t->t_max, i);
        t->t_min = max(t->t_min, lanes_max(rays.t_min));
    }
#endif
}

// Traces the first `count` rays, past masks; beyond the far clip plane there is nothing.
IR_FN void trace_camera_tile(const SceneData* s, uint count, Rng* rng, CameraTile* t) {
#if IR_FEATURES & IR_FEATURE_THIN_LENS
    for (uint i = 0; i < count; ++i)
        t->hits[i] = trace_closest(s, tile_origin(t, i), tile_direction(t, i), t->t_min, t->t_max[i]);
#else
    trace_tile(s, t->origin, t->dx, t->dy, t->dz, count, t->t_min, t->hits);
#endif
    for (uint i = 0; i < count; ++i) {
        t->hits[i] = pass_masks(s, tile_origin(t, i), tile_direction(t, i), t->t_max[i], t->hits[i], rng);
        if (t->hits[i].t >= t->t_max[i]) t->hits[i].primitive = IR_NO_PRIMITIVE;
    }
}
#endif
