// The binary tree from which both device layouts are flattened.
#pragma once
#include <array>
#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "irradia/Scene.h"

namespace irradia::accel {

struct Box {
    std::array<float, 3> lo{1e30f, 1e30f, 1e30f}, hi{-1e30f, -1e30f, -1e30f};
    void add(const Box& b);
    /// Half the surface area.
    [[nodiscard]] float area() const;
};

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

constexpr std::uint32_t kMaxLeafTriangles = 4;  ///< of the binary tree; analytic leaves hold one primitive

/// Throws Error if `count` primitives are more than the leaves' 24-bit indices reach; `source` names the scene.
void check_primitive_count(std::size_t count, const std::string& source);

/// World bounds (after centring) of a primitive: a triangle or an analytic sphere, disk or cylinder.
Box primitive_box(const Scene& scene, std::uint32_t primitive);

/// The best tree Embree builds (surface area heuristic with spatial splits), or the median tree where its depth or size
/// would not fit. Deterministic for any `threads` (0 = all).
/// `progress`, which may be empty, hears the fraction done, from any thread.
HostTree build_host_tree(const Scene& scene, int threads, const std::function<void(double)>& progress = {});

/// Depth at most ceil(log2 n) whatever the geometry: splits at the median along the widest axis.
HostTree build_median_tree(const Scene& scene);

}  // namespace irradia::accel
