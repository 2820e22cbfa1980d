#include <algorithm>

#include "flatten.h"

namespace irradia::accel {
namespace {

using std::uint32_t;

uint32_t leaf_reference(uint32_t kind, uint32_t count, uint32_t first) { return IR_LEAF | kind | count << 24 | first; }

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
        accel_.bvh2_nodes.reserve(tree_.nodes.size() / 2 + 1);
        accel_.bvh2_triangles.reserve(tree_.primitives.size() -
                                      std::min(tree_.primitives.size(), scene_.analytics.size()));
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

void flatten_bvh2(const Scene& scene, const HostTree& tree, float pad, Accel& accel) {
    Bvh2Builder(scene, tree, pad, accel).build();
}

}  // namespace irradia::accel
