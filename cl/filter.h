// Reconstruction filters as distributions of film offsets from a pixel's centre, in pixels.
#ifndef IR_FILTER_H
#define IR_FILTER_H
#include "lanes.h"

// Inverse of the tent filter's distribution function on [-radius, radius].
IR_FN lanes tent_quantile(lanes u, real radius) {
    const lanes left = sqrt(R(2.0) * u) - R(1.0), right = R(1.0) - sqrt(max(R(2.0) - R(2.0) * u, R(0.0)));
    return radius * lanes_select(right, left, u < R(0.5));
}
IR_FN real tent_distribution(real x, real radius) {
    const real t = clamp(x / radius, -R(1.0), R(1.0));
    return t < R(0.0) ? R(0.5) * (R(1.0) + t) * (R(1.0) + t) : R(1.0) - R(0.5) * (R(1.0) - t) * (R(1.0) - t);
}

// Distribution function of the gaussian exp(-x^2/2s^2) minus its value at the radius (Mitsuba's), by its integral:
// F(x) = (s sqrt(pi/2) erf(x / s sqrt 2) - x g(radius)), normalised to [0,1] over the support.
IR_FN real gaussian_distribution(real x, real stddev, real radius) {
    const real k = stddev * R(1.25331413731550025), floor_value = exp(-R(0.5) * radius * radius / (stddev * stddev));
    const real half_width = k * erf(radius * R(0.70710678118654752) / stddev) - radius * floor_value;
    const real t = clamp(x, -radius, radius);
    return R(0.5) + R(0.5) * (k * erf(t * R(0.70710678118654752) / stddev) - t * floor_value) / half_width;
}

// Its inverse for a radius of four standard deviations, the only one there is: x / s = y P(log(q + 0.03)), y = 2u - 1,
// q = sqrt(1 - y^2). Near the ends F grows with the square of the distance to them, further in as a gaussian's tail
// does: in this logarithm the quantile bends little in both, and its symmetry stays exact. P, of degree 9 in the
// logarithm mapped to [-1, 1], is our own least-squares fit to the closed form in double precision; the offset is right
// to 1.1e-6 standard deviations (1.4e-6 in float32), as good as the bisection that it replaced.
IR_FN lanes gaussian_quantile(lanes u, real stddev) {
    const lanes q = sqrt(max(R(4.0) * u * (R(1.0) - u), R(0.0)));
    const lanes t = log(q + R(0.03)) * R(0.565592193) + R(0.983281772);
    lanes p = t * R(0.00259804902) - R(0.00541102545);
    p = p * t - R(0.00112622568);
    p = p * t - R(0.000193984112);
    p = p * t + R(0.00435067482);
    p = p * t + R(0.0634645374);
    p = p * t - R(0.0319351498);
    p = p * t + R(0.00216271621);
    p = p * t - R(1.34773025);
    p = p * t + R(2.56613417);
    return stddev * (R(2.0) * u - R(1.0)) * p;
}
#endif
