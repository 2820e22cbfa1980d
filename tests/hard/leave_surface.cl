// A ray to a surface, and one that leaves it: for tests/hard/scene_rays_test.cpp, no renderer launches this.
#include "sampling.h"
#include "surface.h"

// Ray i, 8 floats: origin, direction, two random numbers for the direction in which the surface is left. `mode` 0: start
// where the renderer does; 1: at the hit itself; 2: there, but from t_min = 1e-4 on. Results, 16 floats: t and primitive
// (-1: none) of the hit, position, geometric normal on the side of the ray, offset, start, t and primitive of the second
// hit, and two of padding; the direction in which it left follows in `ways`, 3 floats.
IR_KERNEL void leave_and_trace(IR_SCENE_ARGS, IR_GLOBAL const float* rays, uint count, uint mode, IR_GLOBAL float* out,
                               IR_GLOBAL float* ways) {
    IR_SCENE_INIT(s);
    const uint i = IR_GLOBAL_ID;
    if (i >= count) return;
    IR_GLOBAL const float* r = rays + 8 * i;
    IR_GLOBAL float* o = out + 16 * i;
    const real3 origin = make_real3(r[0], r[1], r[2]), direction = make_real3(r[3], r[4], r[5]);
    const Hit hit = trace_closest(&s, origin, direction, 0.0f, IR_INFINITY);
    o[0] = hit.t;
    o[1] = hit.primitive == IR_NO_PRIMITIVE ? -1.0f : (float)hit.primitive;
    if (hit.primitive == IR_NO_PRIMITIVE) return;
    const Surface f = surface_at(&s, origin, direction, &hit);
    const Frame frame = make_frame(f.ng);
    const real3 w = to_world(frame, cosine_direction(r[6], r[7]));
    const real3 start = mode == 0u ? leave_surface(&f, w) : f.p;
    const Hit next = trace_closest(&s, start, w, mode == 2u ? 1e-4f : 0.0f, IR_INFINITY);
    o[2] = f.p.x;
    o[3] = f.p.y;
    o[4] = f.p.z;
    o[5] = f.ng.x;
    o[6] = f.ng.y;
    o[7] = f.ng.z;
    o[8] = f.error;
    o[9] = start.x;
    o[10] = start.y;
    o[11] = start.z;
    o[12] = next.t;
    o[13] = next.primitive == IR_NO_PRIMITIVE ? -1.0f : (float)next.primitive;
    o[14] = o[15] = 0.0f;
    ways[3 * i] = w.x;
    ways[3 * i + 1] = w.y;
    ways[3 * i + 2] = w.z;
}
