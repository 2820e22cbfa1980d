// Where a render goes: found unwritable before the render, not after it.
#pragma once
#include <string>

#include "irradia/Image.h"

namespace irradia::app {

/// Extensions this build can write, for --help: ".exr, .png, .pfm", or ".pfm" of a minimal build.
std::string output_kinds();

/// Throws Error if `path` has an extension that save_picture() cannot write (or not without a library that is
/// missing) or its folder takes no new file.
void check_picture_path(const std::string& path);

/// Throws Error if a file `path` cannot be made: no such folder, no right to write, `path` is a folder, disk full.
void check_writable(const std::string& path);

/// write_image(), or PFM alone in a minimal build.
void save_picture(const std::string& path, const Image& image, double exposure, int threads);

/// Writes `text` aside and renames it to `path`. Throws Error.
void save_text(const std::string& path, const std::string& text);

}  // namespace irradia::app
