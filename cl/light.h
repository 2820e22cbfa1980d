// Next-event estimation: one light chosen by power, one point on it. Densities are per solid angle at the receiver and
// include the choice of the light, so that they can be weighed against a BSDF's density.
#ifndef IR_LIGHT_H
#define IR_LIGHT_H
#include "solid_angle.h"
#include "surface.h"

typedef struct LightSample {
    real3 direction;  // unit, towards the light
    float distance;   // to the light; IR_INFINITY for lights at infinity
    real3 radiance;   // arriving radiance divided by the density: W·m⁻²·sr⁻¹ / sr⁻¹
    float density;    // sr⁻¹; 0 for delta lights (which no BSDF sample can hit)
    float cosine;     // between the direction and the light's surface normal there; 1 where there is none
    bool valid;
} LightSample;

// Radiance that area light `light` emits at texture coordinates u, v.
IR_FN real3 area_light_radiance(const SceneData* s, uint light, float u, float v) {
    const IR_GLOBAL Light* l = &s->lights[light];
    return make_real3(l->r, l->g, l->b);
}

// Radiance that comes from the environment in `direction`.
IR_FN real3 environment_radiance(const SceneData* s, real3 direction) {
#if IR_FEATURES & IR_FEATURE_ENVIRONMENT
    if (s->info->environment_light != IR_NO_LIGHT)
        return area_light_radiance(s, (uint)s->info->environment_light, 0.0f, 0.0f);
#endif
    return make_real3(0.0f, 0.0f, 0.0f);
}

// Density with which sample_light at a surface of normal n would have chosen `direction` of the environment.
IR_FN float environment_density(const SceneData* s, real3 direction, real3 n) {
#if IR_FEATURES & IR_FEATURE_ENVIRONMENT
    if (s->info->environment_light != IR_NO_LIGHT)
        return s->lights[s->info->environment_light].probability * max(dot(direction, n), 0.0f) * IR_INV_PI;
#endif
    return 0.0f;
}

// Index of the light chosen by u in [0,1); u is rescaled so that it can be used again.
IR_FN uint choose_light(const SceneData* s, float* u) {
    const uint count = s->info->light_count;
    if (count == 1u) return 0u;
    uint lo = 0u, hi = count - 1u;  // the first light whose cdf exceeds u
    while (lo < hi) {
        const uint mid = (lo + hi) >> 1;
        if (s->lights[mid].cdf > *u)
            hi = mid;
        else
            lo = mid + 1u;
    }
    const float p = s->lights[lo].probability;
    const float before = lo > 0u ? s->lights[lo - 1u].cdf : 0.0f;
    *u = min(max((*u - before) / p, 0.0f), 0.99999994f);
    return lo;
}

// 1 - cos of a sphere light's cone, from sin² of its half angle, without cancellation.
IR_FN float cone_height(float sin2) { return sin2 / (1.0f + sqrt(max(1.0f - sin2, 0.0f))); }

// Quads and triangles are sampled uniformly in solid angle by receivers that are near and see them under at least this
// (sr); farther away cos/r² hardly varies over the light, and area sampling costs less.
#define IR_LEAST_SOLID_ANGLE 0.01f

// Is p nearer to the light's centre than about three half diagonals, and on its emitting side?
IR_FN bool is_near_light(const Light* l, real3 p) {
    if (l->kind != IR_LIGHT_QUAD && l->kind != IR_LIGHT_TRIANGLE) return false;
    const real3 e1 = make_real3(l->e1x, l->e1y, l->e1z), e2 = make_real3(l->e2x, l->e2y, l->e2z);
    const real3 from = p - make_real3(l->px, l->py, l->pz);
    const real3 d = from - (e1 + e2) * (l->kind == IR_LIGHT_QUAD ? 0.5f : 0.33333333f);
    return dot(d, d) < 2.0f * (dot(e1, e1) + dot(e2, e2)) && dot(from, make_real3(l->nx, l->ny, l->nz)) > 0.0f;
}

