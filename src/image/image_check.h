// What writer, reader and metrics share: the shape of an Image, its channels' names, files written aside.
#pragma once
#include <functional>
#include <string>

#include "irradia/Image.h"

namespace irradia {

/// Name of channel `c` of a layer in a file: "R" of the picture, "direct.R", "normal.X", "depth.Z", "records.Y".
std::string channel_name(const Layer& layer, int c);

/// Throws Error (naming `path`) unless every layer has width x height x channels finite values.
void check_image(const std::string& path, const Image& image);

/// The extension of `path`, lower case, with its dot; "" if it has none.
std::string extension_of(const std::string& path);

/// Has `write` make a file under a temporary name in the folder of `path`, then renames it to `path`. Whatever goes
/// wrong, no part of a file stays behind and an older file at `path` stays as it was. Throws Error.
void write_aside(const std::string& path, const std::function<void(const std::string& temporary)>& write);

/// The sRGB transfer function (IEC 61966-2-1): linear [0, 1] to encoded [0, 1]; clamps.
float srgb_encode(float linear);
/// Its inverse.
float srgb_decode(float encoded);

}  // namespace irradia
