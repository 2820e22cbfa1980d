// The first four dimensions of Sobol's sequence with Owen scrambling by hashing: Burley, "Practical hash-based Owen
// scrambling" (JCGT 2020), with Vegdahl's constants. Direction numbers: Joe and Kuo, stored bit-reversed.
#ifndef IR_SOBOL_H
#define IR_SOBOL_H
#include "lanes.h"
#include "random.h"

IR_CONSTANT uint sobol_directions[3][32] = {
    {0x00000001u, 0x00000003u, 0x00000005u, 0x0000000fu, 0x00000011u, 0x00000033u, 0x00000055u, 0x000000ffu,
     0x00000101u, 0x00000303u, 0x00000505u, 0x00000f0fu, 0x00001111u, 0x00003333u, 0x00005555u, 0x0000ffffu,
     0x00010001u, 0x00030003u, 0x00050005u, 0x000f000fu, 0x00110011u, 0x00330033u, 0x00550055u, 0x00ff00ffu,
     0x01010101u, 0x03030303u, 0x05050505u, 0x0f0f0f0fu, 0x11111111u, 0x33333333u, 0x55555555u, 0xffffffffu},
    {0x00000001u, 0x00000003u, 0x00000006u, 0x00000009u, 0x00000017u, 0x0000003au, 0x00000071u, 0x000000a3u,
     0x00000116u, 0x00000339u, 0x00000677u, 0x000009aau, 0x00001601u, 0x00003903u, 0x00007706u, 0x0000aa09u,
     0x00010117u, 0x0003033au, 0x00060671u, 0x000909a3u, 0x00171616u, 0x003a3939u, 0x00717777u, 0x00a3aaaau,
     0x01170001u, 0x033a0003u, 0x06710006u, 0x09a30009u, 0x16160017u, 0x3939003au, 0x77770071u, 0xaaaa00a3u},
    {0x00000001u, 0x00000003u, 0x00000004u, 0x0000000au, 0x0000001fu, 0x0000002eu, 0x00000045u, 0x000000c9u,
     0x0000011bu, 0x000002a4u, 0x0000079au, 0x00000b67u, 0x0000101eu, 0x0000302du, 0x00004041u, 0x0000a0c3u,
     0x0001f104u, 0x0002e28au, 0x000457dfu, 0x000c9baeu, 0x0011a105u, 0x002a7289u, 0x0079e7dbu, 0x00b6dba4u,
     0x0100011au, 0x030002a7u, 0x0400079eu, 0x0a000b6du, 0x1f001001u, 0x2e003003u, 0x45004004u, 0xc900a00au}};

// Nested uniform scramble of a bit-reversed number (Laine and Karras' hash).
IR_FN lanes_uint owen_scramble_reversed(lanes_uint x, uint seed) {
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

// One number of [0,1) (uint_to_unit) a lane.
IR_FN lanes scrambled_number(lanes_uint x, uint seed) {
    return lanes_of_uint(reverse_bits(owen_scramble_reversed(x, hash_uint(seed))) >> 8) * IR_UNIT;
}

// Points first, first + 1, ... of the sequence scrambled by `seed` (one seed a pixel), one a lane: four numbers in [0,1)
// each.
IR_FN void sobol4_lanes(uint first, uint seed, lanes* x) {
    const lanes_uint index = first + lanes_numbers();
    lanes_uint r1 = index ^ index, r2 = r1, r3 = r1;
    uint last = first + IR_LANES - 1u;
    for (uint b = 0; last != 0u; ++b, last >>= 1) {
        const lanes_uint mask = 0u - ((index >> b) & 1u);
        r1 ^= sobol_directions[0][b] & mask;
        r2 ^= sobol_directions[1][b] & mask;
        r3 ^= sobol_directions[2][b] & mask;
    }
    x[0] = scrambled_number(index, seed);
    x[1] = scrambled_number(r1, seed + 0x9e3779b9u);
    x[2] = scrambled_number(r2, seed + 0x3c6ef372u);
    x[3] = scrambled_number(r3, seed + 0xdaa66d2bu);
}

// The index of point `index` in another order of the same points (Burley 2020): what is drawn by it has dimensions of
// its own.
IR_FN uint sobol_shuffle(uint index, uint seed) {
    return lanes_first(reverse_bits(owen_scramble_reversed(reverse_bits((lanes_uint)(index)), hash_uint(~seed))));
}

// Point `index`.
IR_FN void sobol4(uint index, uint seed, real* x) {
    lanes all[4];
    sobol4_lanes(index, seed, all);
    for (uint i = 0; i < 4u; ++i) x[i] = lanes_first(all[i]);
}
#endif
