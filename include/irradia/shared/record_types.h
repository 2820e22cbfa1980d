// Structs of the caching stages as they lie in device memory; see scene_types.h for the rules.
#ifndef IRRADIA_SHARED_RECORD_TYPES_H
#define IRRADIA_SHARED_RECORD_TYPES_H
#include "irradia/shared/align.h"

#if !defined(__OPENCL_VERSION__) && !defined(__CUDACC__)
#include <cstdint>
namespace irradia::shared {
using uint = std::uint32_t;
#endif

// A point that wants a record: what find_misses pushes and sample_hemispheres pops.
#define IR_POINT_NONE 0u  // nothing to do: covered, or no surface there
#define IR_POINT_MISS 1u  // a surface point without enough records for its diffuse part
#define IR_POINT_BUMPED 2u  // flag: a bump map turns n away from g, which then is the normal without the map
#define IR_POINT_COATED(material) (((material) + 1u) << 8)  // flag: seen through the coat of this material
typedef struct IR_ALIGNED_16 ShadingPoint {
    float px, py, pz;              // position on the surface
    uint state;                    // IR_POINT_*, flags
    float nx, ny, nz;              // unit shading normal on the side that is seen
    float footprint;               // edge of a pixel projected onto the surface there, world units
    float gx, gy, gz;              // unit geometric normal on the same side
    float offset;                  // distance by which ray origins are moved off the surface along g
    uint pixel;                    // y * width + x
    float step_x, step_y, step_z;  // from p to where its hemisphere's rays start, before the offset
    float largest;                 // support that the record made here may have at most, world units; 0: no limit
    float least;                   // support that `largest` and near surfaces leave it; 0: by --min-spacing
    float pad0, pad1;
} ShadingPoint;                    // 80 bytes

// Of a pixel of even coordinates, as find_misses has seen it: 0 if it wants a record, shows no diffuse surface, or has
// others close over or beside it, else a code of normal and coat (of nothing seen: 1), and, as a float's bits, where its
// plane lies.
#define IR_PLAIN_WORDS 2u

// A record, in two parts: what every look-up reads of every candidate, and what only accepted ones need.
// Support = the distance at which the weight reaches zero: a R (1.8), or the Hessian's ellipse (theory 6).
typedef struct IR_ALIGNED_16 RecordKey {
    float px, py, pz;
    float support1;       // along the direction of strongest curvature of E (and along the normal)
    float nx, ny, nz;     // unit normal of the sampled hemisphere
    float support2;       // along t2; >= support1 (equal: a disk)
    float t2x, t2y, t2z;  // unit tangent of weakest curvature
    uint coat;            // Material.coat of the surface: E counts what passes it; records of other coats do not apply
} RecordKey;              // 48 bytes

typedef struct IR_ALIGNED_16 RecordValue {
    float e[3];            // irradiance by indirect light (what passes the coat), W·m⁻², RGB
    float rotation[9];     // rotational gradient (1.4), three world-space vectors, one a channel: dE = (n_i x n) . g
    float translation[9];  // translational gradient (1.5), likewise: dE = (p - p_i) . g
    float minimum;         // R of (1.15)
    uint pixel;            // the pixel whose miss made this record
    float harmonic;        // R of (1.14), world units, before any clamp (researchers re-use it)
} RecordValue;             // 96 bytes

// State of the device octree, kept by the kernels, read by the host after each insertion.
typedef struct OctreeState {
    uint node_count;  // nodes in use
    uint entry_count;  // entries handed out (may exceed the capacity: then `overflow` is set)
    uint overflow;  // 1: some record could not be entered completely; the host grows and runs again
    uint levels;    // bit l: level l holds records
} OctreeState;

#define IR_OCTREE_MAX_DEPTH 20u
// Places of the octree's table that one work-item packs on CPU devices: it waits for the memory of all together.
#define IR_PACKED_PLACES 32u
// Work-items that enter a record into its cells on GPUs.
#define IR_INSERT_LANES 32u

// Of a new record, while neighbours are clamped: how many old ones it may shrink, and which, if they are fewer than that.
#define IR_CLAMP_WORDS 16u

// Everything a look-up needs to know besides the arrays; by value into kernels.
#define IR_WEIGHT_WARD 0u       // (1.8) in its safe form, theory 4.1
#define IR_WEIGHT_TABELLION 1u  // (1.11)-(1.13), theory 4.2
#define IR_WEIGHT_CUBIC 2u      // a bell over the support of (1.8)
typedef struct CacheParameters {
    float origin_x, origin_y, origin_z;  // lower corner of the octree's root cube
    float size;                          // edge of the root cube, world units
    float inverse_angle;                 // e_n = inverse_angle |n - n_i| / sqrt 2
    float in_front;                      // slope of the in-front test (theory 4.3), 0 = off
    float coordinate;                    // largest |coordinate| of the scene, for the test's rounding allowance
    float minimum_weight;                // a point is covered if the weights sum to more than this
    float stretch;  // distances and angles count times this: > 1 asks for nearer records than the picture will use
    // Narrow places (find_misses), in footprints: least support of a record there, and how far along the normal to look for
    // another surface (half as far sideways for a ledge, or 2). 0: they are not looked for.
    float gap_least, gap_reach;
    uint levels;  // of the octree, that hold records: bit l for level l
} CacheParameters;  // 48 bytes

// What sample_hemispheres needs to make a record of its sums; by value.
typedef struct RecordParameters {
    float accuracy;     // `a`: support = a R for the distance rules
    float min_spacing;  // support is clamped to [min_spacing, max_spacing] footprints
    float max_spacing;
    float aspect;        // largest support2 / support1
    float r_min, r_max;  // distances are clamped to these, world units (theory 4.4)
    float diagonal;      // of the scene, world units
    float tau;           // Hessian rule: allowed relative error integrated over the support, in pixels (theory 6)
    float overlap;       // supports are enlarged by this in the end: see RenderSettings::overlap
    float firefly;       // gradients and Hessian take a cell as at most this many times the mean; 0 = as it is
    float reach;         // support is at most this many times the distance of the nearest surface seen; 0 = off
    float pad0;
} RecordParameters;  // 48 bytes

#if !defined(__OPENCL_VERSION__) && !defined(__CUDACC__)
static_assert(sizeof(ShadingPoint) == 80 && sizeof(RecordKey) == 48 && sizeof(RecordValue) == 96 &&
              sizeof(OctreeState) == 16 && sizeof(CacheParameters) == 48 && sizeof(RecordParameters) == 48);
}  // namespace irradia::shared
#endif
#endif
