// Packed scenes: everything `render` needs in one versioned, checksummed file. Opening one parses and builds nothing.
#pragma once
#include <string>

#include "irradia/Scene.h"

namespace irradia {

/// Whether the file starts as a packed scene does. False if it cannot be read.
bool is_packed_scene(const std::string& path);

/// Writes `scene`, its acceleration structures included. The file is written beside `path`, synchronised, then renamed:
/// a failed write leaves nothing behind. Throws Error: unwritable path, or a scene that check_scene() refuses.
void write_packed_scene(const std::string& path, const Scene& scene);

/// Reads what write_packed_scene() wrote. Throws Error, one line that names the file, if it is truncated or altered, of
/// another version or byte order, or does not pass check_scene(). Never allocates more than the file's size.
Scene read_packed_scene(const std::string& path);

/// Throws Error "<where>: ..." unless every index of the scene and of its acceleration structures is in range, every
/// number is finite and within its bounds, the lights' cdf ascends to 1, and both trees are trees that fit the
/// traversals' stacks: what a kernel needs so as never to read outside an array.
void check_scene(const std::string& where, const Scene& scene, AccelLayouts layouts = AccelLayouts::both);

}  // namespace irradia
