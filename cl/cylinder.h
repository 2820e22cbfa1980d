// From a hit of a cylinder to its surface.
#ifndef IR_CYLINDER_H
#define IR_CYLINDER_H
#include "scene.h"

// Of a point on the ray that hit `q`: the point moved onto the cylinder (t alone is good to some ulp of the distance
// only), the unit geometric normal, and (u, v): the angle about the axis from the frame's x axis, in turns of [0, 1),
// and the height in lengths, as Mitsuba's.
IR_FN void cylinder_surface(const Analytic* q, real3* p, real3* normal, float* u, float* v) {
    const real3 base = make_real3(q->px, q->py, q->pz), axis = make_real3(q->nx, q->ny, q->nz);
    const real3 from_base = *p - base;
    const float height = dot(from_base, axis);
    const real3 out = normalize(from_base - height * axis);
    *p = base + height * axis + q->radius * out;
    *normal = out * q->sign;
    const float turns =
        atan2(dot(out, make_real3(q->vx, q->vy, q->vz)), dot(out, make_real3(q->ux, q->uy, q->uz))) *
        (0.5f * IR_INV_PI);
    *u = turns < 0.0f ? turns + 1.0f : turns;
    *v = height / q->length;
}
#endif
