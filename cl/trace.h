// Rays against the scene. One interface, two traversals: CPU devices (-D IR_CPU) trace packets of IR_TILE = 16 rays
// that share an origin on a BVH8, and single rays on the same BVH8; GPU devices trace one ray a work-item on a BVH2.
// Nothing else in cl/ knows which of the two it runs on.
#ifndef IR_TRACE_H
#define IR_TRACE_H
#include "scene.h"

typedef struct Hit {
    float t;         // ray parameter, world units for unit directions; IR_INFINITY for a miss
    float u, v;      // triangle: barycentrics of v1 and v2; analytic: unused
    uint primitive;  // IR_NO_PRIMITIVE for a miss
} Hit;

#ifdef IR_CPU
#define IR_TILE 16  // rays of one packet: a 4x4 tile of strata or of a pixel's samples
#include "trace_cpu.h"
#else
#define IR_TILE 1
#include "trace_gpu.h"
#endif
// Both headers define:
//   IR_FN Hit trace_closest(const SceneData* s, real3 origin, real3 direction, float t_min, float t_max);
//   IR_FN bool trace_occluded(const SceneData* s, real3 origin, real3 direction, float t_min, float t_max);
//   IR_FN void trace_tile(const SceneData* s, real3 origin, const float* dx, const float* dy, const float* dz,
//                         uint count, float t_min, Hit* hits);   // closest hits of `count` <= IR_TILE rays from one
//                         origin
//   IR_FN void trace_tile_occluded(const SceneData* s, const float* ox, const float* oy, const float* oz,
//                         const float* dx, const float* dy, const float* dz, uint count, float t_min,
//                         const float* t_max, uint* occluded);   // bit i: ray i of `count` <= IR_TILE, each with an
//                         // origin and t_max of its own, is occluded. Shadow rays from neighbouring points: on few
//                         // triangles faster than single rays, on large meshes as fast.
// t_min >= 0. Intervals are open: a hit has t_min < t < t_max.
#endif
