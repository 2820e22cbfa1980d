// How the executables' --help looks and how a wrong command line ends, the same for all of them.
#pragma once
#include <CLI/CLI.hpp>
#include <string>

namespace irradia::app {

inline constexpr int kBadInput = 1;        ///< exit status: the scene, a picture, a device, a folder
inline constexpr int kBadCommandLine = 2;  ///< exit status: an unknown option, a value out of range
inline constexpr int kSomeFailed = 3;      ///< exit status: of many frames or jobs; the others are done

/// Options in two columns, descriptions wrapped, the default at the end of each: "[0.1]".
class HelpFormatter : public CLI::Formatter {
public:
    HelpFormatter() { column_width(30); }
    std::string make_usage(const CLI::App* app, std::string name) const override;
    std::string make_help(const CLI::App* app, std::string name, CLI::AppFormatMode mode) const override;
    std::string make_option_opts(const CLI::Option* option) const override;
    std::string make_option_desc(const CLI::Option* option) const override;
};

/// Sets formatter, --help and --version of `app`.
void set_up(CLI::App& app, const std::string& usage);

/// Parses; returns -1 to go on, else the status to exit with: --help and --version print to stdout (0), a wrong
/// command line prints one line to `err` (kBadCommandLine).
int parse(CLI::App& app, int argc, const char* const* argv, std::ostream& err);

}  // namespace irradia::app
