// The options of the page that shows a render.
#pragma once
#include <CLI/CLI.hpp>
#include <string>

#include "app/options.h"

namespace irradia::app {

void declare_report(CLI::App& app, Options& options);

/// What is wrong with how they are combined, "" if nothing.
std::string wrong_report_options(const Options& options);

}  // namespace irradia::app
