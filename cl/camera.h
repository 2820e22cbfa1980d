// Camera rays, with the reconstruction filter sampled in proportion to its weight: every sample then has weight one, no
// sample is splatted, and a pixel's estimate depends on that pixel alone.
#ifndef IR_CAMERA_H
#define IR_CAMERA_H
#include "filter.h"
#include "random.h"
#include "scene.h"

typedef struct CameraRay {
    real3 direction;     // unit
    float t_min, t_max;  // clip planes, along this ray
} CameraRay;

// Offset from the pixel's centre for u in [0,1); the filter is cut off at the picture's border [lo, hi] (as Mitsuba's
// film without border samples).
IR_FN lanes filter_offset(const IR_GLOBAL SceneInfo* info, lanes u, float lo, float hi) {
    const float radius = info->rfilter_radius;
    if (info->rfilter == IR_RFILTER_TENT) {
        const float a = tent_distribution(lo, radius), b = tent_distribution(hi, radius);
        return tent_quantile(a + u * (b - a), radius);
    }
    if (info->rfilter == IR_RFILTER_GAUSSIAN) {
        const float a = lo > -radius ? gaussian_distribution(lo, info->rfilter_stddev, radius) : 0.0f;
        const float b = hi < radius ? gaussian_distribution(hi, info->rfilter_stddev, radius) : 1.0f;
        return gaussian_quantile(a + u * (b - a), info->rfilter_stddev);
    }
    const float a = max(lo, -radius), b = min(hi, radius);
    return a + u * (b - a);
}

// Film positions, along one axis, of numbers u in [0, 1) of pixel p of `size`.
IR_FN lanes film_positions(const IR_GLOBAL SceneInfo* info, uint p, uint size, lanes u) {
    const float centre = (float)p + 0.5f;
    return centre + filter_offset(info, u, -centre, (float)size - centre);
}
IR_FN float film_position(const IR_GLOBAL SceneInfo* info, uint p, uint size, float u) {
    return lanes_first(film_positions(info, p, size, lanes_of(u)));
}

// Rays through the film positions (fx, fy) in pixels.
typedef struct CameraRays {
    LaneVector direction;  // unit
    lanes t_min, t_max;
} CameraRays;

IR_FN CameraRays camera_rays_at(const IR_GLOBAL SceneInfo* info, lanes fx, lanes fy) {
    const IR_GLOBAL Camera* c = &info->camera;
    const lanes x = fx / (float)info->width, y = fy / (float)info->height;
    CameraRays rays;
    rays.direction = make_lane_vector(c->cornerx + x * c->dxx + y * c->dyx, c->cornery + x * c->dxy + y * c->dyy,
                                      c->cornerz + x * c->dxz + y * c->dyz);
    rays.direction = lanes_scaled(rays.direction, rsqrt(lanes_dot(rays.direction, rays.direction)));
    const lanes cosine = max(lanes_dot3(rays.direction, make_real3(c->forwardx, c->forwardy, c->forwardz)), 1e-6f);
    rays.t_min = c->near_clip / cosine;
    rays.t_max = c->far_clip / cosine;
    return rays;
}

IR_FN CameraRay camera_ray_at(const IR_GLOBAL SceneInfo* info, float fx, float fy) {
    const CameraRays rays = camera_rays_at(info, lanes_of(fx), lanes_of(fy));
    CameraRay ray;
    ray.direction =
        make_real3(lanes_first(rays.direction.x), lanes_first(rays.direction.y), lanes_first(rays.direction.z));
    ray.t_min = lanes_first(rays.t_min);
    ray.t_max = lanes_first(rays.t_max);
    return ray;
}

IR_FN CameraRay camera_ray(const IR_GLOBAL SceneInfo* info, uint px, uint py, float u, float v) {
    return camera_ray_at(info, film_position(info, px, info->width, u), film_position(info, py, info->height, v));
}

IR_FN real3 camera_origin(const IR_GLOBAL SceneInfo* info) {
    return make_real3(info->camera.ox, info->camera.oy, info->camera.oz);
}

// The index-th of `all` rays that are spread over the picture: through the pixel in which the index-th of so many equal
// parts of it begins.
IR_FN CameraRay camera_ray_of_part(const IR_GLOBAL SceneInfo* info, uint index, uint all, Rng* rng) {
    const uint pixels = info->width * info->height;
    const uint pixel = min((uint)(((float)index + rng_real(rng)) / (float)all * (float)pixels), pixels - 1u);
    const float fx = (float)(pixel % info->width) + rng_real(rng), fy = (float)(pixel / info->width) + rng_real(rng);
    return camera_ray_at(info, fx, fy);
}

#if IR_FEATURES & IR_FEATURE_THIN_LENS
// Uniform on the unit disk, by concentric squares: Shirley and Chiu, "A low distortion map between disk and square",
// Journal of Graphics Tools 2(3), 1997. Strata of the square stay compact.
IR_FN void concentric_disk(float u, float v, float* x, float* y) {
    const float a = 2.0f * u - 1.0f, b = 2.0f * v - 1.0f;
    const bool upright = fabs(a) < fabs(b);
    const float r = upright ? b : a;
    if (r == 0.0f) {
        *x = *y = 0.0f;
        return;
    }
    const float angle = 0.25f * IR_PI * (upright ? a : b) / r;
    float s, c;
    real_sincos(angle, &s, &c);
    *x = r * (upright ? s : c);
    *y = r * (upright ? c : s);
}

// Ray through a film position as camera_ray()'s, from the point (lens_u, lens_v) of the lens through the point of the
// plane in focus that the pinhole's ray meets. The lens lies in the plane of the film's axes, which are perpendicular.
IR_FN CameraRay lens_ray_at(const IR_GLOBAL SceneInfo* info, float fx, float fy, float lens_u, float lens_v,
                            real3* origin) {
    const IR_GLOBAL Camera* c = &info->camera;
    const float film_x = fx / (float)info->width, film_y = fy / (float)info->height;
    const real3 dx = make_real3(c->dxx, c->dxy, c->dxz), dy = make_real3(c->dyx, c->dyy, c->dyz);
    const real3 film = make_real3(c->cornerx, c->cornery, c->cornerz) + film_x * dx + film_y * dy;  // at unit depth
    float x, y;
    concentric_disk(lens_u, lens_v, &x, &y);
    // The camera's x axis runs to the left and its y axis up: against the film's.
    const real3 offset = -c->aperture_radius * (x * normalize(dx) + y * normalize(dy));
    *origin = make_real3(c->ox, c->oy, c->oz) + offset;
    CameraRay ray;
    ray.direction = normalize((c->aperture_radius > 0.0f ? c->focus_distance : 1.0f) * film - offset);  // or a pinhole
    const float cosine = max(dot(ray.direction, make_real3(c->forwardx, c->forwardy, c->forwardz)), 1e-6f);
    ray.t_min = c->near_clip / cosine;
    ray.t_max = c->far_clip / cosine;
    return ray;
}

IR_FN CameraRay lens_ray(const IR_GLOBAL SceneInfo* info, uint px, uint py, float u, float v, float lens_u,
                         float lens_v, real3* origin) {
    return lens_ray_at(info, film_position(info, px, info->width, u), film_position(info, py, info->height, v),
                       lens_u, lens_v, origin);
}
#endif
#endif
