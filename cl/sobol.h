// Four-dimensional points with Owen scrambling by hashing: Burley, "Practical hash-based Owen scrambling" (JCGT 2020), with
// Vegdahl's constants. Dimensions 0 and 1 are Sobol's: of any 2^m points from a multiple of 2^m on, every elementary
// interval of area 2^-m holds one. So are 2 and 3, in another order within each such block of points (their matrices are R
// and P R, where P is that of dimension 1 and R is upper triangular): Sobol's own dimensions 2 and 3 are not that good a
// pair, their first four and eight points lie in half of the quarters of a lamp. R makes of the four dimensions
// together what it can: of the 20, 35, 56 ways to cut the cube into 8, 16, 32 elementary intervals 16, 29, 40 have a point in
// each (Sobol's, by Joe and Kuo: 13, 26, 41). A beam search by these numbers, up to 2^14 points, found it.
#ifndef IR_SOBOL_H
#define IR_SOBOL_H
#include "lanes.h"
#include "random.h"

// Columns of R, bit-reversed.
IR_CONSTANT uint sobol_r[32] = {
    0x00000001u, 0x00000002u, 0x00000005u, 0x0000000bu, 0x00000016u, 0x00000027u, 0x00000054u, 0x000000adu,
    0x00000103u, 0x000002f4u, 0x000006a6u, 0x00000d14u, 0x0000166fu, 0x000021a2u, 0x00004899u, 0x0000c8dbu,
    0x0001d8f1u, 0x00039ac2u, 0x00070e1au, 0x0008813eu, 0x001414c3u, 0x0023c5fdu, 0x005fb535u, 0x00e16737u,
    0x017311d8u, 0x02f1ca20u, 0x069b3b30u, 0x0b0973b4u, 0x1c9e9c61u, 0x26b7f325u, 0x4601cba3u, 0xbe721641u};

// Nested uniform scramble of a bit-reversed number (Laine and Karras' hash).
IR_FN lanes_uint owen_scramble_reversed(lanes_uint x, lanes_uint seed) {
    x ^= x * 0x3d20adeau;
    x += seed;
    x *= (seed >> 16) | 1u;
    x ^= x * 0x05526c56u;
    x ^= x * 0x53a22864u;
    return x;
}

IR_FN lanes_uint reverse_bits(lanes_uint x) {
    x = (x << 16) | (x >> 16);
    x = ((x & 0x00ff00ffu) << 8) | ((x & 0xff00ff00u) >> 8);
    x = ((x & 0x0f0f0f0fu) << 4) | ((x & 0xf0f0f0f0u) >> 4);
    x = ((x & 0x33333333u) << 2) | ((x & 0xccccccccu) >> 2);
    return ((x & 0x55555555u) << 1) | ((x & 0xaaaaaaaau) >> 1);
}

// One number of [0,1) (uint_to_unit) a lane: that of x, bit-reversed, in the scramble that a hashed seed stands for.
IR_FN lanes scrambled_by(lanes_uint x, lanes_uint hashed) {
    return lanes_of_uint(reverse_bits(owen_scramble_reversed(x, hashed)) >> 8) * IR_UNIT;
}
IR_FN lanes scrambled_number(lanes_uint x, uint seed) { return scrambled_by(x, (lanes_uint)(hash_uint(seed))); }

// P times a vector: Pascal's triangle modulo 2, the power of ((1, 1), (0, 1)) that a bit each of the index picks.
IR_FN lanes_uint sobol_pascal(lanes_uint x) {
    x ^= (x >> 1) & 0x55555555u;
    x ^= (x >> 2) & 0x33333333u;
    x ^= (x >> 4) & 0x0f0f0f0fu;
    x ^= (x >> 8) & 0x00ff00ffu;
    return x ^ (x >> 16);
}

// The points `index` of the sequence scrambled by `seed` (one seed a pixel), one a lane: four numbers in [0,1) each. No
// index has bits above those of `most`.
IR_FN void sobol4_at(lanes_uint index, uint most, uint seed, lanes* x) {
    lanes_uint r = index ^ index;
    for (uint b = 0; most != 0u; ++b, most >>= 1) r ^= sobol_r[b] & (0u - ((index >> b) & 1u));
    x[0] = scrambled_number(index, seed);
    x[1] = scrambled_number(sobol_pascal(index), seed + 0x9e3779b9u);
    x[2] = scrambled_number(r, seed + 0x3c6ef372u);
    x[3] = scrambled_number(sobol_pascal(r), seed + 0xdaa66d2bu);
}

// Points first, first + 1, ...
IR_FN void sobol4_lanes(uint first, uint seed, lanes* x) {
    sobol4_at(first + lanes_numbers(), first + IR_LANES - 1u, seed, x);
}

// Point `index`.
IR_FN void sobol4(uint index, uint seed, real* x) {
    lanes all[4];
    sobol4_lanes(index, seed, all);
    for (uint i = 0; i < 4u; ++i) x[i] = lanes_first(all[i]);
}

// sobol4_lanes() in another order of the points (Burley 2020): what is drawn by it has dimensions of its own.
IR_FN void sobol4_shuffled(uint first, uint seed, lanes* x) {
    const lanes_uint index = reverse_bits(first + lanes_numbers());
    const lanes_uint other = reverse_bits(owen_scramble_reversed(index, (lanes_uint)(hash_uint(~seed))));
    sobol4_at(other, 0xffffffffu, hash_uint(seed ^ 0x62736466u), x);
}
#endif
