// Host tree -> device arrays.
#pragma once
#include "host_tree.h"

namespace irradia::accel {

/// Collapses the binary tree to eight-wide nodes and triangle blocks. Boxes are grown by `pad` (world units).
void flatten_bvh8(const Scene& scene, const HostTree& tree, float pad, Accel& accel);
/// The binary tree as it is, both children's boxes in their parent.
void flatten_bvh2(const Scene& scene, const HostTree& tree, float pad, Accel& accel);

}  // namespace irradia::accel