// Solid angle in which p samples the light; 0: by area.
IR_FN float sampled_solid_angle(const Light* l, real3 p) {
    if (!is_near_light(l, p)) return 0.0f;
    const real3 v = make_real3(l->px, l->py, l->pz);
    const real3 e1 = make_real3(l->e1x, l->e1y, l->e1z), e2 = make_real3(l->e2x, l->e2y, l->e2z);
    const float angle = l->kind == IR_LIGHT_QUAD ? spherical_rectangle(p, v, e1, e2).solid_angle
                                                 : spherical_triangle(p, v, e1, e2).solid_angle;
    return angle >= IR_LEAST_SOLID_ANGLE ? angle : 0.0f;
}

// Samples a light that is_near_light(); false: by area, please.
IR_FN bool sample_near_light(const Light* l, real3 p, float u, float v, LightSample* sample) {
    const real3 v0 = make_real3(l->px, l->py, l->pz), n = make_real3(l->nx, l->ny, l->nz);
    const real3 e1 = make_real3(l->e1x, l->e1y, l->e1z), e2 = make_real3(l->e2x, l->e2y, l->e2z);
    float angle;
    if (l->kind == IR_LIGHT_QUAD) {
        const SphericalRectangle q = spherical_rectangle(p, v0, e1, e2);
        angle = q.solid_angle;
        if (!(angle >= IR_LEAST_SOLID_ANGLE)) return false;
        const real3 to_light = sample_spherical_rectangle(&q, u, v);
        sample->distance = length(to_light);
        sample->direction = to_light * (1.0f / sample->distance);
        sample->cosine = -q.z0 / sample->distance;
    } else {
        const SphericalTriangle t = spherical_triangle(p, v0, e1, e2);
        angle = t.solid_angle;
        if (!(angle >= IR_LEAST_SOLID_ANGLE)) return false;
        sample->direction = sample_spherical_triangle(&t, u, v);
        sample->cosine = max(-dot(sample->direction, n), 1e-7f);
        sample->distance = dot(p - v0, n) / sample->cosine;
    }
    sample->density = l->probability / angle;
    sample->radiance = make_real3(l->r, l->g, l->b) * (angle / l->probability);
    sample->valid = sample->distance > 0.0f;
    return true;
}

