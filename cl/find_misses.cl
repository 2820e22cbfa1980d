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

// How far a record at f may reach if another surface is close over it, in a gap or under a thing that nearly touches: as far as
// that is away, or gap_least; else IR_INFINITY. Light changes over that distance there, and records outside, which have not
// seen it, would shine into the dark.
IR_FN float narrow_reach(const SceneData* s, const CacheParameters* c, const Surface* f, float footprint) {
    if (!(c->gap_reach > 0.0f)) return IR_INFINITY;
    const Hit hit = trace_closest(s, leave_surface(f, f->ng), f->ng, 0.0f, c->gap_reach * footprint);
    return hit.primitive == IR_NO_PRIMITIVE ? IR_INFINITY : max(hit.t, c->gap_least * footprint);
}

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
    if (!is_diffuse(f)) return;
    ShadingPoint q = make_shading_point(info, f, seen.direction, seen.depth, pixel, false);
    const float reach = narrow_reach(&s, &cache_parameters, f, q.footprint);
    if (cache_covers(&cache, f->p, f->ns, coat_of(f), reach)) return;
    if (reach < IR_INFINITY) {
        q.largest = reach;
        q.least = cache_parameters.gap_least * q.footprint;
    }
    points[block] = q;
}
