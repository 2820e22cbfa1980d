// Several numbers at once: sums over a hemisphere's cells or a record's samples run over `lanes`, which are eight floats
// on CPU devices and one on GPUs and in host tests. Arithmetic, sqrt, rsqrt, exp, min, max, clamp and fabs are those of
// float; comparisons and !, &&, || of them give a lanes_mask, which lanes_select and lanes_all understand.
// -D IR_SCALAR_LANES=1 makes lanes single numbers on CPU devices too.
#ifndef IR_LANES_H
#define IR_LANES_H
#include "portable.h"

#if defined(IR_CPU) && !IR_SCALAR_LANES
#define IR_LANES 8u
typedef float8 lanes;
typedef int8 lanes_mask;
typedef uint8 lanes_uint;
typedef struct LaneVector {
    lanes x, y, z;
} LaneVector;
#define lanes_load(p, i) vload8(0, (p) + (i))
#define lanes_store(v, p, i) vstore8(v, 0, (p) + (i))
#define lanes_load_uint(p, i) vload8(0, (p) + (i))
#define lanes_first(v) ((v).s0)
#define lanes_of_uint(x) convert_float8(as_int8(x))  // x < 2^31
#define lanes_numbers() ((uint8)(0u, 1u, 2u, 3u, 4u, 5u, 6u, 7u))
#define lanes_select(no, yes, test) select((lanes)(no), (lanes)(yes), (test))
#define lanes_all(test) all(test)
#define lanes_of(x) ((float8)(x))
#define lanes_index() ((float8)(0.0f, 1.0f, 2.0f, 3.0f, 4.0f, 5.0f, 6.0f, 7.0f))
#define lanes_sincos_turns(turns, s, c)                                               \
    do {                                                                              \
        const lanes angle = 6.28318530717958647692f * (turns)-3.14159265358979323846f; \
        *(s) = -native_sin(angle);                                                    \
        *(c) = -native_cos(angle);                                                    \
    } while (0)
IR_FN LaneVector make_lane_vector(lanes x, lanes y, lanes z) {
    LaneVector v;
    v.x = x;
    v.y = y;
    v.z = z;
    return v;
}
// Lane i of the result is lane i - 1 of v; lane 0 is `first`.
IR_FN lanes lanes_shift_in(float first, lanes v) { return (lanes)(first, v.s0123, v.s456); }
IR_FN float lanes_sum(lanes v) {
    const float4 a = v.lo + v.hi;
    const float2 b = a.lo + a.hi;
    return b.x + b.y;
}
IR_FN float lanes_min(lanes v) {
    const float4 a = min(v.lo, v.hi);
    const float2 b = min(a.lo, a.hi);
    return min(b.x, b.y);
}
IR_FN float lanes_max(lanes v) {
    const float4 a = max(v.lo, v.hi);
    const float2 b = max(a.lo, a.hi);
    return max(b.x, b.y);
}
#else
#define IR_LANES 1u
typedef real lanes;
typedef bool lanes_mask;
typedef uint lanes_uint;
typedef real3 LaneVector;
#define lanes_load(p, i) ((p)[i])
#define lanes_store(v, p, i) ((p)[i] = (v))
#define lanes_load_uint(p, i) ((p)[i])
#define lanes_first(v) (v)
#define lanes_of_uint(x) ((real)(x))
#define lanes_numbers() 0u
#define lanes_select(no, yes, test) ((test) ? (yes) : (no))
#define lanes_all(test) (test)
#define lanes_of(x) (x)
#define lanes_index() R(0.0)
#define lanes_sincos_turns(turns, s, c) sincos_turns(turns, s, c)
#define make_lane_vector(x, y, z) make_real3(x, y, z)
#define lanes_shift_in(first, v) (first)
#define lanes_sum(v) (v)
#define lanes_min(v) (v)
#define lanes_max(v) (v)
#endif

// Of linear RGB (ITU-R BT.709), of numbers and of lanes.
#define IR_LUMINANCE(r, g, b) (R(0.2126) * (r) + R(0.7152) * (g) + R(0.0722) * (b))
IR_FN real luminance(real3 rgb) { return IR_LUMINANCE(rgb.x, rgb.y, rgb.z); }

IR_FN lanes lanes_dot(LaneVector a, LaneVector b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
IR_FN lanes lanes_dot3(LaneVector a, real3 b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
IR_FN LaneVector lanes_difference(LaneVector a, LaneVector b) {
    return make_lane_vector(a.x - b.x, a.y - b.y, a.z - b.z);
}
IR_FN LaneVector lanes_scaled(LaneVector a, lanes s) { return make_lane_vector(a.x * s, a.y * s, a.z * s); }
IR_FN LaneVector lanes_cross(LaneVector a, LaneVector b) {
    return make_lane_vector(a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x);
}
// The vector of `yes` where test holds, else that of `no`.
IR_FN LaneVector lanes_select3(LaneVector no, LaneVector yes, lanes_mask test) {
    return make_lane_vector(lanes_select(no.x, yes.x, test), lanes_select(no.y, yes.y, test),
                            lanes_select(no.z, yes.z, test));
}
#endif
