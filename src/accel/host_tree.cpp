#include "host_tree.h"

#include "irradia/Error.h"

#if IRRADIA_EMBREE_MAJOR >= 4
#include <embree4/rtcore.h>
#else
#include <embree3/rtcore.h>
#endif
#include <tbb/task_arena.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <numeric>

namespace irradia::accel {

void Box::add(const Box& b) {
    for (int k = 0; k < 3; ++k) {
        lo[k] = std::min(lo[k], b.lo[k]);
        hi[k] = std::max(hi[k], b.hi[k]);
    }
}

float Box::area() const {
    const float x = hi[0] - lo[0], y = hi[1] - lo[1], z = hi[2] - lo[2];
    return x * y + y * z + z * x;
}

namespace {

constexpr std::size_t kMaxPrimitives = std::size_t{1} << 24;  // IR_LEAF_FIRST has 24 bits

using Point = std::array<float, 3>;

std::array<Point, 3> corners(const Scene& scene, std::uint32_t triangle) {
    const shared::Triangle& t = scene.triangles[triangle];
    std::array<Point, 3> p;
    const std::uint32_t index[3] = {t.v0, t.v1, t.v2};
    for (int i = 0; i < 3; ++i) {
        const shared::Vertex& v = scene.vertices[index[i]];
        p[i] = {v.px, v.py, v.pz};
    }
    return p;
}

void add_point(Box& box, const Point& p) { box.add({p, p}); }

Box overlap(const Box& a, const Box& b) {
    Box r;
    for (int k = 0; k < 3; ++k) {
        r.lo[k] = std::max(a.lo[k], b.lo[k]);
        r.hi[k] = std::max(r.lo[k], std::min(a.hi[k], b.hi[k]));
    }
    return r;
}

Box disk_box(const shared::Analytic& a) {
    // The stored axes are h / |h|^2, so h = axis / |axis|^2; the disk reaches sqrt(hu_k^2 + hv_k^2) along axis k.
    const double u[3] = {a.ux, a.uy, a.uz}, v[3] = {a.vx, a.vy, a.vz};
    const double uu = u[0] * u[0] + u[1] * u[1] + u[2] * u[2], vv = v[0] * v[0] + v[1] * v[1] + v[2] * v[2];
    const float centre[3] = {a.px, a.py, a.pz};
    Box box;
    for (int k = 0; k < 3; ++k) {
        const auto reach = static_cast<float>(std::hypot(u[k] / uu, v[k] / vv) * (1 + 0x1p-22));
        box.lo[k] = centre[k] - reach;
        box.hi[k] = centre[k] + reach;
    }
    return box;
}

Box cylinder_box(const shared::Analytic& a) {
    // Circles of the given radius around both ends; one reaches radius * sqrt(1 - axis_k^2) along axis k.
    const float base[3] = {a.px, a.py, a.pz}, axis[3] = {a.nx, a.ny, a.nz};
    Box box;
    for (int k = 0; k < 3; ++k) {
        const double along = axis[k], end = base[k] + along * a.length;
        const double reach = a.radius * std::sqrt(std::max(1 - along * along, 0.0)) * (1 + 0x1p-20);
        const double slack = (std::abs(base[k]) + a.length + a.radius) * 0x1p-22;  // of a rounded axis
        box.lo[k] = static_cast<float>(std::min(double{base[k]}, end) - reach - slack);
        box.hi[k] = static_cast<float>(std::max(double{base[k]}, end) + reach + slack);
    }
    return box;
}

// ---- Embree's builder ---------------------------------------------------------------------------------------------

struct BuildNode {  // lives in Embree's allocator
    BuildNode* child[2] = {nullptr, nullptr};
    Box box[2];
    std::uint32_t count = 0;  // leaf: primitives
    std::uint32_t primitives[kMaxLeafTriangles] = {};
};

Box to_box(const RTCBounds& b) { return {{b.lower_x, b.lower_y, b.lower_z}, {b.upper_x, b.upper_y, b.upper_z}}; }

void to_bounds(const Box& b, RTCBounds* out) {
    out->lower_x = b.lo[0], out->lower_y = b.lo[1], out->lower_z = b.lo[2];
    out->upper_x = b.hi[0], out->upper_y = b.hi[1], out->upper_z = b.hi[2];
}

void* create_node(RTCThreadLocalAllocator allocator, unsigned, void*) {
    return new (rtcThreadLocalAlloc(allocator, sizeof(BuildNode), 16)) BuildNode;
}

void set_children(void* node, void** children, unsigned count, void*) {
    for (unsigned i = 0; i < count; ++i) static_cast<BuildNode*>(node)->child[i] = static_cast<BuildNode*>(children[i]);
}

void set_bounds(void* node, const RTCBounds** bounds, unsigned count, void*) {
    for (unsigned i = 0; i < count; ++i) static_cast<BuildNode*>(node)->box[i] = to_box(*bounds[i]);
}

void* create_leaf(RTCThreadLocalAllocator allocator, const RTCBuildPrimitive* primitives, std::size_t count, void*) {
    auto* leaf = new (rtcThreadLocalAlloc(allocator, sizeof(BuildNode), 16)) BuildNode;
    leaf->count = static_cast<std::uint32_t>(count);
    for (std::size_t i = 0; i < count; ++i) leaf->primitives[i] = primitives[i].primID;
    // The builder's order within a leaf may depend on its threads; ours must not.
    std::sort(leaf->primitives, leaf->primitives + count);
    leaf->count =
        static_cast<std::uint32_t>(std::unique(leaf->primitives, leaf->primitives + count) - leaf->primitives);
    return leaf;
}

// The bounds of what lies left and right of a plane, of a triangle that is already clipped to the given box.
void split_primitive(const RTCBuildPrimitive* primitive, unsigned axis, float position, RTCBounds* left,
                     RTCBounds* right, void* user) {
    const Scene& scene = *static_cast<const Scene*>(user);
    const Box whole = {{primitive->lower_x, primitive->lower_y, primitive->lower_z},
                       {primitive->upper_x, primitive->upper_y, primitive->upper_z}};
    Box l = whole, r = whole;
    if (primitive->primID < scene.triangles.size()) {
        const std::array<Point, 3> p = corners(scene, primitive->primID);
        l = {}, r = {};
        for (int i = 0; i < 3; ++i) {
            const Point &a = p[i], &b = p[(i + 1) % 3];
            if (a[axis] <= position) add_point(l, a);
            if (a[axis] >= position) add_point(r, a);
            if ((a[axis] < position) == (b[axis] < position) || a[axis] == position || b[axis] == position) continue;
            const double s = (double{position} - a[axis]) / (double{b[axis]} - a[axis]);
            Point c;
            for (int k = 0; k < 3; ++k) c[k] = static_cast<float>(a[k] + s * (double{b[k]} - a[k]));
            c[axis] = position;
            add_point(l, c);
            add_point(r, c);
        }
        l = overlap(whole, l);
        r = overlap(whole, r);
    } else {
        l.hi[axis] = r.lo[axis] = position;
    }
    to_bounds(l, left);
    to_bounds(r, right);
}

// ---- host tree ----------------------------------------------------------------------------------------------------

std::int32_t append_leaf(HostTree& tree, const Box& box, const std::uint32_t* primitives, std::uint32_t count) {
    HostNode node;
    node.box = box;
    node.first = static_cast<std::uint32_t>(tree.primitives.size());
    node.count = count;
    tree.primitives.insert(tree.primitives.end(), primitives, primitives + count);
    tree.nodes.push_back(node);
    return static_cast<std::int32_t>(tree.nodes.size()) - 1;
}

// Leaves hold triangles only or one analytic primitive: anything else becomes a small subtree. `primitives` ascend, so
// that the triangles come first.
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

std::int32_t append_built(const Scene& scene, HostTree& tree, const BuildNode& node, const Box& box,
                          std::uint32_t depth) {
    if (node.count) return append_primitives(scene, tree, box, node.primitives, node.count, depth);
    const auto self = static_cast<std::int32_t>(tree.nodes.size());
    tree.nodes.emplace_back().box = box;
    const std::int32_t l = append_built(scene, tree, *node.child[0], node.box[0], depth + 1);
    const std::int32_t r = append_built(scene, tree, *node.child[1], node.box[1], depth + 1);
    tree.nodes[self].left = l;
    tree.nodes[self].right = r;
    return self;
}

std::int32_t append_median(const Scene& scene, HostTree& tree, const std::vector<Box>& boxes, std::uint32_t* primitives,
                           std::uint32_t count, std::uint32_t depth) {
    Box box, centres;
    const auto centre = [&](std::uint32_t p, int k) { return 0.5f * (boxes[p].lo[k] + boxes[p].hi[k]); };
    for (std::uint32_t i = 0; i < count; ++i) {
        box.add(boxes[primitives[i]]);
        add_point(centres, {centre(primitives[i], 0), centre(primitives[i], 1), centre(primitives[i], 2)});
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

// Embree's tree, or an empty one if it gives up (depth limit).
HostTree build_embree_tree(const Scene& scene, bool spatial_splits) {
    const std::size_t count = scene.triangles.size() + scene.analytics.size();
    const std::unique_ptr<RTCDeviceTy, decltype(&rtcReleaseDevice)> device(rtcNewDevice("set_affinity=0"),
                                                                           rtcReleaseDevice);
    const std::unique_ptr<RTCBVHTy, decltype(&rtcReleaseBVH)> bvh(rtcNewBVH(device.get()), rtcReleaseBVH);
    std::vector<RTCBuildPrimitive> primitives;
    primitives.reserve(spatial_splits ? 2 * count : count);  // room for the fragments of split triangles
    Box root;
    for (std::size_t i = 0; i < count; ++i) {
        const Box b = primitive_box(scene, static_cast<std::uint32_t>(i));
        root.add(b);
        primitives.push_back({b.lo[0], b.lo[1], b.lo[2], 0, b.hi[0], b.hi[1], b.hi[2], static_cast<unsigned>(i)});
    }
    RTCBuildArguments arguments = rtcDefaultBuildArguments();
    arguments.buildQuality = spatial_splits ? RTC_BUILD_QUALITY_HIGH : RTC_BUILD_QUALITY_MEDIUM;
    arguments.maxBranchingFactor = 2;
    arguments.maxDepth = IR_BVH2_MAX_DEPTH - 8;
    arguments.minLeafSize = 1;
    arguments.maxLeafSize = kMaxLeafTriangles;
    arguments.bvh = bvh.get();
    arguments.primitives = primitives.data();
    arguments.primitiveCount = count;
    arguments.primitiveArrayCapacity = primitives.capacity();
    arguments.createNode = create_node;
    arguments.setNodeChildren = set_children;
    arguments.setNodeBounds = set_bounds;
    arguments.createLeaf = create_leaf;
    arguments.splitPrimitive = split_primitive;
    arguments.userPtr = const_cast<Scene*>(&scene);
    const auto* built = static_cast<const BuildNode*>(rtcBuildBVH(&arguments));
    HostTree tree;
    if (built) append_built(scene, tree, *built, root, 0);
    return tree;
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

Box primitive_box(const Scene& scene, std::uint32_t primitive) {
    Box box;
    if (primitive < scene.triangles.size()) {
        for (const Point& p : corners(scene, primitive)) add_point(box, p);
        return box;
    }
    const shared::Analytic& a = scene.analytics[primitive - scene.triangles.size()];
    if (a.kind == IR_ANALYTIC_DISK) return disk_box(a);
    if (a.kind == IR_ANALYTIC_CYLINDER) return cylinder_box(a);
    return {{a.px - a.radius, a.py - a.radius, a.pz - a.radius}, {a.px + a.radius, a.py + a.radius, a.pz + a.radius}};
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

HostTree build_host_tree(const Scene& scene, int threads) {
    if (scene.triangles.empty() && scene.analytics.empty()) return {};
    HostTree tree;
    tbb::task_arena arena(threads > 0 ? threads : tbb::task_arena::automatic);
    arena.execute([&] {
        tree = build_embree_tree(scene, true);
        if (!fits(tree)) tree = build_embree_tree(scene, false);
    });
    if (!fits(tree)) tree = build_median_tree(scene);
    return tree;
}

}  // namespace irradia::accel
