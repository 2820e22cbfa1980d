// Stage 1 of an iteration: one pixel of every 16x16 block looks its surface up in the cache; where the records do not
// suffice it writes the point that wants one; likewise, with radiance caching (-D IR_LOBES=1), for its glossy part. The host
// gathers the marked points into the record stacks, in block order.
#include "camera.h"
#include "cache.h"
#include "path.h"
#include "shading_point.h"
#if IR_LOBES
#include "radiance.h"
#define IR_LOBE_ARGS IR_RADIANCE_ARGS, IR_GLOBAL ShadingPoint *lobe_points,
#else
#define IR_LOBE_ARGS
#endif

IR_KERNEL void find_misses(IR_SCENE_ARGS, IR_CACHE_ARGS, IR_LOBE_ARGS IR_GLOBAL ShadingPoint* points, uint x_in_block,
                           uint y_in_block, uint blocks_x, uint block_count) {
    const uint block = IR_GLOBAL_ID;
    if (block >= block_count) return;
    IR_SCENE_INIT(s);
    IR_CACHE_INIT(cache);
    points[block].state = IR_POINT_NONE;
#if IR_LOBES
    IR_RADIANCE_INIT(radiance);
    lobe_points[block].state = IR_POINT_NONE;
#endif
    const uint x = (block % blocks_x) * 16u + x_in_block, y = (block / blocks_x) * 16u + y_in_block;
    if (x >= info->width || y >= info->height) return;
    const CameraRay ray = camera_ray_at(info, (float)x + 0.5f, (float)y + 0.5f);
    const real3 origin = camera_origin(info);
    const uint pixel = y * info->width + x;
    Rng rng = rng_make(0x6d697373u, pixel, 0u);
    const Hit hit = trace_visible(&s, origin, ray.direction, ray.t_min, ray.t_max, &rng);
    if (hit.primitive == IR_NO_PRIMITIVE) return;
    PathState path = path_from(surface_at(&s, origin, ray.direction, &hit), hit.t);
    float depth = view_depth(info, ray.direction, hit.t);
    real3 direction = ray.direction;
#if IR_FEATURES & IR_FEATURE_BSDFS
    RayCount rays;
    rays.bounce = rays.shadow = 0u;
    uint used;
    float length;
    real3 unused = black();
    if (!follow_specular(&s, &path, 0xffffffffu, &used, &length, &rng, &rays, &unused)) return;
    depth *= length / hit.t;
    direction = -path.surface.view;
#endif
    const Surface* f = &path.surface;
#if IR_LOBES
    if (caches_lobe(&radiance, f)) {
        const bool covered = radiance_covers(&radiance, f);
        ShadingPoint q = make_lobe_point(info, f, direction, depth, pixel);
        if (covered && radiance_parameters.spread > 0.0f) {
            float least;
            if (radiance_spread(&radiance, f, &least) > radiance_parameters.spread &&
                0.5f * least > radiance_parameters.least * q.footprint)
                q.largest = 0.5f * least;
        }
        if (!covered || q.largest > 0.0f) lobe_points[block] = q;
    }
#endif
    if (!is_diffuse(f) || cache_covers(&cache, f->p, f->ns, coat_of(f))) return;
    points[block] = make_shading_point(info, f, direction, depth, pixel);
}
