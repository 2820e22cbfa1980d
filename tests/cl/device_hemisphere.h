// Whole hemispheres in float32 on the device, and what they are compared with.
#pragma once
#include "device.h"
#include "hemisphere.h"

namespace irradia::test {

/// Samples as the device gets them; `scale` multiplies distances.
inline std::vector<float> flatten(const Hemisphere& h, double scale = 1) {
    Inputs in;
    for (const HemisphereSample& s : h.samples)
        in.add(s.direction).add(s.normal).add(s.radiance).add(s.distance >= kMiss ? kMiss : s.distance * scale);
    return in.values();
}

/// The same hemisphere from the rounded numbers.
inline Hemisphere rounded(const Hemisphere& h) {
    Hemisphere out = h;
    const std::vector<float> v = flatten(h);
    for (std::size_t i = 0; i < h.samples.size(); ++i) {
        const float* f = &v[10 * i];
        out.samples[i] = {{f[0], f[1], f[2]}, {f[3], f[4], f[5]}, {f[6], f[7], f[8]}, f[9]};
        if (h.samples[i].distance >= kMiss) out.samples[i].distance = kMiss;
    }
    return out;
}

/// Work-items' sums (23 floats each, `stride` apart) as a record; Ward's gradient is left out.
inline Record record_of_sums(const Hemisphere& h, const std::vector<float>& out, std::size_t stride) {
    std::vector<double> sum(stride);
    double minimum = kMiss;
    for (std::size_t at = 0; at < out.size(); at += stride) {
        for (std::size_t q = 0; q < stride; ++q) sum[q] += static_cast<double>(out[at + q]);
        minimum = std::min(minimum, static_cast<double>(out[at + 22]));
    }
    const double factor = kPi / (h.m * h.n);
    const auto world = [&](double x, double y) { return h.frame.t * x + h.frame.b * y; };
    return {factor * sum[0],
            h.m * h.n / sum[21],
            minimum,
            factor * world(sum[3], sum[6]),
            stride > 24 ? world(sum[23], sum[24]) : real3{0, 0, 0},
            real3{0, 0, 0},
            world(sum[9], sum[12]),
            sum[18],
            sum[19],
            sum[20]};
}

/// The same by sum_cells, as sample_hemispheres has it: eight cells at once on CPU devices. (Its cells have no z.)
inline Record run_sum_cells(const Hemisphere& h, bool cpu_traversal, float limit) {
    constexpr unsigned items = 8, arrays = 9;
    const std::size_t count = h.samples.size();
    std::vector<float> cells(arrays * count), weights, out(items * 23);
    for (std::size_t i = 0; i < count; ++i) {
        const HemisphereSample& s = h.samples[i];
        const double values[arrays] = {s.direction.x, s.direction.y, s.distance,   s.normal.x,  s.normal.y,
                                       s.normal.z,    s.radiance.x,  s.radiance.y, s.radiance.z};
        for (unsigned a = 0; a < arrays; ++a) cells[a * count + i] = static_cast<float>(values[a]);
    }
    for (unsigned j = 0; j < h.m; ++j) weights.push_back(static_cast<float>(host::ring_rotation_weight(j, h.m)));
    Device& d = device(cpu_traversal ? "cpu" : "gpu");
    const Buffer from = d.upload(cells), table = d.upload(weights);
    Buffer to = d.upload(out);
    d.kernel("sum_cells_test.cl", "test_sum_cells",
             {{"IR_M", std::to_string(h.m)},
              {"IR_N", std::to_string(h.n)},
              {"IR_GROUP", std::to_string(items)},
              {"IR_GRADIENT", "2"},
              {"IR_RADIUS", "2"}})
        .arg(from)
        .arg(table)
        .arg(to)
        .arg(limit)
        .run(1, items);
    d.read(to, out.data(), out.size() * sizeof(float));
    return record_of_sums(h, out, 23);
}

inline Record run_record(const Hemisphere& h, double scale = 1) {
    std::vector<float> weights, out(h.m * 25);
    for (unsigned j = 0; j < h.m; ++j) weights.push_back(static_cast<float>(host::ring_rotation_weight(j, h.m)));
    Device& d = device();
    const Buffer samples = d.upload(flatten(h, scale)), table = d.upload(weights);
    Buffer to = d.upload(out);
    Kernel kernel = d.kernel("formulas_test.cl", "formula_hemisphere", {});
    kernel.arg(samples).arg(table).arg(to).arg(h.m).arg(h.n).run((h.m + 15) / 16, 16);
    d.read(to, out.data(), out.size() * sizeof(float));
    return record_of_sums(h, out, 25);
}

/// Sums of the sizes of a hemisphere's terms: what rounding errors are relative to.
struct Sizes {
    double rotation = 0, ward = 0, gradient = 0, hessian = 0;
};

inline Sizes sizes_of(const Hemisphere& h) {
    Sizes s;
    for (unsigned j = 0; j < h.m; ++j)
        for (unsigned k = 0; k < h.n; ++k) {
            HemisphereSums t = host::hemisphere_sums_zero(), w = t;
            const HemisphereSample &own = h.samples[j * h.n + k], &ring = ring_neighbour(h, j, k);
            cell_edges(&t, j, k, h.m, h.n, own, ring, azimuth_neighbour(h, j, k));
            cell_edges_ward(&w, j, k, h.m, h.n, own, ring, azimuth_neighbour(h, j, k), 0, false);
            s.gradient += std::hypot(t.gx.x, t.gy.x);
            s.hessian += std::hypot(t.hxx, t.hxy, t.hyy);
            s.ward += std::hypot(w.gx.x, w.gy.x);
            s.rotation += kPi / (h.m * h.n) * host::ring_rotation_weight(j, h.m) * own.radiance.x;
        }
    return s;
}

// An edge's g is good to 2e-5 and its H to 7e-5 (theory 5, and device_geometry_test), in the worst case; rotational and
// Ward's terms to the fast sine's and some roundings, 1e-6. A crease decided within rounding changes one edge in a
// thousand by at most its size. E, R: sums of 64 terms a ring, 64 roundings.
inline void expect_record(const Record& found, const Record& want, const Sizes& size, const std::string& name) {
    expect_relative(found.E, want.E, 64 * kEps, name + " E");
    expect_relative(found.harmonic, want.harmonic, 64 * kEps, name + " R_HMD");
    expect_relative(found.minimum, want.minimum, 2 * kEps, name + " R_min");
    EXPECT_LE(distance(found.rotation, want.rotation), 1e-6 * size.rotation) << name;
    EXPECT_LE(distance(found.ward, want.ward), 1e-6 * size.ward) << name;
    EXPECT_LE(distance(found.crease, want.crease), 2e-5 * size.gradient) << name;
    EXPECT_NEAR(found.hxx, want.hxx, 7e-5 * size.hessian) << name;
    EXPECT_NEAR(found.hxy, want.hxy, 7e-5 * size.hessian) << name;
    EXPECT_NEAR(found.hyy, want.hyy, 7e-5 * size.hessian) << name;
}

}  // namespace irradia::test
