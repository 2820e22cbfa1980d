// Packets of 16 rays on the BVH8 of CPU devices: included by trace_cpu.h, after the tests of single rays. Either all
// rays share an origin (closest hits: trace_tile), or each has its own (any hits: trace_tile_occluded).
#ifndef IR_TRACE_PACKET_H
#define IR_TRACE_PACKET_H

#define IR_PACKET_MIN_NODE 7  // with fewer active rays a node is left to single rays, which was measured to be faster;
#define IR_PACKET_MIN_LEAF 2  // a leaf pays sooner

IR_FN float largest16(float16 a) {
    // oclgrind 21.10 takes a float16's .hi for uninitialised; compilers make the same of both.
    const float8 b = max(a.lo, (float8)(a.s8, a.s9, a.sa, a.sb, a.sc, a.sd, a.se, a.sf));
    const float4 c = max(b.lo, b.hi);
    const float2 d = max(c.lo, c.hi);
    return max(d.x, d.y);
}

typedef struct Lanes16 {
    ulong lo, hi;  // as lanes8()
} Lanes16;

IR_FN Lanes16 lanes16(int16 m) {
    const ulong2 both = as_ulong2(convert_char16(m));
    Lanes16 l;
    l.lo = both.x & 0x0101010101010101ul;
    l.hi = both.y & 0x0101010101010101ul;
    return l;
}
IR_FN uint lane_count(Lanes16 l) { return (uint)(popcount(l.lo) + popcount(l.hi)); }

// Bounds of the parameters at which any ray of a packet enters and leaves a slab: for t >= 0,
// enter >= max(lo a, hi b), leave <= hi c + lo d + e, with lo and hi relative to the largest and the smallest origin.
typedef struct SlabBound {
    float a, b, c, d, e;
} SlabBound;

IR_FN SlabBound make_slab_bound(float16 direction) {
    const float most = largest16(direction), least = -largest16(-direction);
    SlabBound s;
    s.a = most > 0.0f ? safe_reciprocal(most) : 0.0f;
    s.b = least < 0.0f ? safe_reciprocal(least) : 0.0f;
    s.c = least > 0.0f ? safe_reciprocal(least) : 0.0f;
    s.d = most < 0.0f ? safe_reciprocal(most) : 0.0f;
    s.e = least <= 0.0f && most >= 0.0f ? IR_INFINITY : 0.0f;  // some ray stays within the slab
    return s;
}
IR_FN float8 bound_enter(SlabBound s, float8 lo, float8 hi) { return max(lo * s.a, hi * s.b); }
IR_FN float8 bound_leave(SlabBound s, float8 lo, float8 hi) { return fma(hi, s.c, fma(lo, s.d, s.e)); }

typedef struct Packet {
    // Vectors and arrays of 16 first: each is one aligned cache line.
    float16 dx, dy, dz;         // directions
    float16 rx, ry, rz;         // their reciprocals
    float x[16], y[16], z[16];  // the directions once more
    float t[16], u[16], v[16];  // closest hits so far; t of an unused lane is negative
    uint primitive[16];
    float own_x[16], own_y[16], own_z[16];  // origins, if not shared
    real3 origin;                           // of all rays, or of the first one
    // Rays with origins of their own only: the origins relative to `origin`, that times the reciprocal directions, and
    // -2 (origin x direction).
    float16 ox, oy, oz, orx, ory, orz, mx, my, mz;
    real3 least, most;  // bounds of the origins
    float spread;       // largest coordinate of the relative origins
    float t_min;
    float t_far;     // the largest t of all lanes
    float rounding;  // 2^-20 of the largest |d|_1
    SlabBound bound_x, bound_y, bound_z;
    uint made;  // bit i: single[i] is made
    SingleRay single[16];
} Packet;

