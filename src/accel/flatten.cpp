#include "flatten.h"

#include <algorithm>

namespace irradia::accel {
namespace {

using std::uint32_t;

constexpr uint32_t kBlock = 8;  // triangles of a TriangleBlock, children of a Bvh8Node

uint32_t leaf_reference(uint32_t kind, uint32_t count, uint32_t first) { return IR_LEAF | kind | count << 24 | first; }

// The distinct triangles below a node, as long as they fit one block.
struct Gathered {
    uint32_t count = 0;  // kBlock + 1: more than fit, or not only triangles
    std::array<uint32_t, kBlock> primitives{};
};

Gathered gather(const Scene& scene, const HostTree& tree, const HostNode& node, const std::vector<Gathered>& below) {
    Gathered g;
    std::array<uint32_t, 2 * kBlock> all{};
    uint32_t n = 0;
    if (node.leaf()) {
        for (uint32_t i = 0; i < node.count; ++i) all[n++] = tree.primitives[node.first + i];
        if (all[0] >= scene.triangles.size()) n = kBlock + 1;
    } else {
        const Gathered &l = below[node.left], &r = below[node.right];
        if (l.count > kBlock || r.count > kBlock)
            n = kBlock + 1;
        else
            n = static_cast<uint32_t>(std::set_union(l.primitives.begin(), l.primitives.begin() + l.count,
                                                     r.primitives.begin(), r.primitives.begin() + r.count,
                                                     all.begin()) -
                                      all.begin());
    }
    g.count = std::min(n, kBlock + 1);
    std::copy_n(all.begin(), std::min(n, kBlock), g.primitives.begin());
    return g;
}

uint32_t append_block(const Scene& scene, const Gathered& g, Accel& accel) {
    shared::TriangleBlock block{};  // unused slots: all vertices alike, a 0 / 0 that never compares as a hit
    for (uint32_t i = 0; i < g.count; ++i) {
        const shared::Triangle& t = scene.triangles[g.primitives[i]];
        const shared::Vertex &a = scene.vertices[t.v0], &b = scene.vertices[t.v1], &c = scene.vertices[t.v2];
        block.v0x[i] = a.px, block.v0y[i] = a.py, block.v0z[i] = a.pz;
        block.v1x[i] = b.px, block.v1y[i] = b.py, block.v1z[i] = b.pz;
        block.v2x[i] = c.px, block.v2y[i] = c.py, block.v2z[i] = c.pz;
        block.primitive[i] = g.primitives[i];
    }
    for (uint32_t i = g.count; i < kBlock; ++i) block.primitive[i] = IR_NO_PRIMITIVE;
    accel.bvh8_triangles.push_back(block);
    return leaf_reference(0, g.count, static_cast<uint32_t>(accel.bvh8_triangles.size()) - 1);
}

class Bvh8Builder {
public:
    Bvh8Builder(const Scene& scene, const HostTree& tree, float pad, bool by_level, Accel& accel)
        : scene_(scene), tree_(tree), pad_(pad), by_level_(by_level), accel_(accel), below_(tree.nodes.size()) {
        for (std::size_t i = tree.nodes.size(); i-- > 0;) below_[i] = gather(scene, tree, tree.nodes[i], below_);
    }

    /// Depth of the tree written, in nodes.
    uint32_t build() {
        accel_.bvh8_nodes.clear();
        accel_.bvh8_triangles.clear();
        return append(0);
    }

private:
    [[nodiscard]] bool final(uint32_t node) const { return tree_.nodes[node].leaf() || below_[node].count <= kBlock; }

    // Up to eight descendants that replace `node`'s two children: the one of the largest area is opened first (the ray
    // meets it most often), or in `by_level` mode the shallowest, which bounds the depth by a third of the binary
    // tree's.
    std::vector<uint32_t> collapse(uint32_t node) const {
        if (final(node)) return {node};  // the root of a scene of one leaf
        std::vector<uint32_t> children{static_cast<uint32_t>(tree_.nodes[node].left),
                                       static_cast<uint32_t>(tree_.nodes[node].right)};
        std::vector<uint32_t> level{1, 1};
        while (children.size() < kBlock) {
            std::size_t best = children.size();
            for (std::size_t i = 0; i < children.size(); ++i) {
                if (final(children[i])) continue;
                if (best == children.size() ||
                    (by_level_ ? level[i] < level[best]
                               : tree_.nodes[children[i]].box.area() > tree_.nodes[children[best]].box.area()))
                    best = i;
            }
            if (best == children.size()) break;
            const HostNode& open = tree_.nodes[children[best]];
            children[best] = static_cast<uint32_t>(open.left);
            children.insert(children.begin() + static_cast<std::ptrdiff_t>(best) + 1,
                            static_cast<uint32_t>(open.right));
            level[best] += 1;
            level.insert(level.begin() + static_cast<std::ptrdiff_t>(best), level[best]);
        }
        return children;
    }

