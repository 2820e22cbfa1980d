// Samples of one light for several receivers at once, on CPU devices: included by direct.h. The results are those of
// sample_light() but for rounding (tests ask both). One by one those of a rectangle were two fifths of shading under a large
// lamp.
#ifndef IR_LIGHT_CPU_H
#define IR_LIGHT_CPU_H
#include "arctangent.h"
#include "path.h"

typedef struct RectangleLight {
    real3 corner, x, y, z;   // x, y: unit, along its edges; z = x cross y
    float length1, length2;  // of its edges
    float reach2;            // squared distance from its centre within which it is near (is_near_light)
    float side;              // 1 or -1: of z that it emits to
    float probability, area;
    real3 radiance;
} RectangleLight;

IR_FN RectangleLight rectangle_light(const IR_GLOBAL Light* l) {
    RectangleLight r;
    const real3 e1 = make_real3(l->e1x, l->e1y, l->e1z), e2 = make_real3(l->e2x, l->e2y, l->e2z);
    r.corner = make_real3(l->px, l->py, l->pz);
    r.length1 = length(e1);
    r.length2 = length(e2);
    r.x = e1 * (1.0f / r.length1);
    r.y = e2 * (1.0f / r.length2);
    r.z = cross(r.x, r.y);
    r.reach2 = 2.0f * (dot(e1, e1) + dot(e2, e2));
    r.side = dot(r.z, make_real3(l->nx, l->ny, l->nz)) > 0.0f ? 1.0f : -1.0f;
    r.probability = l->probability;
    r.area = l->area;
    r.radiance = make_real3(l->r, l->g, l->b);
    return r;
}

// arctangent() of solid_angle.h.
IR_FN lanes lanes_arctangent(lanes t) {
    const lanes_mask large = fabs(t) > 1.0f;
    const lanes x = lanes_select(t, 1.0f / t, large), angle = x * lanes_arctangent_ratio(x * x);
    return lanes_select(angle, lanes_select(-0.5f * IR_PI, 0.5f * IR_PI, t > 0.0f) - angle, large);
}

// The rectangle seen from eight points, in the frame of its edges (SphericalRectangle); z of any sign.
typedef struct RectangleView {
    lanes x0, x1, y0, y1, z;
} RectangleView;

IR_FN lanes corner_angle_lanes(lanes x, lanes y, lanes inverse_z, lanes inverse_distance) {
    return lanes_arctangent(x * y * inverse_z * inverse_distance);
}

// sample_spherical_rectangle(): where on the rectangle, in that frame, and the solid angle.
IR_FN lanes sample_view(const RectangleView* w, lanes u, lanes v, lanes* sx, lanes* sy) {
    const lanes z2 = w->z * w->z, depth = fabs(w->z), inverse_z = 1.0f / max(depth, 1e-30f);
    const lanes xx0 = w->x0 * w->x0, xx1 = w->x1 * w->x1, yy0 = w->y0 * w->y0 + z2, yy1 = w->y1 * w->y1 + z2;
    const lanes d00 = sqrt(xx0 + yy0), d01 = sqrt(xx0 + yy1);  // of the corners (x0, y0) and (x0, y1)
    const lanes solid_angle = corner_angle_lanes(w->x1, w->y1, inverse_z, rsqrt(xx1 + yy1)) -
                              corner_angle_lanes(w->x0, w->y1, inverse_z, 1.0f / d01) -
                              corner_angle_lanes(w->x1, w->y0, inverse_z, rsqrt(xx1 + yy0)) +
                              corner_angle_lanes(w->x0, w->y0, inverse_z, 1.0f / d00);
    const lanes r0 = rsqrt(yy0), r2 = rsqrt(yy1), r3 = rsqrt(xx0 + z2);
    const lanes n0 = -w->y0 * r0, n2 = w->y1 * r2, n3 = -w->x0 * r3;
    const lanes c2 = -n2 * n3, s2 = depth * d01 * r2 * r3, c3 = -n3 * n0, s3 = depth * d00 * r3 * r0;
    const lanes sin_k = -(s2 * c3 + c2 * s3), cos_k = c2 * c3 - s2 * s3;
    lanes sin_u, cos_u;
    lanes_sincos_turns(u * solid_angle * 0.15915494309189533577f, &sin_u, &cos_u);
    const lanes sine = sin_u * cos_k + cos_u * sin_k, cos_a = cos_u * cos_k - sin_u * sin_k;
    const lanes sin_a = lanes_select(sine, lanes_select(1e-7f, -1e-7f, sine < 0.0f), fabs(sine) < 1e-7f);
    const lanes f = (cos_a * n0 - n2) / sin_a;
    const lanes across = depth * rsqrt(max(f * f + n0 * n0 - 1.0f, 1e-20f));
    const lanes x = clamp(lanes_select(-across, across, f > 0.0f), w->x0, w->x1), d2 = x * x + z2;
    const lanes h0 = w->y0 * rsqrt(d2 + w->y0 * w->y0), h1 = w->y1 * rsqrt(d2 + w->y1 * w->y1);
    const lanes h = h0 + v * (h1 - h0);
    *sx = x;
    *sy = clamp(h * sqrt(d2) * rsqrt(max(1.0f - h * h, 1e-12f)), w->y0, w->y1);
    return solid_angle;
}

