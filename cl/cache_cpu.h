// Weights of eight records at once, on CPU devices: included by cache.h after record_weight, whose results these are, bit for
// bit (a test asks both).
#ifndef IR_CACHE_CPU_H
#define IR_CACHE_CPU_H

// The i-th quarters of eight keys, four floats each, as four vectors.
typedef struct KeyQuarter {
    lanes a, b, c, d;
} KeyQuarter;

IR_FN KeyQuarter key_quarter(IR_GLOBAL const RecordKey* keys, const uint* records, uint quarter) {
    IR_GLOBAL const float* k = (IR_GLOBAL const float*)keys + 4u * quarter;
    const lanes r0 = (lanes)(vload4(0, k + 12u * (size_t)records[0]), vload4(0, k + 12u * (size_t)records[4]));
    const lanes r1 = (lanes)(vload4(0, k + 12u * (size_t)records[1]), vload4(0, k + 12u * (size_t)records[5]));
    const lanes r2 = (lanes)(vload4(0, k + 12u * (size_t)records[2]), vload4(0, k + 12u * (size_t)records[6]));
    const lanes r3 = (lanes)(vload4(0, k + 12u * (size_t)records[3]), vload4(0, k + 12u * (size_t)records[7]));
    KeyQuarter q;
    q.a = (lanes)(r0.s0, r1.s0, r2.s0, r3.s0, r0.s4, r1.s4, r2.s4, r3.s4);
    q.b = (lanes)(r0.s1, r1.s1, r2.s1, r3.s1, r0.s5, r1.s5, r2.s5, r3.s5);
    q.c = (lanes)(r0.s2, r1.s2, r2.s2, r3.s2, r0.s6, r1.s6, r2.s6, r3.s6);
    q.d = (lanes)(r0.s3, r1.s3, r2.s3, r3.s3, r0.s7, r1.s7, r2.s7, r3.s7);
    return q;
}

// As dot() rounds, which the compiler is not to fuse.
IR_FN lanes lanes_dot_rounded(LaneVector a, LaneVector b) {
#pragma OPENCL FP_CONTRACT OFF
    const lanes x = a.x * b.x, y = a.y * b.y, z = a.z * b.z, xy = x + y;
    return xy + z;
}

// Weights of records[0] to records[7]. Products and sums are fused where the compiler fuses those of record_weight.
IR_FN lanes record_weights(const CacheParameters* c, IR_GLOBAL const RecordKey* keys, const uint* records, real3 p, real3 n,
                           uint coat) {
#pragma OPENCL FP_CONTRACT OFF
    const KeyQuarter place = key_quarter(keys, records, 0u), facing = key_quarter(keys, records, 1u),
                     axis = key_quarter(keys, records, 2u);
    const LaneVector delta = make_lane_vector(p.x - place.a, p.y - place.b, p.z - place.c);
    const lanes along = lanes_dot_rounded(delta, make_lane_vector(axis.a, axis.b, axis.c));
    const lanes square = lanes_dot_rounded(delta, delta), across2 = max(fma(-along, along, square), 0.0f);
    const lanes distance =
        sqrt(across2 / (place.d * place.d) + along * along / (facing.d * facing.d)) * c->stretch;
    const LaneVector turn = make_lane_vector(n.x - facing.a, n.y - facing.b, n.z - facing.c);
    const lanes angle = 0.70710678118654752440f * sqrt(lanes_dot_rounded(turn, turn)) * c->inverse_angle * c->stretch;
#if IR_WEIGHT == 1
    const lanes w = 1.0f - max(distance, angle);
#elif IR_WEIGHT == 2
    const lanes x = distance + angle, y = max(1.0f - x, 0.0f), w = y * y * fma((lanes)(2.0f), x, (lanes)(1.0f));
#else
    const lanes x = distance + angle, w = lanes_select(0.0f, (1.0f - x) / max(x, 0.01f), x < 1.0f);
#endif
    lanes_mask applies = (as_int8(axis.d) == (int)coat) & (distance < 1.0f) & (w > 0.0f);
    if (c->in_front > 0.0f) {
        const LaneVector both = make_lane_vector(n.x + facing.a, n.y + facing.b, n.z + facing.c);
        const lanes height = 0.5f * lanes_dot_rounded(delta, both), apart = sqrt(square);
        const lanes cosine = lanes_dot_rounded(make_lane_vector((lanes)(n.x), (lanes)(n.y), (lanes)(n.z)),
                                               make_lane_vector(facing.a, facing.b, facing.c));
        const lanes tolerance =
            fma((lanes)(c->in_front), apart, (lanes)(4.76837158203125e-7f * c->coordinate));
        applies &= ~((height < -tolerance) | ((cosine > 0.95f) & (height > 0.3f * apart)));
    }
    return lanes_select(0.0f, w, applies);
}
#endif
