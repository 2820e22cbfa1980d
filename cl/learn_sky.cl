// Where the sky is seen from: every work-item follows a path from the camera over surfaces, in directions as likely as
// irradiance counts them, until it leaves the scene. What it tells is where that was, and through which tile of the picture.
#include "camera.h"
#include "film.h"
#include "path.h"

#define IR_SKY_VERTICES 4u  // a path that has not left the scene then tells nothing

// A ray from surface f, cosine-distributed.
IR_FN Hit diffuse_ray(const SceneData* s, const Surface* f, Rng* rng, real3* origin, real3* w) {
    const float u = rng_real(rng), v = rng_real(rng);
    *w = to_world(make_frame(f->ns), cosine_direction(u, v));
    *origin = leave_surface(f, *w);
    return trace_visible(s, *origin, *w, 0.0f, IR_INFINITY, rng);
}

// The index-th of all_paths: the words of its event.
IR_ONCE_FN void sky_path(const SceneData* s, const GridParameters* grid, IR_GLOBAL uint* ray_counts, uint index,
                         uint all_paths, uint seed, uint* event) {
    for (uint i = 0; i < IR_SKY_EVENT_WORDS; ++i) event[i] = 0u;
#if IR_FEATURES & IR_FEATURE_ENVMAP
    Rng rng = rng_make(seed ^ 0x736b7976u, index, 0u);
    const CameraRay ray = camera_ray_of_part(s->info, index, all_paths, &rng);
    real3 origin = camera_origin(s->info), w = ray.direction;
    Hit hit = trace_visible(s, origin, w, ray.t_min, ray.t_max, &rng);
    while (hit.primitive != IR_NO_PRIMITIVE && event[2] < IR_SKY_VERTICES) {
        const Surface f = surface_at(s, origin, w, &hit);
        if (!reflects(&f) || is_specular(&f)) break;
        hit = diffuse_ray(s, &f, &rng, &origin, &w);
        ++event[2];
        if (hit.primitive != IR_NO_PRIMITIVE) continue;
        const Light map = s->lights[s->info->environment_light];
        const Texture picture = s->textures[map.texture];
        const PicturePoint at = picture_point(&map, &picture, w);
        event[0] = grid_key(grid, 0u, f.p, f.ns);
        event[1] = sky_tile(&picture, at.column, at.row);
    }
    count_up(ray_counts, IR_RAYS_CAMERA, 1u);
    count_up(ray_counts, IR_RAYS_BOUNCE, event[2]);
#endif
}

IR_KERNEL void learn_sky(IR_SCENE_ARGS, GridParameters grid, IR_GLOBAL uint* events, IR_GLOBAL uint* ray_counts,
                         uint first_path, uint path_count, uint all_paths, uint seed) {
    if (IR_GLOBAL_ID >= path_count) return;
    IR_SCENE_INIT(s);
    uint event[IR_SKY_EVENT_WORDS];
    sky_path(&s, &grid, ray_counts, first_path + IR_GLOBAL_ID, all_paths, seed, event);
    for (uint i = 0; i < IR_SKY_EVENT_WORDS; ++i) events[IR_SKY_EVENT_WORDS * IR_GLOBAL_ID + i] = event[i];
}
