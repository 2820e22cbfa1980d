// From a hit to a surface: position, normals, texture coordinates, what it reflects.
#ifndef IR_SURFACE_H
#define IR_SURFACE_H
#include "coat.h"
#include "cylinder.h"
#include "tangents.h"
#include "texture.h"
#include "trace.h"

typedef struct Surface {
    real3 p;       // position
    real3 ng;      // unit geometric normal, on the side of ns
    real3 ns;      // unit shading normal, towards the viewer
    real3 albedo;  // radiance reflected diffusely towards the viewer is albedo / pi times the irradiance that passes the
                   // coat (if there is one: coat_transmittance); 0 where the side seen reflects nothing diffusely
    int light;     // area light that this surface belongs to, or IR_NO_LIGHT
    bool emits;    // the side seen is the light's emitting side
    float error;   // how far rays that leave the surface start from it
    uint primitive;
#if IR_FEATURES & IR_FEATURE_TEXTURES
    float u, v;  // texture coordinates
#endif
#if IR_FEATURES & (IR_FEATURE_BSDFS | IR_FEATURE_BUMPS)
    real3 view;  // unit, towards the viewer
#endif
#if IR_FEATURES & IR_FEATURE_BSDFS
    IR_GLOBAL const Material* material;  // of the side seen
    uint material_index;
    uint kind, flags;                    // its kind and flags; a black side counts as diffuse
    real3 specular, transmittance;       // factors of the specular parts
    float eta;                           // dielectrics: index of refraction behind over before
    float alpha_u, alpha_v;
    real3 tangent;  // unit, along which alpha_u is the roughness; set only where alpha_u and alpha_v differ
    float through;  // share of light that the coat lets pass towards the viewer; 1: no coat
#endif
#if IR_FEATURES & IR_FEATURE_BUMPS
    real3 base;   // the shading normal before the bump map, on the side of ns
    bool bumped;  // does a map turn ns away from it?
#endif
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

// What a hit tells about the surface before its material does.
typedef struct HitGeometry {
    uint material;
    float reach;  // largest |coordinate| of the primitive, about
    float u, v;
    Tangents tangents;
} HitGeometry;

IR_FN HitGeometry triangle_geometry(const SceneData* s, const Hit* hit, Surface* f) {
    HitGeometry g;
    const Triangle tri = s->triangles[hit->primitive];
    f->ng = make_real3(tri.nx, tri.ny, tri.nz);
    f->ns = f->ng;
    f->light = tri.light;
    g.material = tri.material;
    g.reach = tri.reach;
    g.u = hit->u;
    g.v = hit->v;
#if IR_FEATURES & IR_FEATURE_SMOOTH_NORMALS
    if (!(tri.flags & IR_TRIANGLE_FLAT)) f->ns = interpolate_normal(s, &tri, hit, f->ng);
#endif
#if IR_FEATURES & IR_FEATURE_TEXTURES
    if (tri.flags & IR_TRIANGLE_HAS_UV) triangle_uv(s, &tri, hit, &g.u, &g.v);
#endif
#if IR_FEATURES & (IR_FEATURE_BSDFS | IR_FEATURE_BUMPS)
    g.tangents = triangle_tangents(s, &tri);
#endif
    return g;
}

IR_FN HitGeometry analytic_geometry(const SceneData* s, const Hit* hit, Surface* f) {
    HitGeometry g;
    const Analytic q = s->analytics[hit->primitive - s->info->triangle_count];
    f->light = q.light;
    g.material = q.material;
    g.reach = max(max(fabs(q.px), fabs(q.py)), fabs(q.pz)) + q.radius + q.length;
    g.u = g.v = 0.0f;
    if (q.kind == IR_ANALYTIC_SPHERE) {
        const real3 centre = make_real3(q.px, q.py, q.pz);
        const real3 out = normalize(f->p - centre);
        f->p = centre + out * q.radius;  // back onto the sphere: t alone is good to some ulp of the distance only
        f->ng = out * q.sign;
#if IR_FEATURES & IR_FEATURE_TEXTURES
        sphere_uv(&q, out, &g.u, &g.v);
#endif
    } else if (q.kind == IR_ANALYTIC_CYLINDER) {
        cylinder_surface(&q, &f->p, &f->ng, &g.u, &g.v);
    } else {
        f->ng = make_real3(q.nx, q.ny, q.nz);
#if IR_FEATURES & IR_FEATURE_TEXTURES
        disk_uv(&q, f->p, &g.u, &g.v);
#endif
    }
    f->ns = f->ng;
#if IR_FEATURES & (IR_FEATURE_BSDFS | IR_FEATURE_BUMPS)
    g.tangents = analytic_tangents(&q, f->p);
#endif
    return g;
}

#if IR_FEATURES & IR_FEATURE_TEXTURES
// A texture where the surface is hit.
IR_FN real3 surface_texture(const SceneData* s, int texture, float u, float v, const Hit* hit) {
    const IR_GLOBAL Texture* t = &s->textures[texture];
    if (t->format != IR_TEXTURE_VERTEX_COLOUR) return texture_lookup(s, texture, u, v);
    if (hit->primitive >= s->info->triangle_count) return make_real3(0.0f, 0.0f, 0.0f);
    const IR_GLOBAL Triangle* tri = &s->triangles[hit->primitive];
    return float_texel(s, t->offset + 3u * tri->v0) * (1.0f - hit->u - hit->v) +
           float_texel(s, t->offset + 3u * tri->v1) * hit->u + float_texel(s, t->offset + 3u * tri->v2) * hit->v;
}

// A colour of a material: the texture if there is one, else the constant.
IR_FN real3 textured(const SceneData* s, int texture, real3 plain, const HitGeometry* g, const Hit* hit) {
    if (texture == IR_NO_TEXTURE) return plain;
    return surface_texture(s, texture, g->u, g->v, hit);
}
#else
#define textured(s, texture, plain, g, hit) (plain)
#endif

#if IR_FEATURES & IR_FEATURE_BUMPS
// Turns the shading normal as the bump or normal map says: Mitsuba's conventions, with its flip of normals that would
// face away from the viewer (Schuessler et al. 2017).
IR_FN void perturb_normal(const SceneData* s, const Material* m, const HitGeometry* g, const Hit* hit, Surface* f) {
    f->base = f->ns;
    f->bumped = m->map != IR_NO_TEXTURE;
    if (!f->bumped) return;
    const real3 n = f->ns;
    const real3 t = normalize(g->tangents.du - n * dot(n, g->tangents.du)), b = cross(n, t);
    real3 map_normal;
    if (m->flags & IR_MATERIAL_NORMAL_MAP) {
        map_normal = surface_texture(s, m->map, g->u, g->v, hit) * 2.0f - make_real3(1.0f, 1.0f, 1.0f);
    } else {
        float du, dv;
        texture_gradient(s, m->map, g->u, g->v, &du, &dv);
        const real3 pu = g->tangents.du + n * (m->map_scale * du - dot(n, g->tangents.du));
        const real3 pv = g->tangents.dv + n * (m->map_scale * dv - dot(n, g->tangents.dv));
        real3 turned = cross(pu, pv);
        if (dot(turned, f->ng) < 0.0f) turned = -turned;
        map_normal = make_real3(dot(turned, t), dot(turned, b), dot(turned, n));
    }
    const real3 v = make_real3(dot(f->view, t), dot(f->view, b), dot(f->view, n));
    if ((m->flags & IR_MATERIAL_MIRRORED_MAP) && v.z < 0.0f)  // n itself is turned about afterwards
        map_normal = make_real3(-map_normal.x, -map_normal.y, map_normal.z);
    if (v.z * dot(v, map_normal) <= 0.0f) map_normal = make_real3(-map_normal.x, -map_normal.y, map_normal.z);
    const float square = dot(map_normal, map_normal);
    if (square > 1e-30f && square < 1e30f)
        f->ns = (t * map_normal.x + b * map_normal.y + n * map_normal.z) * rsqrt(square);
}
#endif

// What material index `m` reflects at f. `front`: the side of the normal is seen.
IR_FN void read_material(const SceneData* s, const Material* m, int index, const HitGeometry* g, const Hit* hit,
                         bool front, Surface* f) {
    f->albedo = textured(s, m->texture, make_real3(m->r, m->g, m->b), g, hit);
#if IR_FEATURES & IR_FEATURE_BSDFS
    f->material = s->materials + index;
    f->material_index = (uint)index;
    f->kind = m->kind;
    f->flags = m->flags;
    f->alpha_u = f->alpha_v = 1.0f;
    f->through = 1.0f;
    if (m->kind == IR_MATERIAL_DIFFUSE) return;
    f->specular =
        textured(s, m->specular_texture, make_real3(m->specular_r, m->specular_g, m->specular_b), g, hit);
    f->transmittance = make_real3(m->transmittance_r, m->transmittance_g, m->transmittance_b);
    f->eta = front ? m->eta : 1.0f / m->eta;
    f->alpha_u = m->alpha_u;
    f->alpha_v = m->alpha_v;
#if IR_FEATURES & IR_FEATURE_TEXTURES
    if (m->alpha_texture != IR_NO_TEXTURE)
        f->alpha_u = f->alpha_v = max(texture_scalar(s, m->alpha_texture, g->u, g->v), 1e-4f);
#endif
    if (f->alpha_u != f->alpha_v) f->tangent = normalize(g->tangents.du - f->ns * dot(f->ns, g->tangents.du));
    if (m->kind != IR_MATERIAL_PLASTIC && m->kind != IR_MATERIAL_ROUGH_PLASTIC) {
        f->albedo = make_real3(0.0f, 0.0f, 0.0f);
        return;
    }
    // Light that the base scatters back and forth under the coat before it gets out: a geometric series.
    f->through = coat_transmission(s, f->material, dot(f->view, f->ns));
    const real3 d = f->albedo, one = make_real3(1.0f, 1.0f, 1.0f);
    const real3 inside = (m->flags & IR_MATERIAL_NONLINEAR ? d : one) * m->internal_reflectance;
    const float scale = f->through / (m->eta * m->eta);
    f->albedo = make_real3(d.x / (1.0f - inside.x), d.y / (1.0f - inside.y), d.z / (1.0f - inside.z)) * scale;
#endif
}

// The side seen reflects nothing.
IR_FN void make_black(Surface* f) {
    f->albedo = make_real3(0.0f, 0.0f, 0.0f);
#if IR_FEATURES & IR_FEATURE_BSDFS
    f->kind = IR_MATERIAL_DIFFUSE;
#endif
}

// The surface that a ray (origin, direction) hits, as seen from the ray's side.
IR_CALL_FN Surface surface_at(const SceneData* s, real3 origin, real3 direction, const Hit* hit) {
    Surface f;
    f.p = origin + direction * hit->t;
    f.primitive = hit->primitive;
    const HitGeometry g = hit->primitive < s->info->triangle_count ? triangle_geometry(s, hit, &f)
                                                                   : analytic_geometry(s, hit, &f);
#if IR_FEATURES & IR_FEATURE_TEXTURES
    f.u = g.u;
    f.v = g.v;
#endif
#if IR_FEATURES & (IR_FEATURE_BSDFS | IR_FEATURE_BUMPS)
    f.view = -direction;
#endif
    int index = (int)g.material;
    Material m = s->materials[index];
    // Emission follows the geometric side.
    f.emits = f.light != IR_NO_LIGHT && dot(direction, f.ng) < 0.0f;
#if IR_FEATURES & IR_FEATURE_BUMPS
    perturb_normal(s, &m, &g, hit, &f);
#endif
    // Sides are told apart by the shading normal, as Mitsuba does.
    const bool front = dot(direction, f.ns) <= 0.0f;
    bool dark = false;
    if (!front) {
        f.ns = -f.ns;
#if IR_FEATURES & IR_FEATURE_BUMPS
        f.base = -f.base;
#endif
        dark = m.back == IR_NO_MATERIAL;
        if (!dark && m.back != index) {
            index = m.back;
            m = s->materials[index];
        }
    }
    read_material(s, &m, index, &g, hit, front, &f);
    if (dark) make_black(&f);
    if (dot(f.ng, f.ns) < 0.0f) f.ng = -f.ng;
    // Rounding of origin + t direction: a few ulp of the largest coordinate and of t. That of t itself: a few ulp of the
    // primitive's own coordinates, which on a large ground are far larger than those of the point.
    const float largest = max(max(fabs(f.p.x), fabs(f.p.y)), fabs(f.p.z));
    f.error = max(4e-6f * max(largest, hit->t), 2e-6f * g.reach);
    return f;
}

IR_FN float largest_channel(real3 rgb) { return max(max(rgb.x, rgb.y), rgb.z); }

IR_FN bool is_zero(real3 rgb) { return !(largest_channel(rgb) > 0.0f); }

// Does the side seen reflect anything diffusely: has it irradiance to be computed?
IR_FN bool is_diffuse(const Surface* f) { return !is_zero(f->albedo); }

#if IR_FEATURES & IR_FEATURE_BSDFS
// Is there a part of the BSDF that has to be traced?
IR_FN bool is_glossy(const Surface* f) { return f->kind != IR_MATERIAL_DIFFUSE; }
// Do all directions that it scatters into have density zero: a mirror, or glass?
IR_FN bool is_specular(const Surface* f) {
    return f->kind == IR_MATERIAL_CONDUCTOR || f->kind == IR_MATERIAL_DIELECTRIC ||
           f->kind == IR_MATERIAL_THIN_DIELECTRIC;
}
// Number of the coat through which the diffuse part is seen; 0: none.
IR_FN uint coat_of(const Surface* f) { return is_diffuse(f) && is_glossy(f) ? f->material->coat : 0u; }
// Share of light at cosine c that reaches the diffuse part of f.
IR_FN float coat_transmittance(const SceneData* s, const Surface* f, float c) {
    return is_glossy(f) ? coat_transmission(s, f->material, c) : 1.0f;
}
#else
#define is_glossy(f) false
#define is_specular(f) false
IR_FN uint coat_of(const Surface* f) { return 0u; }  // no constant: compilers warn of those, on stderr
#define coat_transmittance(s, f, c) 1.0f
#endif

// Does the side seen scatter anything: is there direct and indirect light to be computed?
IR_FN bool reflects(const Surface* f) { return is_diffuse(f) || is_glossy(f); }

// Origin of a ray that leaves `f` in direction w.
IR_FN real3 leave_surface(const Surface* f, real3 w) {
    return f->p + f->ng * (dot(w, f->ng) < 0.0f ? -f->error : f->error);
}
#endif
