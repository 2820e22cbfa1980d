// Rendering to an error: in steps that keep what is there, until the error's interval lies below what is asked.
#pragma once
#include <memory>
#include <vector>

#include "render/error_probes.h"
#include "render/methods.h"

namespace irradia {

/// `settings`, which `run` refers to, are changed from step to step. `caching`: null for methods that only take
/// samples. Returns the pixels of all records; `report` is that of the film as it is left. Stops early at
/// settings.time_limit, but not before the first step is done.
std::vector<std::uint32_t> render_to_target(Run& run, RenderSettings& settings, Film& film,
                                            std::unique_ptr<CachingRenderer>& caching, ErrorReport& report);

}  // namespace irradia
