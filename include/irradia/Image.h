// Pictures in memory: linear float channels, with the metadata that goes into the file.
#pragma once
#include <map>
#include <string>
#include <vector>

#include "irradia/UntouchedVector.h"

namespace irradia {

/// A layer: `channels` interleaved floats a pixel, row-major, top row first. Radiance in W·m⁻²·sr⁻¹ (linear Rec. 709).
struct Layer {
    std::string name;  ///< "" for the picture itself; else "direct", "indirect", "albedo", "normal", "depth", "records",
                       ///< "counted"
    int channels = 3;
    UntouchedVector<float> data;  ///< whose resize() leaves new values as the memory has them
};

/// A picture: layers of one size. layers[0] is the beauty picture (name "").
struct Image {
    int width = 0, height = 0;
    std::vector<Layer> layers;
    std::map<std::string, std::string> metadata;  ///< written as EXR attributes / PNG text
};

/// Writes by extension: .exr (all layers, float), .png (beauty, sRGB, times 2^exposure), .pfm (beauty, float).
/// Written to a temporary name beside `path`, then renamed: a failed write leaves nothing behind.
/// `threads` at most compress an .exr (0: one a processor), to the same bytes.
/// Throws Error: unknown extension, unwritable folder, or a non-finite value (naming pixel, layer).
void write_image(const std::string& path, const Image& image, double exposure = 0.0, int threads = 0);

/// Reads .exr, .pfm and what OpenImageIO reads besides, as linear RGB (beauty layer). Throws Error.
Image read_image(const std::string& path);

}  // namespace irradia
