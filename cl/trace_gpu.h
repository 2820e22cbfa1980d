// Traversal for GPU devices: one ray a work-item on the BVH2, both children tested at their parent, nearer child first.
#ifndef IR_TRACE_GPU_H
#define IR_TRACE_GPU_H
#include "trace_analytic.h"

// 1 / d without infinities: a ray parallel to a slab lies then far outside of it or, also exactly in a box plane,
// inside.
IR_FN float safe_reciprocal(float d) { return fabs(d) > 1e-18f ? 1.0f / d : (d < 0.0f ? -1e18f : 1e18f); }

// What the tests need of a ray, made once.
typedef struct SingleRay {
    real3 origin, direction;
    real3 reciprocal;
    real3 p, q, w;  // coordinates across the ray (perpendicular to it) and along it, in units of t
    float t_min;
} SingleRay;

IR_FN SingleRay make_single_ray(real3 origin, real3 direction, float t_min) {
    SingleRay r;
    r.origin = origin;
    r.direction = direction;
    r.reciprocal = make_real3(safe_reciprocal(direction.x), safe_reciprocal(direction.y), safe_reciprocal(direction.z));
    r.p = fabs(direction.x) > fabs(direction.z) ? make_real3(-direction.y, direction.x, 0.0f)
                                                : make_real3(0.0f, -direction.z, direction.y);
    r.q = cross(direction, r.p);
    r.w = direction * (1.0f / dot(direction, direction));
    r.t_min = t_min;
    return r;
}

// a x b of points across the ray. It is the exact negative of b x a, also rounded (all fma are explicit: a compiler's
// own contractions could differ between calls).
IR_FN float edge_function(float ax, float ay, float bx, float by) {
    const float m = ax * by, n = ay * bx;
    return fma(ax, by, -n) - fma(ay, bx, -m);
}
IR_FN float dot_fma(real3 a, real3 b) { return fma(a.x, b.x, fma(a.y, b.y, a.z * b.z)); }

// Updates *hit if the triangle is hit in (t_min, hit->t). Projects the triangle across the ray, as Woop, Benthin, Wald,
// "Watertight ray/triangle intersection", JCGT 2013, do by permutation and shear: every triangle at a vertex sees the
// same rounded projection of it and the same edges, so no ray passes between triangles.
IR_FN bool intersect_triangle(IR_GLOBAL const TrianglePacked* triangle, const SingleRay* r, Hit* hit) {
    const real3 a = make_real3(triangle->v0x, triangle->v0y, triangle->v0z) - r->origin;
    const real3 b = make_real3(triangle->v1x, triangle->v1y, triangle->v1z) - r->origin;
    const real3 c = make_real3(triangle->v2x, triangle->v2y, triangle->v2z) - r->origin;
    const float ax = dot_fma(r->p, a), ay = dot_fma(r->q, a);
    const float bx = dot_fma(r->p, b), by = dot_fma(r->q, b);
    const float cx = dot_fma(r->p, c), cy = dot_fma(r->q, c);
    const float u = edge_function(cx, cy, ax, ay);  // weight of v1, times the determinant
    const float v = edge_function(ax, ay, bx, by);
    const float w = edge_function(bx, by, cx, cy);
    if (min(min(u, v), w) < 0.0f && max(max(u, v), w) > 0.0f) return false;
    const float scale = 1.0f / (u + v + w);  // degenerate: infinite, t is NaN, no hit
    const float t = (w * dot_fma(r->w, a) + u * dot_fma(r->w, b) + v * dot_fma(r->w, c)) * scale;
    if (!(t > r->t_min && t < hit->t)) return false;
    hit->t = t;
    hit->u = u * scale;
    hit->v = v * scale;
    hit->primitive = triangle->primitive;
    return true;
}

// Tests all primitives of a leaf; true if one was hit in (t_min, hit->t), which it then updates.
IR_FN bool intersect_leaf(const SceneData* s, uint leaf, const SingleRay* r, Hit* hit) {
    if (leaf == IR_EMPTY) return false;
    const uint first = IR_LEAF_FIRST(leaf), count = IR_LEAF_COUNT(leaf);
    bool found = false;
#if IR_FEATURES & IR_FEATURE_ANALYTIC
    if (leaf & IR_LEAF_ANALYTIC) {
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
    for (uint i = first; i < first + count; ++i)
        if (intersect_triangle(s->leaves + i, r, hit)) found = true;
    return found;
}

IR_FN Hit trace_bvh2(const SceneData* s, real3 origin, real3 direction, float t_min, float t_max, const bool any) {
    Hit hit;
    hit.t = t_max;
    hit.u = 0.0f;
    hit.v = 0.0f;
    hit.primitive = IR_NO_PRIMITIVE;
    const SingleRay ray = make_single_ray(origin, direction, t_min);
    const real3 r = ray.reciprocal;
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
            if (first != IR_EMPTY && intersect_leaf(s, first, &ray, &hit) && any) return hit;
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

IR_FN void trace_tile_occluded(const SceneData* s, const float* ox, const float* oy, const float* oz, const float* dx,
                               const float* dy, const float* dz, uint count, float t_min, const float* t_max,
                               uint* occluded) {
    *occluded = 0;
    for (uint i = 0; i < count; ++i) {
        const bool hit =
            trace_occluded(s, make_real3(ox[i], oy[i], oz[i]), make_real3(dx[i], dy[i], dz[i]), t_min, t_max[i]);
        *occluded |= (hit ? 1u : 0u) << i;
    }
}
#endif
