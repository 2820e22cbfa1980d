// From the sums over a hemisphere to a record: irradiance, gradients in world space, and how far it reaches.
#ifndef IR_MAKE_RECORD_H
#define IR_MAKE_RECORD_H
#include "group.h"
#include "hemisphere_reduce.h"
#include "irradia/shared/record_types.h"
#include "radius.h"

// ---- HemisphereSums in a group's memory, one array a member, lanes added up --------------------------------------
#define IR_SUM_FLOATS 23
IR_FN void put3(float* totals, LaneVector v) {
    totals[0] = lanes_sum(v.x);
    totals[1] = lanes_sum(v.y);
    totals[2] = lanes_sum(v.z);
}

IR_ONCE_FN void lane_totals(const HemisphereSums* s, float* totals) {
    put3(totals, s->irradiance);
    put3(totals + 3, s->rx);
    put3(totals + 6, s->ry);
    put3(totals + 9, s->gx);
    put3(totals + 12, s->gy);
    put3(totals + 15, s->gz);
    totals[18] = lanes_sum(s->hxx);
    totals[19] = lanes_sum(s->hxy);
    totals[20] = lanes_sum(s->hyy);
    totals[21] = lanes_sum(s->inverse_distance);
    totals[22] = lanes_min(s->min_distance);
}

IR_INLINE_FN void store_sums(IR_GROUP_SPACE float* store, uint item, const float* totals) {
    for (uint i = 0; i < IR_SUM_FLOATS; ++i) store[i * IR_GROUP + item] = totals[i];
}

IR_INLINE_FN void add_sums(IR_GROUP_SPACE float* store, uint to, uint from) {
    for (uint i = 0; i < 22u; ++i) store[i * IR_GROUP + to] += store[i * IR_GROUP + from];
    store[22 * IR_GROUP + to] = min(store[22 * IR_GROUP + to], store[22 * IR_GROUP + from]);
}

// The members of HemisphereSums, complete.
typedef struct HemisphereTotals {
    real3 irradiance, rx, ry, gx, gy, gz;
    float hxx, hxy, hyy, inverse_distance, min_distance;
} HemisphereTotals;

#define IR_LOAD3(store, first) \
    make_real3(store[(first)*IR_GROUP], store[((first) + 1) * IR_GROUP], store[((first) + 2) * IR_GROUP])

IR_INLINE_FN HemisphereTotals load_totals(const IR_GROUP_SPACE float* store) {
    HemisphereTotals s;
    s.irradiance = IR_LOAD3(store, 0);
    s.rx = IR_LOAD3(store, 3);
    s.ry = IR_LOAD3(store, 6);
    s.gx = IR_LOAD3(store, 9);
    s.gy = IR_LOAD3(store, 12);
    s.gz = IR_LOAD3(store, 15);
    s.hxx = store[18 * IR_GROUP];
    s.hxy = store[19 * IR_GROUP];
    s.hyy = store[20 * IR_GROUP];
    s.inverse_distance = store[21 * IR_GROUP];
    s.min_distance = store[22 * IR_GROUP];
    return s;
}

// Length of a gradient of irradiance, as small or large as radiance may be: squares of its components need not exist.
IR_FN float gradient_length(real3 g) {
    const float most = max(max(fabs(g.x), fabs(g.y)), fabs(g.z));
    return most > 1e-37f && most < 1e37f ? most * length(g * (1.0f / most)) : most;
}

// ---- the record --------------------------------------------------------------------------------------------------

// One channel of the value: e, and its gradients as world vectors; the translational one scaled so that extrapolation
// to the support's rim stays positive (theory 4.4, last step).
IR_FN void make_channel(IR_GLOBAL RecordValue* v, uint channel, float e, real3 rotation, real3 translation,
                        float support) {
#if IR_GRADIENT == 0
    rotation = translation = make_real3(0.0f, 0.0f, 0.0f);
#endif
    translation = translation * gradient_scale(support, e, gradient_length(translation));
    v->e[channel] = e;
    v->rotation[3u * channel] = rotation.x;
    v->rotation[3u * channel + 1u] = rotation.y;
    v->rotation[3u * channel + 2u] = rotation.z;
    v->translation[3u * channel] = translation.x;
    v->translation[3u * channel + 1u] = translation.y;
    v->translation[3u * channel + 2u] = translation.z;
}

