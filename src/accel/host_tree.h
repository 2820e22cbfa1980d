// The binary tree from which both device layouts are flattened.
#pragma once
#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "box.h"

namespace irradia::accel {

struct HostNode {
    Box box;
    std::int32_t left = -1, right = -1;  ///< children, after their parent in the array; -1: a leaf
    std::uint32_t first = 0, count = 0;  ///< leaf: range of HostTree::primitives, ascending, all of one kind
    [[nodiscard]] bool leaf() const { return left < 0; }
};

struct HostTree {
    std::vector<HostNode> nodes;            ///< nodes[0] is the root; empty for an empty scene
    std::vector<std::uint32_t> primitives;  ///< primitive indices; one primitive may lie in several leaves
    std::uint32_t depth = 0;                ///< inner nodes on the longest way down
};

constexpr std::uint32_t kWidth = 8;             ///< triangles of a TriangleBlock, children of a Bvh8Node
constexpr std::uint32_t kMaxLeafTriangles = 4;  ///< of a binary tree that is traversed; analytic leaves hold one

/// Throws Error if `count` primitives are more than the leaves' 24-bit indices reach; `source` names the scene.
void check_primitive_count(std::size_t count, const std::string& source);

/// Appends a leaf, or a small subtree: leaves hold triangles only or one analytic primitive. `primitives` ascend, so
/// that the triangles come first. Its index.
std::int32_t append_primitives(const Scene& scene, HostTree& tree, const Box& box, const std::uint32_t* primitives,
                               std::uint32_t count, std::uint32_t depth);

/// The tree that Embree builds by the surface area heuristic, for AccelQuality::best with spatial splits, or the median
/// tree where its depth or size would not fit. Built quickly for eight-wide nodes alone, leaves hold up to kWidth
/// triangles. Runs on the threads of the caller's task arena, and is the same for any number of them. `progress`, which
/// may be empty, hears the fraction done, from any thread.
HostTree build_host_tree(const Scene& scene, AccelQuality quality, AccelLayouts layouts,
                         const std::function<void(double)>& progress = {});

/// Depth at most ceil(log2 n) whatever the geometry: splits at the median along the widest axis.
HostTree build_median_tree(const Scene& scene);

}  // namespace irradia::accel
