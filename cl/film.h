// What a pixel gathers: sums over its samples of the picture's two parts and, if asked for, of the AOVs.
#ifndef IR_FILM_H
#define IR_FILM_H
#include "irradia/shared/counter_types.h"
#include "surface.h"

// Floats a pixel in the film buffer: direct RGB, indirect RGB [, albedo RGB, normal XYZ, depth].
#ifdef IR_AOVS
#define IR_FILM_CHANNELS 13u
#else
#define IR_FILM_CHANNELS 6u
#endif

// Adds n to a counter (IR_RAYS_*, IR_REQUESTS).
IR_FN void count_up(IR_GLOBAL uint* counters, uint counter, uint n) {
    if (n == 0u) return;
    const uint set = IR_GROUP_ID / IR_COUNTER_GROUPS % IR_COUNTER_SETS;
    IR_ATOMIC_ADD((volatile IR_GLOBAL uint*)&counters[set * IR_COUNTER_STRIDE + counter], n);
}

typedef struct PixelSum {
    real3 direct, indirect;
#ifdef IR_AOVS
    real3 albedo, normal;
    float depth;
#endif
} PixelSum;

IR_FN void pixel_clear(PixelSum* sum) {
    sum->direct = sum->indirect = make_real3(0.0f, 0.0f, 0.0f);
#ifdef IR_AOVS
    sum->albedo = sum->normal = make_real3(0.0f, 0.0f, 0.0f);
    sum->depth = 0.0f;
#endif
}

IR_FN void pixel_add_miss(PixelSum* sum, real3 sky) { sum->direct += sky; }

// One sample that saw surface f at distance t. Depth is the distance along the ray, in world units.
IR_FN void pixel_add(PixelSum* sum, const Surface* f, float t, real3 direct, real3 indirect) {
    sum->direct += direct;
    sum->indirect += indirect;
#ifdef IR_AOVS
    sum->albedo += f->albedo;
    sum->normal += f->ns;
    sum->depth += t;
#endif
}

// Sums of a pixel's samples: tiles of several tell two halves of a launch apart, where the host asks for that.
#if IR_TILE > 1
#define IR_SUMS 2u
// Of sample i of a tile whose samples from `second` on are of the second half.
#define IR_SUM_OF(i, second) ((i) >= (second) ? 1u : 0u)
#else
#define IR_SUMS 1u
#define IR_SUM_OF(i, second) 0u
#endif

// Both halves together.
IR_FN PixelSum pixel_whole(const PixelSum* sums) {
    PixelSum whole = sums[0];
#if IR_TILE > 1
    whole.direct += sums[1].direct;
    whole.indirect += sums[1].indirect;
#ifdef IR_AOVS
    whole.albedo += sums[1].albedo;
    whole.normal += sums[1].normal;
    whole.depth += sums[1].depth;
#endif
#endif
    return whole;
}

IR_FN void pixel_store(const PixelSum* sum, IR_GLOBAL float* film, uint slot) {
    IR_GLOBAL float* out = film + slot * IR_FILM_CHANNELS;
    out[0] = sum->direct.x;
    out[1] = sum->direct.y;
    out[2] = sum->direct.z;
    out[3] = sum->indirect.x;
    out[4] = sum->indirect.y;
    out[5] = sum->indirect.z;
#ifdef IR_AOVS
    out[6] = sum->albedo.x;
    out[7] = sum->albedo.y;
    out[8] = sum->albedo.z;
    out[9] = sum->normal.x;
    out[10] = sum->normal.y;
    out[11] = sum->normal.z;
    out[12] = sum->depth;
#endif
}
#endif
