// Traversal for CPU devices: BVH8, one ray against eight boxes or eight triangles at a time (float8), and packets of 16
// rays from one origin against one box or triangle at a time (float16), where all but three dot products is shared.
// OpenCL C with vector types only; none of these functions contains a barrier, so their arrays stay on the stack.
#ifndef IR_TRACE_CPU_H
#define IR_TRACE_CPU_H
#include "trace_analytic.h"

#define IR_STACK_SIZE (7 * IR_BVH8_MAX_DEPTH + 1)

// Compiled once, not again at every call: a call costs a ray nothing, and a cold start takes an eighth less.
#define IR_TRACE_FN __attribute__((noinline)) static

// ---- small tools ---------------------------------------------------------------------------------------------------

// Bit 8 i for each true lane i: a mask whose lanes can be counted and walked with scalar instructions.
IR_FN ulong lanes8(int8 m) { return as_ulong(convert_char8(m)) & 0x0101010101010101ul; }
// The number of the lowest lane: trailing zeros, in the form that compilers know as such.
IR_FN uint first_lane(ulong lanes) { return (uint)popcount(~lanes & (lanes - 1)) >> 3; }

// 1 / d without infinities: a ray parallel to a slab lies then far outside of it or, also exactly in a box plane,
// inside.
IR_FN float safe_reciprocal(float d) { return fabs(d) > 1e-18f ? 1.0f / d : (d < 0.0f ? -1e18f : 1e18f); }
IR_FN float16 safe_reciprocal16(float16 d) {
    return select(select((float16)(1e18f), (float16)(-1e18f), d < 0.0f), 1.0f / d, fabs(d) > 1e-18f);
}

// ---- one ray -------------------------------------------------------------------------------------------------------

// What single-ray tests need of a ray, made once: for the boxes, reciprocals and which face is near; for the triangles,
// the axis permutation and shear that turn the ray into the z axis (Woop, Benthin, Wald, "Watertight ray/triangle
// intersection", JCGT 2013). Offsets count floats in a Bvh8Node or TriangleBlock.
typedef struct SingleRay {
    real3 origin, direction;
    float rx, ry, rz;             // reciprocal direction
    float ox_rx, oy_ry, oz_rz;    // origin times reciprocal direction
    uint near_x, near_y, near_z;  // offset of the near faces; the far ones are at 24 - near_x, 40 - near_y, 56 - near_z
    uint kx, ky, kz;              // offset of the permuted coordinate within a vertex
    float okx, oky, okz;          // permuted origin
    float sx, sy, sz;             // shear
    float t_min;
} SingleRay;

IR_FN float component(real3 v, uint k) { return k == 0 ? v.x : (k == 1 ? v.y : v.z); }

IR_FN SingleRay make_single_ray(real3 origin, real3 direction, float t_min) {
    SingleRay r;
    r.origin = origin;
    r.direction = direction;
    r.rx = safe_reciprocal(direction.x);
    r.ry = safe_reciprocal(direction.y);
    r.rz = safe_reciprocal(direction.z);
    r.ox_rx = origin.x * r.rx;
    r.oy_ry = origin.y * r.ry;
    r.oz_rz = origin.z * r.rz;
    r.near_x = r.rx < 0.0f ? 24 : 0;
    r.near_y = r.ry < 0.0f ? 32 : 8;
    r.near_z = r.rz < 0.0f ? 40 : 16;
    const real3 a = fabs(direction);
    const uint kz = a.x > a.y ? (a.x > a.z ? 0 : 2) : (a.y > a.z ? 1 : 2);
    const uint kx = kz == 2 ? 0 : kz + 1;
    const uint ky = kx == 2 ? 0 : kx + 1;
    r.sz = 1.0f / component(direction, kz);
    r.sx = component(direction, kx) * r.sz;
    r.sy = component(direction, ky) * r.sz;
    r.okx = component(origin, kx);
    r.oky = component(origin, ky);
    r.okz = component(origin, kz);
    r.kx = 8 * kx;
    r.ky = 8 * ky;
    r.kz = 8 * kz;
    r.t_min = t_min;
    return r;
}

// Tests the eight triangles of a block; true if one was hit in (t_min, hit->t), which it then updates.
IR_FN bool intersect_block(IR_GLOBAL const TriangleBlock* block, const SingleRay* r, Hit* hit) {
// The edge functions of neighbouring triangles are exact negatives of each other only if no product is contracted.
#pragma OPENCL FP_CONTRACT OFF
    IR_GLOBAL const float* v = block->v0x;
    const float8 az = vload8(0, v + r->kz) - r->okz;
    const float8 ax = fma(az, -r->sx, vload8(0, v + r->kx) - r->okx);
    const float8 ay = fma(az, -r->sy, vload8(0, v + r->ky) - r->oky);
    const float8 bz = vload8(0, v + 24 + r->kz) - r->okz;
    const float8 bx = fma(bz, -r->sx, vload8(0, v + 24 + r->kx) - r->okx);
    const float8 by = fma(bz, -r->sy, vload8(0, v + 24 + r->ky) - r->oky);
    const float8 cz = vload8(0, v + 48 + r->kz) - r->okz;
    const float8 cx = fma(cz, -r->sx, vload8(0, v + 48 + r->kx) - r->okx);
    const float8 cy = fma(cz, -r->sy, vload8(0, v + 48 + r->ky) - r->oky);
    const float8 a = cx * by - cy * bx;  // weight of v0, times the determinant
    const float8 b = ax * cy - ay * cx;
    const float8 c = bx * ay - by * ax;
    const int8 inside = (min(min(a, b), c) >= 0.0f) | (max(max(a, b), c) <= 0.0f);
    if (lanes8(inside) == 0) return false;
    const float8 det = a + b + c;
    const float8 t = fma(a, az, fma(b, bz, c * cz)) * r->sz / det;  // degenerate: 0 / 0, no hit
    ulong lanes = lanes8(inside & (t > r->t_min) & (t < hit->t));
    if (lanes == 0) return false;
    float ts[8], bs[8], cs[8];
    vstore8(t, 0, ts);
    vstore8(b / det, 0, bs);
    vstore8(c / det, 0, cs);
    while (lanes) {
        const uint i = first_lane(lanes);
        lanes &= lanes - 1;
        if (ts[i] < hit->t) {
            hit->t = ts[i];
            hit->u = bs[i];
            hit->v = cs[i];
            hit->primitive = block->primitive[i];
        }
    }
    return true;
}

