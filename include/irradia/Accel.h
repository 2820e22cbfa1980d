// Scene -> bounding volume hierarchy -> the flat arrays that the traversal headers of cl/ read.
#pragma once
#include <functional>

#include "irradia/Scene.h"

namespace irradia {

/// Fills scene.accel: Embree builds one binary tree over all primitives (triangles, spheres, disks, cylinders), which is flattened
/// to a BVH8 (CPU devices) and a BVH2 (GPU devices), or to one of them, which takes less memory. The result does not depend on the number of threads.
/// `threads`: workers of the build, 0 = all. `progress` hears fractions of [0, 1], from any thread, two at once too.
/// What `progress` throws ends the build. Throws Error if there are more primitives than a leaf can address (2^24).
void build_accel(Scene& scene, int threads = 0, const std::function<void(double)>& progress = {},
                 AccelLayouts layouts = AccelLayouts::both, AccelQuality quality = AccelQuality::best);

/// Which hierarchy takes less time, built and traced, for so many rays on a device that reads `layouts` (both: it will be
/// kept, and is built well).
AccelQuality accel_quality_for(const Scene& scene, double rays, AccelLayouts layouts);

/// About how many bytes build_accel() takes at its peak besides the scene, hierarchy included.
std::uint64_t accel_memory(const Scene& scene, AccelLayouts layouts);

/// Moves from.accel to `to` if building it anew would yield the same bytes: if it has that quality, and both scenes have the
/// same vertex positions, triangles' corners and analytic shapes, bit for bit; materials, normals and lights may differ.
/// Afterwards `to` has the layouts asked for and from.accel is empty. False, and nothing is changed: geometry or quality
/// differs, or `from` lacks a layout. Costs a pass over both, a small part of what building does.
bool take_accel(Scene& to, Scene& from, AccelLayouts layouts = AccelLayouts::both,
                AccelQuality quality = AccelQuality::best);

}  // namespace irradia