// Embree's Pluecker test with all that the rays share taken out: edge functions are dot products of the direction with
// the normals of the planes through the origin and an edge. They are exact negatives of each other in neighbouring
// triangles, but at a vertex rounding may put a ray outside of all of its edges. So an edge function may fall short of
// zero by its rounding error, at most 8 roundings of 2^-24 of |d|_1 |e|_1 |s|_inf (edge e, sum of its ends s): at a
// distance of 1 the triangle reaches out by a millionth. Edge functions are divided by |e|_1, so that the short edge of
// a sliver reaches out no farther than its long ones. For rays with origins o of their own (not `shared`), relative to
// the packet's, s becomes s - 2 o, which adds e . (-2 o x d) to an edge function.
IR_FN void packet_block(IR_GLOBAL const TriangleBlock* block, uint count, Packet* p, const bool shared,
                        const bool any) {
    const float8 ax = vload8(0, block->v0x) - p->origin.x;
    const float8 ay = vload8(0, block->v0y) - p->origin.y;
    const float8 az = vload8(0, block->v0z) - p->origin.z;
    const float8 bx = vload8(0, block->v1x) - p->origin.x;
    const float8 by = vload8(0, block->v1y) - p->origin.y;
    const float8 bz = vload8(0, block->v1z) - p->origin.z;
    const float8 cx = vload8(0, block->v2x) - p->origin.x;
    const float8 cy = vload8(0, block->v2y) - p->origin.y;
    const float8 cz = vload8(0, block->v2z) - p->origin.z;
    float planes[14][8], scales[3][8] __attribute__((aligned(32)));
    float edge[9][8] __attribute__((aligned(32)));
    float8 ex = cx - ax, ey = cy - ay, ez = cz - az;  // edge v0 v2: weight of v1
    const float8 e_size = fabs(ex) + fabs(ey) + fabs(ez), e_scale = 1.0f / e_size;
    if (!shared)
        vstore8(ex * e_scale, 0, edge[0]), vstore8(ey * e_scale, 0, edge[1]), vstore8(ez * e_scale, 0, edge[2]);
    float8 sx = cx + ax, sy = cy + ay, sz = cz + az;
    vstore8(fma(ey, sz, -(ez * sy)) * e_scale, 0, planes[0]);
    vstore8(fma(ez, sx, -(ex * sz)) * e_scale, 0, planes[1]);
    vstore8(fma(ex, sy, -(ey * sx)) * e_scale, 0, planes[2]);
    vstore8(e_size, 0, scales[0]);
    const float8 fx = ax - bx, fy = ay - by, fz = az - bz;  // edge v1 v0: weight of v2
    const float8 f_size = fabs(fx) + fabs(fy) + fabs(fz), f_scale = 1.0f / f_size;
    if (!shared)
        vstore8(fx * f_scale, 0, edge[3]), vstore8(fy * f_scale, 0, edge[4]), vstore8(fz * f_scale, 0, edge[5]);
    sx = ax + bx, sy = ay + by, sz = az + bz;
    vstore8(fma(fy, sz, -(fz * sy)) * f_scale, 0, planes[3]);
    vstore8(fma(fz, sx, -(fx * sz)) * f_scale, 0, planes[4]);
    vstore8(fma(fx, sy, -(fy * sx)) * f_scale, 0, planes[5]);
    vstore8(f_size, 0, scales[1]);
    const float8 nx = fma(ey, fz, -(ez * fy)), ny = fma(ez, fx, -(ex * fz)), nz = fma(ex, fy, -(ey * fx));
    vstore8(nx, 0, planes[9]);
    vstore8(ny, 0, planes[10]);
    vstore8(nz, 0, planes[11]);
    vstore8(fma(nx, ax, fma(ny, ay, nz * az)), 0, planes[12]);
    float8 reach = max(max(fabs(ax), fabs(ay)), fabs(az)) + e_size + f_size;  // |s|_inf / 2 at most
    if (!shared) reach += p->spread;
    vstore8(reach * p->rounding, 0, planes[13]);
    ex = bx - cx, ey = by - cy, ez = bz - cz;  // edge v2 v1: weight of v0
    const float8 g_size = fabs(ex) + fabs(ey) + fabs(ez), g_scale = 1.0f / g_size;
    if (!shared)
        vstore8(ex * g_scale, 0, edge[6]), vstore8(ey * g_scale, 0, edge[7]), vstore8(ez * g_scale, 0, edge[8]);
    sx = bx + cx, sy = by + cy, sz = bz + cz;
    vstore8(fma(ey, sz, -(ez * sy)) * g_scale, 0, planes[6]);
    vstore8(fma(ez, sx, -(ex * sz)) * g_scale, 0, planes[7]);
    vstore8(fma(ex, sy, -(ey * sx)) * g_scale, 0, planes[8]);
    vstore8(g_size, 0, scales[2]);
    bool changed = false;
    for (uint i = 0; i < count; ++i) {
        float16 u = fma(p->dx, planes[0][i], fma(p->dy, planes[1][i], p->dz * planes[2][i]));
        float16 v = fma(p->dx, planes[3][i], fma(p->dy, planes[4][i], p->dz * planes[5][i]));
        float16 w = fma(p->dx, planes[6][i], fma(p->dy, planes[7][i], p->dz * planes[8][i]));
        if (!shared) {
            u = fma(p->mx, edge[0][i], fma(p->my, edge[1][i], fma(p->mz, edge[2][i], u)));
            v = fma(p->mx, edge[3][i], fma(p->my, edge[4][i], fma(p->mz, edge[5][i], v)));
            w = fma(p->mx, edge[6][i], fma(p->my, edge[7][i], fma(p->mz, edge[8][i], w)));
        }
        const float slack = planes[13][i];
        const int16 inside = (min(min(u, v), w) >= -slack) | (max(max(u, v), w) <= slack);
        const Lanes16 lanes = lanes16(inside);
        if ((lanes.lo | lanes.hi) == 0) continue;
        float16 height = planes[12][i];
        if (!shared) height -= fma(p->ox, planes[9][i], fma(p->oy, planes[10][i], p->oz * planes[11][i]));
        const float16 t = height / fma(p->dx, planes[9][i], fma(p->dy, planes[10][i], p->dz * planes[11][i]));
        const float16 t_max = vload16(0, p->t);
        const int16 hit = inside & (t > p->t_min) & (t < t_max);  // parallel or degenerate: infinite or NaN, no hit
        const Lanes16 hit_lanes = lanes16(hit);
        if ((hit_lanes.lo | hit_lanes.hi) == 0) continue;
        if (any) {
            vstore16(select(t_max, (float16)(-IR_INFINITY), hit), 0, p->t);  // done with these
        } else {
            u *= scales[0][i], v *= scales[1][i], w *= scales[2][i];
            const float16 sum = u + v + w, scale = select(1.0f / sum, (float16)(0.0f), sum == 0.0f);
            const float16 b1 = min(max(u * scale, 0.0f), 1.0f), b2 = min(max(v * scale, 0.0f), 1.0f - b1);
            vstore16(select(t_max, t, hit), 0, p->t);
            vstore16(select(vload16(0, p->u), b1, hit), 0, p->u);
            vstore16(select(vload16(0, p->v), b2, hit), 0, p->v);
        }
        vstore16(select(vload16(0, p->primitive), (uint16)(block->primitive[i]), hit), 0, p->primitive);
        changed = true;
    }
    if (changed) p->t_far = largest16(vload16(0, p->t));
}

