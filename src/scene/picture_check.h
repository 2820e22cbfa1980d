// What is looked at before a picture file is decoded: decoders believe sizes, and libpng prints errors of its own.
#pragma once
#include <cstddef>
#include <string>

namespace irradia::loader {

/// PNG files: whole, every chunk as its checksum says. EXR files: headers whose sizes are believable. Others pass.
/// Throws Error "texture '...' cannot be read: ...".
void check_picture_file(const std::string& path);
/// Throws Error if a picture of so many bytes in memory cannot come out of a file as small as this one.
void check_picture_size(const std::string& path, int width, int height, int channels, std::size_t bytes_a_channel);

}  // namespace irradia::loader
