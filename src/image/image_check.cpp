#include "image/image_check.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <filesystem>

#include "irradia/Error.h"

namespace irradia {

std::string channel_name(const Layer& layer, int c) {
    const bool axes = layer.name == "normal" || layer.name == "position";
    std::string channel;
    if (layer.channels == 1)
        channel += layer.name == "depth" ? 'Z' : 'Y';
    else if (c < 4)
        channel += (axes ? "XYZW" : "RGBA")[c];
    else
        channel = fmt::format("c{}", c);
    return layer.name.empty() ? channel : layer.name + "." + channel;
}

void check_image(const std::string& path, const Image& image) {
    if (image.width <= 0 || image.height <= 0 || image.layers.empty())
        throw Error(fmt::format("{}: a picture of {} x {} pixels and {} layers cannot be written", path, image.width,
                                image.height, image.layers.size()));
    const std::size_t pixels = static_cast<std::size_t>(image.width) * static_cast<std::size_t>(image.height);
    for (const Layer& layer : image.layers) {
        const std::string name = layer.name.empty() ? "picture" : layer.name;
        const std::size_t channels = static_cast<std::size_t>(std::max(layer.channels, 0));
        if (channels == 0 || layer.data.size() != pixels * channels)
            throw Error(fmt::format("{}: layer '{}' has {} values, expected {} x {} x {}", path, name,
                                    layer.data.size(), image.width, image.height, layer.channels));
        for (std::size_t i = 0; i < layer.data.size(); ++i) {
            if (std::isfinite(layer.data[i])) continue;
            const std::size_t pixel = i / channels;
            const std::size_t width = static_cast<std::size_t>(image.width);
            throw Error(fmt::format("{}: not written: layer '{}' is {} at pixel ({}, {}), channel {}", path, name,
                                    layer.data[i], pixel % width, pixel / width,
                                    channel_name(layer, static_cast<int>(i % channels))));
        }
    }
}

std::string extension_of(const std::string& path) {
    std::string extension = std::filesystem::path(path).extension().string();
    std::transform(extension.begin(), extension.end(), extension.begin(),
                   [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
    return extension;
}

float srgb_encode(float linear) {
    const float x = std::clamp(linear, 0.0f, 1.0f);
    return x <= 0.0031308f ? 12.92f * x : 1.055f * std::pow(x, 1.0f / 2.4f) - 0.055f;
}

float srgb_decode(float encoded) {
    return encoded <= 0.04045f ? encoded / 12.92f : std::pow((encoded + 0.055f) / 1.055f, 2.4f);
}

}  // namespace irradia
