// The glossy part of an isotropic rough surface as cached radiance is weighed by it: facets' distribution, shadowing and
// Fresnel reflectance up to a factor, since what is reflected is normalised by the lobe's albedo (theory 7). The same
// function as facet_reflection in bsdf.h, for lanes of directions at once and in world space; a test holds them together.
//
// Conductors differ by channel in their Fresnel reflectance alone. Its shape is taken as Schlick's between the exact
// reflectance at normal incidence and 1, F0 + (1 - F0) (1 - c)^5: two sums then serve all channels. The albedo is exact,
// so this errs only where radiance varies over the lobe and the reflectance does too (near grazing incidence).
#ifndef IR_LOBE_H
#define IR_LOBE_H
#include "bsdf.h"
#include "irradia/shared/radiance_types.h"
#include "lanes.h"

typedef struct Lobe {
    real3 n, o;  // unit: normal, and direction of the view
    float alpha2;
    float eta;  // plastics: index of refraction of the coat; 0: a conductor
    bool beckmann;
} Lobe;

IR_FN Lobe surface_lobe(const Surface* f) {
    Lobe lobe;
    lobe.n = f->ns;
    lobe.o = f->view;
    lobe.alpha2 = f->alpha_u * f->alpha_u;
    lobe.eta = f->kind == IR_MATERIAL_ROUGH_CONDUCTOR ? 0.0f : f->material->eta;
    lobe.beckmann = (f->flags & IR_MATERIAL_BECKMANN) != 0u;
    return lobe;
}

// Weights of unit directions w, whose cosine to the normal is positive. *schlick: (1 - c)^5 of conductors, 0 of plastics,
// whose reflectance is in the weight.
IR_FN lanes lobe_weights(const Lobe* lobe, LaneVector w, lanes cosine, lanes* schlick) {
    LaneVector h;
    h.x = w.x + lobe->o.x;
    h.y = w.y + lobe->o.y;
    h.z = w.z + lobe->o.z;
    const lanes inverse = 1.0f / sqrt(max(lanes_dot(h, h), 1e-12f));
    const lanes c = lanes_dot3(h, lobe->o) * inverse;  // between view and facet
    const lanes along = lanes_dot3(h, lobe->n);
    const lanes nh = along * inverse, nh2 = nh * nh;
    // The part of h in the surface: 1 - nh2 would be good to 2^-24 / alpha2 only, 3e-4 of the weight at roughness .05.
    h.x -= along * lobe->n.x;
    h.y -= along * lobe->n.y;
    h.z -= along * lobe->n.z;
    const lanes sin2 = lanes_dot(h, h) * (inverse * inverse);
    const float a2 = lobe->alpha2;
    const lanes tan2 = a2 * max(1.0f - cosine * cosine, 0.0f) / (cosine * cosine);
    lanes weight;
    if (lobe->beckmann) {
        const lanes a = 1.0f / sqrt(max(tan2, 1e-12f));
        const lanes fit = a * (3.535f + 2.181f * a) / (1.0f + a * (2.276f + 2.577f * a));
        weight = exp(-sin2 / (a2 * nh2)) / (nh2 * nh2) * lanes_select(fit, 1.0f, a >= 1.6f);
    } else {
        const lanes t = sin2 + a2 * nh2;
        weight = 1.0f / (t * t * (1.0f + sqrt(1.0f + tan2)));
    }
    *schlick = lanes_of(0.0f);
    if (lobe->eta == 0.0f) {
        const lanes m = max(1.0f - c, 0.0f), m2 = m * m;
        *schlick = m2 * m2 * m;
        return weight;
    }
    const float eta = lobe->eta;  // fresnel_dielectric
    const lanes t = sqrt(max((eta - 1.0f) * (eta + 1.0f) + c * c, 0.0f)) / eta;
    const lanes s = (c - eta * t) / (c + eta * t), p = (t - eta * c) / (t + eta * c);
    return weight * (s * s + p * p);
}

// ---- tables of lobes (tabulate_lobes.cl) -------------------------------------------------------------------------
// Of every material with a lobe, over roughness (one entry where it is no texture) and the view's angle: the albedo, and
// the lobe's coefficients in hemispherical harmonics for a view of azimuth 0, for l < order and 0 <= m <= l (those of
// negative m are zero); each three channels, without the material's specular factor.
#define IR_LEAST_ALPHA 0.02f  // of the tables over roughness; the largest is 1

IR_FN uint lobe_coefficient(uint l, uint m) { return l * (l + 1u) / 2u + m; }

// Is f's glossy part a lobe that can be tabulated: facets' reflection, alike in all directions, not turned by a map?
IR_FN bool has_lobe(const Surface* f) {
#if IR_FEATURES & IR_FEATURE_BUMPS
    if (f->bumped) return false;
#endif
    return (f->kind == IR_MATERIAL_ROUGH_CONDUCTOR || f->kind == IR_MATERIAL_ROUGH_PLASTIC) && f->alpha_u == f->alpha_v;
}

// Where between which entries of a table of `count` a coordinate x in [0, 1] lies.
typedef struct TablePlace {
    uint i, next;
    float part;
} TablePlace;

IR_FN TablePlace table_place(float x, uint count) {
    const float at = clamp(x, 0.0f, 1.0f) * (float)(count - 1u);
    TablePlace p;
    p.i = min((uint)at, count - 1u);
    p.next = min(p.i + 1u, count - 1u);
    p.part = at - (float)p.i;
    return p;
}

// Cosine of the view at entry i of `count`. In equal steps of the angle: coefficients of |m| > 0 are in proportion to its
// sine where the view is near the normal, which equal steps of the cosine miss by up to .2 of the albedo.
IR_FN float table_cosine(uint i, uint count) { return max(sin(0.5f * IR_PI * (float)i / (float)(count - 1u)), 1e-3f); }

// Entry k of the table of a lobe seen at cosine c, at roughness alpha.
typedef struct LobeEntry {
    IR_GLOBAL const float *e00, *e01, *e10, *e11;
    float part0, part1;
} LobeEntry;

IR_FN LobeEntry lobe_entry(IR_GLOBAL const float* table, const RadianceParameters* q, bool textured, float alpha,
                           float c) {
    const uint floats = IR_LOBE_FLOATS(q->order), row = q->angles * floats;
    const TablePlace angle = table_place(asin(clamp(c, 0.0f, 1.0f)) * (2.0f * IR_INV_PI), q->angles);
    const TablePlace rough = table_place((alpha - IR_LEAST_ALPHA) / (1.0f - IR_LEAST_ALPHA), textured ? q->alphas : 1u);
    LobeEntry e;
    e.e00 = table + rough.i * row + angle.i * floats;
    e.e01 = table + rough.i * row + angle.next * floats;
    e.e10 = table + rough.next * row + angle.i * floats;
    e.e11 = table + rough.next * row + angle.next * floats;
    e.part0 = angle.part;
    e.part1 = rough.part;
    return e;
}

IR_FN float lobe_value(const LobeEntry* e, uint k) {
    const float a = e->e00[k] + (e->e01[k] - e->e00[k]) * e->part0;
    const float b = e->e10[k] + (e->e11[k] - e->e10[k]) * e->part0;
    return a + (b - a) * e->part1;
}

IR_FN real3 lobe_values(const LobeEntry* e, uint k) {
    return make_real3(lobe_value(e, 3u * k), lobe_value(e, 3u * k + 1u), lobe_value(e, 3u * k + 2u));
}
#endif
