// Where things of an environment picture lie, without floating point: hosts need them too (environment.h, sky_view.h).
#ifndef IR_SKY_TILES_H
#define IR_SKY_TILES_H
#include "irradia/shared/sky_types.h"
#include "portable.h"

// The running sums of cells in row `row` of `rows`, among the tables at `table` (environment.h).
IR_FN uint cell_sums(uint table, uint width, uint rows, uint row) { return table + 3u * rows + 1u + row * width; }

// Of `count` columns or rows, those from tile_begin(t) to before tile_begin(t + 1) are tile t's.
IR_FN uint tile_of(uint i, uint tiles, uint count) { return i * tiles / count; }
IR_FN uint tile_begin(uint tile, uint tiles, uint count) { return (tile * count + tiles - 1u) / tiles; }
#endif
