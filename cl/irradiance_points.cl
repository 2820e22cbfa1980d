// Irradiance at points that no camera ray found: which of them want a record, and what they are answered.
#include "cache.h"
#include "film.h"
#include "path.h"
#include "shading_point.h"
#include "sobol.h"

// points[indices[i]], i < count, that have records enough are marked IR_POINT_NONE.
IR_KERNEL void find_point_misses(IR_CACHE_ARGS, IR_GLOBAL ShadingPoint* points, IR_GLOBAL const uint* indices, uint count) {
    if (IR_GLOBAL_ID >= count) return;
    IR_CACHE_INIT(cache);
    const uint i = indices[IR_GLOBAL_ID];
    const ShadingPoint q = points[i];
    if (cache_covers(&cache, make_real3(q.px, q.py, q.pz), make_real3(q.nx, q.ny, q.nz), 0u, IR_INFINITY))
        points[i].state = IR_POINT_NONE;
}

// The point as a white diffuse surface: it reflects 1 / pi of its irradiance.
IR_FN Surface white_surface(const SceneData* s, const ShadingPoint* q) {
    Surface f;
    f.p = make_real3(q->px, q->py, q->pz);
    f.ng = f.ns = make_real3(q->nx, q->ny, q->nz);
    f.albedo = make_real3(1.0f, 1.0f, 1.0f);
    f.light = IR_NO_LIGHT;
    f.emits = false;
    f.error = q->offset;
    f.primitive = IR_NO_PRIMITIVE;
#if IR_FEATURES & (IR_FEATURE_BSDFS | IR_FEATURE_BUMPS)
    f.view = f.ns;
#endif
#if IR_FEATURES & IR_FEATURE_BSDFS
    f.material = s->materials;
    f.material_index = 0u;
    f.kind = IR_MATERIAL_DIFFUSE;
    f.flags = 0u;
    f.alpha_u = f.alpha_v = f.through = 1.0f;
#endif
#if IR_FEATURES & IR_FEATURE_BUMPS
    f.base = f.ns;
    f.bumped = false;
#endif
    return f;
}

// answers[6 i ...]: sums of `samples` samples' direct irradiance, and the cache's indirect one (-1: no record).
IR_KERNEL void point_irradiance(IR_SCENE_ARGS, IR_CACHE_ARGS, IR_GLOBAL const ShadingPoint* points, IR_GLOBAL float* answers,
                                IR_GLOBAL uint* ray_counts, uint count, uint first_sample, uint samples, uint direct,
                                uint seed) {
    const uint i = IR_GLOBAL_ID;
    if (i >= count) return;
    IR_SCENE_INIT(s);
    IR_CACHE_INIT(cache);
    const ShadingPoint q = points[i];
    const Surface f = white_surface(&s, &q);
    RayCount rays;
    rays.bounce = rays.shadow = 0u;
    real3 sum = make_real3(0.0f, 0.0f, 0.0f);
    for (uint k = 0; direct && k < samples; ++k) {
        float u[4];
        sobol4(first_sample + k, hash_uint(q.pixel ^ hash_uint(seed)), u);  // its own, wherever it lies in the list
        sum += next_event(&s, &f, u[2], u[3], true, &rays) * IR_PI;
    }
    real3 e;
    if (!cache_lookup(&cache, f.p, f.ns, 0u, &e)) e = make_real3(-1.0f, -1.0f, -1.0f);
    answers[6u * i] = sum.x;
    answers[6u * i + 1u] = sum.y;
    answers[6u * i + 2u] = sum.z;
    answers[6u * i + 3u] = e.x;
    answers[6u * i + 4u] = e.y;
    answers[6u * i + 5u] = e.z;
    count_up(ray_counts, IR_RAYS_SHADOW, rays.shadow);
}
