// Which nodes of the binary tree become children of which eight-wide node.
#pragma once
#include <vector>

#include "host_tree.h"

namespace irradia::accel {

constexpr std::uint32_t kWidth = 8;  ///< triangles of a TriangleBlock, children of a Bvh8Node

/// The distinct triangles below a node, ascending, as long as they fit one block.
struct Gathered {
    std::uint32_t count = 0;  ///< kWidth + 1: more than fit, or not only triangles
    std::array<std::uint32_t, kWidth> primitives{};
    [[nodiscard]] bool fits() const { return count <= kWidth; }
};
/// One for each node of the tree.
std::vector<Gathered> gather(const Scene& scene, const HostTree& tree);

/// For each node: is it a leaf of the wide tree, and if not, at which descendants do its children start?
class Collapse {
public:
    /// Least expected cost of a random ray (surface area heuristic) over all ways of cutting the binary tree, by
    /// dynamic programming: Ylitie, Karras, Laine, "Efficient incoherent ray traversal on GPUs through compressed wide
    /// BVHs", HPG 2017, section 3.1.
    static Collapse optimal(const HostTree& tree, const std::vector<Gathered>& below);
    /// Three levels of the binary tree make one of the wide tree, which bounds the depth by a third.
    static Collapse by_level(const HostTree& tree, const std::vector<Gathered>& below);

    [[nodiscard]] bool leaf(std::uint32_t node) const { return leaf_[node]; }
    /// At most kWidth nodes that replace the two children of an inner node.
    [[nodiscard]] std::vector<std::uint32_t> children(std::uint32_t node) const;

private:
    explicit Collapse(const HostTree& tree) : tree_(&tree), leaf_(tree.nodes.size()), split_(tree.nodes.size()) {}
    void append_roots(std::uint32_t node, std::uint32_t roots, std::vector<std::uint32_t>& out) const;

    const HostTree* tree_;
    std::vector<char> leaf_;
    // split_[n][i]: of a forest of at most i roots below n, how many go to the left child; 0: as for i - 1 roots.
    std::vector<std::array<std::uint8_t, kWidth + 1>> split_;
};

}  // namespace irradia::accel
