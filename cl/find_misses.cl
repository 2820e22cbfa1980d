// Stage 1 of an iteration: one pixel of every 16x16 block looks its surface up in the cache; where the records do not
// suffice it writes the point that wants one; likewise, with radiance caching (-D IR_LOBES=1), for its glossy part. The host
// gathers the marked points into the record stacks, in block order.
#include "cache.h"
#include "see_pixel.h"
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
    const uint pixel = y * info->width + x;
    Seen seen;
    if (!see_pixel(&s, pixel, &seen)) return;
    const Surface* f = &seen.surface;
#if IR_LOBES
    if (caches_lobe(&radiance, f) && !radiance_covers(&radiance, f))
        lobe_points[block] = make_shading_point(info, f, seen.direction, seen.depth, pixel, true);
#endif
    if (!is_diffuse(f) || cache_covers(&cache, f->p, f->ns, coat_of(f))) return;
    points[block] = make_shading_point(info, f, seen.direction, seen.depth, pixel, false);
}
