// Structs of the irradiance grid (cl/irradiance_grid.h) as they lie in device memory; see scene_types.h for the rules.
#ifndef IRRADIA_SHARED_GRID_TYPES_H
#define IRRADIA_SHARED_GRID_TYPES_H
#include "irradia/shared/align.h"

#if !defined(__OPENCL_VERSION__) && !defined(__CUDACC__)
#include <cstdint>
namespace irradia::shared {
using uint = std::uint32_t;
#endif

#define IR_GRID_LEVELS 4u  // cells of 1, 2, 4, 8 times the finest edge; two bits of a key

typedef struct GridParameters {
    float origin_x, origin_y, origin_z;  // lower corner of the grid
    float cell;                          // edge of the finest cells, world units: at least 1/509 of the scene's extent
    float unit;                          // irradiance that one count of a sum stands for, W·m⁻²
    float shortest;                      // look-ups are for rays longer than this many cells
    uint slots;                          // of the hash table; a power of two
    uint least;                          // estimates without which a cell does not answer
    uint edges;  // that may follow the ray that asks, direct light among them; 0xffffffff: any number
} GridParameters;  // 36 bytes

// Where so many path edges or more may follow a look-up, it may be of a grid whose paths have another limit: what is
// wrong then is light that more than 30 surfaces have reflected, of an albedo of .8 its 1e-3.
#define IR_GRID_DEEP 32u

// A cell while it is filled: open addressing by key, 0 = free.
typedef struct GridSum {
    uint key;
    uint samples;
    uint r[2], g[2], b[2];  // sums in units, low and high word
} GridSum;                  // 32 bytes

// A cell for look-ups: only those with enough estimates, hashed alike.
typedef struct IR_ALIGNED_16 GridCell {
    uint key;
    float r, g, b;  // mean irradiance, W·m⁻²
} GridCell;         // 16 bytes

#if !defined(__OPENCL_VERSION__) && !defined(__CUDACC__)
static_assert(sizeof(GridParameters) == 36 && sizeof(GridSum) == 32 && sizeof(GridCell) == 16);
}  // namespace irradia::shared
#endif
#endif
