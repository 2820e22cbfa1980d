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
                 AccelLayouts layouts = AccelLayouts::both);

/// About how many bytes build_accel() takes at its peak besides the scene, hierarchy included.
std::uint64_t accel_memory(const Scene& scene, AccelLayouts layouts);

}  // namespace irradia
