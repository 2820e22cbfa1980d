// EXR through OpenEXR and PNG through OpenImageIO, made in memory and then written as one file that exists whole or not
// at all.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <vector>

#include "core/aside_file.h"
#include "core/pfm.h"
#include "image/image_check.h"
#include "irradia/Error.h"
#include "pictures/exr.h"
#include "pictures/oiio.h"

namespace irradia {
namespace {

/// By the module that knows the format.
template <typename Library, typename Picture>
void write_with(const Library& library, const Picture& out) {
    std::vector<unsigned char> bytes;
    const std::string why = library.encode(out, bytes);
    if (!why.empty()) throw Error(fmt::format("{}: {}", out.path, why));
    AsideFile file(out.path);
    file.write(bytes.data(), bytes.size());
    file.commit();
}

void write_exr(const std::string& path, const Image& image, int threads) {
    exr::Output out{path, image.width, image.height, {}, image.metadata, threads};
    for (const Layer& layer : image.layers)
        for (int c = 0; c < layer.channels; ++c)
            out.channels.push_back(
                {channel_name(layer, c), layer.data.data() + c, static_cast<std::size_t>(layer.channels)});
    write_with(exr::library(), out);
}

void write_png(const std::string& path, const Image& image, double exposure) {
    const Layer& beauty = image.layers.front();
    const std::size_t pixels = static_cast<std::size_t>(image.width) * static_cast<std::size_t>(image.height);
    const std::size_t n = static_cast<std::size_t>(beauty.channels);
    const float scale = static_cast<float>(std::exp2(exposure));
    std::vector<std::uint8_t> bytes(pixels * 3);
    for (std::size_t p = 0; p < pixels; ++p)
        for (std::size_t c = 0; c < 3; ++c) {
            const float linear = scale * beauty.data[p * n + (n < 3 ? 0 : c)];
            bytes[p * 3 + c] = static_cast<std::uint8_t>(std::lround(255.0f * srgb_encode(linear)));
        }
    write_with(oiio::library(), oiio::Png{path, image.width, image.height, bytes.data(), image.metadata});
}

}  // namespace

void write_image(const std::string& path, const Image& image, double exposure, int threads) {
    const std::string extension = extension_of(path);
    if (extension != ".exr" && extension != ".png" && extension != ".pfm")
        throw Error(fmt::format("{}: unknown kind of picture '{}', expected .exr, .png or .pfm", path, extension));
    check_image(path, image);
    if (extension == ".exr")
        write_exr(path, image, threads);
    else if (extension == ".png")
        write_png(path, image, exposure);
    else
        write_pfm(path, image);
}

}  // namespace irradia
