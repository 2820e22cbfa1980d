// Traversal for GPU devices: one ray a work-item on the BVH2, both children tested at their parent, nearer child first.
#ifndef IR_TRACE_GPU_H
#define IR_TRACE_GPU_H
#include "trace_analytic.h"

// 1 / d without infinities: a ray parallel to a slab lies then far outside of it or, also exactly in a box plane, inside.
IR_FN float safe_reciprocal(float d) {
    return fabs(d) > 1e-18f ? 1.0f / d : (d < 0.0f ? -1e18f : 1e18f);
}

// Twice the signed volume of direction and edge (a, b), a and b relative to the origin. As -(b - a) x (a + b) it is the
// exact negative for the edge (b, a), also rounded (fma is explicit: a compiler's choice of contraction could differ
// between two calls), so of two neighbouring triangles at least one is hit by a ray at their common edge.
IR_FN float edge_volume(real3 a, real3 b, real3 d) {
    const real3 e = a - b, s = a + b;
    const float x = fma(e.y, s.z, -(e.z * s.y));
    const float y = fma(e.z, s.x, -(e.x * s.z));
    const float z = fma(e.x, s.y, -(e.y * s.x));
    return fma(x, d.x, fma(y, d.y, z * d.z));
}

// Updates *hit if the triangle is hit in (t_min, hit->t).
IR_FN bool intersect_triangle(IR_GLOBAL const TrianglePacked* triangle, real3 origin, real3 direction, float t_min, Hit* hit) {
    const real3 a = make_real3(triangle->v0x, triangle->v0y, triangle->v0z) - origin;
    const real3 b = make_real3(triangle->v1x, triangle->v1y, triangle->v1z) - origin;
    const real3 c = make_real3(triangle->v2x, triangle->v2y, triangle->v2z) - origin;
    const float u = edge_volume(c, a, direction);
    const float v = edge_volume(a, b, direction);
    const float w = edge_volume(b, c, direction);
    const bool inside = (u >= 0.0f && v >= 0.0f && w >= 0.0f) || (u <= 0.0f && v <= 0.0f && w <= 0.0f);
    if (!inside) return false;
    const real3 n = cross(b - a, c - a);
    const float t = dot(n, a) / dot(n, direction);  // parallel or degenerate: infinite or NaN, no hit
    if (!(t > t_min && t < hit->t)) return false;
    const float sum = u + v + w;
    hit->t = t;
    hit->u = u / sum;
    hit->v = v / sum;
    hit->primitive = triangle->primitive;
    return true;
}

// Tests all primitives of a leaf; true if one was hit in (t_min, hit->t), which it then updates.
IR_FN bool intersect_leaf(const SceneData* s, uint leaf, real3 origin, real3 direction, float t_min, Hit* hit) {
    if (leaf == IR_EMPTY) return false;
    const uint first = IR_LEAF_FIRST(leaf), count = IR_LEAF_COUNT(leaf);
    bool found = false;
#if IR_FEATURES & IR_FEATURE_ANALYTIC
    if (leaf & IR_LEAF_ANALYTIC) {
        for (uint i = first; i < first + count; ++i) {
            const float t = intersect_analytic(s->analytics + i, origin, direction, t_min, hit->t);
            if (t < hit->t) {
                hit->t = t;
                hit->primitive = s->info->triangle_count + i;
                found = true;
            }
        }
        return found;
    }
#endif
    for (uint i = first; i < first + count; ++i)
        if (intersect_triangle(s->leaves + i, origin, direction, t_min, hit)) found = true;
    return found;
}

IR_FN Hit trace_bvh2(const SceneData* s, real3 origin, real3 direction, float t_min, float t_max, const bool any) {
    Hit hit;
    hit.t = t_max;
    hit.u = 0.0f;
    hit.v = 0.0f;
    hit.primitive = IR_NO_PRIMITIVE;
    const real3 r = make_real3(safe_reciprocal(direction.x), safe_reciprocal(direction.y), safe_reciprocal(direction.z));
    uint stack[IR_BVH2_MAX_DEPTH + 1];
    int top = 0;
    uint node = 0;
    while (true) {
        IR_GLOBAL const Bvh2Node* n = s->nodes + node;
        const float ax0 = (n->lo0x - origin.x) * r.x, bx0 = (n->hi0x - origin.x) * r.x;
        const float ay0 = (n->lo0y - origin.y) * r.y, by0 = (n->hi0y - origin.y) * r.y;
        const float az0 = (n->lo0z - origin.z) * r.z, bz0 = (n->hi0z - origin.z) * r.z;
        const float ax1 = (n->lo1x - origin.x) * r.x, bx1 = (n->hi1x - origin.x) * r.x;
        const float ay1 = (n->lo1y - origin.y) * r.y, by1 = (n->hi1y - origin.y) * r.y;
        const float az1 = (n->lo1z - origin.z) * r.z, bz1 = (n->hi1z - origin.z) * r.z;
        const float near0 = max(max(min(ax0, bx0), min(ay0, by0)), max(min(az0, bz0), t_min));
        const float near1 = max(max(min(ax1, bx1), min(ay1, by1)), max(min(az1, bz1), t_min));
        const float far0 = min(min(max(ax0, bx0), max(ay0, by0)), min(max(az0, bz0), hit.t));
        const float far1 = min(min(max(ax1, bx1), max(ay1, by1)), min(max(az1, bz1), hit.t));
        const bool swap = near1 < near0;
        const bool hit0 = near0 <= far0, hit1 = near1 <= far1;
        // The nearer child of those that are hit, then the farther; IR_EMPTY: none.
        uint first = hit0 ? n->child0 : IR_EMPTY, second = hit1 ? n->child1 : IR_EMPTY;
        if (swap || !hit0) {
            const uint other = first;
            first = second;
            second = other;
        }
        if (second != IR_EMPTY) stack[top++] = second;
        // Leaves are met here; inner nodes go round the loop.
        while (first & IR_LEAF) {
            if (first != IR_EMPTY && intersect_leaf(s, first, origin, direction, t_min, &hit) && any) return hit;
            if (top == 0) return hit;
            first = stack[--top];
        }
        node = first;
    }
}

IR_FN Hit trace_closest(const SceneData* s, real3 origin, real3 direction, float t_min, float t_max) {
    Hit hit = trace_bvh2(s, origin, direction, t_min, t_max, false);
    if (hit.primitive == IR_NO_PRIMITIVE) hit.t = IR_INFINITY;
    return hit;
}

IR_FN bool trace_occluded(const SceneData* s, real3 origin, real3 direction, float t_min, float t_max) {
    return trace_bvh2(s, origin, direction, t_min, t_max, true).primitive != IR_NO_PRIMITIVE;
}

IR_FN void trace_tile(const SceneData* s, real3 origin, const float* dx, const float* dy, const float* dz, uint count,
                      float t_min, Hit* hits) {
    for (uint i = 0; i < count; ++i)
        hits[i] = trace_closest(s, origin, make_real3(dx[i], dy[i], dz[i]), t_min, IR_INFINITY);
}
#endif
