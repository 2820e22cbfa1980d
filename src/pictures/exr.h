// EXR files, written through OpenEXR, which loads in milliseconds: nearly every render writes one, and OpenImageIO with
// its 260 libraries takes a quarter of a second. EXRs are read by OpenImageIO, like all pictures.
#pragma once
#include <string>
#include <vector>

#include "pictures/output.h"

namespace irradia::exr {

/// What the module offers. Nothing here throws an Error: the reason comes back, of one line.
struct Library {
    /// The file's bytes: floats, compressed by ZIP. "" or what is wrong.
    std::string (*encode)(const pictures::Output& picture, std::vector<unsigned char>& file);
};

/// Loaded at the first call, of any thread. Throws Error if the module or what it needs is missing.
const Library& library();

/// The module's one symbol, a `const Library* ()`; another number whenever anything above, or Output, changes.
#define IRRADIA_EXR_SYMBOL irradia_exr_1

}  // namespace irradia::exr
