// Which nodes of the binary tree become children of which eight-wide node.
#pragma once
#include <vector>

#include "host_tree.h"

namespace irradia::accel {

/// The distinct triangles below a node, ascending, as long as they fit one block.
struct Gathered {
    std::uint32_t count = 0;  ///< kWidth + 1: more than fit, or not only triangles
    std::array<std::uint32_t, kWidth> primitives{};
    [[nodiscard]] bool fits() const { return count <= kWidth; }
};
Gathered gather(const Scene& scene, const HostTree& tree, std::uint32_t node);

/// At most kWidth nodes.
struct Children {
    std::uint32_t count = 0;
    std::array<std::uint32_t, kWidth> nodes{};
};

/// For each node: is it a leaf of the wide tree, and if not, at which descendants do its children start?
class Collapse {
public:
    /// Least expected cost of a random ray (surface area heuristic) over all ways of cutting the binary tree, by
    /// dynamic programming: Ylitie, Karras, Laine, "Efficient incoherent ray traversal on GPUs through compressed wide
    /// BVHs", HPG 2017, section 3.1.
    static Collapse optimal(const Scene& scene, const HostTree& tree);
    /// Three levels of the binary tree make one of the wide tree, which bounds the depth by a third.
    static Collapse by_level(const Scene& scene, const HostTree& tree);

    /// A leaf of the wide tree: a block of triangles, or one analytic primitive.
    [[nodiscard]] bool leaf(std::uint32_t node) const { return leaf_[node]; }
    /// What replaces the two children of an inner node.
    [[nodiscard]] Children children(std::uint32_t node) const;

private:
    explicit Collapse(const HostTree& tree) : tree_(&tree), leaf_(tree.nodes.size()), split_(tree.nodes.size()) {}
    /// What the levels above need to know of a node. Not kept: there are millions.
    struct Below {
        Gathered gathered;
        std::array<float, kWidth + 1> cost{};  // [i]: of the best forest of at most i roots that covers the node
    };
    Below solve(const Scene& scene, std::uint32_t node, int depth);
    void append_roots(std::uint32_t node, std::uint32_t roots, Children& out) const;

    const HostTree* tree_;
    std::vector<char> leaf_;
    // split_[n][i]: of a forest of at most i roots below n, how many go to the left child; 0: as for i - 1 roots.
    std::vector<std::array<std::uint8_t, kWidth + 1>> split_;
};

}  // namespace irradia::accel
