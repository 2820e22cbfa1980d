// GGX microfacet lobe with height-correlated Smith shadowing, Fresnel factor 1; local frame, unit directions.
#ifndef IR_GGX_H
#define IR_GGX_H
#include "portable.h"

// BRDF value (1/sr) for incident wi and outgoing wo, both pointing away from the surface; 0 below it.
IR_FN real ggx_brdf(real3 wi, real3 wo, real alpha) {
    if (!(wi.z > R(0.0) && wo.z > R(0.0))) return R(0.0);
    const real3 h = normalize(wi + wo);
    const real a2 = alpha * alpha;
    // 1 + (a2 - 1) h.z^2 loses everything in float32 for small alpha and h near the normal; this does not.
    const real t = h.x * h.x + h.y * h.y + a2 * h.z * h.z;
    const real D = a2 / (IR_PI * t * t);
    const real gi = wo.z * sqrt(wi.z * wi.z + a2 * (wi.x * wi.x + wi.y * wi.y));
    const real go = wi.z * sqrt(wo.z * wo.z + a2 * (wo.x * wo.x + wo.y * wo.y));
    return R(0.5) * D / (gi + go);  // D G / (4 cos_i cos_o)
}
#endif