// As sample_light() samples it for the points (x, y, z) by random numbers u, v, eight each; the first `count` of l.
IR_FN void sample_rectangle(const RectangleLight* r, const float* x, const float* y, const float* z, const float* u,
                            const float* v, uint count, LightSample* l) {
    const lanes px = lanes_load(x, 0), py = lanes_load(y, 0), pz = lanes_load(z, 0), a = lanes_load(u, 0),
                b = lanes_load(v, 0);
    const LaneVector d = make_lane_vector(r->corner.x - px, r->corner.y - py, r->corner.z - pz);
    RectangleView w;
    w.z = lanes_dot3(d, r->z);
    w.x0 = lanes_dot3(d, r->x);
    w.y0 = lanes_dot3(d, r->y);
    w.x1 = w.x0 + r->length1;
    w.y1 = w.y0 + r->length2;
    const lanes rounding = 1e-5f * (fabs(px) + fabs(py) + fabs(pz) + fabs(d.x) + fabs(d.y) + fabs(d.z));
    const lanes middle_x = 0.5f * (w.x0 + w.x1), middle_y = 0.5f * (w.y0 + w.y1), front = -r->side * w.z;
    lanes_mask near = (middle_x * middle_x + middle_y * middle_y + w.z * w.z < r->reach2) & (front > rounding);
    lanes sx = w.x0 + a * r->length1, sy = w.y0 + b * r->length2, solid_angle = 1.0f;
    if (any(near)) {
        lanes near_x, near_y;
        solid_angle = sample_view(&w, a, b, &near_x, &near_y);
        near &= solid_angle >= IR_LEAST_SOLID_ANGLE;
        sx = lanes_select(sx, near_x, near);
        sy = lanes_select(sy, near_y, near);
    }
    const lanes square = sx * sx + sy * sy + w.z * w.z, distance = sqrt(square), inverse = 1.0f / max(distance, 1e-30f);
    const lanes cosine = front * inverse;
    const lanes density =
        r->probability * lanes_select(square / max(cosine * r->area, 1e-30f), 1.0f / solid_angle, near);
    const lanes_mask valid = (cosine > 0.0f) & (square > 0.0f);
    const LaneVector direction = make_lane_vector((r->x.x * sx + r->y.x * sy + r->z.x * w.z) * inverse,
                                                  (r->x.y * sx + r->y.y * sy + r->z.y * w.z) * inverse,
                                                  (r->x.z * sx + r->y.z * sy + r->z.z * w.z) * inverse);
    const lanes scale = 1.0f / density;
    float out[8][IR_LANES];
    vstore8(direction.x, 0, out[0]);
    vstore8(direction.y, 0, out[1]);
    vstore8(direction.z, 0, out[2]);
    vstore8(distance, 0, out[3]);
    vstore8(scale, 0, out[4]);
    vstore8(density, 0, out[5]);
    vstore8(cosine, 0, out[6]);
    vstore8(lanes_select(0.0f, 1.0f, valid), 0, out[7]);
    for (uint i = 0; i < count; ++i) {
        l[i].direction = make_real3(out[0][i], out[1][i], out[2][i]);
        l[i].distance = out[3][i];
        l[i].radiance = r->radiance * out[4][i];
        l[i].density = out[5][i];
        l[i].cosine = out[6][i];
        l[i].valid = out[7][i] > 0.0f;
    }
}
#if IR_FEATURES & IR_FEATURE_ENVMAP
// Cells for `count` samples by random numbers u, v and tiles, as sample_picture() finds them. Large pictures lie in memory,
// and each step of a search waits for it: all searches go on together, and the texels are sent for.
IR_FN void find_picture_cells(const SceneData* s, const Light* map, const Texture* picture, uint count, const uint* tiles,
                              const float* u, const float* v, PicturePoint* at) {
    uint first[IR_TILE], end[IR_TILE];
    for (uint i = 0; i < count; ++i) {
        const PictureRow r = sample_picture_row(s, map, picture, tiles[i], u[i], v[i]);
        at[i] = r.at;
        at[i].column = r.begin;
        end[i] = r.end - 1u;
        first[i] = picture_cells(map, picture, r.at.row);
    }
    for (uint left = picture->width - 1u; left > 0u; left >>= 1)  // at least half of what is left of each goes
        for (uint i = 0; i < count; ++i) {
            if (at[i].column >= end[i]) continue;
            const uint middle = (at[i].column + end[i]) >> 1;
            const bool before = sky_word(s, first[i] + middle) > at[i].x;
            at[i].column = before ? at[i].column : middle + 1u;
            end[i] = before ? middle : end[i];
        }
    for (uint i = 0; i < count; ++i) {
        at[i].x = share_of_sum(s, first[i], at[i].column, at[i].x);
        for (uint k = 0; k < 2u; ++k)
            IR_PREFETCH(s->texels + picture->offset + 3u * ((at[i].row + k) * picture->width + at[i].column));
    }
}

// As sample_light() samples a picture, which is the one light, for the surfaces of paths[i].
IR_FN void sample_picture_tile(const SceneData* s, const Light* map, const PathState* paths, uint count, const float* u,
                               const float* v, LightSample* samples) {
    const Texture picture = s->textures[map->texture];
    PicturePoint at[IR_TILE];
    uint tiles[IR_TILE];
    for (uint i = 0; i < count; ++i) tiles[i] = sky_tiles(s, map, paths[i].surface.p, paths[i].surface.ns);
    find_picture_cells(s, map, &picture, count, tiles, u, v, at);
    for (uint i = 0; i < count; ++i) {
        real3 radiance;
        samples[i] = no_light(paths[i].surface.ns);
        samples[i].direction =
            sample_picture_cell(s, map, &picture, tiles[i], at[i], &samples[i].density, &radiance);
        picture_sample_light(map, radiance, &samples[i]);
    }
}
#endif
#endif
