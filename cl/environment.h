// What surrounds the scene: a constant radiance or a picture of it, and samples of the picture by its flux.
//
// The picture is latitude-longitude after Mitsuba: a direction (x, y, z) in the map's own axes (Light.e1, e2, n) lies at
// u = atan2(x, -z) / 2 pi, v = acos(y) / pi. Columns of texels lie at (i + 1/2) / width and repeat; rows lie at
// i / (height - 1), so the first and the last one are the poles. Radiance is bilinear between four texels: a cell.
// There are `width` cells in a row, cell i between the columns i and i + 1, and `rows` = height - 1 rows of them.
//
// Cells are chosen in proportion to their flux (the integral of the bilinear luminance over solid angle), or of what is
// seen of it from the surface (sky_view.h), and a direction within one uniformly in solid angle. Tables, floats at
// Light.table of the texel array (made by src/scene/environment.cpp):
//   rows           inclusive running sum of the rows' probabilities; the last is 1
//   rows + 1       1 - |cos| of the polar angle of every row of texels: near the poles that is what float32 can hold
//   rows           1 / solid angle of one of the row's cells, sr⁻¹
//   rows * width   for each row the inclusive running sum of its cells' probabilities; the last is 1
// Sums are multiples of 2^-24: their differences, the probabilities, are exact.
#ifndef IR_ENVIRONMENT_H
#define IR_ENVIRONMENT_H
#include "sky_view.h"
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
    return cell_sums(map->table, picture->width, picture->height - 1u, row);
}

// The i-th of the running sums at `first` less the one before: exact, and what a search for random numbers meets.
IR_FN float of_sum(const SceneData* s, uint first, uint i) { return sky_word(s, first + i) - sum_before(s, first, i); }

// Sums from the begin-th to before the end-th at `first`.
IR_FN float of_sums(const SceneData* s, uint first, uint begin, uint end) {
    return sky_word(s, first + end - 1u) - sum_before(s, first, begin);
}

// Density of a cell among all directions for a surface that samples by `tiles` (sky_tiles), without the choice of the
// light. sr⁻¹.
IR_FN float picture_cell_density(const SceneData* s, const Light* map, const Texture* picture, uint tiles, uint column,
                                 uint row) {
    const uint rows = picture->height - 1u, cells = picture_cells(map, picture, row);
    const float of_cell = of_sum(s, cells, column), inverse_angle = sky_word(s, map->table + 2u * rows + 1u + row);
    const float whole = of_sum(s, map->table, row) * of_cell * inverse_angle;
    if (tiles == 0u) return whole;
    const uint i = tile_of(row, IR_SKY_ROWS, rows), j = tile_of(column, IR_SKY_COLUMNS, picture->width);
    const uint band = sky_band(map, picture, j);
    const float of_row = of_sum(s, band, row);
    float seen = 0.0f;
    if (of_row > 0.0f) {
        const float in_tile =
            of_row / of_sums(s, band, tile_begin(i, IR_SKY_ROWS, rows), tile_begin(i + 1u, IR_SKY_ROWS, rows));
        const float in_row = of_cell / of_sums(s, cells, tile_begin(j, IR_SKY_COLUMNS, picture->width),
                                               tile_begin(j + 1u, IR_SKY_COLUMNS, picture->width));
        seen = of_sum(s, tiles, i * IR_SKY_COLUMNS + j) * in_tile * in_row * inverse_angle;
    }
    return IR_SKY_UNSEEN * whole + (1.0f - IR_SKY_UNSEEN) * seen;
}

// Where u lies between the running sum before the i-th at `first` and that one: [0, 1).
IR_FN float share_of_sum(const SceneData* s, uint first, uint i, float u) {
    return min(max((u - sum_before(s, first, i)) / of_sum(s, first, i), 0.0f), 0.99999994f);
}

// The first running sum at `first` from the begin-th to before the end-th that exceeds u; if none does, the last.
IR_FN uint search_sums(const SceneData* s, uint first, uint begin, uint end, float u) {
    uint lo = begin, hi = end - 1u;
    while (lo < hi) {
        const uint mid = (lo + hi) >> 1;
        if (sky_word(s, first + mid) > u)
            hi = mid;
        else
            lo = mid + 1u;
    }
    return lo;
}

// Where the cell of a sample lies: in row `at.row` of the picture, the first from `begin` to before `end` whose running sum
// exceeds at.x.
typedef struct PictureRow {
    PicturePoint at;  // at.y: within the row
    uint begin, end;
} PictureRow;