IR_ONCE_FN void make_record(const ShadingPoint* q, uint coat, const HemisphereTotals* sums, RecordParameters parameters,
                            IR_GLOBAL RecordKey* key, IR_GLOBAL RecordValue* value) {
    const Frame frame = make_frame(make_real3(q->nx, q->ny, q->nz));
    const float scale = IR_PI / (float)(IR_M * IR_N);
    const real3 e = sums->irradiance * scale;
    const real3 grad_r = to_world(frame, make_real3(sums->rx.x, sums->ry.x, 0.0f) * scale);
    const real3 grad_g = to_world(frame, make_real3(sums->rx.y, sums->ry.y, 0.0f) * scale);
    const real3 grad_b = to_world(frame, make_real3(sums->rx.z, sums->ry.z, 0.0f) * scale);
    const real3 move_r = to_world(frame, make_real3(sums->gx.x, sums->gy.x, sums->gz.x));
    const real3 move_g = to_world(frame, make_real3(sums->gx.y, sums->gy.y, sums->gz.y));
    const real3 move_b = to_world(frame, make_real3(sums->gx.z, sums->gy.z, sums->gz.z));
    const float harmonic = harmonic_mean_distance(IR_M * IR_N, sums->inverse_distance);
    const float lo = parameters.min_spacing * q->footprint, hi = parameters.max_spacing * q->footprint;
    const float y = luminance(e);

    float support1, support2;
    real3 t2 = frame.b;
#if IR_RADIUS == 2
    if (is_black(y, 1e-15f)) {
        support1 = support2 = min(parameters.accuracy * harmonic, hi);
    } else {
        const Eigen2 h = eigen_symmetric(sums->hxx, sums->hxy, sums->hyy);
        const EllipseRadii r = hessian_ellipse(h, y, parameters.diagonal, parameters.tau, q->footprint * q->footprint,
                                               0.0f, 0.25f * parameters.diagonal, parameters.aspect);
        support1 = r.r1;
        support2 = r.r2;
        t2 = frame.b * h.x1 - frame.t * h.y1;
    }
    const float gradient_reach = 1.0f;  // the ellipse is the support itself
#else
#if IR_RADIUS == 1
    const float radius = min(sums->min_distance, parameters.r_max);
#else
    const float radius = harmonic;
#endif
    support1 = support2 = parameters.accuracy * radius;
    const float gradient_reach = parameters.accuracy;
#endif
#if IR_GRADIENT_LIMIT
    float limit = gradient_limited_radius(support2 / gradient_reach, e.x, gradient_length(move_r));
    limit = gradient_limited_radius(limit, e.y, gradient_length(move_g));
    limit = gradient_limited_radius(limit, e.z, gradient_length(move_b)) * gradient_reach;
    support2 = min(support2, limit);
    support1 = min(support1, support2);
#endif
    EllipseRadii support = clamp_ellipse(support1, support2, lo, hi, parameters.aspect);
    support.r1 *= parameters.overlap;
    support.r2 *= parameters.overlap;
    const float least = q->least > 0.0f ? q->least : parameters.overlap * lo;
    if (q->largest > 0.0f) {
        const float largest = max(q->largest, least);
        support.r1 = min(support.r1, largest);
        support.r2 = min(support.r2, largest);
    }
    // Not past the nearest surface seen (grazing rays left out): what lies behind it may be another room.
    if (parameters.reach > 0.0f) {
        const float nearest = max(parameters.reach * sums->min_distance, least);
        support.r1 = min(support.r1, nearest);
        support.r2 = min(support.r2, nearest);
    }

    key->px = q->px;
    key->py = q->py;
    key->pz = q->pz;
    key->nx = q->nx;
    key->ny = q->ny;
    key->nz = q->nz;
    key->support1 = support.r1;
    key->support2 = support.r2;
    key->t2x = t2.x;
    key->t2y = t2.y;
    key->t2z = t2.z;
    key->coat = coat;
    make_channel(value, 0u, e.x, grad_r, move_r, support.r2);
    make_channel(value, 1u, e.y, grad_g, move_g, support.r2);
    make_channel(value, 2u, e.z, grad_b, move_b, support.r2);
    value->minimum = sums->min_distance;
    value->pixel = q->pixel;
    value->harmonic = harmonic;
}
#endif
