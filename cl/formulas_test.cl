// One small kernel a formula, for tests/cl: item i reads its inputs at in + i * <inputs> and writes its results at
// out + i * <outputs>; both counts stand at each kernel. No renderer launches these.
#define IR_SCALAR_LANES 1
#include "filter.h"
#include "ggx.h"
#include "harmonics.h"
#include "hemisphere_reduce.h"
#include "probe.h"
#include "radius.h"
#include "reproject.h"
#include "solid_angle.h"
#include "weight.h"

#define IR_FORMULA(name, inputs, outputs)                                              \
    IR_FN void name##_item(IR_GLOBAL const float* in, IR_GLOBAL float* out);           \
    IR_KERNEL void name(IR_GLOBAL const float* in, IR_GLOBAL float* out, uint count) { \
        const uint i = IR_GLOBAL_ID;                                                   \
        if (i < count) name##_item(in + i * inputs, out + i * outputs);                \
    }                                                                                  \
    IR_FN void name##_item(IR_GLOBAL const float* in, IR_GLOBAL float* out)

IR_FN real3 read3(IR_GLOBAL const float* at) { return make_real3(at[0], at[1], at[2]); }
IR_FN void write3(IR_GLOBAL float* at, real3 v) {
    at[0] = v.x;
    at[1] = v.y;
    at[2] = v.z;
}

// j, k, m, n, xi1, xi2 -> direction
IR_FORMULA(formula_stratum, 6, 3) {
    write3(out, stratum_direction((uint)in[0], (uint)in[1], (uint)in[2], (uint)in[3], in[4], in[5]));
}

// j, m -> the entries of the ring tables
IR_FORMULA(formula_ring, 2, 5) {
    const uint j = (uint)in[0], m = (uint)in[1];
    out[0] = ring_rotation_weight(j, m);
    out[1] = ring_sin(j, m);
    out[2] = ring_cos(j, m);
    out[3] = ring_edge_weight(j, m);
    out[4] = azimuth_edge_weight(j, m);
}

// normal -> t, b
IR_FORMULA(formula_frame, 3, 6) {
    const Frame f = make_frame(read3(in));
    write3(out, f.t);
    write3(out + 3, f.b);
}

// u, v -> triangle, disk, sphere
IR_FORMULA(formula_shapes, 2, 9) {
    write3(out, sample_triangle(in[0], in[1]));
    write3(out + 3, sample_disk(in[0], in[1]));
    write3(out + 6, sample_sphere(in[0], in[1]));
}

// u, width, x -> quantiles at u and distributions at x of the tent (width: its radius) and the gaussian (its deviation)
IR_FORMULA(formula_filter, 3, 4) {
    out[0] = tent_quantile(in[0], in[1]);
    out[1] = tent_distribution(in[2], in[1]);
    out[2] = gaussian_quantile(in[0], in[1]);
    out[3] = gaussian_distribution(in[2], in[1], 4.0f * in[1]);
}

// D, x -> atan2(sqrt D, x)/sqrt D
IR_FORMULA(formula_angle, 2, 1) { out[0] = angle_over_sine(in[0], in[1]); }

// ra, rb, n -> g, symmetrised H (xx, xy, xz, yy, yz, zz)
IR_FORMULA(formula_edge_flux, 9, 9) {
    const EdgeFlux f = edge_flux(read3(in), read3(in + 3), read3(in + 6));
    write3(out, f.g);
    out[3] = f.c.x * f.v.x;
    out[4] = R(0.5) * (f.c.x * f.v.y + f.c.y * f.v.x);
    out[5] = R(0.5) * (f.c.x * f.v.z + f.c.z * f.v.x);
    out[6] = f.c.y * f.v.y;
    out[7] = R(0.5) * (f.c.y * f.v.z + f.c.z * f.v.y);
    out[8] = f.c.z * f.v.z;
}

// d, r, n of A and of B, w0, w1 -> inverse0, inverse1, centre
IR_FORMULA(formula_crease, 20, 3) {
    const CellEdge e = crease_edge(read3(in), in[3], read3(in + 4), read3(in + 7), in[10], read3(in + 11),
                                   read3(in + 14), read3(in + 17));
    out[0] = e.inverse0;
    out[1] = e.inverse1;
    out[2] = e.centre;
}

// p, n, pi, ni, R, a, t2 -> e, weight, Tabellion's, ellipse's, d, in front
IR_FORMULA(formula_weight, 17, 6) {
    const real3 p = read3(in), n = read3(in + 3), pi = read3(in + 6), ni = read3(in + 9);
    const real radius = in[12], a = in[13];
    const real coordinate = max(largest_coordinate(p), largest_coordinate(pi));
    out[0] = ward_error(p, n, pi, ni, radius);
    out[1] = ward_weight(out[0], a);
    out[2] = tabellion_weight(length(p - pi), radius, normal_error(n, ni), R(0.5) / a);
    out[3] = elliptic_weight(elliptic_error(p - pi, read3(in + 14), a * radius, R(2.0) * a * radius),
                             normal_error(n, ni), a);
    out[4] = height_over_record(p, n, pi, ni);
    out[5] = is_in_front(p, n, pi, ni, R(0.05), coordinate) ? R(1.0) : R(0.0);
}

