// EXR and PNG through OpenImageIO, made in memory and then written as one file that exists whole or not at all.
#include <OpenImageIO/filesystem.h>
#include <OpenImageIO/imageio.h>
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <memory>
#include <vector>

#include "core/aside_file.h"
#include "core/pfm.h"
#include "image/image_check.h"
#include "irradia/Error.h"

namespace irradia {
namespace {

void add_metadata(OIIO::ImageSpec& spec, const Image& image) {
    spec.attribute("Software", "Irradia");
    spec.attribute("DateTime", "");  // else OpenImageIO puts the clock's: the same picture is the same bytes
    for (const auto& [key, value] : image.metadata) spec.attribute(key, value);
}

// `data` holds what `spec` says, of type `type`, rows from the top.
void write_with_oiio(const std::string& path, const char* format, const OIIO::ImageSpec& spec, OIIO::TypeDesc type,
                     const void* data) {
    const std::unique_ptr<OIIO::ImageOutput> out = OIIO::ImageOutput::create(format);
    if (!out) throw Error(fmt::format("{}: OpenImageIO cannot write {}: {}", path, format, OIIO::geterror()));
    std::vector<unsigned char> bytes;
    OIIO::Filesystem::IOVecOutput memory(bytes);
    out->set_ioproxy(&memory);
    const bool written = out->open(path, spec) && out->write_image(type, data);
    const bool closed = out->close();
    if (!written || !closed) {
        std::string why = out->geterror();
        std::replace(why.begin(), why.end(), '\n', ' ');
        throw Error(fmt::format("{}: cannot be written: {}", path, why));
    }
    AsideFile file(path);
    file.write(bytes.data(), bytes.size());
    file.commit();
}

void write_exr(const std::string& path, const Image& image) {
    int channels = 0;
    for (const Layer& layer : image.layers) channels += layer.channels;
    OIIO::ImageSpec spec(image.width, image.height, channels, OIIO::TypeDesc::FLOAT);
    spec.channelnames.clear();
    for (const Layer& layer : image.layers)
        for (int c = 0; c < layer.channels; ++c) spec.channelnames.push_back(channel_name(layer, c));
    spec.attribute("compression", "zip");
    spec.attribute("oiio:ColorSpace", "Linear");
    add_metadata(spec, image);

    const std::size_t pixels = static_cast<std::size_t>(image.width) * static_cast<std::size_t>(image.height);
    const std::size_t stride = static_cast<std::size_t>(channels);
    std::vector<float> interleaved(pixels * stride);
    std::size_t first = 0;
    for (const Layer& layer : image.layers) {
        const std::size_t n = static_cast<std::size_t>(layer.channels);
        for (std::size_t p = 0; p < pixels; ++p)
            std::memcpy(&interleaved[p * stride + first], &layer.data[p * n], n * sizeof(float));
        first += n;
    }
    write_with_oiio(path, "openexr", spec, OIIO::TypeDesc::FLOAT, interleaved.data());
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
    OIIO::ImageSpec spec(image.width, image.height, 3, OIIO::TypeDesc::UINT8);
    spec.attribute("oiio:ColorSpace", "sRGB");
    add_metadata(spec, image);
    write_with_oiio(path, "png", spec, OIIO::TypeDesc::UINT8, bytes.data());
}

}  // namespace

void write_image(const std::string& path, const Image& image, double exposure) {
    const std::string extension = extension_of(path);
    if (extension != ".exr" && extension != ".png" && extension != ".pfm")
        throw Error(fmt::format("{}: unknown kind of picture '{}', expected .exr, .png or .pfm", path, extension));
    check_image(path, image);
    if (extension == ".exr")
        write_exr(path, image);
    else if (extension == ".png")
        write_png(path, image, exposure);
    else
        write_pfm(path, image);
}

}  // namespace irradia
