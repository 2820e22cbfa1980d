#include "host_tree.h"

#include <algorithm>
#include <numeric>

#include "embree_tree.h"
#include "irradia/Error.h"

namespace irradia::accel {
namespace {

constexpr std::size_t kMaxPrimitives = std::size_t{1} << 24;  // IR_LEAF_FIRST has 24 bits

std::int32_t append_leaf(HostTree& tree, const Box& box, const std::uint32_t* primitives, std::uint32_t count) {
    HostNode node;
    node.box = box;
    node.first = static_cast<std::uint32_t>(tree.primitives.size());
    node.count = count;
    tree.primitives.insert(tree.primitives.end(), primitives, primitives + count);
    tree.nodes.push_back(node);
    return static_cast<std::int32_t>(tree.nodes.size()) - 1;
}

std::int32_t append_median(const Scene& scene, HostTree& tree, const std::vector<Box>& boxes, std::uint32_t* primitives,
                           std::uint32_t count, std::uint32_t depth) {
    Box box, centres;
    const auto centre = [&](std::uint32_t p, int k) { return 0.5f * (boxes[p].lo[k] + boxes[p].hi[k]); };
    for (std::uint32_t i = 0; i < count; ++i) {
        box.add(boxes[primitives[i]]);
        const std::array<float, 3> at{centre(primitives[i], 0), centre(primitives[i], 1), centre(primitives[i], 2)};
        centres.add({at, at});
    }
    if (count <= kMaxLeafTriangles) {
        std::sort(primitives, primitives + count);
        return append_primitives(scene, tree, box, primitives, count, depth);
    }
    int axis = 0;
    for (int k = 1; k < 3; ++k)
        if (centres.hi[k] - centres.lo[k] > centres.hi[axis] - centres.lo[axis]) axis = k;
    const std::uint32_t half = count / 2;
    std::nth_element(primitives, primitives + half, primitives + count, [&](std::uint32_t a, std::uint32_t b) {
        const float ca = centre(a, axis), cb = centre(b, axis);
        return ca != cb ? ca < cb : a < b;  // a total order: the halves are unique as sets
    });
    const auto self = static_cast<std::int32_t>(tree.nodes.size());
    tree.nodes.emplace_back().box = box;
    const std::int32_t l = append_median(scene, tree, boxes, primitives, half, depth + 1);
    const std::int32_t r = append_median(scene, tree, boxes, primitives + half, count - half, depth + 1);
    tree.nodes[self].left = l;
    tree.nodes[self].right = r;
    return self;
}

bool fits(const HostTree& tree) {
    return !tree.nodes.empty() && tree.depth <= IR_BVH2_MAX_DEPTH && tree.primitives.size() <= kMaxPrimitives;
}

}  // namespace

void check_primitive_count(std::size_t count, const std::string& source) {
    if (count <= kMaxPrimitives) return;
    throw Error((source.empty() ? std::string("scene") : source) + ": " + std::to_string(count) +
                " triangles, spheres, disks and cylinders; the acceleration structure holds at most " +
                std::to_string(kMaxPrimitives));
}

std::int32_t append_primitives(const Scene& scene, HostTree& tree, const Box& box, const std::uint32_t* primitives,
                               std::uint32_t count, std::uint32_t depth) {
    tree.depth = std::max(tree.depth, depth);
    const auto is_triangle = [&](std::uint32_t p) { return p < scene.triangles.size(); };
    const auto triangles =
        static_cast<std::uint32_t>(std::partition_point(primitives, primitives + count, is_triangle) - primitives);
    if (count == 1 || triangles == count) return append_leaf(tree, box, primitives, count);
    const std::uint32_t left = triangles ? triangles : count / 2;
    const auto part = [&](std::uint32_t begin, std::uint32_t end) {
        Box b;
        for (std::uint32_t i = begin; i < end; ++i) b.add(overlap(box, primitive_box(scene, primitives[i])));
        return append_primitives(scene, tree, b, primitives + begin, end - begin, depth + 1);
    };
    const auto self = static_cast<std::int32_t>(tree.nodes.size());
    tree.nodes.emplace_back().box = box;
    const std::int32_t l = part(0, left), r = part(left, count);
    tree.nodes[self].left = l;
    tree.nodes[self].right = r;
    return self;
}

HostTree build_median_tree(const Scene& scene) {
    HostTree tree;
    const auto count = static_cast<std::uint32_t>(scene.triangles.size() + scene.analytics.size());
    if (count == 0) return tree;
    std::vector<Box> boxes(count);
    for (std::uint32_t i = 0; i < count; ++i) boxes[i] = primitive_box(scene, i);
    std::vector<std::uint32_t> order(count);
    std::iota(order.begin(), order.end(), 0u);
    append_median(scene, tree, boxes, order.data(), count, 0);
    return tree;
}

HostTree build_host_tree(const Scene& scene, AccelQuality quality, AccelLayouts layouts,
                         const std::function<void(double)>& progress) {
    if (scene.triangles.empty() && scene.analytics.empty()) return {};
    const TreeKind quick = layouts == AccelLayouts::bvh8 ? TreeKind::blocks : TreeKind::pairs;
    const bool best = quality == AccelQuality::best;
    HostTree tree = build_embree_tree(scene, best ? TreeKind::splits : quick, progress);
    if (best && !fits(tree)) tree = build_embree_tree(scene, quick, progress);
    if (!fits(tree)) tree = build_median_tree(scene);
    return tree;
}

}  // namespace irradia::accel
