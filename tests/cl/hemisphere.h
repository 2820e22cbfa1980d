// A whole hemisphere through the functions of hemisphere_reduce.h, in double.
#pragma once
#include <random>

#include "polygon.h"

namespace irradia::test {

using host::HemisphereSample;
using host::HemisphereSums;

/// Samples of one record, row-major j * n + k, in the local frame.
struct Hemisphere {
    unsigned m = 0, n = 0;
    host::Frame frame{};
    std::vector<HemisphereSample> samples;
};

/// What a record is made of; gradients in world space, the Hessian in (T, B).
struct Record {
    double E = 0, harmonic = 0, minimum = 0;
    real3 rotation{}, ward{}, ward_ratio{}, crease{};
    double hxx = 0, hxy = 0, hyy = 0;
};

/// The cells of one case of hemisphere_cells.json; its radiances are grey.
inline Hemisphere hemisphere_of(const json& c) {
    Hemisphere h{c.at("M"), c.at("N"), frame_of(c), {}};
    for (unsigned i = 0; i < h.m * h.n; ++i) {
        const int hit = c["hit_index"][i];
        const double L = hit < 0 ? 0 : c["rect_radiance"][static_cast<std::size_t>(hit)].get<double>();
        const real3 d = c.contains("directions") ? to_local(h.frame, vec3(c["directions"][i]))
                                                 : host::stratum_direction(i / h.n, i % h.n, h.m, h.n, .5, .5);
        const real3 normal = hit < 0 ? real3{0, 0, 1} : vec3(c["rect_normal"][static_cast<std::size_t>(hit)]);
        h.samples.push_back({d, to_local(h.frame, normal), host::make_real3(L, L, L), c["r"][i]});
    }
    return h;
}

/// Jittered cells of a scene of rectangles, seen from p with normal n.
inline Hemisphere sample_scene(const std::vector<Rectangle>& scene, real3 p, real3 normal, unsigned m, unsigned n,
                               std::mt19937& random) {
    std::uniform_real_distribution<double> uniform;
    Hemisphere h{m, n, host::make_frame(normal), {}};
    for (unsigned i = 0; i < m * n; ++i) {
        const double x = uniform(random), y = uniform(random);
        const real3 d = host::stratum_direction(i / n, i % n, m, n, x, y);
        const RectangleHit hit = trace(scene, p, to_world(h.frame, d));
        const double L = hit.index < 0 ? 0 : scene[static_cast<std::size_t>(hit.index)].radiance;
        const real3 q = hit.index < 0 ? real3{0, 0, 1} : scene[static_cast<std::size_t>(hit.index)].normal;
        h.samples.push_back({d, to_local(h.frame, q), host::make_real3(L, L, L), hit.distance});
    }
    return h;
}

inline const HemisphereSample& ring_neighbour(const Hemisphere& h, unsigned j, unsigned k) {
    return h.samples[(j > 0 ? j - 1 : 0) * h.n + k];
}
inline const HemisphereSample& azimuth_neighbour(const Hemisphere& h, unsigned j, unsigned k) {
    return h.samples[j * h.n + (k + h.n - 1) % h.n];
}

inline Record record_of(const Hemisphere& h) {
    HemisphereSums all = host::hemisphere_sums_zero(), ward = all, ratio = all;
    for (unsigned j = 0; j < h.m; ++j)
        for (unsigned k = 0; k < h.n; ++k) {
            const HemisphereSample &own = h.samples[j * h.n + k], &ring = ring_neighbour(h, j, k);
            const HemisphereSample& azimuth = azimuth_neighbour(h, j, k);
            cell_moments(&all, k, h.n, host::ring_rotation_weight(j, h.m), own, own.radiance, 0, kMiss, 0);
            cell_edges(&all, j, k, h.m, h.n, own, ring, azimuth);
            cell_edges_ward(&ward, j, k, h.m, h.n, own, ring, azimuth, 0, false);
            cell_edges_ward(&ratio, j, k, h.m, h.n, own, ring, azimuth, 0, true);
        }
    const double factor = kPi / (h.m * h.n);
    const auto world = [&](double x, double y) { return h.frame.t * x + h.frame.b * y; };
    return {factor * all.irradiance.x,
            host::harmonic_mean_distance(h.m * h.n, all.inverse_distance),
            all.min_distance,
            factor * world(all.rx.x, all.ry.x),
            world(ward.gx.x, ward.gy.x),
            world(ratio.gx.x, ratio.gy.x),
            world(all.gx.x, all.gy.x),
            all.hxx,
            all.hxy,
            all.hyy};
}

}  // namespace irradia::test
