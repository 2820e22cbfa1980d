// What kernels take for granted of a scene's arrays (the acceleration structures: check_accel.cpp).
#include <bit>
#include <cmath>
#include <vector>

#include "core/check.h"
#include "irradia/PackedScene.h"

namespace irradia {
namespace {

using check::Place;

bool in_unit(float x) { return x >= 0.0f && x <= 1.0f; }

void check_geometry(const std::string& where, const Scene& scene) {
    for (std::size_t i = 0; i < scene.vertices.size(); ++i) {
        const shared::Vertex& v = scene.vertices[i];
        Place{where, "vertex", i}.finite(v.px, v.py, v.pz, v.nx, v.ny, v.nz, v.u, v.v);
    }
    for (std::size_t i = 0; i < scene.triangles.size(); ++i) {
        const shared::Triangle& t = scene.triangles[i];
        const Place p{where, "triangle", i};
        p.finite(t.nx, t.ny, t.nz, t.reach);
        p.require((t.flags & ~(IR_TRIANGLE_FLAT | IR_TRIANGLE_HAS_UV)) == 0, "unknown flags");
        for (const std::uint32_t v : {t.v0, t.v1, t.v2}) p.below(v, scene.vertices.size(), "vertex");
        p.below(t.material, scene.materials.size(), "material");
        p.optional_below(t.light, scene.lights.size(), "light");
    }
    for (std::size_t i = 0; i < scene.analytics.size(); ++i) {
        const shared::Analytic& a = scene.analytics[i];
        const Place p{where, "analytic primitive", i};
        p.require(a.kind <= IR_ANALYTIC_CYLINDER, "unknown kind");
        p.finite(a.px, a.py, a.pz, a.radius, a.nx, a.ny, a.nz, a.ux, a.uy, a.uz, a.vx, a.vy, a.vz, a.sign, a.length);
        p.require(a.kind == IR_ANALYTIC_DISK || a.radius > 0.0f, "radius is not positive");
        p.require(a.kind != IR_ANALYTIC_CYLINDER || a.length > 0.0f, "length is not positive");
        p.below(a.material, scene.materials.size(), "material");
        p.optional_below(a.light, scene.lights.size(), "light");
    }
}

void check_texture(const Place& p, const shared::Texture& t, const std::vector<std::uint32_t>& texels, bool unbounded,
                   std::uint64_t vertices) {
    p.require(t.format <= IR_TEXTURE_VERTEX_COLOUR, "unknown format");
    p.require(t.wrap <= IR_WRAP_CLAMP, "unknown wrap mode");
    p.require(t.filter <= IR_FILTER_NEAREST, "unknown filter");
    p.finite(t.m00, t.m01, t.m02, t.m10, t.m11, t.m12);
    // Kernels hold sizes in int (twice the size for mirroring) and texel indices in uint.
    p.require(t.width > 0 && t.height > 0 && t.width <= 1u << 20 && t.height <= 1u << 20, "size out of range");
    std::uint64_t words = std::uint64_t{t.width} * t.height * (t.format == IR_TEXTURE_RGB32F ? 3 : 1);
    if (t.format == IR_TEXTURE_CHECKERBOARD) words = 6;
    if (t.format == IR_TEXTURE_VERTEX_COLOUR) words = 3 * vertices;
    p.require(texels.size() <= 0xffffffffu && t.offset <= texels.size() && words <= texels.size() - t.offset,
              "texels are outside the texel array");
    if (t.format < IR_TEXTURE_RGB32F) return;
    for (std::uint64_t i = 0; i < words; ++i) {
        const float x = std::bit_cast<float>(texels[t.offset + i]);
        p.require(unbounded ? std::isfinite(x) : in_unit(x),
                  unbounded ? "a texel is not finite" : "a texel is outside [0, 1]");
    }
}

void check_appearance(const std::string& where, const Scene& scene) {
    for (std::size_t i = 0; i < scene.materials.size(); ++i) {
        const shared::Material& m = scene.materials[i];
        const Place p{where, "material", i};
        p.require(m.kind < IR_MATERIAL_KINDS, "unknown kind");
        p.require((m.flags & ~(IR_MATERIAL_BECKMANN | IR_MATERIAL_NONLINEAR | IR_MATERIAL_NORMAL_MAP |
                               IR_MATERIAL_MIRRORED_MAP)) == 0,
                  "unknown flags");
        p.optional_below(m.back, scene.materials.size(), "material of the back");
        for (const int texture : {m.texture, m.specular_texture, m.opacity_texture, m.alpha_texture, m.map})
            p.optional_below(texture, scene.textures.size(), "texture");
        p.require(in_unit(m.r) && in_unit(m.g) && in_unit(m.b), "reflectance is outside [0, 1]");
        p.require(in_unit(m.specular_r) && in_unit(m.specular_g) && in_unit(m.specular_b),
                  "specular reflectance is outside [0, 1]");
        p.require(in_unit(m.transmittance_r) && in_unit(m.transmittance_g) && in_unit(m.transmittance_b),
                  "specular transmittance is outside [0, 1]");
        p.require(in_unit(m.opacity), "opacity is outside [0, 1]");
        p.finite(m.eta_r, m.eta_g, m.eta_b, m.k_r, m.k_g, m.k_b, m.eta, m.alpha_u, m.alpha_v, m.map_scale);
        p.require(m.eta > 0.0f, "index of refraction is not positive");
        p.require(
            m.eta_r >= 0.0f && m.eta_g >= 0.0f && m.eta_b >= 0.0f && m.k_r >= 0.0f && m.k_g >= 0.0f && m.k_b >= 0.0f,
            "a conductor's index of refraction is negative");
        // The loader holds roughness at Mitsuba's least, 1e-4: squares and their products stay in float32's range.
        p.require(m.alpha_u >= 0.99e-4f && m.alpha_v >= 0.99e-4f, "roughness is below 0.0001");
        // Kernels divide by 1 - internal_reflectance.
        p.require(m.internal_reflectance >= 0.0f && m.internal_reflectance < 1.0f,
                  "the coat's internal reflectance is outside [0, 1)");
        p.require(in_unit(m.specular_weight), "the coat's weight is outside [0, 1]");
        if (m.kind == IR_MATERIAL_ROUGH_PLASTIC) {
            p.require(std::uint64_t{m.coat_table} + IR_COAT_TABLE <= scene.texels.size(),
                      "the coat's table is outside the texel array");
            for (std::size_t k = 0; k < IR_COAT_TABLE; ++k)
                p.require(in_unit(std::bit_cast<float>(scene.texels[m.coat_table + k])),
                          "a transmittance of the coat is outside [0, 1]");
        }
        for (const int texture : {m.opacity_texture, m.alpha_texture, m.map})
            if (texture >= 0)
                p.require(scene.textures[static_cast<std::size_t>(texture)].format != IR_TEXTURE_VERTEX_COLOUR,
                          "vertex colours that are no reflectance");
    }
    // Radiance and heights may be any numbers; reflectances are looked up unchecked by the kernels.
    std::vector<bool> factor(scene.textures.size(), false), unbounded(scene.textures.size(), false);
    const auto mark = [](std::vector<bool>& marks, int texture) {
        if (texture >= 0) marks[static_cast<std::size_t>(texture)] = true;
    };
    for (const shared::Light& l : scene.lights) mark(unbounded, l.texture);
    for (const shared::Material& m : scene.materials) {
        mark(unbounded, m.map);
        for (const int texture : {m.texture, m.specular_texture, m.opacity_texture, m.alpha_texture})
            mark(factor, texture);
    }
    for (std::size_t i = 0; i < scene.textures.size(); ++i)
        check_texture({where, "texture", i}, scene.textures[i], scene.texels, unbounded[i] && !factor[i],
                      scene.vertices.size());
}

/// An environment picture and the tables by which it is sampled (cl/environment.h).
void check_environment(const Place& p, const shared::Light& l, const Scene& scene) {
    p.require(l.texture >= 0, "an environment without its picture");
    const shared::Texture& t = scene.textures[static_cast<std::size_t>(l.texture)];
    p.require(t.format == IR_TEXTURE_RGB32F, "the environment's picture has another format than floats");
    p.require(t.height >= 2, "the environment's picture has less than 2 rows");
    const std::uint64_t rows = t.height - 1, words = 3 * rows + 1 + rows * t.width;
    p.require(l.view == 0, "what is seen of an environment is no part of a scene");
    p.require(l.table <= scene.texels.size() && words <= scene.texels.size() - l.table,
              "the environment's tables are outside the texel array");
    const auto at = [&](std::uint64_t i) { return std::bit_cast<float>(scene.texels[l.table + i]); };
    const auto sums = [&](std::uint64_t first, std::uint64_t count) {
        float before = 0.0f;
        for (std::uint64_t i = 0; i < count; ++i) {
            p.require(at(first + i) >= before, "a running sum of the environment's tables descends");
            before = at(first + i);
        }
        p.require(before == 1.0f, "a running sum of the environment's tables does not end at 1");
    };
    sums(0, rows);
    for (std::uint64_t i = 0; i <= rows; ++i) p.require(in_unit(at(rows + i)), "a row's height is outside [0, 1]");
    for (std::uint64_t i = 0; i < rows; ++i)
        p.require(std::isfinite(at(2 * rows + 1 + i)) && at(2 * rows + 1 + i) > 0.0f,
                  "the density of a row of the environment is not positive");
    for (std::uint64_t row = 0; row < rows; ++row) sums(3 * rows + 1 + row * t.width, t.width);
    for (const float x : {l.e1x * l.e1x + l.e1y * l.e1y + l.e1z * l.e1z, l.e2x * l.e2x + l.e2y * l.e2y + l.e2z * l.e2z,
                          l.nx * l.nx + l.ny * l.ny + l.nz * l.nz})
        p.require(std::abs(x - 1.0f) < 1e-3f, "an axis of the environment is not of unit length");
}

void check_lights(const std::string& where, const Scene& scene) {
    float before = 0.0f;
    for (std::size_t i = 0; i < scene.lights.size(); ++i) {
        const shared::Light& l = scene.lights[i];
        const Place p{where, "light", i};
        p.require(l.kind <= IR_LIGHT_CYLINDER, "unknown kind");
        p.finite(l.px, l.py, l.pz, l.e1x, l.e1y, l.e1z, l.e2x, l.e2y, l.e2z, l.nx, l.ny, l.nz, l.area, l.radius);
        p.finite(l.r, l.g, l.b, l.probability, l.cdf);
        p.require(l.r >= 0.0f && l.g >= 0.0f && l.b >= 0.0f, "negative radiance");
        p.optional_below(l.texture, scene.textures.size(), "texture");
        p.require(l.area >= 0.0f && l.radius >= 0.0f, "negative area or radius");
        const bool area = l.kind <= IR_LIGHT_DISK || l.kind == IR_LIGHT_CYLINDER;
        p.require(l.kind != IR_LIGHT_CYLINDER || (l.area > 0.0f && l.radius > 0.0f), "a cylinder without area");
        p.require(l.kind != IR_LIGHT_SPOT || (l.e2x >= l.e2y && l.e2y >= 0.0f), "a spot's inner cone is the wider one");
        if (l.kind == IR_LIGHT_ENVMAP)
            check_environment(p, l, scene);
        else
            p.require(l.texture < 0 || area, "a texture on a light without area");
        if (l.texture >= 0 && area) p.below(l.primitive, scene.triangles.size() + scene.analytics.size(), "primitive");
        p.require(in_unit(l.probability), "probability is outside [0, 1]");
        p.require(l.cdf >= before, "the cdf descends");
        before = l.cdf;
        p.require(i + 1 < scene.lights.size() || l.cdf == 1.0f, "the last cdf is not 1");
    }
}

/// The features without which kernels would misread the scene.
std::uint32_t needed_features(const Scene& scene) {
    std::uint32_t needed = scene.analytics.empty() ? 0 : IR_FEATURE_ANALYTIC;
    for (const shared::Material& m : scene.materials) {
        for (const int texture : {m.texture, m.specular_texture, m.opacity_texture, m.alpha_texture, m.map})
            if (texture >= 0) needed |= IR_FEATURE_TEXTURES;
        if (m.kind != IR_MATERIAL_DIFFUSE && m.kind < IR_MATERIAL_KINDS) needed |= IR_FEATURE_BSDFS;
        if (m.opacity < 1.0f || m.opacity_texture >= 0) needed |= IR_FEATURE_MASKS;
        if (m.map >= 0) needed |= IR_FEATURE_BUMPS;
    }
    if (scene.info.camera.aperture_radius > 0.0f) needed |= IR_FEATURE_THIN_LENS;
    for (const shared::Triangle& t : scene.triangles)
        if ((t.flags & IR_TRIANGLE_FLAT) == 0) needed |= IR_FEATURE_SMOOTH_NORMALS;
    for (const shared::Light& l : scene.lights) {
        if (l.kind == IR_LIGHT_CONSTANT || l.kind == IR_LIGHT_ENVMAP) needed |= IR_FEATURE_ENVIRONMENT;
        if (l.kind == IR_LIGHT_ENVMAP) needed |= IR_FEATURE_ENVMAP;
        if (l.kind == IR_LIGHT_POINT || l.kind == IR_LIGHT_DIRECTIONAL || l.kind == IR_LIGHT_SPOT)
            needed |= IR_FEATURE_DELTA_LIGHTS;
        if (l.texture >= 0 && l.kind != IR_LIGHT_ENVMAP) needed |= IR_FEATURE_TEXTURED_LIGHTS | IR_FEATURE_TEXTURES;
    }
    return needed;
}

void check_info(const std::string& where, const Scene& scene) {
    const shared::SceneInfo& s = scene.info;
    const shared::Camera& c = s.camera;
    const Place p{where, "camera", 0}, q{where, "scene", 0};
    p.finite(c.ox, c.oy, c.oz, c.near_clip, c.cornerx, c.cornery, c.cornerz, c.far_clip, c.dxx, c.dxy, c.dxz,
             c.aperture_radius, c.focus_distance);
    p.finite(c.pixel_size, c.dyx, c.dyy, c.dyz, c.forwardx, c.forwardy, c.forwardz);
    q.require(s.width > 0 && s.height > 0 && std::uint64_t{s.width} * s.height < 1u << 31,
              "the picture's size is out of range");
    q.require(s.rfilter <= IR_RFILTER_GAUSSIAN, "unknown reconstruction filter");
    q.finite(s.rfilter_radius, s.rfilter_stddev, s.diagonal);
    q.require(s.rfilter_radius > 0.0f && s.rfilter_radius <= 1000.0f, "the filter's radius is out of range");
    q.require(s.rfilter != IR_RFILTER_GAUSSIAN || s.rfilter_stddev > 0.0f, "the filter's width is not positive");
    // cl/filter.h inverts that distribution alone.
    q.require(s.rfilter != IR_RFILTER_GAUSSIAN || s.rfilter_radius == 4.0f * s.rfilter_stddev,
              "the gaussian filter's radius is not four standard deviations");
    q.require(s.triangle_count == scene.triangles.size() && s.analytic_count == scene.analytics.size() &&
                  s.light_count == scene.lights.size(),
              "counts do not match the arrays");
    q.require(scene.triangles.size() + scene.analytics.size() < IR_NO_PRIMITIVE, "too many primitives");
    q.optional_below(s.environment_light, scene.lights.size(), "environment light");
    q.require(s.environment_light < 0 ||
                  scene.lights[static_cast<std::size_t>(s.environment_light)].kind == IR_LIGHT_CONSTANT ||
                  scene.lights[static_cast<std::size_t>(s.environment_light)].kind == IR_LIGHT_ENVMAP,
              "the environment light is of another kind");
    q.require(s.fov_axis <= IR_FOV_AXIS_LARGER, "unknown axis of the field of view");
    q.require(s.diagonal >= 0.0f, "the diagonal is negative");
    q.finite(s.min_x, s.min_y, s.min_z, s.max_x, s.max_y, s.max_z);
    q.require(s.min_x <= s.max_x && s.min_y <= s.max_y && s.min_z <= s.max_z, "the bounds are inverted");
    constexpr std::uint32_t kKnown = IR_FEATURE_TEXTURES | IR_FEATURE_ANALYTIC | IR_FEATURE_SMOOTH_NORMALS |
                                     IR_FEATURE_ENVIRONMENT | IR_FEATURE_DELTA_LIGHTS | IR_FEATURE_BSDFS |
                                     IR_FEATURE_MASKS | IR_FEATURE_BUMPS | IR_FEATURE_ENVMAP |
                                     IR_FEATURE_TEXTURED_LIGHTS | IR_FEATURE_THIN_LENS;
    q.require((scene.features & ~kKnown) == 0, "unknown features");
    q.require((needed_features(scene) & ~scene.features) == 0, "a feature that it needs is not listed");
    q.require(scene.sample_count > 0, "no samples a pixel");
    q.finite(scene.centre[0], scene.centre[1], scene.centre[2]);
    for (const char ch : scene.source)
        q.require(static_cast<unsigned char>(ch) >= 32 && ch != 127, "a control character in the source's name");
}

}  // namespace

void check_scene(const std::string& where, const Scene& scene, AccelLayouts layouts) {
    check_info(where, scene);
    check_geometry(where, scene);
    check_lights(where, scene);
    check_appearance(where, scene);
    check::check_accel(where, scene, layouts);
}

}  // namespace irradia
