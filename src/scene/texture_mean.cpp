#include <bit>

#include "scene/build.h"

namespace irradia::loader {

double mean_of_texture(const Scene& scene, const shared::Texture& t) {
    const auto number = [&](std::size_t i) {
        return static_cast<double>(std::bit_cast<float>(scene.texels[t.offset + i]));
    };
    if (t.format == IR_TEXTURE_CHECKERBOARD)
        return (number(0) + number(1) + number(2) + number(3) + number(4) + number(5)) / 6.0;
    if (t.format == IR_TEXTURE_VERTEX_COLOUR) return 0.5;  // any: Mitsuba has none
    const std::size_t count = std::size_t{t.width} * t.height;
    glm::dvec3 sum(0.0);
    if (t.format == IR_TEXTURE_RGB32F) {
        for (std::size_t i = 0; i < count; ++i) sum += glm::dvec3(number(3 * i), number(3 * i + 1), number(3 * i + 2));
    } else {
        double decoded[256];
        for (int i = 0; i < 256; ++i)
            decoded[i] = t.format == IR_TEXTURE_RGBA8_LINEAR ? i / 255.0 : srgb_to_linear(i / 255.0);
        for (std::size_t i = 0; i < count; ++i) {
            const std::uint32_t rgb = scene.texels[t.offset + i];
            sum += glm::dvec3(decoded[rgb & 255u], decoded[(rgb >> 8) & 255u], decoded[(rgb >> 16) & 255u]);
        }
    }
    return luminance(sum) / static_cast<double>(count);
}

}  // namespace irradia::loader
