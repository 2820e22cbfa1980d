// Text from files in messages of one line.
#pragma once
#include <string>

namespace irradia {

/// Control characters, line ends among them, become '?'.
inline std::string one_line(std::string text) {
    for (char& c : text)
        if (static_cast<unsigned char>(c) < 0x20 || c == 0x7f) c = '?';
    return text;
}

}  // namespace irradia
