// EXR files, written through OpenEXR, which loads in milliseconds: nearly every render writes one, and OpenImageIO with
// its 260 libraries takes a quarter of a second. EXRs are read by OpenImageIO, like all pictures.
#pragma once
#include <cstddef>
#include <map>
#include <string>
#include <vector>

namespace irradia::exr {

struct Channel {
    std::string name;
    const float* first;  ///< of the top left pixel; of pixel i, rows from the top, it is first[i * stride]
    std::size_t stride;
};

struct Output {
    std::string path;  // for messages
    int width = 0, height = 0;
    std::vector<Channel> channels = {};
    std::map<std::string, std::string> attributes = {};
    int threads = 0;  ///< at most; 0: one a processor
};

/// What the module offers. Nothing here throws an Error: the reason comes back, of one line.
struct Library {
    /// The file's bytes: floats, large ones compressed row by row (ZIPS). "" or what is wrong.
    std::string (*encode)(const Output& picture, std::vector<unsigned char>& file);
};

/// Loaded at the first call, of any thread. Throws Error if the module or what it needs is missing.
const Library& library();

/// The module's one symbol, a `const Library* ()`; another number whenever anything above changes.
#define IRRADIA_EXR_SYMBOL irradia_exr_2

}  // namespace irradia::exr