// A sample of the light arriving at p (unit normal n: used by the constant environment only).
IR_FN LightSample sample_light(const SceneData* s, real3 p, real3 n, float u0, float u1) {
    LightSample sample;
    sample.valid = false;
    sample.density = 0.0f;
    sample.cosine = 1.0f;
    sample.distance = IR_INFINITY;
    sample.radiance = make_real3(0.0f, 0.0f, 0.0f);
    sample.direction = n;
    if (s->info->light_count == 0u) return sample;
    const Light light = s->lights[choose_light(s, &u0)];
    const real3 power = make_real3(light.r, light.g, light.b);
    const real3 position = make_real3(light.px, light.py, light.pz);
#if IR_FEATURES & IR_FEATURE_ENVIRONMENT
    if (light.kind == IR_LIGHT_CONSTANT) {
        const Frame frame = make_frame(n);
        const real3 in_frame = cosine_direction(u0, u1);
        sample.direction = to_world(frame, in_frame);
        sample.density = light.probability * in_frame.z * IR_INV_PI;
        sample.radiance = power * (1.0f / sample.density);
        sample.valid = true;
        return sample;
    }
#endif
#if IR_FEATURES & IR_FEATURE_DELTA_LIGHTS
    if (light.kind == IR_LIGHT_DIRECTIONAL) {
        sample.direction = make_real3(-light.nx, -light.ny, -light.nz);
        sample.radiance = power * (1.0f / light.probability);
        sample.valid = true;
        return sample;
    }
    if (light.kind == IR_LIGHT_POINT) {
        const real3 to_light = position - p;
        const float square = dot(to_light, to_light);
        sample.distance = sqrt(square);
        sample.direction = to_light * (1.0f / sample.distance);
        sample.radiance = power * (1.0f / (square * light.probability));
        sample.valid = square > 0.0f;
        return sample;
    }
#endif
    if (is_near_light(&light, p) && sample_near_light(&light, p, u0, u1, &sample)) return sample;
    real3 point = position, normal = make_real3(light.nx, light.ny, light.nz);
#if IR_FEATURES & IR_FEATURE_ANALYTIC
    if (light.kind == IR_LIGHT_SPHERE) {
        const real3 to_centre = position - p;
        const float square = dot(to_centre, to_centre), radius2 = light.radius * light.radius;
        if (light.nx > 0.0f && square > radius2 * 1.0002f) {  // outside: uniform in the cone of visible directions
            const float sin2 = radius2 / square, height = cone_height(sin2);
            const float cosine = 1.0f - u0 * height;
            const float sine = sqrt(max(u0 * height * (1.0f + cosine), 0.0f));
            float sp, cp;
            sincos_turns(u1, &sp, &cp);
            const Frame frame = make_frame(to_centre * rsqrt(square));
            sample.direction = to_world(frame, make_real3(sine * cp, sine * sp, cosine));
            const float b = dot(to_centre, sample.direction);
            // distance to the near side: q = (square - r²) / (b + sqrt(b² - square + r²)), without cancellation
            const float root = sqrt(max(b * b - square + radius2, 0.0f));
            sample.distance = (square - radius2) / (b + root);
            sample.cosine = root / light.radius;
            sample.density = light.probability / (2.0f * IR_PI * height);
            sample.radiance = power * (1.0f / sample.density);
            sample.valid = true;
            return sample;
        }
        const real3 out = sample_sphere(u0, u1);
        point = position + out * light.radius;
        normal = out * light.nx;
    } else
#endif
    {
        const real3 e1 = make_real3(light.e1x, light.e1y, light.e1z), e2 = make_real3(light.e2x, light.e2y, light.e2z);
        float a = u0, b = u1;
        if (light.kind == IR_LIGHT_TRIANGLE) {
            const float root = sqrt(u0);
            a = root * (1.0f - u1);
            b = root * u1;
        }
#if IR_FEATURES & IR_FEATURE_ANALYTIC
        if (light.kind == IR_LIGHT_DISK) {
            const real3 d = sample_disk(u0, u1);
            a = d.x;
            b = d.y;
        }
#endif
        point = position + e1 * a + e2 * b;
    }
    const real3 to_light = point - p;
    const float square = dot(to_light, to_light);
    const float distance = sqrt(square);
    const real3 w = to_light * (1.0f / max(distance, 1e-30f));
    const float cosine = -dot(normal, w);
    sample.direction = w;
    sample.distance = distance;
    sample.cosine = cosine;
    if (cosine > 0.0f && square > 0.0f) {
        sample.density = light.probability * square / (cosine * light.area);
        sample.radiance = power * (1.0f / sample.density);
        sample.valid = true;
    }
    return sample;
}

// Density with which sample_light at p would have chosen the direction w that hit light `index` at `distance`, where
// the light's emitting normal makes `cosine` = |n_light . w|. Per steradian.
IR_FN float light_density(const SceneData* s, uint index, real3 p, float cosine, float distance) {
    const Light light = s->lights[index];
#if IR_FEATURES & IR_FEATURE_ANALYTIC
    if (light.kind == IR_LIGHT_SPHERE) {
        const real3 to_centre = make_real3(light.px, light.py, light.pz) - p;
        const float square = dot(to_centre, to_centre), radius2 = light.radius * light.radius;
        if (light.nx > 0.0f && square > radius2 * 1.0002f)
            return light.probability / (2.0f * IR_PI * cone_height(radius2 / square));
    }
#endif
    const float angle = sampled_solid_angle(&light, p);
    if (angle > 0.0f) return light.probability / angle;
    return light.probability * distance * distance / max(cosine * light.area, 1e-30f);
}
#endif
