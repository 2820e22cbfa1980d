#include "collapse.h"

#include <tbb/parallel_invoke.h>

#include <algorithm>
#include <limits>

namespace irradia::accel {
namespace {

using std::uint32_t;

// Measured on the CPU traversal: a block of eight triangles costs a ray about as much as eight boxes, and a packet pays
// for each triangle.
constexpr float kNodeCost = 1.0f, kBlockCost = 0.7f, kTriangleCost = 0.05f, kAnalyticCost = 1.0f;

constexpr int kParallelDepth = 10;  // levels below the root whose halves are worth a task each

/// Both children's triangles as one.
Gathered merge(const Gathered& l, const Gathered& r) {
    Gathered both;
    both.count = kWidth + 1;
    if (!l.fits() || !r.fits()) return both;
    std::array<uint32_t, 2 * kWidth> all{};
    const auto end = std::set_union(l.primitives.begin(), l.primitives.begin() + l.count, r.primitives.begin(),
                                    r.primitives.begin() + r.count, all.begin());
    both.count = std::min(static_cast<uint32_t>(end - all.begin()), kWidth + 1);
    if (both.fits()) std::copy_n(all.begin(), both.count, both.primitives.begin());
    return both;
}

Gathered of_leaf(const Scene& scene, const HostTree& tree, const HostNode& leaf) {
    Gathered g;
    g.count = kWidth + 1;
    if (tree.primitives[leaf.first] >= scene.triangles.size()) return g;
    g.count = leaf.count;
    std::copy_n(tree.primitives.begin() + leaf.first, leaf.count, g.primitives.begin());
    return g;
}

uint32_t left_of(const HostNode& node) { return static_cast<uint32_t>(node.left); }
uint32_t right_of(const HostNode& node) { return static_cast<uint32_t>(node.right); }

}  // namespace

Gathered gather(const Scene& scene, const HostTree& tree, uint32_t node) {
    const HostNode& n = tree.nodes[node];
    if (n.leaf()) return of_leaf(scene, tree, n);
    const Gathered left = gather(scene, tree, left_of(n));
    return left.fits() ? merge(left, gather(scene, tree, right_of(n))) : left;
}

Collapse::Below Collapse::solve(const Scene& scene, uint32_t n, int depth) {
    const HostNode& node = tree_->nodes[n];
    const float area = node.box.area();
    Below below;
    if (node.leaf()) {
        below.gathered = of_leaf(scene, *tree_, node);
        const auto count = static_cast<float>(below.gathered.count);
        leaf_[n] = 1;
        below.cost.fill(area * (below.gathered.fits() ? kBlockCost + count * kTriangleCost : kAnalyticCost));
        return below;
    }
    Below left, right;
    const auto solve_left = [&] { left = solve(scene, left_of(node), depth + 1); };
    const auto solve_right = [&] { right = solve(scene, right_of(node), depth + 1); };
    if (depth < kParallelDepth) {
        tbb::parallel_invoke(solve_left, solve_right);
    } else {
        solve_left();
        solve_right();
    }
    below.gathered = merge(left.gathered, right.gathered);
    std::array<float, kWidth + 1>& best = below.cost;
    const float as_leaf = below.gathered.fits()
                              ? area * (kBlockCost + static_cast<float>(below.gathered.count) * kTriangleCost)
                              : std::numeric_limits<float>::infinity();
    for (uint32_t roots = 2; roots <= kWidth; ++roots) {
        best[roots] = std::numeric_limits<float>::infinity();
        for (uint32_t l = 1; l < roots; ++l) {
            const float both = left.cost[l] + right.cost[roots - l];
            if (both < best[roots]) best[roots] = both, split_[n][roots] = static_cast<std::uint8_t>(l);
        }
    }
    const float as_node = area * kNodeCost + best[kWidth];
    leaf_[n] = as_leaf <= as_node;
    best[1] = std::min(as_leaf, as_node);
    // An inner node always spreads its children over all eight slots: split_[n][kWidth] stays. Fewer roots may be
    // best.
    for (uint32_t roots = 2; roots < kWidth; ++roots)
        if (best[roots - 1] <= best[roots]) best[roots] = best[roots - 1], split_[n][roots] = 0;
    return below;
}

Collapse Collapse::optimal(const Scene& scene, const HostTree& tree) {
    Collapse c(tree);
    if (!tree.nodes.empty()) c.solve(scene, 0, 0);
    return c;
}

Collapse Collapse::by_level(const Scene& scene, const HostTree& tree) {
    Collapse c(tree);
    for (std::size_t n = 0; n < tree.nodes.size(); ++n) {
        c.leaf_[n] = tree.nodes[n].leaf() || gather(scene, tree, static_cast<uint32_t>(n)).fits();
        if (!c.leaf_[n]) c.split_[n] = {0, 0, 1, 0, 2, 0, 0, 0, 4};
    }
    return c;
}

void Collapse::append_roots(uint32_t node, uint32_t roots, Children& out) const {
    if (tree_->nodes[node].leaf()) roots = 1;
    while (roots > 1 && split_[node][roots] == 0) --roots;
    if (roots == 1) {
        out.nodes[out.count++] = node;
        return;
    }
    const uint32_t left = split_[node][roots];
    append_roots(static_cast<uint32_t>(tree_->nodes[node].left), left, out);
    append_roots(static_cast<uint32_t>(tree_->nodes[node].right), roots - left, out);
}

Children Collapse::children(uint32_t node) const {
    Children out;
    const uint32_t left = split_[node][kWidth];
    append_roots(static_cast<uint32_t>(tree_->nodes[node].left), left, out);
    append_roots(static_cast<uint32_t>(tree_->nodes[node].right), kWidth - left, out);
    return out;
}

}  // namespace irradia::accel
