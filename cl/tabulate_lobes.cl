// Tables of the materials' lobes (lobe.h): albedo, and coefficients in hemispherical harmonics, over the view's cosine and,
// where it is a texture, the roughness. By quadrature over the visible facets: IR_STEPS² directions in proportion to the
// lobe, so that narrow ones cost no more than wide ones. One work-item an entry.
// Compile-time: IR_ORDER, 0: albedos alone.
#include "harmonics.h"
#include "irradia/shared/radiance_types.h"
#include "lobe.h"

#define IR_STEPS 64u
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
    for (uint i = 0; i < IR_STEPS * IR_STEPS; ++i) {
        const float u = ((float)(i / IR_STEPS) + 0.5f) / (float)IR_STEPS, v = ((float)(i % IR_STEPS) + 0.5f) / (float)IR_STEPS;
        real3 w;
        float eta, density;
        if (!sample_facets(&f, view, 0.0f, u, v, &w, &eta)) continue;
        const real3 value = facet_reflection(&f, view, w, &density);
        if (!(density > 0.0f)) continue;
        const real3 weight = value * (1.0f / (density * (float)(IR_STEPS * IR_STEPS)));
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

// Entries of the table of material `material`, which begins at `offset`: cosines of them for each of `alphas` roughnesses
// (1: the material's own).
IR_KERNEL void tabulate_lobes(IR_GLOBAL const Material* materials, IR_GLOBAL float* tables, RadianceParameters parameters,
                              uint material, uint offset, uint alphas) {
    if (IR_GLOBAL_ID >= parameters.cosines * alphas) return;
    const uint i = IR_GLOBAL_ID % parameters.cosines, row = IR_GLOBAL_ID / parameters.cosines;
    const float alpha = alphas == 1u ? materials[material].alpha_u
                                     : IR_LEAST_ALPHA + (1.0f - IR_LEAST_ALPHA) * (float)row / (float)(alphas - 1u);
    float entry[IR_LOBE_SIZE];
    tabulate_lobe(materials + material, alpha, max((float)i / (float)(parameters.cosines - 1u), 1e-3f), entry);
    for (uint k = 0; k < IR_LOBE_SIZE; ++k) tables[offset + IR_GLOBAL_ID * IR_LOBE_SIZE + k] = entry[k];
}
