// Bitmap textures: repeat, mirror or clamp, nearest or bilinear; texel centres at half integers, row 0 at v = 0 (as
// Mitsuba).
#ifndef IR_TEXTURE_H
#define IR_TEXTURE_H
#include "sampling.h"
#include "scene.h"

#if IR_FEATURES & IR_FEATURE_TEXTURES
#if defined(IR_CPU)
#include "srgb_table.h"
#endif

IR_FN float srgb_to_linear(float c) {
    // IEC 61966-2-1; powr is slow on CPUs, so x^2.4 = x^2 * (x^0.4) by exp2/log2 of one number.
    return c <= 0.04045f ? c * (1.0f / 12.92f) : exp2(2.4f * log2((c + 0.055f) * (1.0f / 1.055f)));
}

IR_FN int wrap_coordinate(int i, int size, uint wrap) {
    if (wrap == IR_WRAP_CLAMP) return min(max(i, 0), size - 1);
    if (wrap == IR_WRAP_MIRROR) {
        int m = i % (2 * size);
        if (m < 0) m += 2 * size;
        return m < size ? m : 2 * size - 1 - m;
    }
    const int m = i % size;
    return m < 0 ? m + size : m;
}

// Three floats at word `offset` of the texels.
IR_FN real3 float_texel(const SceneData* s, uint offset) {
    const IR_GLOBAL uint* c = s->texels + offset;
    return make_real3(IR_AS_FLOAT(c[0]), IR_AS_FLOAT(c[1]), IR_AS_FLOAT(c[2]));
}

// A texel of eight bits a channel, decoded.
IR_FN real3 decode_texel(uint format, uint c) {
    const uint r = c & 255u, g = (c >> 8) & 255u, b = (c >> 16) & 255u;
#if defined(IR_CPU)
    if (format == IR_TEXTURE_RGBA8_SRGB) return make_real3(srgb_table[r], srgb_table[g], srgb_table[b]);
#endif
    const real3 raw = make_real3((float)r, (float)g, (float)b) * (1.0f / 255.0f);
    if (format == IR_TEXTURE_RGBA8_LINEAR) return raw;
    return make_real3(srgb_to_linear(raw.x), srgb_to_linear(raw.y), srgb_to_linear(raw.z));
}

// Texels (x, y), (x + 1, y), (x, y + 1) and (x + 1, y + 1).
typedef struct TexelQuad {
    real3 a, b, c, d;
} TexelQuad;

IR_FN TexelQuad texel_quad(const SceneData* s, const Texture* t, int x, int y) {
    const uint left = (uint)wrap_coordinate(x, (int)t->width, t->wrap),
               right = (uint)wrap_coordinate(x + 1, (int)t->width, t->wrap),
               top = (uint)wrap_coordinate(y, (int)t->height, t->wrap) * t->width,
               bottom = (uint)wrap_coordinate(y + 1, (int)t->height, t->wrap) * t->width;
    TexelQuad q;
    if (t->format == IR_TEXTURE_RGB32F) {
        q.a = float_texel(s, t->offset + 3u * (top + left));
        q.b = float_texel(s, t->offset + 3u * (top + right));
        q.c = float_texel(s, t->offset + 3u * (bottom + left));
        q.d = float_texel(s, t->offset + 3u * (bottom + right));
        return q;
    }
    const IR_GLOBAL uint* texels = s->texels + t->offset;  // all four first: their memory is waited for once
    const uint a = texels[top + left], b = texels[top + right], c = texels[bottom + left], d = texels[bottom + right];
    q.a = decode_texel(t->format, a);
    q.b = decode_texel(t->format, b);
    q.c = decode_texel(t->format, c);
    q.d = decode_texel(t->format, d);
    return q;
}

IR_FN real3 nearest_texel(const SceneData* s, const Texture* t, int x, int y) {
    const uint index = (uint)wrap_coordinate(y, (int)t->height, t->wrap) * t->width +
                       (uint)wrap_coordinate(x, (int)t->width, t->wrap);
    if (t->format == IR_TEXTURE_RGB32F) return float_texel(s, t->offset + 3u * index);
    return decode_texel(t->format, s->texels[t->offset + index]);
}

// Mitsuba's checkerboard: color0 where both or neither coordinate is in the upper half of a unit square.
IR_FN real3 checkerboard(const SceneData* s, const Texture* t, float u, float v) {
    const bool a = u - floor(u) > 0.5f, b = v - floor(v) > 0.5f;
    return float_texel(s, t->offset + (a == b ? 0u : 3u));
}

