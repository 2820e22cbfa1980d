// Irradiance at given places instead of a picture: what --points asks, like Radiance's rtrace -I.
#pragma once
#include <array>
#include <vector>

#include "irradia/Renderer.h"

namespace irradia {

struct IrradiancePoint {
    std::array<double, 3> position{};  ///< in the scene file's world, world units
    std::array<double, 3> normal{};    ///< of the side that is asked, of any length but zero
};

/// RGB, W·m⁻². What falls onto a surface there, by light sources directly and by other surfaces.
struct PointIrradiance {
    std::array<float, 3> direct{}, indirect{};
};

/// Irradiance at points, which need not lie on surfaces nor be seen by the camera. Direct light is the mean of settings.spp
/// samples; indirect light comes from the irradiance cache, with records made where there are none: they are spaced as those
/// of a picture, by pixels as wide as the camera would see one at that distance. Answers lie in the order of the points.
/// `records`: as for render(). Throws Error: a method without a cache, or a normal of length zero.
std::vector<PointIrradiance> irradiance_at(const Scene& scene, Device& device, const RenderSettings& settings,
                                           const std::vector<IrradiancePoint>& points,
                                           const ProgressCallback& progress = {}, RecordSet* records = nullptr,
                                           RenderStatistics* statistics = nullptr);

}  // namespace irradia
