#include "app/help.h"

#include <algorithm>
#include <iostream>
#include <memory>
#include <sstream>
#include <vector>

namespace irradia::app {
namespace {

constexpr std::size_t kTextWidth = 80;  // columns of a description

std::string wrap(const std::string& text) {
    std::istringstream words(text);
    std::string out, word;
    std::size_t column = 0;
    while (words >> word) {
        if (column > 0 && column + 1 + word.size() > kTextWidth) {
            out += '\n';
            column = 0;
        }
        if (column > 0) {
            out += ' ';
            ++column;
        }
        out += word;
        column += word.size();
    }
    return out;
}

}  // namespace

std::string HelpFormatter::make_usage(const CLI::App* app, std::string name) const {
    return "\nUsage: " + name + " " + app->get_option_no_throw("--help")->get_option_text() + "\n";
}

std::string HelpFormatter::make_help(const CLI::App* app, std::string name, CLI::AppFormatMode) const {
    std::vector<std::string> groups = app->get_groups();
    // --help and --version are declared first and belong at the end.
    std::stable_partition(groups.begin(), groups.end(), [](const std::string& group) { return group != "Other"; });
    std::string out = make_description(app) + make_usage(app, name) + make_positionals(app);
    for (const std::string& group : groups) {
        const std::vector<const CLI::Option*> options = app->get_options(
            [&](const CLI::Option* option) { return option->get_group() == group && option->nonpositional(); });
        if (!group.empty() && !options.empty()) out += make_group(group, false, options);
    }
    return out + "\n" + make_footer(app);
}

std::string HelpFormatter::make_option_opts(const CLI::Option* option) const {
    if (option->get_positional() || option->get_type_size() == 0) return "";
    const std::string type = option->get_type_name();  // followed by the names of its checks
    return " " + type.substr(0, type.find(':'));
}

std::string HelpFormatter::make_option_desc(const CLI::Option* option) const {
    std::string text = option->get_description();
    if (!option->get_default_str().empty()) text += " [" + option->get_default_str() + "]";
    return wrap(text);
}

void set_up(CLI::App& app, const std::string& usage) {
    const auto formatter = std::make_shared<HelpFormatter>();
    formatter->label("Positionals", "Arguments");
    app.formatter(formatter);
    app.set_help_flag("-h,--help", "This text")->group("Other")->option_text(usage);
    app.set_version_flag("--version", std::string(IRRADIA_VERSION), "The version")->group("Other");
}

int parse(CLI::App& app, int argc, const char* const* argv, std::ostream& err) {
    try {
        app.parse(argc, argv);
        return -1;
    } catch (const CLI::ParseError& error) {
        if (error.get_exit_code() == 0) return app.exit(error, std::cout, err);  // --help, --version
        std::string what = error.what();
        for (char& c : what)
            if (c == '\n') c = ' ';
        err << app.get_name() << ": " << what << " (" << app.get_name() << " --help lists the options)\n";
        return kBadCommandLine;
    }
}

}  // namespace irradia::app
