// Where the present view shows lamps (cl/probe_pixels.cl).
#pragma once
#include <cstdint>
#include <vector>

#include "render/run.h"

namespace irradia {

/// 1 for pixels where neither the pixel's centre nor a corner of it, nor of a pixel that the filter mixes into it,
/// shows a lamp. Seen through a pinhole, and not through mirrors.
std::vector<std::uint8_t> pixels_without_lamps(Run& run);

}  // namespace irradia
