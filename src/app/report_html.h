// Pieces of a page: text that cannot break out of its place, numbers for people, PNG pictures as addresses.
#pragma once
#include <string>
#include <utility>
#include <vector>

namespace irradia::app::html {

/// For text and for attributes in double quotes, of HTML and of XML: <>&"' as references, what is no UTF-8 or no
/// character of XML as U+FFFD.
std::string escape(const std::string& text);

/// A number with `digits` significant ones, or all before the point: "0.0123", "12.3", "4567", "1.23e+07".
std::string number(double value, int digits = 3);
/// "1.23 %"
std::string percent(double share, int digits = 3);

/// Text in base 64 (RFC 4648).
std::string base64(const std::vector<unsigned char>& bytes);

struct Row {
    std::string name, value;  ///< plain text
    bool marked = false;
};
/// A table of two columns.
std::string table(const std::string& caption, const std::vector<Row>& rows);

}  // namespace irradia::app::html
