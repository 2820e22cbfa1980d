// What traversals take for granted of the acceleration structures: trees of bounded depth (so that their stacks hold),
// references within the arrays, boxes that let no ray into a child that does not exist.
#include <algorithm>
#include <vector>

#include "core/check.h"

namespace irradia::check {
namespace {

// The boxes of children that do not exist are inverted by this much at least, so that no rounding lets a ray in.
constexpr float kInverted = 1e29f;

/// Walks from node 0; `visit(node, push)` checks a node and pushes its inner children. Each node may be met once.
template <class Visit>
void walk(const Place& tree, std::size_t count, std::uint32_t max_depth, Visit&& visit) {
    struct Item {
        std::uint32_t node, depth;
    };
    std::vector<bool> met(count, false);
    std::vector<Item> stack{{0, 1}};
    met[0] = true;
    while (!stack.empty()) {
        const Item item = stack.back();
        stack.pop_back();
        const Place p{tree.where, tree.array, item.node};
        if (item.depth > max_depth) p.fail("deeper than " + std::to_string(max_depth) + " nodes");
        visit(p, item.node, [&](std::uint32_t child) {
            p.below(child, count, "child");
            p.require(!met[child], "a child that has another parent already");
            met[child] = true;
            stack.push_back({child, item.depth + 1});
        });
    }
}

/// A leaf's range: analytic primitives, or `count` triangles from `first` on, of `triangles` in all.
void check_leaf(const Place& p, std::uint32_t leaf, std::size_t analytics, std::uint64_t first, std::uint64_t end,
                std::size_t triangles) {
    if (leaf & IR_LEAF_ANALYTIC) {
        if (IR_LEAF_FIRST(leaf) + IR_LEAF_COUNT(leaf) > analytics) p.fail("a leaf beyond the analytic primitives");
    } else if (first >= end || end > triangles) {
        p.fail("a leaf beyond the triangles");
    }
}

void check_bvh8(const std::string& where, const Scene& scene) {
    const Accel& a = scene.accel;
    for (std::size_t i = 0; i < a.bvh8_triangles.size(); ++i) {
        const shared::TriangleBlock& b = a.bvh8_triangles[i];
        const Place p{where, "triangle block", i};
        for (int k = 0; k < 8; ++k) {
            const float v[3][3] = {
                {b.v0x[k], b.v0y[k], b.v0z[k]}, {b.v1x[k], b.v1y[k], b.v1z[k]}, {b.v2x[k], b.v2y[k], b.v2z[k]}};
            for (const auto& vertex : v) p.finite(vertex[0], vertex[1], vertex[2]);
            if (b.primitive[k] == IR_NO_PRIMITIVE)
                p.require(std::equal(v[0], v[0] + 3, v[1]) && std::equal(v[0], v[0] + 3, v[2]),
                          "an unused slot has a surface");
            else
                p.below(b.primitive[k], scene.triangles.size(), "triangle");
        }
    }
    walk({where, "BVH8 node"}, a.bvh8_nodes.size(), IR_BVH8_MAX_DEPTH,
         [&](const Place& p, std::uint32_t index, auto push) {
             const shared::Bvh8Node& n = a.bvh8_nodes[index];
             p.require(n.count <= 8, "more than eight children");
             for (std::uint32_t k = 0; k < 8; ++k) {
                 if (k >= n.count) {
                     p.require(n.child[k] == IR_EMPTY, "a child beyond the count");
                     p.require(n.lo_x[k] >= kInverted && n.lo_y[k] >= kInverted && n.lo_z[k] >= kInverted &&
                                   n.hi_x[k] <= -kInverted && n.hi_y[k] <= -kInverted && n.hi_z[k] <= -kInverted,
                               "an empty child has a box");
                     continue;
                 }
                 p.finite(n.lo_x[k], n.lo_y[k], n.lo_z[k], n.hi_x[k], n.hi_y[k], n.hi_z[k]);
                 const std::uint32_t child = n.child[k];
                 p.require(child != IR_EMPTY, "a child is missing");
                 if (!(child & IR_LEAF)) {
                     push(child);
                     continue;
                 }
                 const std::uint64_t first = IR_LEAF_FIRST(child);
                 const bool block = !(child & IR_LEAF_ANALYTIC);
                 p.require(!block || (IR_LEAF_COUNT(child) >= 1 && IR_LEAF_COUNT(child) <= 8),
                           "a leaf's count is out of range");
                 check_leaf(p, child, scene.analytics.size(), first, first + 1, a.bvh8_triangles.size());
             }
         });
}

void check_bvh2(const std::string& where, const Scene& scene) {
    const Accel& a = scene.accel;
    for (std::size_t i = 0; i < a.bvh2_triangles.size(); ++i) {
        const shared::TrianglePacked& t = a.bvh2_triangles[i];
        const Place p{where, "packed triangle", i};
        p.finite(t.v0x, t.v0y, t.v0z, t.v1x, t.v1y, t.v1z, t.v2x, t.v2y, t.v2z);
        p.below(t.primitive, scene.triangles.size(), "triangle");
    }
    walk({where, "BVH2 node"}, a.bvh2_nodes.size(), IR_BVH2_MAX_DEPTH,
         [&](const Place& p, std::uint32_t index, auto push) {
             const shared::Bvh2Node& n = a.bvh2_nodes[index];
             p.finite(n.lo0x, n.lo0y, n.lo0z, n.hi0x, n.hi0y, n.hi0z, n.lo1x, n.lo1y, n.lo1z, n.hi1x, n.hi1y, n.hi1z);
             for (const std::uint32_t child : {n.child0, n.child1}) {
                 if (child == IR_EMPTY) continue;
                 if (!(child & IR_LEAF)) {
                     push(child);
                     continue;
                 }
                 const std::uint64_t first = IR_LEAF_FIRST(child);
                 check_leaf(p, child, scene.analytics.size(), first, first + IR_LEAF_COUNT(child),
                            a.bvh2_triangles.size());
             }
         });
}

}  // namespace

void check_accel(const std::string& where, const Scene& scene, AccelLayouts layouts) {
    const bool bvh8 = layouts != AccelLayouts::bvh2, bvh2 = layouts != AccelLayouts::bvh8;
    if ((bvh8 && scene.accel.bvh8_nodes.empty()) || (bvh2 && scene.accel.bvh2_nodes.empty()))
        throw Error(where + ": no acceleration structure");
    if (bvh8) check_bvh8(where, scene);
    if (bvh2) check_bvh2(where, scene);
}

}  // namespace irradia::check
