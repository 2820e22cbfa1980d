// Kernels of device_test.cpp and threads_test.cpp.
#include "portable.h"

#ifdef BREAK
IR_KERNEL void broken(IR_GLOBAL uint* out) {
    // an unknown name:
    // (device_test.cpp knows that it stands in line 8)
    out[0] = no_such_variable;
}
#endif

#ifndef BINS
#define BINS 1u
#endif
#ifndef VALUE
#define VALUE 0u
#endif

// Sums one value per work-item over its work-group.
IR_KERNEL void sum_groups(IR_GLOBAL const uint* in, IR_GLOBAL uint* out, IR_LOCAL uint* part) {
    const uint i = IR_LOCAL_ID;
    part[i] = in[IR_GLOBAL_ID];
    IR_BARRIER();
    for (uint n = IR_LOCAL_SIZE / 2u; n > 0u; n /= 2u) {
        if (i < n) part[i] += part[i + n];
        IR_BARRIER();
    }
    if (i == 0u) out[IR_GROUP_ID] = part[0];
}

IR_KERNEL void histogram(IR_GLOBAL uint* counts, IR_GLOBAL uint* extremes, uint shift) {
    const uint i = IR_GLOBAL_ID;
    IR_ATOMIC_ADD(&counts[i % BINS], 1u);
    IR_ATOMIC_MIN(&extremes[0], i + shift);
    IR_ATOMIC_MAX(&extremes[1], i + shift);
}

IR_KERNEL void write_value(IR_GLOBAL uint* out) { out[0] = VALUE; }

IR_KERNEL void write_traversal(IR_GLOBAL uint* out) {
#ifdef IR_CPU
    out[0] = 1u;
#else
    out[0] = 0u;
#endif
}

// Keeps a thread busy: `rounds` dependent steps an item.
IR_KERNEL void spin(IR_GLOBAL uint* out, uint rounds) {
    uint x = IR_GLOBAL_ID * 2654435761u + 1u;
    for (uint i = 0; i < rounds; ++i) {
        x ^= x << 13;
        x ^= x >> 17;
        x ^= x << 5;
    }
    out[IR_GLOBAL_ID] = x;
}

// How often each item comes, and whether its numbers fit together; `rounds` steps each, so that launches overlap. (The
// last term is 0, which the compiler does not know: so it keeps the steps.)
IR_KERNEL void visit(IR_GLOBAL uint* visits, IR_GLOBAL uint* places, uint rounds) {
    uint x = IR_GLOBAL_ID + 1u;
    for (uint i = 0; i < rounds; ++i) x = x * 1664525u + 1013904223u;
    IR_ATOMIC_ADD(&visits[IR_GLOBAL_ID], 1u);
    places[IR_GLOBAL_ID] = IR_GROUP_ID * IR_LOCAL_SIZE + IR_LOCAL_ID + (x == rounds && rounds > 1000000u ? 1u : 0u);
}
