// Next-event estimation: one light chosen by power, one point on it. Densities are per solid angle at the receiver and
// include the choice of the light, so that they can be weighed against a BSDF's density.
#ifndef IR_LIGHT_H
#define IR_LIGHT_H
#include "environment.h"
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

// Is p nearer to the light's centre than about three half diagonals, and on its emitting side? By more than its
// rounding: a point of the light itself, on either side, would see half of its sphere filled with the light.
IR_FN bool is_near_light(const Light* l, real3 p) {
    if (l->kind != IR_LIGHT_QUAD && l->kind != IR_LIGHT_TRIANGLE) return false;
    const real3 e1 = make_real3(l->e1x, l->e1y, l->e1z), e2 = make_real3(l->e2x, l->e2y, l->e2z);
    const real3 from = p - make_real3(l->px, l->py, l->pz);
    const real3 d = from - (e1 + e2) * (l->kind == IR_LIGHT_QUAD ? 0.5f : 0.33333333f);
    const float rounding = 1e-5f * (fabs(p.x) + fabs(p.y) + fabs(p.z) + fabs(from.x) + fabs(from.y) + fabs(from.z));
    return dot(d, d) < 2.0f * (dot(e1, e1) + dot(e2, e2)) && dot(from, make_real3(l->nx, l->ny, l->nz)) > rounding;
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

#if IR_FEATURES & IR_FEATURE_TEXTURED_LIGHTS
// Texture coordinates of a point on a textured area light, by the primitive that carries them.
IR_FN void light_coordinates(const SceneData* s, const Light* l, real3 point, float* u, float* v) {
    if (l->primitive < s->info->triangle_count) {
        const Triangle tri = s->triangles[l->primitive];
        const Vertex a = s->vertices[tri.v0], b = s->vertices[tri.v1], c = s->vertices[tri.v2];
        const real3 origin = make_real3(a.px, a.py, a.pz), d = point - origin;
        const real3 e1 = make_real3(b.px, b.py, b.pz) - origin, e2 = make_real3(c.px, c.py, c.pz) - origin;
        // Barycentrics; of a rectangle's other half they lie outside [0, 1], and the mapping is the same affine one.
        const float e11 = dot(e1, e1), e12 = dot(e1, e2), e22 = dot(e2, e2), d1 = dot(d, e1), d2 = dot(d, e2);
        const float inverse = 1.0f / max(e11 * e22 - e12 * e12, 1e-37f);
        const float beta = (d1 * e22 - d2 * e12) * inverse, gamma = (d2 * e11 - d1 * e12) * inverse;
        const bool mapped = (tri.flags & IR_TRIANGLE_HAS_UV) != 0u;
        *u = mapped ? a.u + beta * (b.u - a.u) + gamma * (c.u - a.u) : beta;
        *v = mapped ? a.v + beta * (b.v - a.v) + gamma * (c.v - a.v) : gamma;
        return;
    }
#if IR_FEATURES & IR_FEATURE_ANALYTIC
    const Analytic q = s->analytics[l->primitive - s->info->triangle_count];
    const real3 d = point - make_real3(q.px, q.py, q.pz);
    if (q.kind == IR_ANALYTIC_SPHERE) {
        sphere_uv(&q, normalize(d), u, v);
    } else if (q.kind == IR_ANALYTIC_CYLINDER) {
        real3 normal;
        cylinder_surface(&q, &point, &normal, u, v);
    } else {
        disk_uv(&q, point, u, v);
    }
#endif
}
#endif

// Radiance that an area light emits at texture coordinates u, v, to its emitting side.
IR_FN real3 area_light_radiance(const SceneData* s, uint light, float u, float v) {
    const IR_GLOBAL Light* l = &s->lights[light];
#if IR_FEATURES & IR_FEATURE_TEXTURED_LIGHTS
    if (l->texture != IR_NO_TEXTURE) return texture_lookup(s, l->texture, u, v);
#endif
    return make_real3(l->r, l->g, l->b);
}

#if IR_FEATURES & IR_FEATURE_DELTA_LIGHTS
// Factor of a spot's intensity in direction w (unit, away from it): 1 within the inner cone, falling linearly with the
// angle to 0 at the cutoff (Mitsuba). By the angle: cosines of narrow cones hardly differ in float32.
IR_FN float spot_falloff(const Light* l, real3 w) {
    const real3 axis = make_real3(l->nx, l->ny, l->nz);
    const float angle = 2.0f * IR_PI * turns_of(dot(axis, w), length(cross(axis, w)));
    const float cutoff = l->e2x, beam = l->e2y;
    if (angle <= beam) return 1.0f;
    return angle < cutoff ? (cutoff - angle) / (cutoff - beam) : 0.0f;
}
#endif

// A sample of an area light of radiance `power`.
IR_FN LightSample sample_area_light(const Light* l, real3 power, real3 p, float u0, float u1) {
    LightSample sample;
    sample.valid = false;
    sample.density = 0.0f;
    sample.radiance = make_real3(0.0f, 0.0f, 0.0f);
    if (is_near_light(l, p) && sample_near_light(l, p, u0, u1, &sample)) return sample;
    const real3 position = make_real3(l->px, l->py, l->pz);
    real3 point = position, normal = make_real3(l->nx, l->ny, l->nz);
#if IR_FEATURES & IR_FEATURE_ANALYTIC
    if (l->kind == IR_LIGHT_SPHERE) {
        const real3 to_centre = position - p;
        const float square = dot(to_centre, to_centre), radius2 = l->radius * l->radius;
        if (l->nx > 0.0f && square > radius2 * 1.0002f) {  // outside: uniform in the cone of visible directions
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
            sample.cosine = root / l->radius;
            sample.density = l->probability / (2.0f * IR_PI * height);
            sample.radiance = power * (1.0f / sample.density);
            sample.valid = true;
            return sample;
        }
        const real3 out = sample_sphere(u0, u1);
        point = position + out * l->radius;
        normal = out * l->nx;
    } else if (l->kind == IR_LIGHT_CYLINDER) {
        const real3 axis = make_real3(l->e1x, l->e1y, l->e1z);
        const Frame frame = make_frame(normalize(axis));
        float sp, cp;
        sincos_turns(u1, &sp, &cp);
        const real3 out = frame.t * cp + frame.b * sp;
        point = position + axis * u0 + out * l->radius;
        normal = out * l->nx;
    } else
#endif
    {
        const real3 e1 = make_real3(l->e1x, l->e1y, l->e1z), e2 = make_real3(l->e2x, l->e2y, l->e2z);
        float a = u0, b = u1;
        if (l->kind == IR_LIGHT_TRIANGLE) {
            const float root = sqrt(u0);
            a = root * (1.0f - u1);
            b = root * u1;
        }
#if IR_FEATURES & IR_FEATURE_ANALYTIC
        if (l->kind == IR_LIGHT_DISK) {
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
        sample.density = l->probability * square / (cosine * l->area);
        sample.radiance = power * (1.0f / sample.density);
        sample.valid = true;
    }
    return sample;
}

// No light; `direction` is any.
IR_FN LightSample no_light(real3 direction) {
    LightSample sample;
    sample.valid = false;
    sample.density = 0.0f;
    sample.cosine = 1.0f;
    sample.distance = IR_INFINITY;
    sample.radiance = make_real3(0.0f, 0.0f, 0.0f);
    sample.direction = direction;
    return sample;
}

#if IR_FEATURES & IR_FEATURE_ENVMAP
// What a direction of the picture, whose density is *sample's, stands for among the samples of all lights.
IR_FN void picture_sample_light(const Light* map, real3 radiance, LightSample* sample) {
    sample->density *= map->probability;
    sample->valid = sample->density > 0.0f;
    if (sample->valid) sample->radiance = radiance * (1.0f / sample->density);
}
#endif

// A sample of the light arriving at p (unit normal n: used by environments only).
IR_CALL_FN LightSample sample_light(const SceneData* s, real3 p, real3 n, float u0, float u1) {
    LightSample sample = no_light(n);
    if (s->info->light_count == 0u) return sample;
    const Light light = s->lights[choose_light(s, &u0)];
    const real3 power = make_real3(light.r, light.g, light.b);
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
#if IR_FEATURES & IR_FEATURE_ENVMAP
    if (light.kind == IR_LIGHT_ENVMAP) {
        real3 radiance;
        sample.direction = sample_picture(s, &light, p, n, u0, u1, &sample.density, &radiance);
        picture_sample_light(&light, radiance, &sample);
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
    if (light.kind == IR_LIGHT_POINT || light.kind == IR_LIGHT_SPOT) {
        const real3 to_light = make_real3(light.px, light.py, light.pz) - p;
        const float square = dot(to_light, to_light);
        sample.distance = sqrt(square);
        sample.direction = to_light * (1.0f / sample.distance);
        sample.valid = square > 0.0f;
        float intensity = 1.0f;
        if (light.kind == IR_LIGHT_SPOT && sample.valid) {
            intensity = spot_falloff(&light, -sample.direction);
            sample.valid = intensity > 0.0f;
        }
        sample.radiance = power * (intensity / (square * light.probability));
        return sample;
    }
#endif
    sample = sample_area_light(&light, power, p, u0, u1);
#if IR_FEATURES & IR_FEATURE_TEXTURED_LIGHTS
    if (light.texture != IR_NO_TEXTURE && sample.valid) {
        float u = 0.0f, v = 0.0f;
        light_coordinates(s, &light, p + sample.direction * sample.distance, &u, &v);
        sample.radiance = texture_lookup(s, light.texture, u, v) * (1.0f / sample.density);
    }
#endif
    return sample;
}

// Density with which sample_light at p would have chosen the direction w that hit light `index` at `distance`, where
// the light's emitting normal makes `cosine` = |n_light . w|. Per steradian.
IR_CALL_FN float light_density(const SceneData* s, uint index, real3 p, float cosine, float distance) {
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
