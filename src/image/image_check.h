// What writer, reader and metrics share: the shape of an Image, its channels' names, the sRGB curve.
#pragma once
#include <string>

#include "irradia/Image.h"

namespace irradia {

/// Name of channel `c` of a layer in a file: "R" of the picture, "direct.R", "normal.X", "depth.Z", "records.Y".
std::string channel_name(const Layer& layer, int c);

/// Throws Error (naming `path`) unless every layer has width x height x channels finite values.
void check_image(const std::string& path, const Image& image);

/// The extension of `path`, lower case, with its dot; "" if it has none.
std::string extension_of(const std::string& path);

/// The sRGB transfer function (IEC 61966-2-1): linear [0, 1] to encoded [0, 1]; clamps.
float srgb_encode(float linear);
/// Its inverse.
float srgb_decode(float encoded);

}  // namespace irradia
