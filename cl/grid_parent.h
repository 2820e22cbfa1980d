// Keys of the irradiance grid's cells (irradiance_grid.h) without floating point: hosts need them too.
#ifndef IR_GRID_PARENT_H
#define IR_GRID_PARENT_H
#include "portable.h"

// Key of the cell of the next coarser level around the cell of `key`.
IR_FN uint grid_parent(uint key) {
    const uint x = (((key & 511u) - 1u) >> 1) + 1u, y = ((((key >> 9) & 511u) - 1u) >> 1) + 1u,
               z = ((((key >> 18) & 511u) - 1u) >> 1) + 1u;
    return x | (y << 9) | (z << 18) | (key & 0x38000000u) | (((key >> 30) + 1u) << 30);
}
#endif
