// Points that want a record or a hemisphere of their own.
#ifndef IR_SHADING_POINT_H
#define IR_SHADING_POINT_H
#include "irradia/shared/record_types.h"
#include "surface.h"

// Edge of a pixel on the surface: its size at that depth, over the root of the cosine (the projected area is 1 / cos),
// which is kept above .1 so that grazing surfaces do not get huge records. `depth`: along the view axis; behind mirrors
// and glass that of the image, as long as they are flat.
IR_FN float pixel_footprint(const IR_GLOBAL SceneInfo* info, real3 direction, float depth, real3 ng) {
    return depth * info->camera.pixel_size * rsqrt(max(fabs(dot(direction, ng)), 0.1f));
}

// View depth of a camera ray's point at distance t.
IR_FN float view_depth(const IR_GLOBAL SceneInfo* info, real3 direction, float t) {
    return t * dot(direction, make_real3(info->camera.forwardx, info->camera.forwardy, info->camera.forwardz));
}

// Surface f, found by a ray of `direction`, as a point that wants a record: of irradiance (of the light that passes its
// coat and its bumps), or, `lobe`, of radiance (of all that arrives).
IR_FN ShadingPoint make_shading_point(const IR_GLOBAL SceneInfo* info, const Surface* f, real3 direction, float depth,
                                      uint pixel, const bool lobe) {
    ShadingPoint q;
    q.px = f->p.x;
    q.py = f->p.y;
    q.pz = f->p.z;
    q.state = IR_POINT_MISS;
    q.nx = f->ns.x;
    q.ny = f->ns.y;
    q.nz = f->ns.z;
    q.footprint = pixel_footprint(info, direction, depth, f->ng);
    real3 g = f->ng;
#if IR_FEATURES & IR_FEATURE_BUMPS
    if (f->bumped && !lobe) {
        g = f->base;
        q.state |= IR_POINT_BUMPED;
    }
#endif
#if IR_FEATURES & IR_FEATURE_BSDFS
    if (!lobe && coat_of(f) != 0u) q.state |= IR_POINT_COATED(f->material_index);
#endif
    q.gx = g.x;
    q.gy = g.y;
    q.gz = g.z;
    q.offset = f->error;
    q.pixel = pixel;
    // A point in the crease of two surfaces may by rounding lie behind the other one, and half of its hemisphere outside of
    // the scene. The viewing ray came through free space: a step back along it, in the surface, is on the right side.
    const real3 step = (f->ng * dot(direction, f->ng) - direction) * (8.0f * f->error);
    q.step_x = step.x;
    q.step_y = step.y;
    q.step_z = step.z;
    q.largest = q.least = q.pad0 = q.pad1 = 0.0f;
    return q;
}
#endif
