#include "app/report_pictures.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <span>

#include "app/progress.h"
#include "app/report_html.h"
#include "image/image_check.h"
#include "irradia/Error.h"
#include "pictures/oiio.h"

namespace irradia::app {
namespace {

std::uint8_t byte(float share) {
    return static_cast<std::uint8_t>(std::lround(255.0f * std::clamp(share, 0.0f, 1.0f)));
}

/// Values on a scale through a colour map; those that are not counted are dark grey.
Picture mapped(const char* map, int width, int height, std::span<const float> values, const Scale& scale,
               const std::vector<bool>& counted) {
    std::vector<float> shares(values.size());
    const double span = scale.high - scale.low;
    for (std::size_t i = 0; i < values.size(); ++i)
        shares[i] = span > 0 ? static_cast<float>(std::clamp((values[i] - scale.low) / span, 0.0, 1.0)) : 1.0f;
    Picture out{width, height, map_colours(map, shares)};
    for (std::size_t i = 0; i < counted.size(); ++i)
        if (!counted[i]) std::fill_n(&out.rgb[3 * i], 3, std::uint8_t{40});
    return out;
}

// The thousandth part of the values beyond which do not decide about the colours of all others.
double high_end(std::vector<float> values) {
    if (values.empty()) return 0;
    const auto at =
        values.begin() + static_cast<std::ptrdiff_t>(std::ceil(0.999 * static_cast<double>(values.size() - 1)));
    std::nth_element(values.begin(), at, values.end());
    return static_cast<double>(*at);
}

LayerView depth_view(const Layer& layer, int width, int height) {
    std::vector<bool> counted;
    std::vector<float> seen;
    for (const float d : layer.data) {
        counted.push_back(d > 0);
        if (d > 0) seen.push_back(d);
    }
    LayerView view{layer.name, "Depth", "Distance from the camera along the ray; dark grey: no surface.", {}};
    view.scale = {seen.empty() ? 0.0 : static_cast<double>(*std::min_element(seen.begin(), seen.end())), high_end(seen),
                  false, "world units", scale_colours("viridis")};
    view.picture = mapped("viridis", width, height, layer.data, view.scale, counted);
    return view;
}

LayerView records_view(const Layer& layer, int width, int height) {
    const float most = *std::max_element(layer.data.begin(), layer.data.end());
    std::vector<bool> none(layer.data.size());
    std::size_t pixels = 0;
    for (std::size_t i = 0; i < none.size(); ++i) {
        none[i] = layer.data[i] > 0;
        pixels += none[i] ? 1 : 0;
    }
    const std::string text =
        pixels > 0 ? fmt::format("Pixels whose lack of records made new ones: {} of {}.",
                                 count_text(static_cast<double>(pixels)), count_text(static_cast<double>(none.size())))
                   : "Pixels whose lack of records made new ones: none.";
    LayerView view{layer.name, "Records made", text, {}};
    // One record is to be seen against none.
    const double low = 1 - std::max(1.0, static_cast<double>(most) - 1);
    const Scale inner{low, std::max(2.0, static_cast<double>(most)), false, "", {}};
    view.picture = mapped("inferno", width, height, layer.data, inner, none);
    if (most > 1) view.scale = {1, static_cast<double>(most), false, "records a pixel", scale_colours("inferno", 0.5f)};
    return view;
}

LayerView plain_view(const Layer& layer, const std::string& title, const std::string& text, int width, int height,
                     float scale, float offset) {
    LayerView view{layer.name, title, text, {width, height, {}}};
    view.picture.rgb.reserve(3 * layer.data.size() / static_cast<std::size_t>(layer.channels));
    for (const float value : layer.data)
        view.picture.rgb.insert(view.picture.rgb.end(), layer.channels == 1 ? 3 : 1, byte(scale * value + offset));
    return view;
}

}  // namespace

std::vector<std::uint8_t> map_colours(const char* map, const std::vector<float>& values) {
    std::vector<float> linear(3 * values.size());
    const std::string why =
        oiio::library().colour_map(map, static_cast<int>(values.size()), 1, values.data(), linear.data());
    if (!why.empty()) throw Error(fmt::format("the colour map {} cannot be had: {}", map, why));
    std::vector<std::uint8_t> bytes(linear.size());
    std::transform(linear.begin(), linear.end(), bytes.begin(), [](float x) { return byte(srgb_encode(x)); });
    return bytes;
}

std::vector<std::string> scale_colours(const char* map, float from, float to) {
    constexpr std::size_t n = 17;
    std::vector<float> values;
    for (std::size_t i = 0; i < n; ++i)
        values.push_back(from + (to - from) * static_cast<float>(i) / static_cast<float>(n - 1));
    const std::vector<std::uint8_t> bytes = map_colours(map, values);
    std::vector<std::string> out;
    for (std::size_t i = 0; i < n; ++i)
        out.push_back(fmt::format("#{:02x}{:02x}{:02x}", bytes[3 * i], bytes[3 * i + 1], bytes[3 * i + 2]));
    return out;
}

Picture tone_mapped(const Layer& layer, int width, int height, double exposure) {
    Picture out{width, height, std::vector<std::uint8_t>(layer.data.size())};
    const float scale = static_cast<float>(std::exp2(exposure));
    std::transform(layer.data.begin(), layer.data.end(), out.rgb.begin(),
                   [&](float x) { return byte(srgb_encode(scale * x)); });
    return out;
}

LayerView layer_view(const Layer& layer, int width, int height, double exposure) {
    const auto light = [&](const char* title, const char* text) {
        return LayerView{layer.name, title, text, tone_mapped(layer, width, height, exposure)};
    };
    if (layer.name == "direct") return light("Direct light", "Light that came from lamps at once, and lamps.");
    if (layer.name == "indirect")
        return light("Indirect light", "Light that was reflected before: what the caches answer for.");
    if (layer.name == "albedo") {
        LayerView view{layer.name, "Albedo", "Share of light that the surface reflects, in sRGB.", {}};
        view.picture = tone_mapped(layer, width, height, 0);
        return view;
    }
    if (layer.name == "normal")
        return plain_view(layer, "Normal", "Shading normal: red, green, blue are x, y, z from -1 to 1.", width, height,
                          0.5f, 0.5f);
    if (layer.name == "depth") return depth_view(layer, width, height);
    if (layer.name == "records") return records_view(layer, width, height);
    return plain_view(layer, "Counted", "White: pixels that show no lamp, which an estimate of the error counts.",
                      width, height, 1, 0);
}

const Layer* find_layer(const Image& image, const std::string& name) {
    const auto at =
        std::find_if(image.layers.begin(), image.layers.end(), [&](const Layer& layer) { return layer.name == name; });
    return at == image.layers.end() ? nullptr : &*at;
}

std::string png_address(const Picture& picture) {
    const oiio::Png out{"a picture of the report", picture.width, picture.height, picture.rgb.data()};
    std::vector<unsigned char> bytes;
    const std::string why = oiio::library().encode(out, bytes);
    if (!why.empty()) throw Error(out.path + ": " + why);
    return "data:image/png;base64," + html::base64(bytes);
}

}  // namespace irradia::app
