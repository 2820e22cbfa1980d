// What every report has: its style, its script, what stands before and after its content.
#pragma once
#include <string>

namespace irradia::app {

/// From the first byte to <body>. `title`: plain text.
std::string page_begin(const std::string& title);
/// The script, and what closes the page.
std::string page_end();

}  // namespace irradia::app
