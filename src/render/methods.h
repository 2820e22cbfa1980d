// The methods, each in its own file. They fill `film` and run.statistics; irradiance() returns where records were made.
#pragma once
#include <cstdint>
#include <vector>

#include "render/run.h"

namespace irradia {

void render_path(Run& run, Film& film);
void render_gather(Run& run, Film& film);
/// Irradiance and radiance caching. Returns the pixel of every record.
std::vector<std::uint32_t> render_caching(Run& run, Film& film);

}  // namespace irradia
