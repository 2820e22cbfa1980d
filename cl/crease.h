// The crease rule (theory 3.3): where, in distance, the radiance step between two neighbouring samples of a hemisphere
// lies. Seen from a point, the inverse distance of a plane is linear in direction: 1/d(w) = w.q, q = n/(r d.n), for a
// hit at distance r along d with geometric normal n (either orientation).
#ifndef IR_CREASE_H
#define IR_CREASE_H
#include "portable.h"

IR_FN bool is_miss(real distance) { return distance >= R(1e29); }

// Inverse distances of the edge between two cells: at its two corners and at the crossing of A-B. centre == 0: both
// samples missed, there is no edge.
typedef struct CellEdge {
    real inverse0, inverse1, centre;
} CellEdge;

// Corner w where the planes qa, qb of A and B meet or agree; q_a, q_b: their change from A to B.
IR_FN real crease_corner(real3 w, real3 qa, real3 qb, real q_a, real q_b, real centre) {
    const real ia = dot(w, qa), ib = dot(w, qb);
    const real f = ia - ib, ft = q_a - q_b;
    real i = centre;
    if (fabs(f) <= R(0.02) * max(ia, ib))
        i = R(0.5) * (ia + ib);
    else if (fabs(f) <= fabs(ft))
        i = ia - f / ft * q_a;
    return i >= R(0.5) * centre && i <= R(2.0) * centre ? i : centre;
}

// The edge between neighbouring samples A and B: unit directions d, distances r (IR_INFINITY: a miss), unit normals n
// of the hits, and the unit directions w0, w1 of the corners that their cells share.
IR_FN CellEdge crease_edge(real3 da, real ra, real3 na, real3 db, real rb, real3 nb, real3 w0, real3 w1) {
    CellEdge edge;
    edge.inverse0 = edge.inverse1 = edge.centre = R(0.0);
    const bool miss_a = is_miss(ra), miss_b = is_miss(rb);
    if (miss_a && miss_b) return edge;

    const real cos_a = dot(da, na), cos_b = dot(db, nb);
    const bool flat_a = fabs(cos_a) < R(1e-6), flat_b = fabs(cos_b) < R(1e-6);  // seen edge-on: no plane to speak of
    const real3 qa = na * (R(1.0) / (ra * (flat_a ? R(1.0) : cos_a)));
    const real3 qb = nb * (R(1.0) / (rb * (flat_b ? R(1.0) : cos_b)));
    const real a0 = R(1.0) / ra, b1 = R(1.0) / rb;

    if (!(miss_a || miss_b || flat_a || flat_b)) {
        const real a1 = dot(db, qa), b0 = dot(da, qb);
        const real f0 = a0 - b0, f1 = a1 - b1, m = max(a0, b1);
        real centre = R(0.0);  // stays 0: an occlusion
        if (fabs(f0) <= R(0.02) * m && fabs(f1) <= R(0.02) * m)
            centre = R(0.5) * (a0 + b1);  // one plane
        else if (min(f0, f1) <= R(0.0) && max(f0, f1) >= R(0.0))
            centre = a0 + f0 / (f0 - f1) * (a1 - a0);  // the planes meet between A and B
        if (centre > R(0.0)) {
            edge.centre = centre;
            edge.inverse0 = crease_corner(w0, qa, qb, a1 - a0, b1 - b0, centre);
            edge.inverse1 = crease_corner(w1, qa, qb, a1 - a0, b1 - b0, centre);
            return edge;
        }
    }
    // The nearer surface occludes the farther one (or the void): the edge lies on it.
    const bool near_a = miss_b || (!miss_a && ra < rb);
    const bool flat = near_a ? flat_a : flat_b;
    const real centre = near_a ? a0 : b1;
    const real3 q = near_a ? qa : qb;
    edge.centre = centre;
    edge.inverse0 = flat ? centre : clamp(dot(w0, q), R(0.5) * centre, R(2.0) * centre);
    edge.inverse1 = flat ? centre : clamp(dot(w1, q), R(0.5) * centre, R(2.0) * centre);
    return edge;
}
#endif
