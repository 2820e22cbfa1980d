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
    Bvh8Builder(const Scene& scene, const HostTree& tree, const Collapse& collapse, float pad, Accel& accel)
        : scene_(scene), tree_(tree), collapse_(collapse), pad_(pad), accel_(accel) {}

    /// Depth of the tree written, in nodes.
    uint32_t build() {
        accel_.bvh8_nodes.clear();
        accel_.bvh8_triangles.clear();
        // Counted first: arrays that grow are in memory twice while they do.
        std::size_t nodes = 1, blocks = 0;
        if (!tree_.nodes.empty()) count(0, nodes, blocks);
        accel_.bvh8_nodes.reserve(nodes);
        accel_.bvh8_triangles.reserve(blocks);
        return append(0);
    }

private:
    [[nodiscard]] bool is_block(uint32_t leaf) const {
        uint32_t n = leaf;
        while (!tree_.nodes[n].leaf()) n = static_cast<uint32_t>(tree_.nodes[n].left);
        return tree_.primitives[tree_.nodes[n].first] < scene_.triangles.size();  // leaves hold primitives of one kind
    }

    void count(uint32_t node, std::size_t& nodes, std::size_t& blocks) const {
        if (collapse_.leaf(node)) {
            blocks += is_block(node);
            return;
        }
        const Children children = collapse_.children(node);
        for (uint32_t i = 0; i < children.count; ++i) {
            nodes += !collapse_.leaf(children.nodes[i]);
            count(children.nodes[i], nodes, blocks);
        }
    }

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
            const Children all = collapse_.leaf(node) ? Children{1, {node}} : collapse_.children(node);
            const auto& children = all.nodes;
            out.count = all.count;
            for (uint32_t i = 0; i < out.count; ++i) {
                const HostNode& child = tree_.nodes[children[i]];
                out.lo_x[i] = child.box.lo[0] - pad_, out.hi_x[i] = child.box.hi[0] + pad_;
                out.lo_y[i] = child.box.lo[1] - pad_, out.hi_y[i] = child.box.hi[1] + pad_;
                out.lo_z[i] = child.box.lo[2] - pad_, out.hi_z[i] = child.box.hi[2] + pad_;
                if (collapse_.leaf(children[i]) && is_block(children[i])) {
                    out.child[i] = append_block(scene_, gather(scene_, tree_, children[i]), accel_);
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
    const Collapse& collapse_;
    float pad_;
    Accel& accel_;
};

}  // namespace

void flatten_bvh8(const Scene& scene, const HostTree& tree, float pad, Accel& accel) {
    if (Bvh8Builder(scene, tree, Collapse::optimal(scene, tree), pad, accel).build() <= IR_BVH8_MAX_DEPTH) return;
    Bvh8Builder(scene, tree, Collapse::by_level(scene, tree), pad, accel).build();
}

}  // namespace irradia::accel
