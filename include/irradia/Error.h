// Errors a user can mend: one clear line, an exit status.
#pragma once
#include <stdexcept>
#include <string>

namespace irradia {

/// Bad input or environment. what() is one line: file, line or field, what was found, what was expected.
class Error : public std::runtime_error {
public:
    explicit Error(const std::string& message, int exit_status = 1)
        : std::runtime_error(message), exit_status_(exit_status) {}
    [[nodiscard]] int exit_status() const noexcept { return exit_status_; }

private:
    int exit_status_;
};

}  // namespace irradia
