// What surrounds the scene: a constant radiance or a picture of it, and samples of the picture by its flux.
//
// The picture is latitude-longitude after Mitsuba: a direction (x, y, z) in the map's own axes (Light.e1, e2, n) lies at
// u = atan2(x, -z) / 2 pi, v = acos(y) / pi. Columns of texels lie at (i + 1/2) / width and repeat; rows lie at
// i / (height - 1), so the first and the last one are the poles. Radiance is bilinear between four texels: a cell.
// There are `width` cells in a row, cell i between the columns i and i + 1, and `rows` = height - 1 rows of them.
//
// Cells are chosen in proportion to their flux (the integral of the bilinear luminance over solid angle), and a
// direction within one uniformly in solid angle. Tables, floats at Light.table of the texel array (made by
// src/scene/environment.cpp):
//   rows           inclusive running sum of the rows' probabilities; the last is 1
//   rows + 1       1 - |cos| of the polar angle of every row of texels: near the poles that is what float32 can hold
//   rows           1 / solid angle of one of the row's cells, sr⁻¹
//   rows * width   for each row the inclusive running sum of its cells' probabilities; the last is 1
// Sums are multiples of 2^-24: their differences, the probabilities, are exact.
#ifndef IR_ENVIRONMENT_H
#define IR_ENVIRONMENT_H
#include "scene.h"
#include "solid_angle.h"

// The angle of the point (x, y) from the x axis, in turns: [0, 1].
IR_FN float turns_of(float x, float y) {
    const float a = fabs(x), b = fabs(y), larger = max(a, b);
    if (!(larger > 0.0f)) return 0.0f;
    const float t = min(a, b) / larger;
    float turns = t * arctangent_ratio(t * t) * (0.5f * IR_INV_PI);
    if (b > a) turns = 0.25f - turns;
    if (x < 0.0f) turns = 0.5f - turns;
    return y < 0.0f ? 1.0f - turns : turns;
}

#if IR_FEATURES & IR_FEATURE_ENVMAP
// A point of the picture: between columns `column` and the next one, rows `row` and row + 1.
typedef struct PicturePoint {
    uint column, row;
    float x, y;  // where in the cell, [0, 1]
} PicturePoint;

IR_FN PicturePoint picture_point(const Light* map, const Texture* picture, real3 direction) {
    const float x = dot(direction, make_real3(map->e1x, map->e1y, map->e1z));
    const float y = dot(direction, make_real3(map->e2x, map->e2y, map->e2z));
    const float z = dot(direction, make_real3(map->nx, map->ny, map->nz));
    const uint rows = picture->height - 1u;
    PicturePoint at;
    float across = turns_of(-z, x) * (float)picture->width - 0.5f;
    if (across < 0.0f) across += (float)picture->width;
    at.column = min((uint)across, picture->width - 1u);
    at.x = min(across - (float)at.column, 1.0f);
    // the polar angle by its sine: acos(y) would lose half the digits next to the poles
    const float down = turns_of(y, sqrt(x * x + z * z)) * 2.0f * (float)rows;
    at.row = min((uint)down, rows - 1u);
    at.y = min(down - (float)at.row, 1.0f);
    return at;
}

IR_FN real3 picture_texel(const SceneData* s, const Texture* picture, uint column, uint row) {
    const IR_GLOBAL uint* c = s->texels + picture->offset + 3u * (row * picture->width + column);
    return make_real3(IR_AS_FLOAT(c[0]), IR_AS_FLOAT(c[1]), IR_AS_FLOAT(c[2]));
}

IR_FN real3 picture_radiance(const SceneData* s, const Texture* picture, PicturePoint at) {
    const uint next = at.column + 1u == picture->width ? 0u : at.column + 1u;
    const real3 above = picture_texel(s, picture, at.column, at.row) * (1.0f - at.x) +
                        picture_texel(s, picture, next, at.row) * at.x;
    const real3 below = picture_texel(s, picture, at.column, at.row + 1u) * (1.0f - at.x) +
                        picture_texel(s, picture, next, at.row + 1u) * at.x;
    return above * (1.0f - at.y) + below * at.y;
}

// The running sums of a row's cells, in the array of texels.
IR_FN uint picture_cells(const Light* map, const Texture* picture, uint row) {
    return map->table + 3u * (picture->height - 1u) + 1u + row * picture->width;
}

// Density of a cell among all directions, without the choice of the light. sr⁻¹.
IR_FN float picture_cell_density(const SceneData* s, const Light* map, const Texture* picture, uint column, uint row) {
    const uint rows = picture->height - 1u;
    const IR_GLOBAL uint* of_rows = s->texels + map->table;
    const IR_GLOBAL uint* of_cells = s->texels + picture_cells(map, picture, row);
    const float row_before = row > 0u ? IR_AS_FLOAT(of_rows[row - 1u]) : 0.0f;
    const float cell_before = column > 0u ? IR_AS_FLOAT(of_cells[column - 1u]) : 0.0f;
    return (IR_AS_FLOAT(of_rows[row]) - row_before) * (IR_AS_FLOAT(of_cells[column]) - cell_before) *
           IR_AS_FLOAT(of_rows[2u * rows + 1u + row]);
}

