// A picture on its way into a file.
#pragma once
#include <cstdint>
#include <string>
#include <utility>
#include <vector>

namespace irradia::pictures {

struct Output {
    std::string path;           // for messages
    const char* format;         // OpenImageIO's name of it
    int width = 0, height = 0;  // of the picture
    std::vector<std::string> channels = {};
    std::vector<std::pair<std::string, std::string>> attributes = {};
    const float* floats = nullptr;  // all channels of all pixels, interleaved, rows from the top: these, or
    const std::uint8_t* bytes = nullptr;
};

}  // namespace irradia::pictures
