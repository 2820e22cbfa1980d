// The options of irradiance and radiance caching.
#pragma once
#include <CLI/CLI.hpp>

#include "irradia/Renderer.h"

namespace irradia::app {

void declare_caches(CLI::App& app, RenderSettings& settings);

}  // namespace irradia::app
