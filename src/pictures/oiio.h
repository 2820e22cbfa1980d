// Picture files through OpenImageIO. It brings some 260 libraries, which take a quarter of a second to load: so nothing
// links it but the module libirradia_oiio.so, which is loaded when the first picture is read, or a PNG written.
#pragma once
#include <cstdint>
#include <map>
#include <memory>
#include <string>
#include <vector>

namespace irradia::oiio {

/// What a file holds. Integers carry sRGB-encoded values, whether bytes or wider.
enum class Values { bytes, integers, floats };

/// A file whose header has been read: its first picture.
class Input {
public:
    virtual ~Input() = default;
    int width = 0, height = 0, depth = 0;
    std::vector<std::string> channels;
    Values values = Values::floats;
    bool srgb = false;  ///< OpenImageIO takes the colours for sRGB-encoded
    std::map<std::string, std::string> metadata;
    /// All channels of all pixels, interleaved, rows from the top. "" or why they cannot be read.
    virtual std::string read(float* data) = 0;
    virtual std::string read(std::uint8_t* data) = 0;
};

struct Png {
    std::string path;  // for messages
    int width = 0, height = 0;
    const std::uint8_t* rgb = nullptr;  // sRGB, rows from the top
    std::map<std::string, std::string> attributes = {};
};

/// What the module offers. Nothing here throws an Error: the reason comes back, of one line.
struct Library {
    /// Null: `why` says why. `unassociated`: colours as they stand in the file, not multiplied by alpha.
    std::unique_ptr<Input> (*open)(const std::string& path, bool unassociated, std::string& why);
    /// The file's bytes; no date, so that the same picture has the same. "" or what is wrong.
    std::string (*encode)(const Png& picture, std::vector<unsigned char>& file);
    /// Linear RGB of a colour map ("inferno", "viridis", ...) for values 0 to 1. "" or why not.
    std::string (*colour_map)(const char* name, int width, int height, const float* values, float* rgb);
};

/// Loaded at the first call, of any thread. Throws Error if the module or what it needs is missing.
const Library& library();

/// The module's one symbol, a `const Library* ()`; another number whenever anything above changes.
#define IRRADIA_OIIO_SYMBOL irradia_oiio_3

}  // namespace irradia::oiio
