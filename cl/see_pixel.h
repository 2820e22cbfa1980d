// What a pixel's centre shows, behind mirrors and glass: where records are placed.
#ifndef IR_SEE_PIXEL_H
#define IR_SEE_PIXEL_H
#include "camera.h"
#include "path.h"
#include "shading_point.h"

typedef struct Seen {
    Surface surface;
    real3 direction;  // of the ray that found it
    float depth;      // of its image, along the view axis
} Seen;

// false: nothing.
IR_ONCE_FN bool see_pixel(const SceneData* s, uint pixel, Seen* seen) {
    const IR_GLOBAL SceneInfo* info = s->info;
    const CameraRay ray =
        camera_ray_at(info, (float)(pixel % info->width) + 0.5f, (float)(pixel / info->width) + 0.5f);
    const real3 origin = camera_origin(info);
    Rng rng = rng_make(0x6d697373u, pixel, 0u);
    const Hit hit = trace_visible(s, origin, ray.direction, ray.t_min, ray.t_max, &rng);
    if (hit.primitive == IR_NO_PRIMITIVE) return false;
    PathState path = path_from(surface_at(s, origin, ray.direction, &hit), hit.t);
    seen->depth = view_depth(info, ray.direction, hit.t);
    seen->direction = ray.direction;
#if IR_FEATURES & IR_FEATURE_BSDFS
    RayCount rays;
    rays.bounce = rays.shadow = 0u;
    uint used;
    float length;
    real3 unused = black();
    if (!follow_specular(s, &path, 0xffffffffu, &used, &length, &rng, &rays, &unused)) return false;
    seen->depth *= length / hit.t;
    seen->direction = -path.surface.view;
#endif
    seen->surface = path.surface;
    return true;
}
#endif
