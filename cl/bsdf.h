// Scattering at a surface: Mitsuba 3's BSDFs. Every value comes in two parts, because the caches treat them apart:
// `diffuse`, what the irradiance of the surface answers, and `glossy`, what has to be traced. Directions point away from
// the surface; the view is on the side of f->ns. Kernels of scenes without IR_FEATURE_BSDFS know the diffuse BSDF alone.
#ifndef IR_BSDF_H
#define IR_BSDF_H
#include "coat.h"
#include "fresnel.h"
#include "microfacet.h"
#include "surface.h"

// BSDF times cosine for one direction, and the density with which bsdf_sample would have chosen it (sr⁻¹). Perfectly
// specular parts are zero here: no direction that was chosen otherwise ever meets them.
typedef struct BsdfValue {
    real3 diffuse, glossy;  // sr⁻¹
    float density;
} BsdfValue;

// A direction drawn by the BSDF. Weights are BSDF times cosine over density.
typedef struct BsdfSample {
    real3 direction;
    real3 diffuse, glossy;
    float density;  // sr⁻¹; 0: a perfectly specular direction, which no light sample can find
    float eta;      // index of refraction behind over before, of a direction that crosses the surface; otherwise 1
} BsdfSample;

IR_FN real3 black(void) { return make_real3(0.0f, 0.0f, 0.0f); }

#if IR_FEATURES & IR_FEATURE_BUMPS
// What the bump lets through of light from w: directions on different sides of the perturbed and of the smooth surface
// do not count, and near the terminator facets shade each other (Estevez et al., Ray Tracing Gems 12).
IR_FN float visibility_over_bump(real3 ns, real3 smooth, real3 w) {
    const float base = dot(w, smooth);
    if (!(base * dot(w, ns) > 0.0f)) return 0.0f;
    const float c = dot(ns, smooth), c2 = c * c, w2 = base * base;
    const float alpha2 = min(0.125f * max(1.0f - c2, 0.0f) / max(c2, 1e-12f), 1.0f);
    return 2.0f / (1.0f + sqrt(1.0f + alpha2 * max(1.0f - w2, 0.0f) / w2));
}
IR_FN float bump_visibility(const Surface* f, real3 w) {
    return f->bumped ? visibility_over_bump(f->ns, f->base, w) : 1.0f;
}
#else
#define bump_visibility(f, w) 1.0f
#endif

#if IR_FEATURES & IR_FEATURE_BSDFS
IR_FN Frame bsdf_frame(const Surface* f) {
    if (f->alpha_u == f->alpha_v) return make_frame(f->ns);
    Frame frame;
    frame.n = f->ns;
    frame.t = f->tangent;
    frame.b = cross(f->ns, f->tangent);
    return frame;
}

IR_FN Microfacets surface_facets(const Surface* f) {
    Microfacets m;
    m.alpha_u = f->alpha_u;
    m.alpha_v = f->alpha_v;
    m.beckmann = (f->flags & IR_MATERIAL_BECKMANN) != 0u;
    return m;
}

// Reflectance of a conductor at cosine c.
IR_FN real3 conductor_reflectance(const Surface* f, float c) {
    const IR_GLOBAL Material* m = f->material;
    return f->specular * make_real3(fresnel_conductor(c, m->eta_r, m->k_r), fresnel_conductor(c, m->eta_g, m->k_g),
                                    fresnel_conductor(c, m->eta_b, m->k_b));
}

// Probability of choosing the coat rather than the base, where the coat lets `through` pass.
IR_FN float coat_probability(const Surface* f, float through) {
    const float coat = (1.0f - through) * f->material->specular_weight;
    return coat / max(coat + through * (1.0f - f->material->specular_weight), 1e-20f);  // neither: none
}

// Rough conductor, and a rough plastic's coat: reflection by facets; *density as if nothing else were sampled.
IR_FN real3 facet_reflection(const Surface* f, real3 wi, real3 wo, float* density) {
    *density = 0.0f;
    if (!(wi.z > 0.0f && wo.z > 0.0f)) return black();  // wi.z == 0: Smith's 0 / 0
    const Microfacets facets = surface_facets(f);
    const real3 h = normalize(wi + wo);
    const float d = microfacet_density(&facets, h), gi = smith_g1(&facets, wi, h);
    const float c = dot(wi, h);
    float unused;
    const real3 fresnel = f->kind == IR_MATERIAL_ROUGH_CONDUCTOR
                              ? conductor_reflectance(f, c)
                              : f->specular * fresnel_dielectric(c, f->material->eta, &unused);
    *density = d * gi / (4.0f * wi.z);
    return fresnel * (*density * smith_g1(&facets, wo, h));
}

