// The options of what is said, how, and to whom.
#pragma once
#include <CLI/CLI.hpp>

#include "app/log.h"
#include "app/options.h"

namespace irradia::app {

void declare_messages(CLI::App& app, Options& options);

LogSettings log_settings(const Options& options);

}  // namespace irradia::app
