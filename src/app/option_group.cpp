#include "app/option_group.h"

#include <cmath>
#include <cstdlib>
#include <sstream>

namespace irradia::app {

std::string option_text(double value) {
    std::ostringstream out;
    out << value;
    return out.str();
}

std::string join(const std::vector<std::string>& parts, const char* between) {
    std::string out;
    for (const std::string& part : parts) out += (out.empty() ? "" : between) + part;
    return out;
}

std::function<std::string(const std::string&)> number(const std::string& what,
                                                      const std::function<bool(double)>& good) {
    return [what, good](const std::string& given) {
        char* end = nullptr;
        const double value = std::strtod(given.c_str(), &end);
        return end != given.c_str() && *end == '\0' && std::isfinite(value) && good(value)
                   ? std::string()
                   : "'" + given + "' is not a number " + what;
    };
}

}  // namespace irradia::app
