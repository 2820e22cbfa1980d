// Counter-seeded random numbers: every stream is a function of (seed, stream, index) alone, so results do not depend on
// how work is spread over threads.
#ifndef IR_RANDOM_H
#define IR_RANDOM_H
#include "portable.h"

// Integer hash with low bias (Wellons' lowbias32), of a number or of each lane (strata.h).
#define IR_HASH_FN(type, name)     \
    IR_FN type name(type x) {      \
        x ^= x >> 16;              \
        x *= 0x7feb352du;          \
        x ^= x >> 15;              \
        x *= 0x846ca68bu;          \
        return x ^ (x >> 16);      \
    }
IR_HASH_FN(uint, hash_uint)

// Where a table of `slots`, a power of two, is asked for `key` first.
IR_FN uint hash_slot(uint key, uint slots) { return hash_uint(key) & (slots - 1u); }

// [0,1): the 24 leading bits, so that the largest value is 1 - 2^-24 and never rounds to 1.
#define IR_UNIT R(5.9604644775390625e-8)  // 2^-24
IR_FN real uint_to_unit(uint x) { return (real)(x >> 8) * IR_UNIT; }

// PCG32 (O'Neill 2014), XSH-RR on a 64-bit linear congruential state.
typedef struct Rng {
    ulong state;
} Rng;

IR_FN ulong mix_ulong(ulong z) {  // splitmix64's finaliser
    z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9ul;
    z = (z ^ (z >> 27)) * 0x94d049bb133111ebul;
    return z ^ (z >> 31);
}

IR_FN Rng rng_make(uint seed, uint stream, uint index) {
    Rng rng;
    rng.state = mix_ulong(mix_ulong(((ulong)seed << 32) | stream) + 0x9e3779b97f4a7c15ul * ((ulong)index + 1ul));
    return rng;
}

IR_FN uint rng_uint(Rng* rng) {
    const ulong old = rng->state;
    rng->state = old * 6364136223846793005ul + 1442695040888963407ul;
    const uint x = (uint)(((old >> 18) ^ old) >> 27);
    const uint r = (uint)(old >> 59);
    return (x >> r) | (x << ((32u - r) & 31u));
}

IR_FN real rng_real(Rng* rng) { return uint_to_unit(rng_uint(rng)); }
#endif