IR_FN real3 texture_lookup(const SceneData* s, int index, float u, float v) {
    const Texture t = s->textures[index];
    const float x = (t.m00 * u + t.m01 * v + t.m02) * (float)t.width;
    const float y = (t.m10 * u + t.m11 * v + t.m12) * (float)t.height;
    if (t.format == IR_TEXTURE_CHECKERBOARD) return checkerboard(s, &t, x, y);  // width and height are 1
    if (t.filter == IR_FILTER_NEAREST) return nearest_texel(s, &t, (int)floor(x), (int)floor(y));
    const float fx = floor(x - 0.5f), fy = floor(y - 0.5f);
    const float ax = x - 0.5f - fx, ay = y - 0.5f - fy;
    const TexelQuad q = texel_quad(s, &t, (int)fx, (int)fy);
    const real3 top = q.a * (1.0f - ax) + q.b * ax, bottom = q.c * (1.0f - ax) + q.d * ax;
    return top * (1.0f - ay) + bottom * ay;
}

// A texture as one number: its Rec. 709 luminance.
IR_FN float texture_scalar(const SceneData* s, int index, float u, float v) {
    const real3 c = texture_lookup(s, index, u, v);
    return 0.2126f * c.x + 0.7152f * c.y + 0.0722f * c.z;
}

#if IR_FEATURES & IR_FEATURE_BUMPS
// Derivatives of texture_scalar by u and v: slopes of the bilinear patch between four texel centres. Nearest texels and
// checkerboards are flat. (Mitsuba 3.9.1's eval_1_grad is these derivatives too, but for pictures that are not square
// under a to_uv that rotates or shears, where it multiplies by the wrong one of width and height.)
IR_FN void texture_gradient(const SceneData* s, int index, float u, float v, float* du, float* dv) {
    const Texture t = s->textures[index];
    *du = *dv = 0.0f;
    if (t.format >= IR_TEXTURE_CHECKERBOARD || t.filter == IR_FILTER_NEAREST) return;
    const float x = (t.m00 * u + t.m01 * v + t.m02) * (float)t.width - 0.5f;
    const float y = (t.m10 * u + t.m11 * v + t.m12) * (float)t.height - 0.5f;
    const float fx = floor(x), fy = floor(y), ax = x - fx, ay = y - fy;
    const TexelQuad q = texel_quad(s, &t, (int)fx, (int)fy);
    const real3 grey = make_real3(0.2126f, 0.7152f, 0.0722f);
    const float a = dot(grey, q.a), b = dot(grey, q.b), c = dot(grey, q.c), d = dot(grey, q.d);
    const float dx = ((b - a) * (1.0f - ay) + (d - c) * ay) * (float)t.width;
    const float dy = ((c - a) * (1.0f - ax) + (d - b) * ax) * (float)t.height;
    *du = dx * t.m00 + dy * t.m10;
    *dv = dx * t.m01 + dy * t.m11;
}
#endif

// Mitsuba's sphere: u = azimuth / 2 pi in the object frame, v = polar angle / pi.
IR_FN void sphere_uv(const Analytic* q, real3 out, float* u, float* v) {
    const real3 x = make_real3(q->ux, q->uy, q->uz), z = make_real3(q->vx, q->vy, q->vz);
    const real3 y = cross(z, x);
    float phi = atan2(dot(out, y), dot(out, x));
    if (phi < 0.0f) phi += 2.0f * IR_PI;
    *u = phi * (0.5f * IR_INV_PI);
    *v = acos(clamp(dot(out, z), -1.0f, 1.0f)) * IR_INV_PI;
}

// Mitsuba's disk: u = radius in [0,1], v = azimuth / 2 pi.
IR_FN void disk_uv(const Analytic* q, real3 p, float* u, float* v) {
    const real3 d = p - make_real3(q->px, q->py, q->pz);
    const float x = dot(d, make_real3(q->ux, q->uy, q->uz)), y = dot(d, make_real3(q->vx, q->vy, q->vz));
    float phi = atan2(y, x);
    if (phi < 0.0f) phi += 2.0f * IR_PI;
    *u = sqrt(x * x + y * y);
    *v = phi * (0.5f * IR_INV_PI);
}
#endif
#endif
