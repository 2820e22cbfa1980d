// Stage 1 of an iteration: pixels look their surfaces up in the cache; where the records do not suffice they push the point
// that wants one; likewise, with radiance caching (-D IR_LOBES=1), for their glossy parts. The host chooses from them what
// goes on the record stacks.
#include "cache.h"
#include "point_list.h"
#include "see_pixel.h"
#include "shading_point.h"
#if IR_LOBES
#include "radiance.h"
#define IR_LOBE_ARGS IR_RADIANCE_ARGS, IR_GLOBAL ShadingPoint *lobe_points,
#define IR_LOBE_PARAMETERS const RadianceCache *radiance, IR_GLOBAL ShadingPoint *lobe_points,
#define IR_LOBES_PASSED &radiance, lobe_points,
#else
#define IR_LOBE_ARGS
#define IR_LOBE_PARAMETERS
#define IR_LOBES_PASSED
#endif

// How far a record at f may reach if another surface is close over it, in a gap or under a thing that nearly touches: as far as
// that is away, or gap_least; else IR_INFINITY. Light changes over that distance there, and records outside, which have not
// seen it, would shine into the dark.
IR_FN float narrow_reach(const SceneData* s, const CacheParameters* c, const Surface* f, float footprint) {
    if (!(c->gap_reach > 0.0f)) return IR_INFINITY;
    const Hit hit = trace_closest(s, leave_surface(f, f->ng), f->ng, 0.0f, c->gap_reach * footprint);
    return hit.primitive == IR_NO_PRIMITIVE ? IR_INFINITY : max(hit.t, c->gap_least * footprint);
}

// Distance from f to the nearest ledge beside it: a surface that a look sideways close over f meets, and a higher look does
// not. What light passes over it at grazing angles leaves a strip along it dark, of which records outside know nothing; a
// wall, which meets both looks, keeps such light from all around. IR_INFINITY: none within `far`.
IR_FN float ledge_distance(const SceneData* s, const Surface* f, float footprint, float far) {
    const Frame frame = make_frame(f->ng);
    const real3 low = f->p + f->ng * (0.25f * footprint), high = f->p + f->ng * (0.5f * far);
    float least = IR_INFINITY;
    for (uint side = 0; side < 4u; ++side) {
        const real3 direction = (side & 1u ? frame.b : frame.t) * (side & 2u ? -1.0f : 1.0f);
        const Hit hit = trace_closest(s, low, direction, 0.0f, min(far, least));
        if (hit.primitive == IR_NO_PRIMITIVE) continue;
        if (trace_closest(s, high, direction, 0.0f, hit.t + footprint).primitive == IR_NO_PRIMITIVE) least = hit.t;
    }
    return least;
}

// Do the records suffice at f? If not, *reach is how far the one to be made may reach; if so, less than infinity where other
// surfaces are near. Beside a ledge they must agree, or be as short as it is near: where no light passes over it, a strip
// costs nothing.
IR_FN bool records_suffice(const SceneData* s, const Cache* cache, const Surface* f, float footprint, float* reach) {
    const CacheParameters* c = &cache->parameters;
    *reach = narrow_reach(s, c, f, footprint);
    if (!cache_covers(cache, f->p, f->ns, coat_of(f), *reach)) return false;
    const float least_support = 0.5f * c->gap_reach;  // of records elsewhere
    if (*reach < IR_INFINITY || c->gap_least >= least_support) return true;
    // From where those reach here, and from as far as what is about a pixel high leaves its strip.
    const float far = max(least_support, 2.0f) * footprint, ledge = ledge_distance(s, f, footprint, far);
    if (ledge == IR_INFINITY) return true;
    *reach = max(ledge, c->gap_least * footprint);
    if (cache_agrees(cache, f->p, f->ns, coat_of(f), 2.0f * far)) return true;
    return cache_covers(cache, f->p, f->ns, coat_of(f), *reach);
}

// Tells in its IR_PLAIN_WORDS that a pixel shows f, without anything near. Normals count in steps of 1/511.
IR_FN void tell_plain(IR_GLOBAL uint* plain, const Surface* f) {
    const uint code = (uint)(f->ns.x * 511.0f + 512.5f) | ((uint)(f->ns.y * 511.0f + 512.5f) << 10) |
                      ((uint)(f->ns.z * 511.0f + 512.5f) << 20);
    plain[0] = (code ^ (coat_of(f) * 0x9e3779b1u)) | 0x80000000u;
    plain[1] = IR_AS_UINT(dot(f->ns, f->p));
}

// `plain`: the pixel's words; null: nobody wants to know.
IR_ONCE_FN void find_miss(const SceneData* s, const Cache* cache, IR_LOBE_PARAMETERS IR_GLOBAL ShadingPoint* points,
                          IR_GLOBAL uint* plain, uint pixel) {
    Seen seen;
    const bool sees = see_pixel(s, pixel, &seen);
    if (plain != 0) {
        plain[0] = sees ? 0u : 1u;
        plain[1] = 0u;
    }
    if (!sees) return;
    const Surface* f = &seen.surface;
#if IR_LOBES
    if (caches_lobe(radiance, f) && !radiance_covers(radiance, f)) {
        const ShadingPoint q = make_shading_point(s->info, f, seen.direction, seen.depth, pixel, true);
        push_point(lobe_points, &q);
        plain = 0;
    }
#endif
    if (!is_diffuse(f)) return;
    ShadingPoint q = make_shading_point(s->info, f, seen.direction, seen.depth, pixel, false);
    float reach;
    if (records_suffice(s, cache, f, q.footprint, &reach)) {
        if (plain != 0 && reach == IR_INFINITY) tell_plain(plain, f);
        return;
    }
    if (reach < IR_INFINITY) {
        q.largest = reach;
        q.least = cache->parameters.gap_least * q.footprint;
    }
    push_point(points, &q);
}

IR_KERNEL void find_misses(IR_SCENE_ARGS, IR_CACHE_ARGS, IR_LOBE_ARGS IR_GLOBAL ShadingPoint* points,
                           IR_GLOBAL const uint* pixels, uint count, IR_GLOBAL uint* plain_words, uint tell) {
    if (IR_GLOBAL_ID >= count) return;
    IR_SCENE_INIT(s);
    IR_CACHE_INIT(cache);
#if IR_LOBES
    IR_RADIANCE_INIT(radiance);
#endif
    const uint pixel = pixels[IR_GLOBAL_ID], x = pixel % s.info->width, y = pixel / s.info->width;
    IR_GLOBAL uint* plain = 0;
    if (tell != 0u && ((x | y) & 1u) == 0u)
        plain = plain_words + IR_PLAIN_WORDS * ((size_t)(y / 2u) * ((s.info->width + 1u) / 2u) + x / 2u);
    find_miss(&s, &cache, IR_LOBES_PASSED points, plain, pixel);
}
