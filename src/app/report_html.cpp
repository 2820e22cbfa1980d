#include "app/report_html.h"

#include <fmt/format.h>

#include <cmath>
#include <cstdint>

namespace irradia::app::html {
namespace {

const char* const kReplacement = "\xEF\xBF\xBD";  // U+FFFD

// Bytes of the UTF-8 sequence that begins at text[at]; 0: there is none. Unicode 15, table 3-7.
std::size_t sequence(const std::string& text, std::size_t at) {
    const auto byte = [&](std::size_t i) {
        return at + i < text.size() ? static_cast<unsigned char>(text[at + i]) : std::uint8_t{0};
    };
    const auto within = [](unsigned char b, unsigned char low, unsigned char high) { return b >= low && b <= high; };
    const unsigned char first = byte(0);
    if (first < 0x80) return 1;
    if (within(first, 0xC2, 0xDF)) return within(byte(1), 0x80, 0xBF) ? 2 : 0;
    if (within(first, 0xE0, 0xEF)) {
        const unsigned char low = first == 0xE0 ? 0xA0 : 0x80, high = first == 0xED ? 0x9F : 0xBF;
        const bool noncharacter = first == 0xEF && byte(1) == 0xBF && byte(2) >= 0xBE;  // U+FFFE, U+FFFF
        return within(byte(1), low, high) && within(byte(2), 0x80, 0xBF) && !noncharacter ? 3 : 0;
    }
    if (within(first, 0xF0, 0xF4)) {
        const unsigned char low = first == 0xF0 ? 0x90 : 0x80, high = first == 0xF4 ? 0x8F : 0xBF;
        return within(byte(1), low, high) && within(byte(2), 0x80, 0xBF) && within(byte(3), 0x80, 0xBF) ? 4 : 0;
    }
    return 0;
}

}  // namespace

std::string escape(const std::string& text) {
    std::string out;
    for (std::size_t at = 0; at < text.size();) {
        const std::size_t length = sequence(text, at);
        const char c = text[at];
        const bool control = length == 1 && static_cast<unsigned char>(c) < 0x20 && c != '\t' && c != '\n';
        if (length == 0 || control || c == '\x7f')
            out += kReplacement;
        else if (c == '<')
            out += "&lt;";
        else if (c == '>')
            out += "&gt;";
        else if (c == '&')
            out += "&amp;";
        else if (c == '"')
            out += "&quot;";
        else if (c == '\'')
            out += "&#39;";
        else
            out += text.substr(at, length);
        at += length == 0 ? 1 : length;
    }
    return out;
}

std::string number(double value, int digits) {
    const double size = std::abs(value);
    return size >= 1000 && size < 1e6 ? fmt::format("{:.0f}", value) : fmt::format("{:.{}g}", value, digits);
}

std::string percent(double share, int digits) { return number(100 * share, digits) + " %"; }

std::string base64(const std::vector<unsigned char>& bytes) {
    static const char* const letters = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    std::string out;
    out.reserve((bytes.size() + 2) / 3 * 4);
    for (std::size_t i = 0; i < bytes.size(); i += 3) {
        const std::size_t left = bytes.size() - i;
        const std::uint32_t word = (std::uint32_t{bytes[i]} << 16) | (left > 1 ? std::uint32_t{bytes[i + 1]} << 8 : 0) |
                                   (left > 2 ? std::uint32_t{bytes[i + 2]} : 0);
        out += letters[word >> 18];
        out += letters[(word >> 12) & 63];
        out += left > 1 ? letters[(word >> 6) & 63] : '=';
        out += left > 2 ? letters[word & 63] : '=';
    }
    return out;
}

std::string table(const std::string& caption, const std::vector<Row>& rows) {
    std::string out = "<table><caption>" + escape(caption) + "</caption><tbody>\n";
    for (const Row& row : rows)
        out += fmt::format("<tr{}><th scope=\"row\">{}</th><td>{}</td></tr>\n", row.marked ? " class=\"marked\"" : "",
                           escape(row.name), escape(row.value));
    return out + "</tbody></table>\n";
}

}  // namespace irradia::app::html
