#include "core/pfm.h"

#include <algorithm>
#include <bit>
#include <cerrno>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <vector>

#include "core/aside_file.h"
#include "irradia/Error.h"

namespace irradia {

void write_pfm(const std::string& path, const Image& image) {
    if (image.layers.empty() || image.width <= 0 || image.height <= 0)
        throw Error(path + ": cannot be written: the picture is empty");
    const Layer& layer = image.layers[0];
    const auto width = static_cast<std::size_t>(image.width), height = static_cast<std::size_t>(image.height);
    const auto channels = static_cast<std::size_t>(layer.channels);
    if ((channels != 1 && channels < 3) || layer.data.size() != width * height * channels)
        throw Error(path + ": cannot be written: " + std::to_string(layer.data.size()) + " values for " +
                    std::to_string(width) + " x " + std::to_string(height) + " pixels of " + std::to_string(channels) +
                    " channels");
    const auto bad = std::find_if(layer.data.begin(), layer.data.end(), [](float v) { return !std::isfinite(v); });
    if (bad != layer.data.end()) {
        const auto at = static_cast<std::size_t>(bad - layer.data.begin());
        throw Error(path + ": not written: pixel (" + std::to_string(at / channels % width) + ", " +
                    std::to_string(at / channels / width) + "), channel " + std::to_string(at % channels) + " is " +
                    (std::isnan(*bad) ? "not a number" : "infinite"));
    }

    AsideFile out(path);
    // The scale's sign states the byte order: negative is little endian.
    const std::string header = "PF\n" + std::to_string(width) + " " + std::to_string(height) +
                               (std::endian::native == std::endian::little ? "\n-1.0\n" : "\n1.0\n");
    out.write(header.data(), header.size());
    std::vector<float> row(width * 3);
    for (std::size_t y = height; y-- > 0;) {
        for (std::size_t x = 0; x < width; ++x)
            for (std::size_t c = 0; c < 3; ++c)
                row[x * 3 + c] = layer.data[(y * width + x) * channels + (channels == 1 ? 0 : c)];
        out.write(row.data(), row.size() * sizeof(float));
    }
    out.commit();
}

Image read_pfm(const std::string& path) {
    errno = 0;
    std::ifstream in(path, std::ios::binary);
    if (!in) throw Error(path + ": cannot be read: " + std::strerror(errno));
    std::string kind;
    int width = 0, height = 0;
    double scale = 0;
    in >> kind >> width >> height >> scale;
    in.get();  // the one white-space character that ends the header
    if (!in || (kind != "PF" && kind != "Pf") || width <= 0 || height <= 0 || !std::isfinite(scale) || scale == 0)
        throw Error(path + ": not a PFM file: expected 'PF' or 'Pf', width, height, scale");
    const std::uint64_t w = static_cast<std::uint64_t>(width), h = static_cast<std::uint64_t>(height);
    const std::uint64_t channels = kind == "PF" ? 3 : 1;
    std::error_code error;
    const std::uint64_t size = std::filesystem::file_size(path, error);
    const auto header = static_cast<std::uint64_t>(in.tellg());
    if (error || size < header || (size - header) / 4 / channels / w < h)  // divided, so that nothing overflows
        throw Error(path + ": truncated: " + std::to_string(width) + " x " + std::to_string(height) +
                    " pixels were expected");
    const bool swap = (scale < 0) != (std::endian::native == std::endian::little);
    Image image{width, height, {{"", 3, UntouchedVector<float>(w * h * 3)}}, {}};
    std::vector<float> row(w * channels);
    for (std::uint64_t y = h; y-- > 0;) {
        if (!in.read(reinterpret_cast<char*>(row.data()), static_cast<std::streamsize>(row.size() * sizeof(float))))
            throw Error(path + ": cannot be read: the file became shorter");
        for (std::uint64_t i = 0; i < w * 3; ++i) {
            std::uint32_t bits = std::bit_cast<std::uint32_t>(row[channels == 3 ? i : i / 3]);
            if (swap) bits = bits >> 24 | (bits >> 8 & 0xff00u) | (bits << 8 & 0xff0000u) | bits << 24;
            image.layers[0].data[y * w * 3 + i] = std::bit_cast<float>(bits);
        }
    }
    return image;
}

}  // namespace irradia
