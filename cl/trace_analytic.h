// Rays against spheres, disks and cylinders, for both traversals. Both sides are hit.
#ifndef IR_TRACE_ANALYTIC_H
#define IR_TRACE_ANALYTIC_H

// The nearest hit in the open interval (t_min, t_max), or IR_INFINITY.
IR_FN real intersect_sphere(real3 centre, real radius, real3 origin, real3 direction, real t_min, real t_max) {
    // Distances from the point of the ray's line closest to the centre: no cancellation for small or far spheres
    // (Haines, Guenther, Akenine-Moeller, "Precision improvements for ray/sphere intersection", Ray Tracing Gems 7).
    const real3 f = origin - centre;
    const real a = dot(direction, direction);
    const real b = -dot(f, direction);
    const real3 l = f + (b / a) * direction;
    const real under_root = radius * radius - dot(l, l);
    if (under_root < R(0.0)) return IR_INFINITY;
    const real q = b + (b < R(0.0) ? -sqrt(a * under_root) : sqrt(a * under_root));
    const real t0 = (dot(f, f) - radius * radius) / q;  // q = 0 only for a tangent ray from the sphere: NaN, no hit
    const real t1 = q / a;
    const real first = min(t0, t1), second = max(t0, t1);
    if (first > t_min && first < t_max) return first;
    if (second > t_min && second < t_max) return second;
    return IR_INFINITY;
}

IR_FN real intersect_disk(real3 centre, real3 normal, real3 u, real3 v, real3 origin, real3 direction, real t_min,
                          real t_max) {
    const real t = dot(normal, centre - origin) / dot(normal, direction);  // parallel: infinite or NaN, no hit
    if (!(t > t_min && t < t_max)) return IR_INFINITY;
    const real3 p = origin + t * direction - centre;
    const real x = dot(p, u), y = dot(p, v);  // in units of the half axes
    return x * x + y * y <= R(1.0) ? t : IR_INFINITY;
}

// Open at both ends: base + [0, length] axis, axis of unit length. In the plane across the axis it is the sphere's
// problem in two dimensions, solved the same way. Along the axis (a = 0): NaN, no hit.
IR_FN real intersect_cylinder(real3 base, real3 axis, real radius, real length_of_axis, real3 origin, real3 direction,
                              real t_min, real t_max) {
    const real3 from_base = origin - base;
    const real height = dot(from_base, axis), climb = dot(direction, axis);
    const real3 f = from_base - height * axis, d = direction - climb * axis;
    const real a = dot(d, d);
    const real b = -dot(f, d);
    const real3 l = f + (b / a) * d;
    const real under_root = radius * radius - dot(l, l);
    if (under_root < R(0.0)) return IR_INFINITY;
    const real q = b + (b < R(0.0) ? -sqrt(a * under_root) : sqrt(a * under_root));
    const real t0 = (dot(f, f) - radius * radius) / q;
    const real t1 = q / a;
    const real first = min(t0, t1), second = max(t0, t1);
    const real z = height + first * climb;
    if (first > t_min && first < t_max && z >= R(0.0) && z <= length_of_axis) return first;
    const real w = height + second * climb;
    if (second > t_min && second < t_max && w >= R(0.0) && w <= length_of_axis) return second;
    return IR_INFINITY;
}

IR_FN real intersect_analytic(IR_GLOBAL const Analytic* a, real3 origin, real3 direction, real t_min, real t_max) {
    const real3 centre = make_real3(a->px, a->py, a->pz);
    if (a->kind == IR_ANALYTIC_SPHERE) return intersect_sphere(centre, a->radius, origin, direction, t_min, t_max);
    if (a->kind == IR_ANALYTIC_CYLINDER)
        return intersect_cylinder(centre, make_real3(a->nx, a->ny, a->nz), a->radius, a->length, origin, direction,
                                  t_min, t_max);
    return intersect_disk(centre, make_real3(a->nx, a->ny, a->nz), make_real3(a->ux, a->uy, a->uz),
                          make_real3(a->vx, a->vy, a->vz), origin, direction, t_min, t_max);
}
#endif
