// Structs of radiance caching as they lie in device memory; see scene_types.h for the rules.
#ifndef IRRADIA_SHARED_RADIANCE_TYPES_H
#define IRRADIA_SHARED_RADIANCE_TYPES_H

#if !defined(__OPENCL_VERSION__) && !defined(__CUDACC__)
#include <cstdint>
namespace irradia::shared {
using uint = std::uint32_t;
#endif

// A radiance record is a RecordKey and a RecordValue, like any record, and one or both of these blocks of floats:
//   samples    IR_SAMPLE_FLOATS arrays of `stride` floats, an entry a direction of its hemisphere:
//              x, y, z of the point seen, relative to the record's position, world units (a miss: far away);
//              x, y, z of the unit normal there; the solid angle's factor r² / (|n . w| cos), world units squared;
//              r, g, b of the radiance that comes from there, W·m⁻²·sr⁻¹. Entries beyond the last direction are zero.
//   harmonics  IR_HARMONIC_SETS arrays of order² coefficients in hemispherical harmonics of the record's frame, of
//              radiance less its cosine-weighted mean E / pi: r, g, b; their derivatives along the frame's x axis
//              (r, g, b), and along its y axis, per world unit.
#define IR_SAMPLE_FLOATS 10u
#define IR_HARMONIC_SETS 9u

#define IR_FAR_DIAGONALS 1e4f  // where a miss is kept, diagonals of the scene: the same from everywhere in it
// Floats of an entry of the lobes' tables (cl/lobe.h).
#define IR_LOBE_FLOATS(order) (3u + 3u * ((order) * ((order) + 1u) / 2u))

#define IR_NO_LOBE 0xffffffffu  // a material without a lobe that records answer

// Everything that a look-up of radiance needs to know besides the arrays; by value into kernels.
typedef struct RadianceParameters {
    uint stride;           // directions of a record, rounded up to whole vectors
    uint order;            // of the harmonics; 0: records have none
    uint angles;           // entries of the lobes' tables over the view's angle, from the horizon to the normal
    uint alphas;           // entries over the roughness, for materials whose roughness is a texture
    float trace_below;     // lobes of less roughness are traced
    float harmonics_from;  // lobes of at least this roughness are answered by harmonics, others by samples
    float full_reach;      // lobes of at least this roughness use records to their full support, narrower ones nearer
    float spread;          // records that disagree by more than this, relative to their mean, want another between them
    float least;           // least support of a record, footprints: none is wanted for disagreement below
    float share;           // lobes that reflect less than this share of all that the surface reflects are traced
    float pad0, pad1;
} RadianceParameters;      // 48 bytes

#if !defined(__OPENCL_VERSION__) && !defined(__CUDACC__)
static_assert(sizeof(RadianceParameters) == 48);
}  // namespace irradia::shared
#endif
#endif
