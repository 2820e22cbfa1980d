// Several numbers at once: sums over a record's samples run over `lanes`, which are eight floats on CPU devices and one
// on GPUs. Arithmetic, sqrt, exp, min, max and fabs are those of float; comparisons only within lanes_select.
#ifndef IR_LANES_H
#define IR_LANES_H
#include "portable.h"

#ifdef IR_CPU
#define IR_LANES 8u
typedef float8 lanes;
#define lanes_load(p, i) vload8(0, (p) + (i))
#define lanes_select(no, yes, test) select((lanes)(no), (lanes)(yes), (test))
#define lanes_of(x) ((float8)(x))
IR_FN float lanes_sum(lanes v) {
    const float4 a = v.lo + v.hi;
    const float2 b = a.lo + a.hi;
    return b.x + b.y;
}
#else
#define IR_LANES 1u
typedef float lanes;
#define lanes_load(p, i) ((p)[i])
#define lanes_select(no, yes, test) ((test) ? (yes) : (no))
#define lanes_of(x) (x)
#define lanes_sum(v) (v)
#endif

typedef struct LaneVector {
    lanes x, y, z;
} LaneVector;

IR_FN lanes lanes_dot(LaneVector a, LaneVector b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
IR_FN lanes lanes_dot3(LaneVector a, real3 b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
#endif
