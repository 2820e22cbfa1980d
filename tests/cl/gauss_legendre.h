// Quadrature that integrates polynomials exactly, for tests.
#pragma once
#include <array>
#include <cmath>
#include <vector>

#include "formulas.h"

namespace irradia::test {

/// Gauss-Legendre nodes and weights on [0, 1], by Newton's method: exact for polynomials of degree below 2 order.
inline std::vector<std::array<double, 2>> gauss_legendre(int order) {
    std::vector<std::array<double, 2>> out;
    for (int i = 0; i < order; ++i) {
        double x = std::cos(kPi * (i + .75) / (order + .5)), derivative = 1;
        for (int it = 0; it < 50; ++it) {
            double p0 = 1, p1 = x;
            for (int k = 2; k <= order; ++k) {
                const double p2 = ((2 * k - 1) * x * p1 - (k - 1) * p0) / k;
                p0 = p1, p1 = p2;
            }
            derivative = order * (x * p1 - p0) / (x * x - 1);
            x -= p1 / derivative;
        }
        out.push_back({.5 * (x + 1), 1 / ((1 - x * x) * derivative * derivative)});
    }
    return out;
}

}  // namespace irradia::test