// The rays of `lanes` one by one from `reference` on.
IR_FN void packet_singles(const SceneData* s, uint reference, Lanes16 lanes, Packet* p, const bool shared,
                          const bool any) {
    bool changed = false;
    while (lanes.lo | lanes.hi) {
        uint i;
        if (lanes.lo) {
            i = first_lane(lanes.lo);
            lanes.lo &= lanes.lo - 1;
        } else {
            i = first_lane(lanes.hi) + 8;
            lanes.hi &= lanes.hi - 1;
        }
        if (p->t[i] <= p->t_min) continue;  // done since the lanes were found
        if (!(p->made >> i & 1)) {
            const real3 origin = shared ? p->origin : (real3)(p->own_x[i], p->own_y[i], p->own_z[i]);
            p->single[i] = make_single_ray(origin, (real3)(p->x[i], p->y[i], p->z[i]), p->t_min);
            p->made |= 1u << i;
        }
        Hit hit = make_miss(p->t[i]);
        trace_bvh8(s, p->single + i, reference, &hit, any);
        if (hit.primitive == IR_NO_PRIMITIVE) continue;
        p->t[i] = any ? -IR_INFINITY : hit.t;
        p->u[i] = hit.u;
        p->v[i] = hit.v;
        p->primitive[i] = hit.primitive;
        changed = true;
    }
    if (changed) p->t_far = largest16(vload16(0, p->t));
}

