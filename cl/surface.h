// From a hit to a surface: position, normals, texture coordinates, reflectance.
#ifndef IR_SURFACE_H
#define IR_SURFACE_H
#include "texture.h"
#include "trace.h"

typedef struct Surface {
    real3 p;       // position
    real3 ng;      // unit geometric normal, on the side of ns
    real3 ns;      // unit shading normal, towards the viewer
    real3 albedo;  // reflectance; 0 where the side seen does not reflect
    int light;     // area light that this surface belongs to, or IR_NO_LIGHT
    bool emits;    // the side seen is the light's emitting side
    float error;   // how far rays that leave the surface start from it
    uint primitive;
} Surface;

IR_FN real3 interpolate_normal(const SceneData* s, const Triangle* tri, const Hit* hit, real3 ng) {
    const IR_GLOBAL Vertex* a = &s->vertices[tri->v0];
    const IR_GLOBAL Vertex* b = &s->vertices[tri->v1];
    const IR_GLOBAL Vertex* c = &s->vertices[tri->v2];
    const float w = 1.0f - hit->u - hit->v;
    const real3 n = make_real3(w * a->nx + hit->u * b->nx + hit->v * c->nx, w * a->ny + hit->u * b->ny + hit->v * c->ny,
                               w * a->nz + hit->u * b->nz + hit->v * c->nz);
    const float square = dot(n, n);
    return square > 1e-12f ? n * rsqrt(square) : ng;
}

// The surface that a ray (origin, direction) hits, as seen from the ray's side.
IR_FN Surface surface_at(const SceneData* s, real3 origin, real3 direction, const Hit* hit) {
    Surface f;
    f.p = origin + direction * hit->t;
    f.primitive = hit->primitive;
    uint material_index;
    float u = hit->u, v = hit->v;
    if (hit->primitive < s->info->triangle_count) {
        const Triangle tri = s->triangles[hit->primitive];
        f.ng = make_real3(tri.nx, tri.ny, tri.nz);
        f.ns = f.ng;
#if IR_FEATURES & IR_FEATURE_SMOOTH_NORMALS
        if (!(tri.flags & IR_TRIANGLE_FLAT)) f.ns = interpolate_normal(s, &tri, hit, f.ng);
#endif
#if IR_FEATURES & IR_FEATURE_TEXTURES
        if (tri.flags & IR_TRIANGLE_HAS_UV) {
            const IR_GLOBAL Vertex* a = &s->vertices[tri.v0];
            const IR_GLOBAL Vertex* b = &s->vertices[tri.v1];
            const IR_GLOBAL Vertex* c = &s->vertices[tri.v2];
            const float w = 1.0f - hit->u - hit->v;
            u = w * a->u + hit->u * b->u + hit->v * c->u;
            v = w * a->v + hit->u * b->v + hit->v * c->v;
        }
#endif
        material_index = tri.material;
        f.light = tri.light;
    } else {
        const Analytic q = s->analytics[hit->primitive - s->info->triangle_count];
        if (q.kind == IR_ANALYTIC_SPHERE) {
            const real3 centre = make_real3(q.px, q.py, q.pz);
            const real3 out = normalize(f.p - centre);
            f.p = centre + out * q.radius;  // back onto the sphere: t alone is good to some ulp of the distance only
            f.ng = out * q.sign;
#if IR_FEATURES & IR_FEATURE_TEXTURES
            sphere_uv(&q, out, &u, &v);
#endif
        } else {
            f.ng = make_real3(q.nx, q.ny, q.nz);
#if IR_FEATURES & IR_FEATURE_TEXTURES
            disk_uv(&q, f.p, &u, &v);
#endif
        }
        f.ns = f.ng;
        material_index = q.material;
        f.light = q.light;
    }
    const Material m = s->materials[material_index];
    f.albedo = make_real3(m.r, m.g, m.b);
#if IR_FEATURES & IR_FEATURE_TEXTURES
    if (m.texture != IR_NO_TEXTURE) f.albedo = texture_lookup(s, m.texture, u, v);
#endif
    // Sides are told apart by the shading normal, as Mitsuba does; emission by the geometric one.
    f.emits = f.light != IR_NO_LIGHT && dot(direction, f.ng) < 0.0f;
    if (dot(direction, f.ns) > 0.0f) {
        f.ns = -f.ns;
        if (m.back == IR_NO_MATERIAL) f.albedo = make_real3(0.0f, 0.0f, 0.0f);
    }
    if (dot(f.ng, f.ns) < 0.0f) f.ng = -f.ng;
    // Rounding of origin + t direction: a few ulp of the largest coordinate and of t.
    const float largest = max(max(fabs(f.p.x), fabs(f.p.y)), fabs(f.p.z));
    f.error = 4e-6f * max(largest, hit->t);
    return f;
}

IR_FN float largest_channel(real3 rgb) { return max(max(rgb.x, rgb.y), rgb.z); }

IR_FN bool is_zero(real3 rgb) { return !(largest_channel(rgb) > 0.0f); }

// Does the side seen reflect anything: is there direct and indirect light to be computed?
IR_FN bool reflects(const Surface* f) { return !is_zero(f->albedo); }

// Origin of a ray that leaves `f` in direction w.
IR_FN real3 leave_surface(const Surface* f, real3 w) {
    return f->p + f->ng * (dot(w, f->ng) < 0.0f ? -f->error : f->error);
}
#endif
