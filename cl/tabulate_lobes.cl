// Tables of the materials' lobes (lobe.h): albedo, and coefficients in hemispherical harmonics, over the view's angle and,
// where it is a texture, the roughness. By quadrature over the facets, of IR_SLOPES slopes and IR_AZIMUTHS azimuths in
// proportion to their distribution, so that narrow lobes cost no more than wide ones; steep facets, which are few but
// reflect much, are taken more often and count less. One work-item an entry.
//
// As many points in proportion to the visible facets err by up to .6 % of the albedo, differently from entry to entry
// (and Beckmann's are drawn by exact shadowing, while the BSDF has Walter's fit: .25 % more); these by .1 %.
// Compile-time: IR_ORDER, 0: albedos alone.
#include "harmonics.h"
#include "irradia/shared/radiance_types.h"
#include "lobe.h"

#define IR_SLOPES 128u
#define IR_AZIMUTHS 32u  // of half the circle: the other half mirrors them
#define IR_LOBE_SIZE IR_LOBE_FLOATS(IR_ORDER)

// Material `material`'s lobe at roughness `alpha`, seen at cosine c, without its specular factor.
IR_FN void tabulate_lobe(IR_GLOBAL const Material* material, float alpha, float c, float* out) {
    Surface f;
    f.material = material;
    f.kind = material->kind;
    f.flags = material->flags;
    f.specular = make_real3(1.0f, 1.0f, 1.0f);
    f.alpha_u = f.alpha_v = alpha;
    const real3 view = make_real3(sqrt(max(1.0f - c * c, 0.0f)), 0.0f, c);
    for (uint i = 0; i < IR_LOBE_SIZE; ++i) out[i] = 0.0f;
    const Microfacets facets = surface_facets(&f);
    for (uint i = 0; i < IR_SLOPES * IR_AZIMUTHS; ++i) {
        // Quantile 1 - rest² of the density D cos.
        const float rest = ((float)(i / IR_AZIMUTHS) + 0.5f) / (float)IR_SLOPES, steeper = rest * rest;
        const float tan2 = alpha * alpha * (facets.beckmann ? -log(steeper) : (1.0f - steeper) / steeper);
        float sin_phi, cos_phi;
        sincos_turns(0.5f * ((float)(i % IR_AZIMUTHS) + 0.5f) / (float)IR_AZIMUTHS, &sin_phi, &cos_phi);
        const float z = rsqrt(1.0f + tan2), flat = sqrt(tan2) * z;
        const real3 h = make_real3(flat * cos_phi, flat * sin_phi, z);
        const float h_view = dot(h, view);
        const real3 w = h * (2.0f * h_view) - view;
        if (!(h_view > 0.0f && w.z > 0.0f)) continue;
        // Of facets, times the Jacobian from facets to reflected directions.
        const float density = microfacet_density(&facets, h) * z / (2.0f * rest) / (4.0f * h_view);
        float unused;
        const real3 value = facet_reflection(&f, view, w, &unused);
        if (!(density > 0.0f)) continue;
        const real3 weight = value * (1.0f / (density * (float)(IR_SLOPES * IR_AZIMUTHS)));
        out[0] += weight.x;
        out[1] += weight.y;
        out[2] += weight.z;
#if IR_ORDER > 0
        float basis[IR_ORDER * IR_ORDER];
        hsh_basis(w, IR_ORDER, basis);
        for (uint l = 0; l < IR_ORDER; ++l)
            for (uint m = 0; m <= l; ++m) {
                const float y = basis[l * l + l + m];
                float* to = out + 3u + 3u * lobe_coefficient(l, m);
                to[0] += y * weight.x;
                to[1] += y * weight.y;
                to[2] += y * weight.z;
            }
#endif
    }
}

// Entries of the table of material `material`, which begins at `offset`: angles of them for each of `alphas` roughnesses
// (1: the material's own).
IR_KERNEL void tabulate_lobes(IR_GLOBAL const Material* materials, IR_GLOBAL float* tables, RadianceParameters parameters,
                              uint material, uint offset, uint alphas) {
    if (IR_GLOBAL_ID >= parameters.angles * alphas) return;
    const uint i = IR_GLOBAL_ID % parameters.angles, row = IR_GLOBAL_ID / parameters.angles;
    const float alpha = alphas == 1u ? materials[material].alpha_u
                                     : IR_LEAST_ALPHA + (1.0f - IR_LEAST_ALPHA) * (float)row / (float)(alphas - 1u);
    float entry[IR_LOBE_SIZE];
    tabulate_lobe(materials + material, alpha, table_cosine(i, parameters.angles), entry);
    for (uint k = 0; k < IR_LOBE_SIZE; ++k) tables[offset + IR_GLOBAL_ID * IR_LOBE_SIZE + k] = entry[k];
}
