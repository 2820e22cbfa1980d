#include <fmt/format.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <atomic>
#include <bit>
#include <cmath>
#include <exception>

#include "pictures/oiio.h"
#include "scene/build.h"
#include "scene/parts.h"
#include "scene/picture_check.h"

namespace irradia::loader {
namespace {

template <class T>
std::vector<T> three_channels(const std::vector<T>& data, int channels) {
    if (channels == 3) return data;
    std::vector<T> out(data.size() / static_cast<std::size_t>(channels) * 3);
    for (std::size_t i = 0, n = out.size() / 3; i < n; ++i)
        for (std::size_t c = 0; c < 3; ++c)  // grey, grey + alpha: repeated; RGBA: alpha dropped
            out[3 * i + c] = data[i * static_cast<std::size_t>(channels) + (channels < 3 ? 0 : c)];
    return out;
}

Picture read_picture(const std::string& path, bool raw) {
    check_picture_file(path);
    std::string why;
    const std::unique_ptr<oiio::Input> input = oiio::library().open(path, true, why);
    if (!input) throw Error(fmt::format("texture '{}' cannot be read: {}", path, why));
    const int width = input->width, height = input->height, channels = static_cast<int>(input->channels.size());
    if (width < 1 || height < 1 || channels < 1)
        throw Error(fmt::format("texture '{}' is empty ({} x {}, {} channels)", path, width, height, channels));
    if (input->depth > 1) throw Error(fmt::format("texture '{}' is a volume, a picture was expected", path));
    const bool bytes = input->values == oiio::Values::bytes;
    check_picture_size(path, width, height, channels, bytes ? 1 : sizeof(float));
    Picture picture;
    picture.width = static_cast<std::uint32_t>(width);
    picture.height = static_cast<std::uint32_t>(height);
    const std::size_t count = static_cast<std::size_t>(width) * height * channels;
    if (bytes) {
        std::vector<std::uint8_t> data(count);
        why = input->read(data.data());
        picture.bytes = three_channels(data, channels);
    } else {
        std::vector<float> data(count);
        why = input->read(data.data());
        picture.floats = three_channels(data, channels);
        // 16-bit integer formats carry sRGB-encoded values, floating point ones are linear.
        if (!raw && input->values == oiio::Values::integers)
            for (auto& v : picture.floats) v = static_cast<float>(srgb_to_linear(v));
    }
    if (!why.empty()) throw Error(fmt::format("texture '{}' cannot be read: {}", path, why));
    return picture;
}

bool is_bitmap(const TextureSpec& spec) { return !spec.checkerboard && !spec.vertex_colours; }

bool same(const TextureSpec& a, const TextureSpec& b) {
    return a.path == b.path && a.raw == b.raw && a.unbounded == b.unbounded && a.wrap == b.wrap &&
           a.filter == b.filter && a.to_uv == b.to_uv && a.checkerboard == b.checkerboard && a.colours == b.colours &&
           a.vertex_colours == b.vertex_colours;
}

}  // namespace

std::shared_ptr<const Picture> picture_of(const Context& context, const std::string& path, bool raw) {
    return from_parts(context.options.parts, &SceneParts::Impl::pictures, path, raw ? "raw" : "",
                      [&] { return read_picture(path, raw); });
}

int TextureTable::add(const TextureSpec& spec) {
    for (std::size_t i = 0; i < specs_.size(); ++i)
        if (same(specs_[i], spec)) return static_cast<int>(i);
    specs_.push_back(spec);
    return static_cast<int>(specs_.size() - 1);
}

void TextureTable::load(const Context& context, Scene& scene) const {
    // One read a file: textures that differ in wrap or to_uv share their texels.
    std::vector<std::size_t> first(specs_.size());
    for (std::size_t i = 0; i < specs_.size(); ++i) {
        first[i] = i;
        for (std::size_t j = 0; j < i; ++j)
            if (is_bitmap(specs_[i]) && specs_[j].path == specs_[i].path && specs_[j].raw == specs_[i].raw &&
                specs_[j].unbounded == specs_[i].unbounded) {
                first[i] = j;
                break;
            }
    }
    std::vector<std::shared_ptr<const Picture>> pictures(specs_.size());
    std::vector<std::exception_ptr> errors(specs_.size());
    std::atomic<std::size_t> done = 0;
    tbb::parallel_for(std::size_t{0}, specs_.size(), [&](std::size_t i) {
        if (first[i] != i || !is_bitmap(specs_[i])) return;
        try {
            pictures[i] = picture_of(context, specs_[i].path, specs_[i].raw);
        } catch (...) {
            errors[i] = std::current_exception();
        }
        context.progress("textures", static_cast<double>(++done) / static_cast<double>(specs_.size()));
    });
    const auto words_of = [](const Picture& picture) {
        return std::size_t{picture.width} * picture.height * (picture.bytes.empty() ? 3 : 1);
    };
    std::size_t all_words = scene.texels.size();  // at once: a step each texture would copy those before it every time
    for (const auto& picture : pictures)
        if (picture) all_words += words_of(*picture);
    scene.texels.reserve(std::min<std::size_t>(all_words, 0xffffffffu));
    for (std::size_t i = 0; i < specs_.size(); ++i) {
        const auto& spec = specs_[i];
        if (errors[i]) {
            try {
                std::rethrow_exception(errors[i]);
            } catch (const Error& error) {
                fail(*spec.node, error.what());
            }
        }
        shared::Texture texture{};
        texture.wrap = spec.wrap;
        texture.filter = spec.filter;
        texture.m00 = static_cast<float>(spec.to_uv[0][0]);
        texture.m01 = static_cast<float>(spec.to_uv[1][0]);
        texture.m02 = static_cast<float>(spec.to_uv[3][0]);
        texture.m10 = static_cast<float>(spec.to_uv[0][1]);
        texture.m11 = static_cast<float>(spec.to_uv[1][1]);
        texture.m12 = static_cast<float>(spec.to_uv[3][1]);
        if (!is_bitmap(spec)) {
            texture.width = texture.height = 1;
            texture.format = spec.checkerboard ? IR_TEXTURE_CHECKERBOARD : IR_TEXTURE_VERTEX_COLOUR;
            texture.offset = static_cast<std::uint32_t>(scene.texels.size());  // vertex colours: add_vertex_colours()
            if (spec.checkerboard)
                for (const glm::dvec3& colour : spec.colours)
                    for (int c = 0; c < 3; ++c)
                        scene.texels.push_back(std::bit_cast<std::uint32_t>(static_cast<float>(colour[c])));
            scene.textures.push_back(texture);
            continue;
        }
        if (first[i] != i) {
            const auto& original = scene.textures[first[i]];
            texture.offset = original.offset;
            texture.width = original.width;
            texture.height = original.height;
            texture.format = original.format;
            scene.textures.push_back(texture);
            continue;
        }
        const Picture& picture = *pictures[i];
        texture.width = picture.width;
        texture.height = picture.height;
        if (scene.texels.size() + words_of(picture) > 0xffffffffu)
            fail(*spec.node, "the scene's textures exceed 16 GiB");
        texture.offset = static_cast<std::uint32_t>(scene.texels.size());
        if (!picture.bytes.empty()) {
            texture.format = spec.raw ? IR_TEXTURE_RGBA8_LINEAR : IR_TEXTURE_RGBA8_SRGB;
            for (std::size_t t = 0; t < picture.bytes.size(); t += 3)
                scene.texels.push_back(picture.bytes[t] | static_cast<std::uint32_t>(picture.bytes[t + 1]) << 8 |
                                       static_cast<std::uint32_t>(picture.bytes[t + 2]) << 16 | 0xff000000u);
        } else {
            texture.format = IR_TEXTURE_RGB32F;
            std::size_t clamped = 0;
            for (std::size_t t = 0; t < picture.floats.size(); ++t) {
                float v = picture.floats[t];
                if (!std::isfinite(v))
                    fail(*spec.node, fmt::format("texture '{}' has a value that is not finite at pixel ({}, {})",
                                                 spec.path, t / 3 % picture.width, t / 3 / picture.width));
                if (!spec.unbounded) {
                    if (v < 0.0f || v > 1.0f) ++clamped;
                    v = std::min(std::max(v, 0.0f), 1.0f);
                }
                scene.texels.push_back(std::bit_cast<std::uint32_t>(v));
            }
            if (clamped)
                context.warn(
                    *spec.node,
                    fmt::format("texture '{}': {} values outside [0, 1] clamped, as a reflectance cannot exceed 1",
                                spec.path, clamped));
        }
        scene.textures.push_back(texture);
        pictures[i].reset();
    }
}

glm::dvec3 mean_colour(const Context& context, const Node& node, const std::string& path, bool raw,
                       double (*row_weight)(double)) {
    std::shared_ptr<const Picture> read;
    try {
        read = picture_of(context, path, raw);
    } catch (const Error& error) {
        fail(node, error.what());
    }
    const Picture& picture = *read;
    double table[256];
    for (int i = 0; i < 256; ++i) table[i] = raw ? i / 255.0 : srgb_to_linear(i / 255.0);
    glm::dvec3 sum(0.0);
    double total = 0.0;
    for (std::size_t y = 0; y < picture.height; ++y) {
        const double weight = row_weight((static_cast<double>(y) + 0.5) / picture.height);
        glm::dvec3 row(0.0);
        for (std::size_t x = 0; x < picture.width; ++x)
            for (std::size_t c = 0; c < 3; ++c) {
                const std::size_t i = (y * picture.width + x) * 3 + c;
                const double v =
                    picture.bytes.empty() ? static_cast<double>(picture.floats[i]) : table[picture.bytes[i]];
                if (!std::isfinite(v))
                    fail(node,
                         fmt::format("texture '{}' has a value that is not finite at pixel ({}, {})", path, x, y));
                row[static_cast<int>(c)] += v;
            }
        sum += weight * row;
        total += weight * picture.width;
    }
    return glm::max(sum / total, glm::dvec3(0.0));
}

}  // namespace irradia::loader
