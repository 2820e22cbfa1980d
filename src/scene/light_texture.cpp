// Area lights whose radiance is a texture: what the scene file says of it, and its mean over each light.
#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <numbers>

#include "scene/build.h"

namespace irradia::loader {
namespace {

constexpr double pi = std::numbers::pi;

/// A texture of the scene, looked up as cl/texture.h does.
class Sampler {
public:
    Sampler(const Scene& scene, int texture) : scene_(scene), t_(scene.textures[static_cast<std::size_t>(texture)]) {}

    [[nodiscard]] glm::dvec3 operator()(double u, double v) const {
        const double x = (double{t_.m00} * u + double{t_.m01} * v + double{t_.m02}) * t_.width;
        const double y = (double{t_.m10} * u + double{t_.m11} * v + double{t_.m12}) * t_.height;
        if (t_.filter == IR_FILTER_NEAREST) return texel(std::floor(x), std::floor(y));
        const double x0 = std::floor(x - 0.5), y0 = std::floor(y - 0.5), a = x - 0.5 - x0, b = y - 0.5 - y0;
        return (texel(x0, y0) * (1.0 - a) + texel(x0 + 1.0, y0) * a) * (1.0 - b) +
               (texel(x0, y0 + 1.0) * (1.0 - a) + texel(x0 + 1.0, y0 + 1.0) * a) * b;
    }
    /// How many texels a stretch of (u, v) runs over.
    [[nodiscard]] double texels_along(double u, double v) const {
        return std::abs(double{t_.m00} * u + double{t_.m01} * v) * t_.width +
               std::abs(double{t_.m10} * u + double{t_.m11} * v) * t_.height;
    }
    [[nodiscard]] glm::dvec3 mean_of_texels() const {
        glm::dvec3 sum(0.0);
        for (std::uint32_t y = 0; y < t_.height; ++y)
            for (std::uint32_t x = 0; x < t_.width; ++x) sum += texel(x, y);
        return sum / (static_cast<double>(t_.width) * t_.height);
    }

private:
    const Scene& scene_;
    const shared::Texture& t_;

