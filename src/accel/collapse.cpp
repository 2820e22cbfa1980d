#include "collapse.h"

#include <algorithm>
#include <limits>

namespace irradia::accel {
namespace {

using std::uint32_t;

// Measured on the CPU traversal: a block of eight triangles costs a ray about as much as eight boxes, and a packet pays
// for each triangle.
constexpr float kNodeCost = 1.0f, kBlockCost = 0.7f, kTriangleCost = 0.05f, kAnalyticCost = 1.0f;

}  // namespace

std::vector<Gathered> gather(const Scene& scene, const HostTree& tree) {
    std::vector<Gathered> below(tree.nodes.size());
    for (std::size_t i = tree.nodes.size(); i-- > 0;) {  // children lie after their parent
        const HostNode& node = tree.nodes[i];
        std::array<uint32_t, 2 * kWidth> all{};
        uint32_t n = kWidth + 1;
        if (node.leaf()) {
            if (tree.primitives[node.first] < scene.triangles.size()) {
                n = node.count;
                std::copy_n(tree.primitives.begin() + node.first, n, all.begin());
            }
        } else if (below[node.left].fits() && below[node.right].fits()) {
            const Gathered &l = below[node.left], &r = below[node.right];
            const auto end = std::set_union(l.primitives.begin(), l.primitives.begin() + l.count, r.primitives.begin(),
                                            r.primitives.begin() + r.count, all.begin());
            n = static_cast<uint32_t>(end - all.begin());
        }
        below[i].count = std::min(n, kWidth + 1);
        if (below[i].fits()) std::copy_n(all.begin(), n, below[i].primitives.begin());
    }
    return below;
}

Collapse Collapse::optimal(const HostTree& tree, const std::vector<Gathered>& below) {
    Collapse c(tree);
    // cost[n][i]: of the best forest of at most i roots that covers what lies below n.
    std::vector<std::array<float, kWidth + 1>> cost(tree.nodes.size());
    for (std::size_t n = tree.nodes.size(); n-- > 0;) {
        const HostNode& node = tree.nodes[n];
        const float area = node.box.area();
        std::array<float, kWidth + 1>& best = cost[n];
        const auto count = static_cast<float>(below[n].count);
        const float as_leaf = below[n].fits() ? area * (kBlockCost + count * kTriangleCost)
                              : node.leaf()   ? area * kAnalyticCost
                                              : std::numeric_limits<float>::infinity();
        c.leaf_[n] = 1;
        if (node.leaf()) {
            best.fill(as_leaf);
            continue;
        }
        for (uint32_t roots = 2; roots <= kWidth; ++roots) {
            best[roots] = std::numeric_limits<float>::infinity();
            for (uint32_t left = 1; left < roots; ++left) {
                const float both = cost[node.left][left] + cost[node.right][roots - left];
                if (both < best[roots]) best[roots] = both, c.split_[n][roots] = static_cast<std::uint8_t>(left);
            }
        }
        const float as_node = area * kNodeCost + best[kWidth];
        c.leaf_[n] = as_leaf <= as_node;
        best[1] = std::min(as_leaf, as_node);
        // An inner node always spreads its children over all eight slots: split_[n][kWidth] stays. Fewer roots may be
        // best.
        for (uint32_t roots = 2; roots < kWidth; ++roots)
            if (best[roots - 1] <= best[roots]) best[roots] = best[roots - 1], c.split_[n][roots] = 0;
    }
    return c;
}

Collapse Collapse::by_level(const HostTree& tree, const std::vector<Gathered>& below) {
    Collapse c(tree);
    for (std::size_t n = 0; n < tree.nodes.size(); ++n) {
        c.leaf_[n] = tree.nodes[n].leaf() || below[n].fits();
        if (!c.leaf_[n]) c.split_[n] = {0, 0, 1, 0, 2, 0, 0, 0, 4};
    }
    return c;
}

void Collapse::append_roots(uint32_t node, uint32_t roots, std::vector<uint32_t>& out) const {
    if (tree_->nodes[node].leaf()) roots = 1;
    while (roots > 1 && split_[node][roots] == 0) --roots;
    if (roots == 1) {
        out.push_back(node);
        return;
    }
    const uint32_t left = split_[node][roots];
    append_roots(static_cast<uint32_t>(tree_->nodes[node].left), left, out);
    append_roots(static_cast<uint32_t>(tree_->nodes[node].right), roots - left, out);
}

std::vector<uint32_t> Collapse::children(uint32_t node) const {
    std::vector<uint32_t> out;
    const uint32_t left = split_[node][kWidth];
    append_roots(static_cast<uint32_t>(tree_->nodes[node].left), left, out);
    append_roots(static_cast<uint32_t>(tree_->nodes[node].right), kWidth - left, out);
    return out;
}

}  // namespace irradia::accel
