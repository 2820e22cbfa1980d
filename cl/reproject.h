// Radiance caching on the samples themselves (theory 7): a record keeps P_s = p_i + r_s w_s, the hit normals n_s and
// radiances L_s; at another point p they are seen in other directions and under other solid angles. Frame-free.
//
//   Lo = albedo(wo) sum F_s L_s / sum F_s,  F_s = weight f(w', wo) cosine   (self-normalised: exact in a furnace)
#ifndef IR_REPROJECT_H
#define IR_REPROJECT_H
#include "crease.h"
#include "portable.h"

// A point that was sampled from afar and comes close would count for all that is around it: solid angles grow by at most
// the inverse of this.
#define IR_NEAREST2 R(0.25)

// A sample as seen from p. weight: W_s, proportional to solid angle there. cosine: n.w', 0 for a dropped sample.
typedef struct ReprojectedSample {
    real3 direction;
    real weight, cosine;
} ReprojectedSample;

// to_record = p_i - p; unit direction w, distance r and normal n_s of the sample, cos_s = its cosine at the record;
// n = normal at p. All in one frame, any.
IR_FN ReprojectedSample reproject_sample(real3 to_record, real3 w, real r, real3 n_s, real cos_s, real3 n) {
    ReprojectedSample s;
    s.direction = w;
    real J = R(1.0);
    if (!is_miss(r)) {
        const real3 v = to_record + w * r;
        const real r2 = max(dot(v, v), R(1e-12) * r * r);  // p on the hit point itself: no division by 0
        s.direction = v * rsqrt(r2);
        J = r * r / max(r2, IR_NEAREST2 * r * r) * (fabs(dot(n_s, s.direction)) / max(fabs(dot(n_s, w)), R(1e-4)));
    }
    const real cosine = dot(n, s.direction);
    s.weight = J / max(cos_s, R(1e-3));
    s.cosine = cosine > R(1e-4) ? cosine : R(0.0);
    return s;
}

// The two sums of the self-normalised estimate.
typedef struct ReprojectedSum {
    real3 weighted;  // sum F L, RGB
    real total;      // sum F
} ReprojectedSum;

IR_FN ReprojectedSum reprojected_sum_zero(void) {
    ReprojectedSum sum;
    sum.weighted = make_real3(R(0.0), R(0.0), R(0.0));
    sum.total = R(0.0);
    return sum;
}

// f = BRDF value for s.direction; 1 gives irradiance (albedo = pi).
IR_FN ReprojectedSum reprojected_add(ReprojectedSum sum, ReprojectedSample s, real f, real3 radiance) {
    const real F = s.weight * f * s.cosine;
    sum.weighted = sum.weighted + radiance * F;
    sum.total += F;
    return sum;
}

IR_FN real3 reprojected_radiance(ReprojectedSum sum, real albedo) {
    return sum.total > R(0.0) ? sum.weighted * (albedo / sum.total) : make_real3(R(0.0), R(0.0), R(0.0));
}
#endif