    [[nodiscard]] std::size_t wrapped(double i, std::uint32_t size) const {
        if (t_.wrap == IR_WRAP_CLAMP) return static_cast<std::size_t>(std::clamp(i, 0.0, size - 1.0));
        const double period = t_.wrap == IR_WRAP_MIRROR ? 2.0 * size : size;
        const double m = i - std::floor(i / period) * period;
        return static_cast<std::size_t>(m < size ? m : period - 1.0 - m);
    }
    [[nodiscard]] glm::dvec3 texel(double x, double y) const {
        const std::size_t i = wrapped(y, t_.height) * t_.width + wrapped(x, t_.width);
        if (t_.format == IR_TEXTURE_RGB32F) {
            const std::uint32_t* c = scene_.texels.data() + t_.offset + 3 * i;
            return {std::bit_cast<float>(c[0]), std::bit_cast<float>(c[1]), std::bit_cast<float>(c[2])};
        }
        const std::uint32_t c = scene_.texels[t_.offset + i];
        const glm::dvec3 raw = glm::dvec3(c & 255u, (c >> 8) & 255u, (c >> 16) & 255u) / 255.0;
        if (t_.format == IR_TEXTURE_RGBA8_LINEAR) return raw;
        return {srgb_to_linear(raw.x), srgb_to_linear(raw.y), srgb_to_linear(raw.z)};
    }
};

/// Mean of f(a, b) over the unit square, at the middles of n x n strata.
template <class F>
glm::dvec3 mean_over_square(std::size_t n, const F& f) {
    glm::dvec3 sum(0.0);
    for (std::size_t i = 0; i < n; ++i) {
        glm::dvec3 row(0.0);
        for (std::size_t k = 0; k < n; ++k)
            row += f((static_cast<double>(k) + 0.5) / static_cast<double>(n),
                     (static_cast<double>(i) + 0.5) / static_cast<double>(n));
        sum += row;
    }
    return sum / static_cast<double>(n * n);
}

/// Four strata a texel, within reason.
std::size_t strata(double texels) {
    return static_cast<std::size_t>(std::clamp(std::ceil(4.0 * texels), 16.0, 1024.0));
}

glm::dvec3 mean_over_triangle_or_quad(const Scene& scene, const shared::Light& l, const Sampler& radiance) {
    const shared::Triangle& tri = scene.triangles[l.primitive];
    std::array<glm::dvec2, 3> uv{glm::dvec2(0, 0), glm::dvec2(1, 0), glm::dvec2(0, 1)};
    if ((tri.flags & IR_TRIANGLE_HAS_UV) != 0) {
        const std::array<std::uint32_t, 3> corners{tri.v0, tri.v1, tri.v2};
        for (std::size_t k = 0; k < 3; ++k) uv[k] = {scene.vertices[corners[k]].u, scene.vertices[corners[k]].v};
    }
    // Barycentrics of the light's corner and edges in the triangle, which is one half of a quad.
    const auto position = [&](std::uint32_t i) {
        const shared::Vertex& v = scene.vertices[i];
        return glm::dvec3(v.px, v.py, v.pz);
    };
    const glm::dvec3 origin = position(tri.v0), e1 = position(tri.v1) - origin, e2 = position(tri.v2) - origin;
    const double e11 = glm::dot(e1, e1), e12 = glm::dot(e1, e2), e22 = glm::dot(e2, e2), det = e11 * e22 - e12 * e12;
    const auto mapped = [&](const glm::dvec3& d) {
        const double d1 = glm::dot(d, e1), d2 = glm::dot(d, e2);
        return (uv[1] - uv[0]) * ((d1 * e22 - d2 * e12) / det) + (uv[2] - uv[0]) * ((d2 * e11 - d1 * e12) / det);
    };
    const glm::dvec2 corner = uv[0] + mapped(glm::dvec3(l.px, l.py, l.pz) - origin),
                     along1 = mapped({l.e1x, l.e1y, l.e1z}), along2 = mapped({l.e2x, l.e2y, l.e2z});
    const std::size_t n =
        strata(std::max(radiance.texels_along(along1.x, along1.y), radiance.texels_along(along2.x, along2.y)));
    return mean_over_square(n, [&](double a, double b) {
        if (l.kind == IR_LIGHT_TRIANGLE && a + b > 1.0) a = 1.0 - a, b = 1.0 - b;
        const glm::dvec2 at = corner + along1 * a + along2 * b;
        return radiance(at.x, at.y);
    });
}

glm::dvec3 mean_over_light(const Scene& scene, const shared::Light& l, const Sampler& radiance) {
    if (l.kind == IR_LIGHT_QUAD || l.kind == IR_LIGHT_TRIANGLE) return mean_over_triangle_or_quad(scene, l, radiance);
    // Coordinates that go over the area uniformly, of surfaces that show the whole unit square of texture coordinates.
    return mean_over_square(strata(radiance.texels_along(1.0, 1.0)), [&](double a, double b) {
        if (l.kind == IR_LIGHT_SPHERE) return radiance(a, std::acos(1.0 - 2.0 * b) / pi);
        if (l.kind == IR_LIGHT_DISK) return radiance(std::sqrt(a), b);
        return radiance(a, b);
    });
}

int add_radiance_texture(const Context& context, const Document& document, TextureTable& textures, const Node& node) {
    TextureSpec spec = read_texture(context, document, node);
    spec.unbounded = true;
    return textures.add(spec);
}

}  // namespace

void read_radiance_textures(const Context& context, const Document& document, TextureTable& textures,
                            std::vector<Shape>& shapes) {
    for (Shape& shape : shapes) {
        if (!shape.radiance) continue;
        Properties p(context, document, *shape.node);
        const auto emitters = p.objects("emitter");
        if (emitters.empty()) continue;
        Properties emitter(context, document, *emitters.front());
        const Node* radiance = emitter.property("radiance");
        if (radiance && is_bitmap(*radiance))
            shape.radiance_texture = add_radiance_texture(context, document, textures, *radiance);
    }
}

void set_mean_of_textures(const Scene& scene, std::vector<Shape>& shapes) {
    for (Shape& shape : shapes) {
        if (shape.radiance_texture == IR_NO_TEXTURE) continue;
        const shared::Texture& t = scene.textures[static_cast<std::size_t>(shape.radiance_texture)];
        if (t.format == IR_TEXTURE_RGB32F)
            for (std::size_t i = 0, n = std::size_t{t.width} * t.height * 3; i < n; ++i)
                if (const float v = std::bit_cast<float>(scene.texels[t.offset + i]); v < 0.0f)
                    fail(*shape.node, fmt::format("{}: its radiance is {} at pixel ({}, {}) of the texture; no "
                                                  "negative value was expected",
                                                  describe(*shape.node), v, i / 3 % t.width, i / 3 / t.width));
        shape.radiance = Sampler(scene, shape.radiance_texture).mean_of_texels();
    }
}

void set_mean_of_textured_lights(Scene& scene) {
    for (shared::Light& l : scene.lights) {
        if (l.texture == IR_NO_TEXTURE || l.kind == IR_LIGHT_ENVMAP) continue;
        // Never nothing: what the strata miss is chosen too, if rarely.
        const glm::dvec3 mean =
            glm::max(mean_over_light(scene, l, Sampler(scene, l.texture)), 1e-3 * glm::dvec3(l.r, l.g, l.b));
        l.r = static_cast<float>(mean.x);
        l.g = static_cast<float>(mean.y);
        l.b = static_cast<float>(mean.z);
    }
}

}  // namespace irradia::loader