// The row for random numbers u0, u1, of which the second chooses the cell, by `tiles` (sky_tiles).
IR_FN PictureRow sample_picture_row(const SceneData* s, const Light* map, const Texture* picture, uint tiles, float u0,
                                    float u1) {
    const uint rows = picture->height - 1u;
    PictureRow r;
    r.at.column = 0u;
    if (tiles == 0u || u0 < IR_SKY_UNSEEN) {
        const float u = tiles == 0u ? u0 : min(u0 * (1.0f / IR_SKY_UNSEEN), 0.99999994f);
        r.at.row = search_sums(s, map->table, 0u, rows, u);
        r.at.y = share_of_sum(s, map->table, r.at.row, u);
        r.at.x = u1;
        r.begin = 0u;
        r.end = picture->width;
        return r;
    }
    const float u = min((u0 - IR_SKY_UNSEEN) * (1.0f / (1.0f - IR_SKY_UNSEEN)), 0.99999994f);
    const uint tile = search_sums(s, tiles, 0u, IR_SKY_TILES, u), i = tile / IR_SKY_COLUMNS, j = tile % IR_SKY_COLUMNS;
    const uint band = sky_band(map, picture, j);
    const uint top = tile_begin(i, IR_SKY_ROWS, rows), bottom = tile_begin(i + 1u, IR_SKY_ROWS, rows);
    const float down = sum_before(s, band, top) + share_of_sum(s, tiles, tile, u) * of_sums(s, band, top, bottom);
    r.at.row = search_sums(s, band, top, bottom, down);
    r.at.y = share_of_sum(s, band, r.at.row, down);
    r.begin = tile_begin(j, IR_SKY_COLUMNS, picture->width);
    r.end = tile_begin(j + 1u, IR_SKY_COLUMNS, picture->width);
    const uint cells = picture_cells(map, picture, r.at.row);
    r.at.x = sum_before(s, cells, r.begin) + u1 * of_sums(s, cells, r.begin, r.end);
    return r;
}

// A direction in the cell of `at`, whose y is 0 to 1 between its rows by solid angle: its density without the choice of the
// light, its radiance.
IR_FN real3 sample_picture_cell(const SceneData* s, const Light* map, const Texture* picture, uint tiles, PicturePoint at,
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
    *density = picture_cell_density(s, map, picture, tiles, at.column, at.row);
    *radiance = picture_radiance(s, picture, at);
    return make_real3(map->e1x, map->e1y, map->e1z) * (sine * sine_phi) +
           make_real3(map->e2x, map->e2y, map->e2z) * cosine -
           make_real3(map->nx, map->ny, map->nz) * (sine * cosine_phi);
}

// A direction of the picture, likewise: by its flux, or by what is seen of that at p, normal n.
IR_FN real3 sample_picture(const SceneData* s, const Light* map, real3 p, real3 n, float u0, float u1, float* density,
                           real3* radiance) {
    const Texture picture = s->textures[map->texture];
    const uint tiles = sky_tiles(s, map, p, n);
    PictureRow r = sample_picture_row(s, map, &picture, tiles, u0, u1);
    const uint cells = picture_cells(map, &picture, r.at.row);
    r.at.column = search_sums(s, cells, r.begin, r.end, r.at.x);
    r.at.x = share_of_sum(s, cells, r.at.column, r.at.x);
    return sample_picture_cell(s, map, &picture, tiles, r.at, density, radiance);
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

// Density with which sample_light() at a surface at p, normal n, chooses `direction` (unit), among the samples of all
// lights, by sampling the environment; 0 if there is none. sr⁻¹.
IR_FN float environment_density(const SceneData* s, real3 p, real3 n, real3 direction) {
#if IR_FEATURES & IR_FEATURE_ENVIRONMENT
    if (s->info->environment_light != IR_NO_LIGHT) {
        const IR_GLOBAL Light* sky = &s->lights[s->info->environment_light];
#if IR_FEATURES & IR_FEATURE_ENVMAP
        if (sky->kind == IR_LIGHT_ENVMAP) {
            const Light map = *sky;
            const Texture picture = s->textures[map.texture];
            const PicturePoint at = picture_point(&map, &picture, direction);
            return map.probability *
                   picture_cell_density(s, &map, &picture, sky_tiles(s, &map, p, n), at.column, at.row);
        }
#endif
        return sky->probability * max(dot(direction, n), 0.0f) * IR_INV_PI;
    }
#endif
    return 0.0f;
}
#endif
