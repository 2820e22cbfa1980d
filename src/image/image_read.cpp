// Pictures from files, as linear float layers.
#include <fmt/format.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <fstream>
#include <memory>
#include <vector>

#include "core/pfm.h"
#include "image/image_check.h"
#include "irradia/Error.h"
#include "pictures/oiio.h"

namespace irradia {
namespace {

// Place of a channel in its layer: R G B A, X Y Z.
int rank_of(const std::string& channel) {
    static const std::string order = "RXrxYGgyBbZzAaWw";
    const std::size_t at = channel.size() == 1 ? order.find(channel) : std::string::npos;
    return at == std::string::npos ? static_cast<int>(order.size()) : static_cast<int>(at);
}

struct Found {
    std::string name;           // layer
    std::vector<int> channels;  // indices in the file, in the layer's order
};

// Groups "direct.R", "direct.G", ... by what stands before the last dot; the picture itself ("R") comes first.
std::vector<Found> layers_of(const std::vector<std::string>& channels) {
    std::vector<Found> layers{{"", {}}};
    std::vector<std::string> suffix(channels.size());
    for (std::size_t c = 0; c < channels.size(); ++c) {
        const std::string& full = channels[c];
        const std::size_t dot = full.rfind('.');
        const std::string name = dot == std::string::npos ? "" : full.substr(0, dot);
        suffix[c] = dot == std::string::npos ? full : full.substr(dot + 1);
        auto layer = std::find_if(layers.begin(), layers.end(), [&](const Found& l) { return l.name == name; });
        if (layer == layers.end()) layer = layers.insert(layers.end(), {name, {}});
        layer->channels.push_back(static_cast<int>(c));
    }
    for (Found& layer : layers)
        std::stable_sort(layer.channels.begin(), layer.channels.end(), [&](int a, int b) {
            return rank_of(suffix[static_cast<std::size_t>(a)]) < rank_of(suffix[static_cast<std::size_t>(b)]);
        });
    if (layers.front().channels.empty()) layers.erase(layers.begin());  // a file of named layers only
    return layers;
}

}  // namespace

Image read_image(const std::string& path) {
    if (extension_of(path) == ".pfm") return read_pfm(path);
    std::string why;
    const std::unique_ptr<oiio::Input> in = oiio::library().open(path, false, why);
    if (!in) {
        if (!std::ifstream(path)) why = std::strerror(errno);
        throw Error(fmt::format("{}: cannot be read: {}", path, why));
    }
    const std::size_t pixels = static_cast<std::size_t>(in->width) * static_cast<std::size_t>(in->height);
    const std::size_t stride = in->channels.size();
    std::vector<float> all(pixels * stride);
    why = in->read(all.data());
    if (!why.empty()) throw Error(fmt::format("{}: cannot be read: {}", path, why));

    Image image;
    image.width = in->width;
    image.height = in->height;
    image.metadata = in->metadata;
    for (const Found& found : layers_of(in->channels)) {
        const bool beauty = image.layers.empty();
        // The picture is always RGB: grey is repeated, alpha dropped.
        std::vector<int> channels = found.channels;
        if (beauty && channels.size() < 3) channels.assign(3, channels.front());
        if (beauty) channels.resize(3);
        Layer layer{beauty ? "" : found.name, static_cast<int>(channels.size()), {}};
        layer.data.resize(pixels * channels.size());
        for (std::size_t p = 0; p < pixels; ++p)
            for (std::size_t c = 0; c < channels.size(); ++c)
                layer.data[p * channels.size() + c] = all[p * stride + static_cast<std::size_t>(channels[c])];
        image.layers.push_back(std::move(layer));
    }
    if (in->srgb)
        for (float& value : image.layers.front().data) value = srgb_decode(value);
    return image;
}

}  // namespace irradia
