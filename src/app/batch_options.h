// The options of renders that go on without anybody: many frames, many jobs, checkpoints.
#pragma once
#include <CLI/CLI.hpp>
#include <string>

#include "app/options.h"

namespace irradia::app {

void declare_batch(CLI::App& app, Options& options);

/// What is wrong with how they are combined, "" if nothing.
std::string wrong_batch_options(const Options& options);

}  // namespace irradia::app