IR_FN void packet_bvh8(const SceneData* s, Packet* p, const bool shared, const bool any) {
    uint stack[IR_STACK_SIZE];
    float distance[IR_STACK_SIZE];
    Lanes16 active[IR_STACK_SIZE];
    int top = 0;
    uint reference = 0;
    while (true) {
        if (reference & IR_LEAF) {
            packet_block(s->leaves + IR_LEAF_FIRST(reference), IR_LEAF_COUNT(reference), p, shared, any);
        } else {
            IR_GLOBAL const Bvh8Node* node = s->nodes + reference;
            const float8 lx = vload8(0, node->lo_x) - p->origin.x, hx = vload8(0, node->hi_x) - p->origin.x;
            const float8 ly = vload8(0, node->lo_y) - p->origin.y, hy = vload8(0, node->hi_y) - p->origin.y;
            const float8 lz = vload8(0, node->lo_z) - p->origin.z, hz = vload8(0, node->hi_z) - p->origin.z;
            float8 blx = lx, bhx = hx, bly = ly, bhy = hy, blz = lz, bhz = hz;
            if (!shared) {
                blx = vload8(0, node->lo_x) - p->most.x, bhx = vload8(0, node->hi_x) - p->least.x;
                bly = vload8(0, node->lo_y) - p->most.y, bhy = vload8(0, node->hi_y) - p->least.y;
                blz = vload8(0, node->lo_z) - p->most.z, bhz = vload8(0, node->hi_z) - p->least.z;
            }
            const float8 first = max(max(bound_enter(p->bound_x, blx, bhx), bound_enter(p->bound_y, bly, bhy)),
                                     max(bound_enter(p->bound_z, blz, bhz), p->t_min));
            const float8 last = min(min(bound_leave(p->bound_x, blx, bhx), bound_leave(p->bound_y, bly, bhy)),
                                    min(bound_leave(p->bound_z, blz, bhz), p->t_far));
            ulong boxes = lanes8(first <= last);
            float x0[8] __attribute__((aligned(32))), x1[8] __attribute__((aligned(32)));
            float y0[8] __attribute__((aligned(32))), y1[8] __attribute__((aligned(32)));
            float z0[8] __attribute__((aligned(32))), z1[8] __attribute__((aligned(32)));
            float g[8] __attribute__((aligned(32)));
            vstore8(lx, 0, x0);
            vstore8(hx, 0, x1);
            vstore8(ly, 0, y0);
            vstore8(hy, 0, y1);
            vstore8(lz, 0, z0);
            vstore8(hz, 0, z1);
            vstore8(first, 0, g);
            const int bottom = top;
            const float16 t = vload16(0, p->t);
            for (; boxes; boxes &= boxes - 1) {
                const uint i = first_lane(boxes);
                float16 xa = x0[i] * p->rx, xb = x1[i] * p->rx;
                float16 ya = y0[i] * p->ry, yb = y1[i] * p->ry;
                float16 za = z0[i] * p->rz, zb = z1[i] * p->rz;
                if (!shared) {
                    xa -= p->orx, xb -= p->orx;
                    ya -= p->ory, yb -= p->ory;
                    za -= p->orz, zb -= p->orz;
                }
                const float16 enter = max(max(min(xa, xb), min(ya, yb)), max(min(za, zb), p->t_min));
                const float16 leave = min(min(max(xa, xb), max(ya, yb)), min(max(za, zb), t));
                const Lanes16 lanes = lanes16(enter <= leave);
                if ((lanes.lo | lanes.hi) == 0) continue;
                int k = top++;
                for (; !any && k > bottom && distance[k - 1] < g[i]; --k) {
                    distance[k] = distance[k - 1];
                    stack[k] = stack[k - 1];
                    active[k] = active[k - 1];
                }
                distance[k] = g[i];
                stack[k] = node->child[i];
                active[k] = lanes;
            }
        }
        while (true) {
            if (top == 0) return;
            --top;
            if (distance[top] >= p->t_far) continue;
            reference = stack[top];
            const uint count = lane_count(active[top]);
            if (!(reference & IR_LEAF) ? count >= IR_PACKET_MIN_NODE
                                       : count >= IR_PACKET_MIN_LEAF && !(reference & IR_LEAF_ANALYTIC))
                break;
            packet_singles(s, reference, active[top], p, shared, any);
        }
    }
}

