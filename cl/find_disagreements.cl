// After the iterations of radiance caching: where the records that answer a pixel's lobe disagree about what it reflects,
// another one is wanted between them, of half the reach of the least of them. The host picks some of the points that are
// pushed, has records made there, and asks again. Every other pixel of every other row is asked: a record
// serves many.
#include "point_list.h"
#include "radiance.h"
#include "see_pixel.h"

IR_KERNEL void find_disagreements(IR_SCENE_ARGS, IR_RADIANCE_ARGS, IR_GLOBAL ShadingPoint* lobe_points, uint first,
                                  uint count) {
    const uint slot = IR_GLOBAL_ID;
    if (slot >= count) return;
    IR_SCENE_INIT(s);
    IR_RADIANCE_INIT(radiance);
    const uint columns = (info->width + 1u) / 2u;
    const uint pixel = (first + slot) / columns * 2u * info->width + (first + slot) % columns * 2u;
    Seen seen;
    if (!see_pixel(&s, pixel, &seen) || !caches_lobe(&radiance, &seen.surface)) return;
    float least;
    if (!(radiance_spread(&radiance, &seen.surface, &least) > radiance_parameters.spread)) return;
    const float footprint = pixel_footprint(info, seen.direction, seen.depth, seen.surface.ng);
    if (!(0.5f * least > radiance_parameters.least * footprint)) return;
    ShadingPoint q = make_shading_point(info, &seen.surface, seen.direction, seen.depth, pixel, true);
    q.largest = 0.5f * least;
    push_point(lobe_points, &q);
}