// xx, xy, yy, E, D, tau, area, lo, hi, aspect -> l1, l2, x1, y1, r1, r2
IR_FORMULA(formula_ellipse, 10, 6) {
    const Eigen2 h = eigen_symmetric(in[0], in[1], in[2]);
    const EllipseRadii e = hessian_ellipse(h, in[3], in[4], in[5], in[6], in[7], in[8], in[9]);
    out[0] = h.l1;
    out[1] = h.l2;
    out[2] = h.x1;
    out[3] = h.y1;
    out[4] = e.r1;
    out[5] = e.r2;
}

// R, E, |gradient|, distance -> limited R, scale, clamped R, extrapolated E
IR_FORMULA(formula_limits, 4, 4) {
    out[0] = gradient_limited_radius(in[0], in[1], in[2]);
    out[1] = gradient_scale(in[0], in[1], in[2]);
    out[2] = neighbour_clamped_radius(in[0], in[1], in[3]);
    out[3] = extrapolate(in[1], in[2] * in[3]);
}

// direction -> 36 of SH, 36 of HSH
IR_FORMULA(formula_harmonics, 3, 72) {
    real values[36];
    sh_basis(read3(in), 6, values);
    for (uint i = 0; i < 36; ++i) out[i] = values[i];
    hsh_basis(read3(in), 6, values);
    for (uint i = 0; i < 36; ++i) out[36 + i] = values[i];
}

// wi, wo, alpha -> BRDF
IR_FORMULA(formula_ggx, 7, 1) { out[0] = ggx_brdf(read3(in), read3(in + 3), in[6]); }

// pi - p, w, r, n_s, cos_s, n -> direction, weight, cosine
IR_FORMULA(formula_reproject, 14, 5) {
    const ReprojectedSample s =
        reproject_sample(read3(in), read3(in + 3), in[6], read3(in + 7), in[10], read3(in + 11));
    write3(out, s.direction);
    out[3] = s.weight;
    out[4] = s.cosine;
}

// I, 8 samples -> q
IR_FORMULA(formula_probe, 9, 1) {
    Moments m = moments_zero();
    for (uint i = 1; i < 9; ++i) m = moments_add(m, in[i]);
    out[0] = squared_error_estimate(in[0], m);
}

// p, corner, e1, e2, u, v -> solid angle, offset to the sample
IR_FORMULA(formula_rectangle, 14, 4) {
    const SphericalRectangle q = spherical_rectangle(read3(in), read3(in + 3), read3(in + 6), read3(in + 9));
    out[0] = q.solid_angle;
    write3(out + 1, sample_spherical_rectangle(&q, in[12], in[13]));
}

// p, vertex, e1, e2, u, v -> solid angle, direction of the sample
IR_FORMULA(formula_triangle, 14, 4) {
    const SphericalTriangle t = spherical_triangle(read3(in), read3(in + 3), read3(in + 6), read3(in + 9));
    out[0] = t.solid_angle;
    write3(out + 1, sample_spherical_triangle(&t, in[12], in[13]));
}

// ---- a whole hemisphere --------------------------------------------------------------------------------------------

#define IR_SAMPLE_FLOATS 10  // direction, normal, radiance, distance
#define IR_SUMS_FLOATS 25    // HemisphereSums, and Ward's gx, gy of the first channel

IR_FN HemisphereSample read_sample(IR_GLOBAL const float* samples, uint cell) {
    IR_GLOBAL const float* at = samples + cell * IR_SAMPLE_FLOATS;
    HemisphereSample s;
    s.direction = read3(at);
    s.normal = read3(at + 3);
    s.radiance = read3(at + 6);
    s.distance = at[9];
    return s;
}

// Item j sums ring j of m; the host adds the rings. weights: m rotational weights.
IR_KERNEL void formula_hemisphere(IR_GLOBAL const float* samples, IR_GLOBAL const float* weights, IR_GLOBAL float* out,
                                  uint m, uint n) {
    const uint j = IR_GLOBAL_ID;
    if (j >= m) return;
    HemisphereSums sums = hemisphere_sums_zero(), ward = hemisphere_sums_zero();
    for (uint k = 0; k < n; ++k) {
        const HemisphereSample own = read_sample(samples, j * n + k);
        const HemisphereSample ring = read_sample(samples, (j > 0 ? j - 1 : 0) * n + k);
        const HemisphereSample azimuth = read_sample(samples, j * n + (k > 0 ? k - 1 : n - 1));
        cell_moments(&sums, k, n, weights[j], own, own.radiance, R(1e-10), IR_INFINITY, R(0.0));
        cell_edges(&sums, j, k, m, n, own, ring, azimuth);
        cell_edges_ward(&ward, j, k, m, n, own, ring, azimuth, R(1e-10), false);
    }
    out += j * IR_SUMS_FLOATS;
    write3(out, sums.irradiance);
    write3(out + 3, sums.rx);
    write3(out + 6, sums.ry);
    write3(out + 9, sums.gx);
    write3(out + 12, sums.gy);
    write3(out + 15, sums.gz);
    out[18] = sums.hxx;
    out[19] = sums.hxy;
    out[20] = sums.hyy;
    out[21] = sums.inverse_distance;
    out[22] = sums.min_distance;
    out[23] = ward.gx.x;
    out[24] = ward.gy.x;
}
