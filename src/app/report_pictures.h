// Layers as pictures to look at: 8-bit sRGB, and what their colours stand for.
#pragma once
#include <cstdint>
#include <string>
#include <vector>

#include "irradia/Image.h"

namespace irradia::app {

/// 8-bit sRGB, three bytes a pixel, rows from the top.
struct Picture {
    int width = 0, height = 0;
    std::vector<std::uint8_t> rgb{};
};

/// What the colours of a map stand for.
struct Scale {
    double low = 0, high = 0;
    bool logarithmic = false;
    std::string unit;                    ///< "" = none
    std::vector<std::string> colours{};  ///< "#rrggbb" from low to high, evenly spaced
};

/// Bytes of a colour map of OpenImageIO (sRGB, three a value) for values 0 to 1.
std::vector<std::uint8_t> map_colours(const char* map, const std::vector<float>& values);
/// Scale::colours of the map's part from `from` to `to`.
std::vector<std::string> scale_colours(const char* map, float from = 0, float to = 1);

/// Linear radiance times 2^exposure, as a PNG file of it has it.
Picture tone_mapped(const Layer& layer, int width, int height, double exposure);

struct LayerView {
    std::string name, title;  ///< "depth", "Depth"
    std::string text;         ///< what the display map shows, one sentence
    Picture picture;
    Scale scale{};  ///< of a colour map; no colours: there is none
};
/// A layer of aov_names(), shown as suits it.
LayerView layer_view(const Layer& layer, int width, int height, double exposure);

/// The layer of that name; null: there is none.
const Layer* find_layer(const Image& image, const std::string& name);

/// "data:image/png;base64,..."
std::string png_address(const Picture& picture);

}  // namespace irradia::app
