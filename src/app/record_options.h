// The options of records that outlive a run, and of irradiance at points.
#pragma once
#include <CLI/CLI.hpp>
#include <string>

#include "app/options.h"

namespace irradia::app {

void declare_records(CLI::App& app, Options& options);

/// What is wrong with how they are combined, "" if nothing.
std::string wrong_record_options(const Options& options);

}  // namespace irradia::app
