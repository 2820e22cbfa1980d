// The binary tree by Embree's builder.
#pragma once
#include <functional>

#include "host_tree.h"

namespace irradia::accel {

enum class TreeKind {
    splits,  ///< triangles may be cut, as Stich, Friedrich, Dietrich, "Spatial splits in bounding volume hierarchies",
             ///< HPG 2009; it takes two to five times as long
    pairs,   ///< of pairs of triangles, up to kMaxLeafTriangles a leaf
    blocks   ///< of pairs, up to kWidth triangles a leaf; all cost the same, as they are tested at once
};

/// By the surface area heuristic, or an empty tree if Embree gives up (depth limit). `progress` as for
/// build_host_tree(). Throws std::bad_alloc.
HostTree build_embree_tree(const Scene& scene, TreeKind kind, const std::function<void(double)>& progress);

}  // namespace irradia::accel
