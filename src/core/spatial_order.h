// The order in which points far apart are looked up.
#pragma once
#include <array>
#include <cstdint>
#include <span>
#include <vector>

namespace irradia {

/// Indices of `points` along a Morton curve through their bounds (Morton 1966), 2^21 steps an axis; points of one step
/// in their own order. What lies together in space comes together, and finds in caches what its neighbours have
/// fetched. Coordinates are finite.
std::vector<std::uint32_t> spatial_order(std::span<const std::array<float, 3>> points);

}  // namespace irradia