// Directions and all that follows from them; origins are up to the caller. Unused lanes: copies of the first ray with
// an empty interval. `t_max`: 0, or `count` of them.
IR_FN void start_packet(Packet* p, const float* dx, const float* dy, const float* dz, uint count, float t_min,
                        const float* t_max) {
    for (uint i = 0; i < IR_TILE; ++i) {
        const uint k = i < count ? i : 0;
        p->x[i] = dx[k];
        p->y[i] = dy[k];
        p->z[i] = dz[k];
        p->t[i] = i < count ? (t_max ? t_max[k] : IR_INFINITY) : -IR_INFINITY;
    }
    p->dx = vload16(0, p->x);
    p->dy = vload16(0, p->y);
    p->dz = vload16(0, p->z);
    p->rx = safe_reciprocal16(p->dx);
    p->ry = safe_reciprocal16(p->dy);
    p->rz = safe_reciprocal16(p->dz);
    vstore16((float16)(0.0f), 0, p->u);
    vstore16((float16)(0.0f), 0, p->v);
    vstore16((uint16)(IR_NO_PRIMITIVE), 0, p->primitive);
    p->t_min = t_min;
    p->t_far = t_max ? largest16(vload16(0, p->t)) : IR_INFINITY;
    p->rounding = 0x1p-20f * largest16(fabs(p->dx) + fabs(p->dy) + fabs(p->dz));
    p->bound_x = make_slab_bound(p->dx);
    p->bound_y = make_slab_bound(p->dy);
    p->bound_z = make_slab_bound(p->dz);
    p->made = 0;
}

IR_FN void set_origins(Packet* p, const float* ox, const float* oy, const float* oz, uint count) {
    for (uint i = 0; i < IR_TILE; ++i) {
        const uint k = i < count ? i : 0;
        p->own_x[i] = ox[k];
        p->own_y[i] = oy[k];
        p->own_z[i] = oz[k];
    }
    const float16 x = vload16(0, p->own_x), y = vload16(0, p->own_y), z = vload16(0, p->own_z);
    p->origin = (real3)(p->own_x[0], p->own_y[0], p->own_z[0]);
    p->most = (real3)(largest16(x), largest16(y), largest16(z));
    p->least = (real3)(-largest16(-x), -largest16(-y), -largest16(-z));
    p->ox = x - p->origin.x;
    p->oy = y - p->origin.y;
    p->oz = z - p->origin.z;
    p->spread = largest16(max(max(fabs(p->ox), fabs(p->oy)), fabs(p->oz)));
    p->orx = p->ox * p->rx;
    p->ory = p->oy * p->ry;
    p->orz = p->oz * p->rz;
    p->mx = 2.0f * (p->oz * p->dy - p->oy * p->dz);
    p->my = 2.0f * (p->ox * p->dz - p->oz * p->dx);
    p->mz = 2.0f * (p->oy * p->dx - p->ox * p->dy);
}

IR_FN void copy_hits(const Packet* p, uint count, Hit* hits) {
    for (uint i = 0; i < count; ++i) {
        hits[i].t = p->t[i];
        hits[i].u = p->u[i];
        hits[i].v = p->v[i];
        hits[i].primitive = p->primitive[i];
    }
}

IR_TRACE_FN void trace_tile(const SceneData* s, real3 origin, const float* dx, const float* dy, const float* dz,
                            uint count, float t_min, Hit* hits) {
    Packet p;
    start_packet(&p, dx, dy, dz, count, t_min, 0);
    p.origin = origin;
    packet_bvh8(s, &p, true, false);
    copy_hits(&p, count, hits);
}

IR_TRACE_FN void trace_tile_occluded(const SceneData* s, const float* ox, const float* oy, const float* oz,
                                     const float* dx, const float* dy, const float* dz, uint count, float t_min,
                                     const float* t_max, uint* occluded) {
    Packet p;
    start_packet(&p, dx, dy, dz, count, t_min, t_max);
    set_origins(&p, ox, oy, oz, count);
    packet_bvh8(s, &p, false, true);
    *occluded = 0;
    for (uint i = 0; i < count; ++i) *occluded |= (p.primitive[i] != IR_NO_PRIMITIVE ? 1u : 0u) << i;
}
#endif
