// Packed entries of the octree, eight at a time: included by packed.h on CPU devices.
#ifndef IR_PACKED_CPU_H
#define IR_PACKED_CPU_H

// Which of the eight entries from `entry` on answer yes, a byte each (0 or 1), lowest first.
IR_FN ulong packed_test(IR_GLOBAL const uint* entry, const PackedQuery* q, const NodeQuery* s) {
    const uint16 a = vload16(0, entry), b = vload16(1, entry);
    const uint8 w0 = (uint8)(a.s048c, b.s048c), w1 = (uint8)(a.s159d, b.s159d), w2 = (uint8)(a.s26ae, b.s26ae);
    const lanes dx = convert_float8(as_int8(w0 & 0xffffu)) - s->p.x, dy = convert_float8(as_int8(w0 >> 16)) - s->p.y;
    const lanes dz = convert_float8(as_int8(w1 & 0xffffu)) - s->p.z, support = convert_float8(as_int8(w1 >> 16));
    const lanes reach = max(support * q->share + s->more, s->least);
    const lanes cosine = convert_float8(as_int8(w2 << 24) >> 24) * q->n.x +
                         convert_float8(as_int8(w2 << 16) >> 24) * q->n.y +
                         convert_float8(as_int8(w2 << 8) >> 24) * q->n.z;
    const int8 near = (dx * dx + dy * dy + dz * dz < reach * reach) | (support == 65535.0f);
    const int8 yes = near & (cosine > q->cosine) & (((w2 ^ q->coat) & q->coat_mask) == 0u);
    return as_ulong(convert_char8(yes)) & 0x0101010101010101ul;
}

// The number of the lowest entry that answers yes: trailing zeros, in the form that compilers know as such.
IR_FN uint packed_first(ulong yes) { return (uint)popcount(~yes & (yes - 1ul)) >> 3; }
#endif
