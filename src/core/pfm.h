// PFM pictures: the one format that needs no library.
#pragma once
#include <string>

#include "irradia/Image.h"

namespace irradia {

/// Writes layers[0] as three floats a pixel (one channel is written three times), rows from the bottom up, in this
/// machine's byte order; beside `path`, then renamed. Throws Error: unwritable path, or a value that is not finite
/// (naming its pixel and channel).
void write_pfm(const std::string& path, const Image& image);

/// Reads "PF" (three channels) and "Pf" (one) of either byte order; the layer has three channels, the top row first.
/// Throws Error: unreadable, not a PFM file, or truncated.
Image read_pfm(const std::string& path);

}  // namespace irradia
