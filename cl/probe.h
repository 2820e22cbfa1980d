// The unbiased estimate of a pixel's squared error (theory 8): freeze the cache, finish the picture, then take n
// independent unbiased samples of a pixel's true value.
#ifndef IR_PROBE_H
#define IR_PROBE_H
#include "portable.h"

// Running mean and sum of squared deviations of samples (Welford): no cancellation in float32.
typedef struct Moments {
    real mean, deviation2;
    uint count;
} Moments;

IR_FN Moments moments_zero(void) {
    Moments m;
    m.mean = m.deviation2 = R(0.0);
    m.count = 0;
    return m;
}

IR_FN Moments moments_add(Moments m, real x) {
    m.count += 1;
    const real d = x - m.mean;
    m.mean += d / (real)m.count;
    m.deviation2 += d * (x - m.mean);
    return m;
}

// q = (I - mean)^2 - s^2/n; its expectation is the squared error of the pixel value I. Needs two samples or more.
IR_FN real squared_error_estimate(real I, Moments m) {
    const real d = I - m.mean;
    return d * d - m.deviation2 / ((real)(m.count - 1) * (real)m.count);
}

// Weight of a pixel in the relative error, 1/(I^2 + eps^2).
IR_FN real relative_weight(real I, real eps) { return R(1.0) / (I * I + eps * eps); }
#endif
