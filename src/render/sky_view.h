// What of an environment picture is seen from where: learned from paths of the view (cl/learn_sky.cl), for light
// samples (cl/sky_view.h).
#pragma once
#include <cstdint>
#include <vector>

#include "irradia/shared/grid_types.h"
#include "render/run.h"

namespace irradia {

/// Is there a picture, large enough for tiles, and RenderSettings::learn_sky on?
bool learns_sky(const Run& run);

/// Has all kernels of `run` but those that sample hemispheres take light samples of the environment picture by what is
/// seen of it in the present view, if learns_sky() and the view is not mostly open. A function of scene, view, seed and
/// `spp`, the samples a pixel that are asked for; light samples stay unbiased. `counted`: the statistics count its
/// rays.
void learn_sky(Run& run, std::uint32_t spp, bool counted);

/// The cells in which it is learned: origin and edge.
shared::GridParameters sky_cells(const Scene& scene);

/// The tables of cl/sky_view.h, for word `first` of the texels, by what paths have met: IR_SKY_EVENT_WORDS a path.
std::vector<std::uint32_t> sky_tables(const Scene& scene, const std::vector<std::uint32_t>& events, std::size_t first);

}  // namespace irradia