// Where u lies between the running sum before the i-th at `first` and that one: [0, 1).
IR_FN float share_of_sum(const SceneData* s, uint first, uint i, float u) {
    const float before = i > 0u ? IR_AS_FLOAT(s->texels[first + i - 1u]) : 0.0f;
    return min(max((u - before) / (IR_AS_FLOAT(s->texels[first + i]) - before), 0.0f), 0.99999994f);
}

// The first of `count` running sums at `first` that exceeds u in [0, 1); u is rescaled to where it lies within.
IR_FN uint search_sums(const SceneData* s, uint first, uint count, float* u) {
    uint lo = 0u, hi = count - 1u;
    while (lo < hi) {
        const uint mid = (lo + hi) >> 1;
        if (IR_AS_FLOAT(s->texels[first + mid]) > *u)
            hi = mid;
        else
            lo = mid + 1u;
    }
    *u = share_of_sum(s, first, lo, *u);
    return lo;
}

// A direction in the cell of `at`, whose y is 0 to 1 between its rows by solid angle: its density without the choice of the
// light, its radiance.
IR_FN real3 sample_picture_cell(const SceneData* s, const Light* map, const Texture* picture, PicturePoint at,
                                float* density, real3* radiance) {
    const uint rows = picture->height - 1u;
    const float u0 = at.y;
    const float above = IR_AS_FLOAT(s->texels[map->table + rows + at.row]);  // 1 - |cos|
    const float below = IR_AS_FLOAT(s->texels[map->table + rows + at.row + 1u]);
    float cosine, sine2;
    if (2u * at.row + 1u == rows) {  // across the equator
        cosine = (1.0f - above) * (1.0f - u0) - (1.0f - below) * u0;
        sine2 = 1.0f - cosine * cosine;
    } else {
        const float height = above * (1.0f - u0) + below * u0;
        cosine = 2u * at.row < rows ? 1.0f - height : height - 1.0f;
        sine2 = height * (2.0f - height);
    }
    const float sine = sqrt(max(sine2, 0.0f));
    at.y = clamp(turns_of(cosine, sine) * 2.0f * (float)rows - (float)at.row, 0.0f, 1.0f);
    float turns = ((float)at.column + 0.5f + at.x) / (float)picture->width, sine_phi, cosine_phi;
    if (turns > 1.0f) turns -= 1.0f;
    sincos_turns(turns, &sine_phi, &cosine_phi);
    *density = picture_cell_density(s, map, picture, at.column, at.row);
    *radiance = picture_radiance(s, picture, at);
    return make_real3(map->e1x, map->e1y, map->e1z) * (sine * sine_phi) +
           make_real3(map->e2x, map->e2y, map->e2z) * cosine -
           make_real3(map->nx, map->ny, map->nz) * (sine * cosine_phi);
}

// A direction of the picture by its flux, likewise.
IR_FN real3 sample_picture(const SceneData* s, const Light* map, float u0, float u1, float* density, real3* radiance) {
    const Texture picture = s->textures[map->texture];
    PicturePoint at;
    at.y = u0;
    at.x = u1;
    at.row = search_sums(s, map->table, picture.height - 1u, &at.y);
    at.column = search_sums(s, picture_cells(map, &picture, at.row), picture.width, &at.x);
    return sample_picture_cell(s, map, &picture, at, density, radiance);
}
#endif

// Radiance that arrives from `direction` (unit) where nothing is in the way.
IR_FN real3 environment_radiance(const SceneData* s, real3 direction) {
#if IR_FEATURES & IR_FEATURE_ENVIRONMENT
    if (s->info->environment_light != IR_NO_LIGHT) {
        const IR_GLOBAL Light* sky = &s->lights[s->info->environment_light];
#if IR_FEATURES & IR_FEATURE_ENVMAP
        if (sky->kind == IR_LIGHT_ENVMAP) {
            const Light map = *sky;
            const Texture picture = s->textures[map.texture];
            return picture_radiance(s, &picture, picture_point(&map, &picture, direction));
        }
#endif
        return make_real3(sky->r, sky->g, sky->b);
    }
#endif
    return make_real3(0.0f, 0.0f, 0.0f);
}

// Density with which sample_light() at a surface of normal n chooses `direction` (unit), among the samples of all
// lights, by sampling the environment; 0 if there is none. sr⁻¹.
IR_FN float environment_density(const SceneData* s, real3 direction, real3 n) {
#if IR_FEATURES & IR_FEATURE_ENVIRONMENT
    if (s->info->environment_light != IR_NO_LIGHT) {
        const IR_GLOBAL Light* sky = &s->lights[s->info->environment_light];
#if IR_FEATURES & IR_FEATURE_ENVMAP
        if (sky->kind == IR_LIGHT_ENVMAP) {
            const Light map = *sky;
            const Texture picture = s->textures[map.texture];
            const PicturePoint at = picture_point(&map, &picture, direction);
            return map.probability * picture_cell_density(s, &map, &picture, at.column, at.row);
        }
#endif
        return sky->probability * max(dot(direction, n), 0.0f) * IR_INV_PI;
    }
#endif
    return 0.0f;
}
#endif