// Rough dielectric: reflection and refraction by facets.
IR_FN real3 facet_scattering(const Surface* f, real3 wi, real3 wo, float* density) {
    *density = 0.0f;
    if (!(wi.z > 0.0f)) return black();
    const bool reflection = wo.z > 0.0f;
    real3 h = wi + wo * (reflection ? 1.0f : f->eta);
    const float square = dot(h, h);
    if (!(square > 1e-20f)) return black();
    h = h * (h.z < 0.0f ? -rsqrt(square) : rsqrt(square));
    const float ci = dot(wi, h), co = dot(wo, h);
    if (!(ci > 0.0f) || (co > 0.0f) != reflection) return black();
    const Microfacets facets = surface_facets(f);
    float cos_t;
    const float fresnel = fresnel_dielectric(ci, f->eta, &cos_t);
    const float d = microfacet_density(&facets, h), gi = smith_g1(&facets, wi, h), go = smith_g1(&facets, wo, h);
    if (reflection) {
        *density = fresnel * d * gi / (4.0f * wi.z);
        return f->specular * (*density * go);
    }
    const float s = ci + f->eta * co;  // both terms differ in sign
    const float common = (1.0f - fresnel) * d * gi * ci * fabs(co) / (wi.z * s * s);
    *density = common * f->eta * f->eta;  // radiance is compressed by the square of the index
    return f->transmittance * (common * go);
}

IR_CALL_FN BsdfValue bsdf_value(const SceneData* s, const Surface* f, real3 w, const bool lobe) {
    BsdfValue v;
    v.diffuse = v.glossy = black();
    v.density = 0.0f;
    const float c = dot(w, f->ns);
    if (f->kind == IR_MATERIAL_DIFFUSE || f->kind == IR_MATERIAL_PLASTIC) {
        if (!(c > 0.0f)) return v;
        v.density = c * IR_INV_PI;
        v.diffuse = f->albedo * (v.density * coat_transmittance(s, f, c));
        if (f->kind == IR_MATERIAL_PLASTIC) v.density *= 1.0f - coat_probability(f, f->through);
        if (lobe) v.density = 0.0f;
        return v;
    }
    if (is_specular(f)) return v;
    const Frame frame = bsdf_frame(f);
    const real3 wi = to_local(frame, f->view), wo = to_local(frame, w);
    if (f->kind == IR_MATERIAL_ROUGH_DIELECTRIC) {
        v.glossy = facet_scattering(f, wi, wo, &v.density);
        return v;
    }
    v.glossy = facet_reflection(f, wi, wo, &v.density);
    if (f->kind == IR_MATERIAL_ROUGH_PLASTIC && c > 0.0f) {
        const float p = coat_probability(f, f->through);
        v.diffuse = f->albedo * (c * IR_INV_PI * coat_transmittance(s, f, c));
        v.density = p * v.density + (lobe ? 0.0f : (1.0f - p) * c * IR_INV_PI);
    }
    return v;
}

// BSDF times cosine and density for direction w. `lobe`: the density is that of samples of the glossy part alone.
IR_FN BsdfValue bsdf_evaluate(const SceneData* s, const Surface* f, real3 w, const bool lobe) {
    BsdfValue v = bsdf_value(s, f, w, lobe);
    const float visible = bump_visibility(f, w);
    v.diffuse = v.diffuse * visible;
    v.glossy = v.glossy * visible;
    if (visible == 0.0f) v.density = 0.0f;
    return v;
}

