// Derivatives of a surface's position by its texture coordinates, and what is interpolated over triangles.
#ifndef IR_TANGENTS_H
#define IR_TANGENTS_H
#include "sampling.h"
#include "scene.h"
#include "trace.h"

typedef struct Tangents {
    real3 du, dv;  // world units
} Tangents;

IR_FN real3 vertex_position(const SceneData* s, uint index) {
    const IR_GLOBAL Vertex* v = &s->vertices[index];
    return make_real3(v->px, v->py, v->pz);
}

#if IR_FEATURES & IR_FEATURE_TEXTURES
IR_FN void triangle_uv(const SceneData* s, const Triangle* tri, const Hit* hit, float* u, float* v) {
    const IR_GLOBAL Vertex* a = &s->vertices[tri->v0];
    const IR_GLOBAL Vertex* b = &s->vertices[tri->v1];
    const IR_GLOBAL Vertex* c = &s->vertices[tri->v2];
    const float w = 1.0f - hit->u - hit->v;
    *u = w * a->u + hit->u * b->u + hit->v * c->u;
    *v = w * a->v + hit->u * b->v + hit->v * c->v;
}
#endif

#if IR_FEATURES & (IR_FEATURE_BSDFS | IR_FEATURE_BUMPS)
// Any two directions across n, where there are no texture coordinates (Mitsuba's choice).
IR_FN Tangents any_tangents(real3 n) {
    const Frame frame = make_frame(n);
    Tangents t;
    t.du = frame.t;
    t.dv = frame.b;
    return t;
}

IR_FN Tangents triangle_tangents(const SceneData* s, const Triangle* tri) {
    const real3 p = vertex_position(s, tri->v0), n = make_real3(tri->nx, tri->ny, tri->nz);
    if (!(tri->flags & IR_TRIANGLE_HAS_UV)) return any_tangents(n);
    const IR_GLOBAL Vertex* a = &s->vertices[tri->v0];
    const IR_GLOBAL Vertex* b = &s->vertices[tri->v1];
    const IR_GLOBAL Vertex* c = &s->vertices[tri->v2];
    const float u1 = b->u - a->u, v1 = b->v - a->v, u2 = c->u - a->u, v2 = c->v - a->v;
    const float det = u1 * v2 - v1 * u2;
    if (det == 0.0f) return any_tangents(n);
    const real3 e1 = vertex_position(s, tri->v1) - p, e2 = vertex_position(s, tri->v2) - p;
    Tangents t;
    t.du = (e1 * v2 - e2 * v1) * (1.0f / det);
    t.dv = (e2 * u1 - e1 * u2) * (1.0f / det);
    return t;
}

// At point p of a sphere, disk or cylinder; see sphere_uv() and its like in texture.h.
IR_FN Tangents analytic_tangents(const Analytic* q, real3 p) {
    const real3 d = p - make_real3(q->px, q->py, q->pz);
    const real3 n = make_real3(q->nx, q->ny, q->nz);
    Tangents t;
    if (q->kind == IR_ANALYTIC_SPHERE) {
        const real3 pole = make_real3(q->vx, q->vy, q->vz);
        const float height = dot(d, pole);
        const real3 flat = d - pole * height;
        const float across = length(flat);
        t.du = cross(pole, d) * (2.0f * IR_PI);
        t.dv = (flat * (height / max(across, 1e-20f)) - pole * across) * IR_PI;
        return across > 1e-6f * q->radius ? t : any_tangents(normalize(d));
    }
    if (q->kind == IR_ANALYTIC_CYLINDER) {
        t.du = cross(n, d) * (2.0f * IR_PI);
        t.dv = n * q->length;
        return t;
    }
    const float square = dot(d, d);
    if (!(square > 0.0f)) return any_tangents(n);
    const real3 u = make_real3(q->ux, q->uy, q->uz), v = make_real3(q->vx, q->vy, q->vz);
    const float x = dot(d, u), y = dot(d, v);
    t.du = d * rsqrt(x * x + y * y);
    t.dv = (u * (-y / dot(u, u)) + v * (x / dot(v, v))) * (2.0f * IR_PI);
    return t;
}
#endif
#endif
