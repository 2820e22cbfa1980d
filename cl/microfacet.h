// Microfacet distributions, GGX and Beckmann, with Smith's shadowing, in the surface's frame (z = its normal), after
// Walter et al. 2007; normals are drawn in proportion to what of them is visible (Heitz and d'Eon 2014). Shadowing is
// separable and Beckmann's is Walter's rational fit, as in Mitsuba 3, so that its pictures can judge ours.
#ifndef IR_MICROFACET_H
#define IR_MICROFACET_H
#include "sampling.h"

typedef struct Microfacets {
    real alpha_u, alpha_v;  // roughness along x and y
    bool beckmann;
} Microfacets;

// D(m), sr⁻¹. Arranged so that small roughness near the normal loses nothing in float32: neither form takes 1 - cos².
IR_FN real microfacet_density(const Microfacets* f, real3 m) {
    if (!(m.z > R(0.0))) return R(0.0);
    const real a = f->alpha_u * f->alpha_v;
    const real x = m.x / f->alpha_u, y = m.y / f->alpha_v, cos2 = m.z * m.z;
    if (f->beckmann) return exp(-(x * x + y * y) / cos2) / max(IR_PI * a * cos2 * cos2, R(1e-30));
    const real t = x * x + y * y + cos2;
    return R(1.0) / (IR_PI * a * t * t);
}

// Share of the facets of normal m that direction v sees.
IR_FN real smith_g1(const Microfacets* f, real3 v, real3 m) {
    if (!(dot(v, m) * v.z > R(0.0))) return R(0.0);
    const real x = f->alpha_u * v.x, y = f->alpha_v * v.y;
    const real tan2 = (x * x + y * y) / (v.z * v.z);
    if (f->beckmann) {
        if (!(tan2 > R(1e-12))) return R(1.0);
        const real a = rsqrt(tan2);
        return a >= R(1.6) ? R(1.0) : a * (R(3.535) + R(2.181) * a) / (R(1.0) + a * (R(2.276) + R(2.577) * a));
    }
    return R(2.0) / (R(1.0) + sqrt(R(1.0) + tan2));
}

// Density with which sample_visible_normal draws m for viewers at v (v.z > 0), sr⁻¹.
IR_FN real visible_normal_density(const Microfacets* f, real3 v, real3 m) {
    return microfacet_density(f, m) * smith_g1(f, v, m) * fabs(dot(v, m)) / v.z;
}

// Inverse of the error function, single precision (Giles 2010).
IR_FN real inverse_erf(real x) {
    real w = -log(max((R(1.0) - x) * (R(1.0) + x), R(1e-30)));
    real p;
    if (w < R(5.0)) {
        w -= R(2.5);
        p = R(2.81022636e-08);
        p = R(3.43273939e-07) + p * w;
        p = R(-3.5233877e-06) + p * w;
        p = R(-4.39150654e-06) + p * w;
        p = R(0.00021858087) + p * w;
        p = R(-0.00125372503) + p * w;
        p = R(-0.00417768164) + p * w;
        p = R(0.246640727) + p * w;
        p = R(1.50140941) + p * w;
    } else {
        w = sqrt(w) - R(3.0);
        p = R(-0.000200214257);
        p = R(0.000100950558) + p * w;
        p = R(0.00134934322) + p * w;
        p = R(-0.00367342844) + p * w;
        p = R(0.00573950773) + p * w;
        p = R(-0.0076224613) + p * w;
        p = R(0.00943887047) + p * w;
        p = R(1.00167406) + p * w;
        p = R(2.83297682) + p * w;
    }
    return p * x;
}

// Slope along the view's azimuth of Beckmann's visible facets at roughness 1: the quantile u of the density
// max(0, cos - x sin) exp(-x²). Its integral is C(x) = erfc(-x) / 2 + tan exp(-x²) / (2 sqrt pi), up to x = cot.
IR_FN real beckmann_visible_slope(real cosine, real u) {
    const real sine = sqrt(max(R(1.0) - cosine * cosine, R(0.0)));
    const real inv_sqrt_pi = R(0.56418958354775629);
    if (!(sine > R(1e-4))) return inverse_erf(clamp(R(2.0) * u - R(1.0), R(-0.999999), R(0.999999)));
    const real tangent = sine / cosine;
    real lo = R(-4.0), hi = min(R(1.0) / tangent, R(4.0));
    const real wanted = u * (erfc(-hi) + inv_sqrt_pi * tangent * exp(-hi * hi));
    real x = R(0.5) * (lo + hi);
    for (int i = 0; i < 16; ++i) {  // Newton's steps, or halving where they would leave the bracket
        const real e = exp(-x * x);
        const real excess = erfc(-x) + inv_sqrt_pi * tangent * e - wanted;
        if (excess > R(0.0))
            hi = x;
        else
            lo = x;
        const real slope = R(2.0) * inv_sqrt_pi * e * (R(1.0) - x * tangent);
        const real step = excess / max(slope, R(1e-12));
        const real next = x - step;
        if (fabs(step) < R(1e-5)) return clamp(next, lo, hi);  // before it is halved away: next may be lo or hi itself
        x = next > lo && next < hi ? next : R(0.5) * (lo + hi);
    }
    return x;
}

// A facet's normal, drawn in proportion to how much of it direction v (v.z > 0) sees.
IR_FN real3 sample_visible_normal(const Microfacets* f, real3 v, real u0, real u1) {
    // In the frame where the roughness is 1 the view is stretched (Heitz 2018).
    const real3 s = normalize(make_real3(f->alpha_u * v.x, f->alpha_v * v.y, v.z));
    const real flat = s.x * s.x + s.y * s.y;
    const real inverse = flat > R(1e-14) ? rsqrt(flat) : R(0.0);
    const real cx = inverse > R(0.0) ? s.x * inverse : R(1.0), cy = s.y * inverse;  // azimuth of the view
    if (f->beckmann) {
        const real a = beckmann_visible_slope(s.z, u0);
        const real b = inverse_erf(clamp(R(2.0) * u1 - R(1.0), R(-0.999999), R(0.999999)));
        const real sx = (cx * a - cy * b) * f->alpha_u, sy = (cy * a + cx * b) * f->alpha_v;
        return normalize(make_real3(-sx, -sy, R(1.0)));
    }
    const real3 t1 = make_real3(-cy, cx, R(0.0));
    const real3 t2 = cross(s, t1);
    const real3 d = sample_disk(u0, u1);
    const real half_way = R(0.5) * (R(1.0) + s.z);
    const real y = (R(1.0) - half_way) * sqrt(max(R(1.0) - d.x * d.x, R(0.0))) + half_way * d.y;
    const real z = sqrt(max(R(1.0) - d.x * d.x - y * y, R(0.0)));
    const real3 n = t1 * d.x + t2 * y + s * z;
    return normalize(make_real3(f->alpha_u * n.x, f->alpha_v * n.y, max(n.z, R(1e-6))));
}
#endif
