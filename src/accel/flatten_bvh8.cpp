#include <algorithm>

#include "collapse.h"
#include "flatten.h"

namespace irradia::accel {
namespace {

using std::uint32_t;

uint32_t leaf_reference(uint32_t kind, uint32_t count, uint32_t first) { return IR_LEAF | kind | count << 24 | first; }

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
    for (uint32_t i = g.count; i < kWidth; ++i) block.primitive[i] = IR_NO_PRIMITIVE;
    accel.bvh8_triangles.push_back(block);
    return leaf_reference(0, g.count, static_cast<uint32_t>(accel.bvh8_triangles.size()) - 1);
}

class Bvh8Builder {
public:
    Bvh8Builder(const Scene& scene, const HostTree& tree, const std::vector<Gathered>& below, const Collapse& collapse,
                float pad, Accel& accel)
        : scene_(scene), tree_(tree), below_(below), collapse_(collapse), pad_(pad), accel_(accel) {}

    /// Depth of the tree written, in nodes.
    uint32_t build() {
        accel_.bvh8_nodes.clear();
        accel_.bvh8_triangles.clear();
        return append(0);
    }

private:
    uint32_t append(uint32_t node) {
        const std::size_t self = accel_.bvh8_nodes.size();
        accel_.bvh8_nodes.emplace_back();
        shared::Bvh8Node out{};
        std::fill_n(out.child, kWidth, IR_EMPTY);
        for (uint32_t i = 0; i < kWidth; ++i) {
            out.lo_x[i] = out.lo_y[i] = out.lo_z[i] = 1e30f;
            out.hi_x[i] = out.hi_y[i] = out.hi_z[i] = -1e30f;
        }
        uint32_t depth = 0;
        if (!tree_.nodes.empty()) {
            // The root of a scene of one leaf has that leaf as its only child.
            const std::vector<uint32_t> children =
                collapse_.leaf(node) ? std::vector<uint32_t>{node} : collapse_.children(node);
            out.count = static_cast<uint32_t>(children.size());
            for (uint32_t i = 0; i < out.count; ++i) {
                const HostNode& child = tree_.nodes[children[i]];
                out.lo_x[i] = child.box.lo[0] - pad_, out.hi_x[i] = child.box.hi[0] + pad_;
                out.lo_y[i] = child.box.lo[1] - pad_, out.hi_y[i] = child.box.hi[1] + pad_;
                out.lo_z[i] = child.box.lo[2] - pad_, out.hi_z[i] = child.box.hi[2] + pad_;
                if (collapse_.leaf(children[i]) && below_[children[i]].fits()) {
                    out.child[i] = append_block(scene_, below_[children[i]], accel_);
                } else if (collapse_.leaf(children[i])) {
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
    const std::vector<Gathered>& below_;
    const Collapse& collapse_;
    float pad_;
    Accel& accel_;
};

}  // namespace

void flatten_bvh8(const Scene& scene, const HostTree& tree, float pad, Accel& accel) {
    const std::vector<Gathered> below = gather(scene, tree);
    if (Bvh8Builder(scene, tree, below, Collapse::optimal(tree, below), pad, accel).build() <= IR_BVH8_MAX_DEPTH)
        return;
    Bvh8Builder(scene, tree, below, Collapse::by_level(tree, below), pad, accel).build();
}

}  // namespace irradia::accel
