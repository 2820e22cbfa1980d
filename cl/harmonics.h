// Real orthonormal spherical (SH) and hemispherical (HSH) harmonics, no Condon-Shortley phase, index l*l + l + m.
#ifndef IR_HARMONICS_H
#define IR_HARMONICS_H
#include "portable.h"

#define IR_HARMONICS_MAX 12  // bands

// Values of the n*n functions of bands l < n, 1 <= n <= IR_HARMONICS_MAX, in unit direction d, times `scale`.
// P_l^m/sin^m theta times sin^m theta e^(i m phi) = (x + iy)^m: no angle, no pole, no trigonometric function.
IR_FN void sh_evaluate(real3 d, uint n, real scale, real* values) {
    real cos_m = R(1.0), sin_m = R(0.0);                // (x + iy)^m
    real diagonal = R(0.28209479177387814347) * scale;  // normalised P_m^m/sin^m; m = 0: 1/sqrt(4 pi)
    for (uint m = 0; m < n; ++m) {
        const real mm = (real)(m * m);
        const real fold = m == 0 ? R(1.0) : R(1.41421356237309504880);
        real before = R(0.0), p = diagonal;  // bands l-1 and l
        for (uint l = m; l < n; ++l) {
            const uint centre = l * l + l;
            values[centre + m] = fold * p * cos_m;
            if (m > 0) values[centre - m] = fold * p * sin_m;
            // P_{l+1} = a_{l+1} (z P_l - P_{l-1}/a_l), a_l = sqrt((4 l^2 - 1)/(l^2 - m^2))
            const real l1 = (real)((l + 1) * (l + 1)), l0 = (real)(l * l);
            const real a = sqrt((R(4.0) * l1 - R(1.0)) / (l1 - mm));
            const real b = l > m ? sqrt((l0 - mm) / (R(4.0) * l0 - R(1.0))) : R(0.0);
            const real next = a * (d.z * p - b * before);
            before = p;
            p = next;
        }
        const real c = cos_m * d.x - sin_m * d.y;
        sin_m = cos_m * d.y + sin_m * d.x;
        cos_m = c;
        diagonal *= sqrt((R(2.0) * (real)m + R(3.0)) / (R(2.0) * (real)m + R(2.0)));
    }
}

IR_FN void sh_basis(real3 d, uint n, real* values) { sh_evaluate(d, n, R(1.0), values); }

// HSH, P_l^m(2 cos - 1) on the upper hemisphere: sqrt 2 times SH in the direction whose cosine is 2 cos - 1.
IR_FN void hsh_basis(real3 d, uint n, real* values) {
    const real z = max(d.z, R(0.0));
    const real stretch = R(2.0) * sqrt(z / (R(1.0) + z));
    sh_evaluate(make_real3(d.x * stretch, d.y * stretch, R(2.0) * z - R(1.0)), n, R(1.41421356237309504880), values);
}

// Coefficients of a cosine-distributed sample carry 1/cos; floored (theory 7).
IR_FN real inverse_cosine(real z) { return R(1.0) / max(z, R(1e-3)); }
#endif
