// Fresnel reflectance of smooth interfaces, unpolarised.
#ifndef IR_FRESNEL_H
#define IR_FRESNEL_H
#include "portable.h"

// Dielectric: light comes at cosine cos_i >= 0 from the side whose index of refraction is the smaller by `eta`
// (eta = index behind over index before). *cos_t: cosine of the refracted direction, 0 beyond the critical angle.
IR_FN real fresnel_dielectric(real cos_i, real eta, real* cos_t) {
    // 1 - sin² / eta², arranged so that grazing incidence on nearly equal indices loses nothing in float32.
    const real under_root = ((eta - R(1.0)) * (eta + R(1.0)) + cos_i * cos_i) / (eta * eta);
    if (!(under_root > R(0.0))) {
        *cos_t = R(0.0);
        return R(1.0);
    }
    const real t = sqrt(under_root);
    *cos_t = t;
    const real s = (cos_i - eta * t) / (cos_i + eta * t), p = (t - eta * cos_i) / (t + eta * cos_i);
    return R(0.5) * (s * s + p * p);
}

// Conductor of complex index eta + i k, one wavelength.
IR_FN real fresnel_conductor(real cos_i, real eta, real k) {
    const real cos2 = cos_i * cos_i, sin2 = max(R(1.0) - cos2, R(0.0));
    const real t = eta * eta - k * k - sin2;
    const real root = sqrt(t * t + R(4.0) * eta * eta * k * k);  // a² + b²
    const real a = sqrt(max(R(0.5) * (root + t), R(0.0)));
    const real ac = R(2.0) * a * cos_i;
    // Held above 0: rounding, and 0 / 0 where there is no interface (eta = 1, k = 0) along the surface.
    const real s = max(root + cos2 - ac, R(0.0)) / max(root + cos2 + ac, R(1e-30));
    const real q = cos2 * root + sin2 * sin2, r = R(2.0) * a * cos_i * sin2;
    return R(0.5) * s * (R(1.0) + (q - r) / (q + r));
}
#endif
