// What of an environment picture is seen from where. Through a window most light samples of a sky meet the walls around it.
// So paths from the camera tell (learn_sky.cl) through which tiles of the picture a surface sees the sky, by cells in space
// and six directions of the normal (those of the irradiance grid), and light samples there take a tile by what was seen
// through it. A share of them (IR_SKY_UNSEEN) takes the whole picture as before, and densities are of both: whatever was
// learned, samples stay unbiased.
//
// Tables at Light.view of the texel array (src/render/sky_view.cpp), words:
//   origin x, y, z, edge of the finest cells; slots; 3 unused        (IR_SKY_HEADER)
//   IR_SKY_COLUMNS * rows  floats: for each column of tiles the inclusive running sum of its flux over the picture's rows
//   2 * slots              hash table of cells: key (grid_key), where its tiles begin in the texel array; key 0: free
//   IR_SKY_TILES a cell    floats: inclusive running sums of its tiles' probabilities, row by row; the last is 1
#ifndef IR_SKY_VIEW_H
#define IR_SKY_VIEW_H
#include "irradiance_grid.h"
#include "scene.h"
#include "sky_tiles.h"

#if IR_FEATURES & IR_FEATURE_ENVMAP
IR_FN float sky_word(const SceneData* s, uint at) { return IR_AS_FLOAT(s->texels[at]); }

// The running sum before the i-th at `first`.
IR_FN float sum_before(const SceneData* s, uint first, uint i) { return i > 0u ? sky_word(s, first + i - 1u) : 0.0f; }

// Tile of a cell of the picture.
IR_FN uint sky_tile(const Texture* picture, uint column, uint row) {
    return tile_of(row, IR_SKY_ROWS, picture->height - 1u) * IR_SKY_COLUMNS +
           tile_of(column, IR_SKY_COLUMNS, picture->width);
}

// Where in the array of texels the tiles begin by which a surface at p, normal n, samples the sky; 0: it takes it whole
// (always with IR_SKY_WHOLE).
IR_FN uint sky_tiles(const SceneData* s, const Light* map, real3 p, real3 n) {
#ifdef IR_SKY_WHOLE
    return 0u;
#else
    if (map->view == 0u) return 0u;
    const IR_GLOBAL uint* view = s->texels + map->view;
    GridParameters g;
    g.origin_x = IR_AS_FLOAT(view[0]);
    g.origin_y = IR_AS_FLOAT(view[1]);
    g.origin_z = IR_AS_FLOAT(view[2]);
    g.cell = IR_AS_FLOAT(view[3]);
    const uint slots = view[4];
    const IR_GLOBAL uint* table = view + IR_SKY_HEADER + IR_SKY_COLUMNS * (s->textures[map->texture].height - 1u);
    for (uint level = 0; level < IR_GRID_LEVELS; ++level) {
        const uint key = grid_key(&g, level, p, n);
        for (uint slot = hash_slot(key, slots); table[2u * slot] != 0u; slot = (slot + 1u) & (slots - 1u))
            if (table[2u * slot] == key) return table[2u * slot + 1u];
    }
    return 0u;
#endif
}

// The running sums of a column of tiles over the picture's rows, in the array of texels.
IR_FN uint sky_band(const Light* map, const Texture* picture, uint column_of_tiles) {
    return map->view + IR_SKY_HEADER + column_of_tiles * (picture->height - 1u);
}
#endif
#endif