IR_FN bool intersect_leaf(const SceneData* s, uint leaf, const SingleRay* r, Hit* hit) {
#if IR_FEATURES & IR_FEATURE_ANALYTIC
    if (leaf & IR_LEAF_ANALYTIC) {
        bool found = false;
        const uint first = IR_LEAF_FIRST(leaf), count = IR_LEAF_COUNT(leaf);
        for (uint i = first; i < first + count; ++i) {
            const float t = intersect_analytic(s->analytics + i, r->origin, r->direction, r->t_min, hit->t);
            if (t < hit->t) {
                hit->t = t;
                hit->primitive = s->info->triangle_count + i;
                found = true;
            }
        }
        return found;
    }
#endif
    return intersect_block(s->leaves + IR_LEAF_FIRST(leaf), r, hit);
}

// Updates *hit with the closest (any: some) hit below `reference` that is nearer than hit->t.
IR_FN void trace_bvh8(const SceneData* s, const SingleRay* r, uint reference, Hit* hit, const bool any) {
    uint stack[IR_STACK_SIZE];
    float distance[IR_STACK_SIZE];
    int top = 0;
    while (true) {
        if (reference & IR_LEAF) {
            if (intersect_leaf(s, reference, r, hit) && any) return;
        } else {
            IR_GLOBAL const Bvh8Node* node = s->nodes + reference;
            IR_GLOBAL const float* faces = node->lo_x;
            const float8 nx = fma(vload8(0, faces + r->near_x), r->rx, -r->ox_rx);
            const float8 ny = fma(vload8(0, faces + r->near_y), r->ry, -r->oy_ry);
            const float8 nz = fma(vload8(0, faces + r->near_z), r->rz, -r->oz_rz);
            const float8 fx = fma(vload8(0, faces + (24 - r->near_x)), r->rx, -r->ox_rx);
            const float8 fy = fma(vload8(0, faces + (40 - r->near_y)), r->ry, -r->oy_ry);
            const float8 fz = fma(vload8(0, faces + (56 - r->near_z)), r->rz, -r->oz_rz);
            const float8 enter = max(max(nx, ny), max(nz, r->t_min));
            const float8 leave = min(min(fx, fy), min(fz, hit->t));
            ulong lanes = lanes8(enter <= leave);
            if (lanes) {
                uint i = first_lane(lanes);
                lanes &= lanes - 1;
                reference = node->child[i];
                if (lanes == 0) continue;  // the most frequent case
                if (any) {
                    do {
                        stack[top++] = node->child[first_lane(lanes)];
                        lanes &= lanes - 1;
                    } while (lanes);
                    continue;
                }
                float d[8];
                vstore8(enter, 0, d);
                float nearest = d[i];
                // The nearest child is visited next, the others go to the stack.
                do {
                    i = first_lane(lanes);
                    lanes &= lanes - 1;
                    const uint child = node->child[i];
                    const bool nearer = d[i] < nearest;
                    stack[top] = nearer ? reference : child;
                    distance[top++] = nearer ? nearest : d[i];
                    reference = nearer ? child : reference;
                    nearest = nearer ? d[i] : nearest;
                } while (lanes);
                continue;
            }
        }
        do {
            if (top == 0) return;
            reference = stack[--top];
        } while (!any && distance[top] >= hit->t);
    }
}

IR_FN Hit make_miss(float t_max) {
    Hit hit;
    hit.t = t_max;
    hit.u = 0.0f;
    hit.v = 0.0f;
    hit.primitive = IR_NO_PRIMITIVE;
    return hit;
}

IR_TRACE_FN Hit trace_closest(const SceneData* s, real3 origin, real3 direction, float t_min, float t_max) {
    const SingleRay r = make_single_ray(origin, direction, t_min);
    Hit hit = make_miss(t_max);
    trace_bvh8(s, &r, 0, &hit, false);
    if (hit.primitive == IR_NO_PRIMITIVE) hit.t = IR_INFINITY;
    return hit;
}

IR_TRACE_FN bool trace_occluded(const SceneData* s, real3 origin, real3 direction, float t_min, float t_max) {
    const SingleRay r = make_single_ray(origin, direction, t_min);
    Hit hit = make_miss(t_max);
    trace_bvh8(s, &r, 0, &hit, true);
    return hit.primitive != IR_NO_PRIMITIVE;
}

#include "trace_packet.h"
#endif
