// The crease rule (theory 3.3): where, in distance, the radiance step between two neighbouring samples of a hemisphere
// lies. Seen from a point, the inverse distance of a plane is linear in direction: 1/d(w) = w.q, q = n/(r d.n), for a
// hit at distance r along d with geometric normal n (either orientation).
#ifndef IR_CREASE_H
#define IR_CREASE_H
#include "lanes.h"

#define is_miss(distance) ((distance) >= R(1e29))  // of a number or of lanes

// Inverse distances of the edge between two cells: at its two corners and at the crossing of A-B. centre == 0: both
// samples missed, there is no edge.
typedef struct CellEdge {
    lanes inverse0, inverse1, centre;
} CellEdge;

// `inverse` where it is within a factor of two of the inverse distance at the edge's centre, else that.
IR_FN lanes crease_plausible(lanes inverse, lanes centre) {
    return lanes_select(centre, inverse, inverse >= R(0.5) * centre && inverse <= R(2.0) * centre);
}

// Corner w where the planes qa, qb of A and B meet or agree; q_a, q_b: their change from A to B.
IR_FN lanes crease_corner(LaneVector w, LaneVector qa, LaneVector qb, lanes q_a, lanes q_b, lanes centre) {
    const lanes ia = lanes_dot(w, qa), ib = lanes_dot(w, qb);
    const lanes f = ia - ib, ft = q_a - q_b;
    const lanes_mask crossing = fabs(f) <= fabs(ft) && fabs(ft) > R(0.0);
    const lanes met = ia - f / lanes_select(R(1.0), ft, crossing) * q_a;
    const lanes apart = lanes_select(centre, met, crossing);
    return crease_plausible(lanes_select(apart, R(0.5) * (ia + ib), fabs(f) <= R(0.02) * max(ia, ib)), centre);
}

// The edge between neighbouring samples A and B: unit directions d, distances r (IR_INFINITY: a miss), unit normals n
// of the hits, and the unit directions w0, w1 of the corners that their cells share.
IR_FN CellEdge crease_edge(LaneVector da, lanes ra, LaneVector na, LaneVector db, lanes rb, LaneVector nb, LaneVector w0,
                           LaneVector w1) {
    const lanes_mask miss_a = is_miss(ra), miss_b = is_miss(rb);
    const lanes cos_a = lanes_dot(da, na), cos_b = lanes_dot(db, nb);
    // Seen edge-on: no plane to speak of.
    const lanes_mask flat_a = fabs(cos_a) < R(1e-6), flat_b = fabs(cos_b) < R(1e-6);
    const LaneVector qa = lanes_scaled(na, R(1.0) / (ra * lanes_select(cos_a, R(1.0), flat_a)));
    const LaneVector qb = lanes_scaled(nb, R(1.0) / (rb * lanes_select(cos_b, R(1.0), flat_b)));
    const lanes a0 = R(1.0) / ra, b1 = R(1.0) / rb;

    const lanes a1 = lanes_dot(db, qa), b0 = lanes_dot(da, qb);
    const lanes f0 = a0 - b0, f1 = a1 - b1, m = max(a0, b1);
    const lanes_mask one_plane = fabs(f0) <= R(0.02) * m && fabs(f1) <= R(0.02) * m;
    // The planes meet between A and B; otherwise it is an occlusion.
    const lanes_mask meet = min(f0, f1) <= R(0.0) && max(f0, f1) >= R(0.0) && f0 != f1;
    const lanes met = a0 + f0 / lanes_select(R(1.0), f0 - f1, meet) * (a1 - a0);
    const lanes joint = lanes_select(lanes_select(R(0.0), met, meet), R(0.5) * (a0 + b1), one_plane);
    // Opposite walls meet at infinity, where rounding would decide whether they do.
    const lanes_mask joined = !(miss_a || miss_b || flat_a || flat_b) && joint > R(1e-5) * m;

    // Else the nearer surface occludes the farther one (or the void): the edge lies on it.
    const lanes_mask near_a = miss_b || (!miss_a && ra < rb);
    const lanes_mask flat = (near_a && flat_a) || (!near_a && flat_b);
    const lanes centre = lanes_select(b1, a0, near_a);
    const LaneVector q = lanes_select3(qb, qa, near_a);
    const lanes on0 = clamp(lanes_dot(w0, q), R(0.5) * centre, R(2.0) * centre);
    const lanes on1 = clamp(lanes_dot(w1, q), R(0.5) * centre, R(2.0) * centre);

    const lanes_mask none = miss_a && miss_b;
    CellEdge edge;
    edge.centre = lanes_select(lanes_select(centre, joint, joined), R(0.0), none);
    edge.inverse0 = lanes_select(lanes_select(lanes_select(on0, centre, flat),
                                              crease_corner(w0, qa, qb, a1 - a0, b1 - b0, joint), joined),
                                 R(0.0), none);
    edge.inverse1 = lanes_select(lanes_select(lanes_select(on1, centre, flat),
                                              crease_corner(w1, qa, qb, a1 - a0, b1 - b0, joint), joined),
                                 R(0.0), none);
    return edge;
}
#endif