    uint32_t append(uint32_t node) {
        const std::size_t self = accel_.bvh8_nodes.size();
        accel_.bvh8_nodes.emplace_back();
        shared::Bvh8Node out{};
        std::fill_n(out.child, kBlock, IR_EMPTY);
        for (uint32_t i = 0; i < kBlock; ++i) {
            out.lo_x[i] = out.lo_y[i] = out.lo_z[i] = 1e30f;
            out.hi_x[i] = out.hi_y[i] = out.hi_z[i] = -1e30f;
        }
        uint32_t depth = 0;
        if (!tree_.nodes.empty()) {
            const std::vector<uint32_t> children = collapse(node);
            out.count = static_cast<uint32_t>(children.size());
            for (uint32_t i = 0; i < out.count; ++i) {
                const HostNode& child = tree_.nodes[children[i]];
                out.lo_x[i] = child.box.lo[0] - pad_, out.hi_x[i] = child.box.hi[0] + pad_;
                out.lo_y[i] = child.box.lo[1] - pad_, out.hi_y[i] = child.box.hi[1] + pad_;
                out.lo_z[i] = child.box.lo[2] - pad_, out.hi_z[i] = child.box.hi[2] + pad_;
                if (below_[children[i]].count <= kBlock) {
                    out.child[i] = append_block(scene_, below_[children[i]], accel_);
                } else if (child.leaf()) {
                    const auto first = static_cast<uint32_t>(tree_.primitives[child.first] - scene_.triangles.size());
                    out.child[i] = leaf_reference(IR_LEAF_ANALYTIC, child.count, first);
                } else {
                    out.child[i] = static_cast<uint32_t>(accel_.bvh8_nodes.size());
                    depth = std::max(depth, append(children[i]));
                }
            }
        }
        accel_.bvh8_nodes[self] = out;
        return depth + 1;
    }

    const Scene& scene_;
    const HostTree& tree_;
    float pad_;
    bool by_level_;
    Accel& accel_;
    std::vector<Gathered> below_;
};

uint32_t append_packed(const Scene& scene, const HostTree& tree, const HostNode& leaf, Accel& accel) {
    const auto first = static_cast<uint32_t>(accel.bvh2_triangles.size());
    if (tree.primitives[leaf.first] >= scene.triangles.size())
        return leaf_reference(IR_LEAF_ANALYTIC, leaf.count,
                              static_cast<uint32_t>(tree.primitives[leaf.first] - scene.triangles.size()));
    for (uint32_t i = 0; i < leaf.count; ++i) {
        const uint32_t p = tree.primitives[leaf.first + i];
        const shared::Triangle& t = scene.triangles[p];
        const shared::Vertex &a = scene.vertices[t.v0], &b = scene.vertices[t.v1], &c = scene.vertices[t.v2];
        accel.bvh2_triangles.push_back({a.px, a.py, a.pz, p, b.px, b.py, b.pz, 0, c.px, c.py, c.pz, 0});
    }
    return leaf_reference(0, leaf.count, first);
}

class Bvh2Builder {
public:
    Bvh2Builder(const Scene& scene, const HostTree& tree, float pad, Accel& accel)
        : scene_(scene), tree_(tree), pad_(pad), accel_(accel) {}

    void build() {
        if (tree_.nodes.empty() || tree_.nodes[0].leaf()) {  // a root with one child or none
            accel_.bvh2_nodes.push_back(empty_node());
            if (!tree_.nodes.empty()) set_child(accel_.bvh2_nodes[0], 0, tree_.nodes[0].box, reference(0));
            return;
        }
        append(0);
    }

private:
    static shared::Bvh2Node empty_node() {
        shared::Bvh2Node n{};
        n.lo0x = n.lo0y = n.lo0z = n.lo1x = n.lo1y = n.lo1z = 1e30f;
        n.hi0x = n.hi0y = n.hi0z = n.hi1x = n.hi1y = n.hi1z = -1e30f;
        n.child0 = n.child1 = IR_EMPTY;
        return n;
    }

    void set_child(shared::Bvh2Node& n, int which, const Box& b, uint32_t ref) const {
        if (which == 0) {
            n.lo0x = b.lo[0] - pad_, n.lo0y = b.lo[1] - pad_, n.lo0z = b.lo[2] - pad_;
            n.hi0x = b.hi[0] + pad_, n.hi0y = b.hi[1] + pad_, n.hi0z = b.hi[2] + pad_;
            n.child0 = ref;
        } else {
            n.lo1x = b.lo[0] - pad_, n.lo1y = b.lo[1] - pad_, n.lo1z = b.lo[2] - pad_;
            n.hi1x = b.hi[0] + pad_, n.hi1y = b.hi[1] + pad_, n.hi1z = b.hi[2] + pad_;
            n.child1 = ref;
        }
    }

    uint32_t reference(uint32_t node) {
        return tree_.nodes[node].leaf() ? append_packed(scene_, tree_, tree_.nodes[node], accel_) : append(node);
    }

    uint32_t append(uint32_t node) {
        const auto self = static_cast<uint32_t>(accel_.bvh2_nodes.size());
        accel_.bvh2_nodes.push_back(empty_node());
        const HostNode& in = tree_.nodes[node];
        shared::Bvh2Node out = empty_node();
        set_child(out, 0, tree_.nodes[in.left].box, reference(static_cast<uint32_t>(in.left)));
        set_child(out, 1, tree_.nodes[in.right].box, reference(static_cast<uint32_t>(in.right)));
        accel_.bvh2_nodes[self] = out;
        return self;
    }

    const Scene& scene_;
    const HostTree& tree_;
    float pad_;
    Accel& accel_;
};

}  // namespace

void flatten_bvh8(const Scene& scene, const HostTree& tree, float pad, Accel& accel) {
    if (Bvh8Builder(scene, tree, pad, false, accel).build() > IR_BVH8_MAX_DEPTH)
        Bvh8Builder(scene, tree, pad, true, accel).build();
}

void flatten_bvh2(const Scene& scene, const HostTree& tree, float pad, Accel& accel) {
    Bvh2Builder(scene, tree, pad, accel).build();
}

}  // namespace irradia::accel
