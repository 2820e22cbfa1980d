// The dielectric coat of plastics, as the diffuse base sees it.
#ifndef IR_COAT_H
#define IR_COAT_H
#include "fresnel.h"
#include "scene.h"

#if IR_FEATURES & IR_FEATURE_BSDFS
// Share of light at cosine c that the coat of material m lets through. 1 where there is no coat.
IR_FN float coat_transmission(const SceneData* s, const IR_GLOBAL Material* m, float c) {
    if (m->kind == IR_MATERIAL_PLASTIC) {
        float cos_t;
        return 1.0f - fresnel_dielectric(c, m->eta, &cos_t);
    }
    if (m->kind != IR_MATERIAL_ROUGH_PLASTIC) return 1.0f;
    const float x = clamp(c, 0.0f, 1.0f) * (float)(IR_COAT_TABLE - 1u);
    const uint i = min((uint)x, IR_COAT_TABLE - 2u);
    const float a = IR_AS_FLOAT(s->texels[m->coat_table + i]), b = IR_AS_FLOAT(s->texels[m->coat_table + i + 1u]);
    return a + (b - a) * (x - (float)i);
}
#endif
#endif