// A perfectly specular direction; false if the surface has none, or the draw u0 fell on its other parts.
IR_FN bool sample_specular(const Surface* f, float u0, BsdfSample* b) {
    const float c = dot(f->view, f->ns);
    b->density = 0.0f;
    b->eta = 1.0f;
    b->diffuse = black();
    b->direction = f->ns * (2.0f * c) - f->view;
    if (f->kind == IR_MATERIAL_CONDUCTOR) {
        b->glossy = conductor_reflectance(f, c);
        return true;
    }
    if (f->kind == IR_MATERIAL_PLASTIC) {
        const float p = coat_probability(f, f->through);
        b->glossy = f->specular * ((1.0f - f->through) / p);
        return u0 < p;
    }
    if (f->kind != IR_MATERIAL_DIELECTRIC && f->kind != IR_MATERIAL_THIN_DIELECTRIC) return false;
    const bool thin = f->kind == IR_MATERIAL_THIN_DIELECTRIC;
    float cos_t;
    float fresnel = fresnel_dielectric(c, thin ? f->material->eta : f->eta, &cos_t);  // a sheet is seen from outside
    if (thin) fresnel *= 2.0f / (1.0f + fresnel);  // all orders between both sides
    if (u0 < fresnel) {
        b->glossy = f->specular;
        return true;
    }
    b->glossy = f->transmittance;
    if (thin) {
        b->direction = -f->view;
        return true;
    }
    b->eta = f->eta;
    b->glossy = b->glossy * (1.0f / (f->eta * f->eta));
    b->direction = f->ns * (c / f->eta - cos_t) - f->view * (1.0f / f->eta);
    return true;
}

// A direction in proportion to the facets' part of the BSDF (about so), local frame; false: absorbed.
IR_FN bool sample_facets(const Surface* f, real3 wi, float u0, float u1, float u2, real3* wo, float* eta) {
    const Microfacets facets = surface_facets(f);
    const real3 m = sample_visible_normal(&facets, wi, u1, u2);
    const float c = dot(wi, m);
    *eta = 1.0f;
    *wo = m * (2.0f * c) - wi;
    if (f->kind != IR_MATERIAL_ROUGH_DIELECTRIC) return wo->z > 0.0f;
    if (!(c > 0.0f)) return false;
    float cos_t;
    if (u0 < fresnel_dielectric(c, f->eta, &cos_t)) return wo->z > 0.0f;
    *eta = f->eta;
    *wo = m * (c / f->eta - cos_t) - wi * (1.0f / f->eta);
    return wo->z < 0.0f;
}

// Draws a direction by random numbers u0 (the part of the BSDF), u1, u2; false: absorbed. `lobe`: of the glossy part alone;
// false, too, where the diffuse part would have been chosen, so that most samples of a plastic cost nothing.
IR_FN bool bsdf_sample(const SceneData* s, const Surface* f, float u0, float u1, float u2, const bool lobe, BsdfSample* b) {
    if (sample_specular(f, u0, b)) {
        b->glossy = b->glossy * bump_visibility(f, b->direction);
        return !is_zero(b->glossy);
    }
    bool cosine = f->kind == IR_MATERIAL_DIFFUSE || f->kind == IR_MATERIAL_PLASTIC;
    if (f->kind == IR_MATERIAL_ROUGH_PLASTIC) cosine = u0 >= coat_probability(f, f->through);
    if (cosine) {
        if (lobe) return false;
        b->direction = to_world(make_frame(f->ns), cosine_direction(u1, u2));
    } else {
        const Frame frame = bsdf_frame(f);
        real3 wo;
        if (!sample_facets(f, to_local(frame, f->view), u0, u1, u2, &wo, &b->eta)) return false;
        b->direction = to_world(frame, wo);
    }
    const BsdfValue v = bsdf_evaluate(s, f, b->direction, lobe);
    if (!(v.density > 0.0f)) return false;
    b->density = v.density;
    b->diffuse = lobe ? black() : v.diffuse * (1.0f / v.density);
    b->glossy = v.glossy * (1.0f / v.density);
    return true;
}
#else  // ------------------------------------------------------------------------------------------ diffuse alone
IR_FN BsdfValue bsdf_evaluate(const SceneData* s, const Surface* f, real3 w, const bool lobe) {
    BsdfValue v;
    v.density = max(dot(w, f->ns), 0.0f) * IR_INV_PI;
    v.diffuse = f->albedo * (v.density * bump_visibility(f, w));
    v.glossy = black();
    return v;
}

IR_FN bool bsdf_sample(const SceneData* s, const Surface* f, float u0, float u1, float u2, const bool lobe, BsdfSample* b) {
    const real3 in_frame = cosine_direction(u1, u2);
    b->direction = to_world(make_frame(f->ns), in_frame);
    b->density = in_frame.z * IR_INV_PI;
    b->eta = 1.0f;
    b->diffuse = f->albedo * bump_visibility(f, b->direction);
    b->glossy = black();
    return true;
}
#endif
#endif
