#include "host_tree.h"

#include "irradia/Error.h"

#if IRRADIA_EMBREE_MAJOR >= 4
#include <embree4/rtcore.h>
#else
#include <embree3/rtcore.h>
#endif
#include <tbb/enumerable_thread_specific.h>
#include <tbb/parallel_reduce.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstring>
#include <exception>
#include <memory>
#include <mutex>
#include <new>
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

// Both live in Embree's allocator; large scenes have millions of them.
struct BuildNode {
    bool leaf = false;
};
struct BuildInner : BuildNode {
    BuildNode* child[2] = {nullptr, nullptr};
    Box box[2];
};
struct BuildLeaf : BuildNode {
    std::uint32_t count = 0;
    std::uint32_t primitives[kMaxLeafTriangles] = {};
};

struct Counts {
    std::size_t nodes = 0, references = 0;
};
struct BuildContext {
    const Scene& scene;
    const std::function<void(double)>& progress;
    tbb::enumerable_thread_specific<Counts> counts{};  // each thread its own: they all count all the time
    std::mutex mutex{};
    std::exception_ptr refusal{};  // what progress has thrown
};

Box to_box(const RTCBounds& b) { return {{b.lower_x, b.lower_y, b.lower_z}, {b.upper_x, b.upper_y, b.upper_z}}; }

/// Embree's own builders throw the same where its allocator fails; rtcBuildBVH() makes an error code of it.
void* node_memory(RTCThreadLocalAllocator allocator, std::size_t bytes) {
    void* const memory = rtcThreadLocalAlloc(allocator, bytes, 16);
    if (memory == nullptr) throw std::bad_alloc();
    return memory;
}

void* create_node(RTCThreadLocalAllocator allocator, unsigned, void* user) {
    ++static_cast<BuildContext*>(user)->counts.local().nodes;
    return static_cast<BuildNode*>(new (node_memory(allocator, sizeof(BuildInner))) BuildInner);
}

BuildInner* inner(void* node) { return static_cast<BuildInner*>(static_cast<BuildNode*>(node)); }

void set_children(void* node, void** children, unsigned count, void*) {
    for (unsigned i = 0; i < count; ++i) inner(node)->child[i] = static_cast<BuildNode*>(children[i]);
}

void set_bounds(void* node, const RTCBounds** bounds, unsigned count, void*) {
    for (unsigned i = 0; i < count; ++i) inner(node)->box[i] = to_box(*bounds[i]);
}

void* create_leaf(RTCThreadLocalAllocator allocator, const RTCBuildPrimitive* primitives, std::size_t count,
                  void* user) {
    auto* leaf = new (node_memory(allocator, sizeof(BuildLeaf))) BuildLeaf;
    leaf->leaf = true;
    for (std::size_t i = 0; i < count; ++i) leaf->primitives[i] = primitives[i].primID;
    // The builder's order within a leaf may depend on its threads; ours must not.
    std::sort(leaf->primitives, leaf->primitives + count);
    leaf->count =
        static_cast<std::uint32_t>(std::unique(leaf->primitives, leaf->primitives + count) - leaf->primitives);
    Counts& counts = static_cast<BuildContext*>(user)->counts.local();
    ++counts.nodes;
    counts.references += leaf->count;
    return static_cast<BuildNode*>(leaf);
}

bool report_progress(void* user, double fraction) {
    auto& context = *static_cast<BuildContext*>(user);
    try {
        context.progress(fraction);
        return true;
    } catch (...) {  // not through Embree, which is asked to give up
        const std::lock_guard lock(context.mutex);
        context.refusal = std::current_exception();
        return false;
    }
}

// x, y, z and something of no meaning, in one register (GCC's and Clang's vectors; left to itself GCC makes scalars of
// half of what follows).
typedef float Lanes __attribute__((vector_size(16)));
typedef std::int32_t IntLanes __attribute__((vector_size(16)));

Lanes smaller(Lanes a, Lanes b) { return a < b ? a : b; }
Lanes larger(Lanes a, Lanes b) { return a > b ? a : b; }

Lanes load(const float* four) {
    Lanes v;
    std::memcpy(&v, four, sizeof v);
    return v;
}

struct LaneBox {
    Lanes lo{1e30f, 1e30f, 1e30f, 1e30f}, hi{-1e30f, -1e30f, -1e30f, -1e30f};
    void add(Lanes p) {
        lo = smaller(p, lo);
        hi = larger(p, hi);
    }
    /// What of it lies in `whole`, which is not empty.
    void store_overlap(const LaneBox& whole, RTCBounds* out) const {
        const Lanes l = larger(lo, whole.lo), h = larger(l, smaller(hi, whole.hi));
        std::memcpy(&out->lower_x, &l, sizeof l);
        std::memcpy(&out->upper_x, &h, sizeof h);
    }
};
static_assert(offsetof(RTCBounds, upper_x) == 16 && sizeof(RTCBounds) == 32);
static_assert(offsetof(RTCBuildPrimitive, upper_x) == 16 && offsetof(RTCBuildPrimitive, geomID) == 12);
static_assert(offsetof(shared::Vertex, px) == 0 && offsetof(shared::Vertex, pz) == 8);

// The bounds of what lies left and right of a plane, of a triangle that is already clipped to the given box. Half of a
// build is spent here. Corners on the edges are rounded by a few units in the last place of the scene's extent, for
// which build_accel() grows all boxes.
void split_primitive(const RTCBuildPrimitive* primitive, unsigned axis, float position, RTCBounds* left,
                     RTCBounds* right, void* user) {
    const Scene& scene = static_cast<BuildContext*>(user)->scene;
    const LaneBox whole{load(&primitive->lower_x), load(&primitive->upper_x)};  // and indices behind them
    const IntLanes on_axis = IntLanes{0, 1, 2, 3} == static_cast<std::int32_t>(axis);
    const Lanes plane = Lanes{} + position;
    LaneBox l, r;
    if (primitive->primID < scene.triangles.size()) {
        const shared::Triangle& t = scene.triangles[primitive->primID];
        const Lanes p[3] = {load(&scene.vertices[t.v0].px), load(&scene.vertices[t.v1].px),
                            load(&scene.vertices[t.v2].px)};
        for (int i = 0; i < 3; ++i) {
            const Lanes a = p[i], b = p[(i + 1) % 3];
            const float from = a[axis], to = b[axis];
            if (from <= position) l.add(a);
            if (from >= position) r.add(a);
            if (!((from < position && to > position) || (from > position && to < position))) continue;
            const Lanes c = on_axis ? plane : a + (position - from) / (to - from) * (b - a);
            l.add(c);
            r.add(c);
        }
    } else {
        l = r = whole;
        l.hi = on_axis ? plane : l.hi;
        r.lo = on_axis ? plane : r.lo;
    }
    l.store_overlap(whole, left);
    r.store_overlap(whole, right);
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
    if (node.leaf) {
        const auto& leaf = static_cast<const BuildLeaf&>(node);
        return append_primitives(scene, tree, box, leaf.primitives, leaf.count, depth);
    }
    const auto& both = static_cast<const BuildInner&>(node);
    const auto self = static_cast<std::int32_t>(tree.nodes.size());
    tree.nodes.emplace_back().box = box;
    const std::int32_t l = append_built(scene, tree, *both.child[0], both.box[0], depth + 1);
    const std::int32_t r = append_built(scene, tree, *both.child[1], both.box[1], depth + 1);
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
HostTree build_embree_tree(const Scene& scene, bool spatial_splits, const std::function<void(double)>& progress) {
    const std::size_t count = scene.triangles.size() + scene.analytics.size();
    const std::unique_ptr<RTCDeviceTy, decltype(&rtcReleaseDevice)> device(rtcNewDevice("set_affinity=0"),
                                                                           rtcReleaseDevice);
    const std::unique_ptr<RTCBVHTy, decltype(&rtcReleaseBVH)> bvh(rtcNewBVH(device.get()), rtcReleaseBVH);
    if (!device || !bvh) throw std::bad_alloc();
    // Room for the fragments of split triangles, which costs nothing until it is used: no vector, which would clear it.
    const std::size_t capacity = spatial_splits ? 2 * count : count;
    std::unique_ptr<RTCBuildPrimitive[]> primitives(new RTCBuildPrimitive[capacity]);
    const Box root = tbb::parallel_reduce(
        tbb::blocked_range<std::size_t>(0, count, 1 << 14), Box{},
        [&](const auto& range, Box all) {
            for (std::size_t i = range.begin(); i != range.end(); ++i) {
                const Box b = primitive_box(scene, static_cast<std::uint32_t>(i));
                all.add(b);
                primitives[i] = {b.lo[0], b.lo[1], b.lo[2], 0, b.hi[0], b.hi[1], b.hi[2], static_cast<unsigned>(i)};
            }
            return all;
        },
        [](Box a, const Box& b) {
            a.add(b);
            return a;
        });
    BuildContext context{scene, progress};
    RTCBuildArguments arguments = rtcDefaultBuildArguments();
    arguments.buildQuality = spatial_splits ? RTC_BUILD_QUALITY_HIGH : RTC_BUILD_QUALITY_MEDIUM;
    arguments.maxBranchingFactor = 2;
    arguments.maxDepth = IR_BVH2_MAX_DEPTH - 8;
    arguments.minLeafSize = 1;
    arguments.maxLeafSize = kMaxLeafTriangles;
    arguments.bvh = bvh.get();
    arguments.primitives = primitives.get();
    arguments.primitiveCount = count;
    arguments.primitiveArrayCapacity = capacity;
    arguments.createNode = create_node;
    arguments.setNodeChildren = set_children;
    arguments.setNodeBounds = set_bounds;
    arguments.createLeaf = create_leaf;
    arguments.splitPrimitive = split_primitive;
    if (progress) arguments.buildProgress = report_progress;
    arguments.userPtr = &context;
    const auto* built = static_cast<const BuildNode*>(rtcBuildBVH(&arguments));
    primitives.reset();
    if (context.refusal) std::rethrow_exception(context.refusal);
    if (!built && rtcGetDeviceError(device.get()) == RTC_ERROR_OUT_OF_MEMORY) throw std::bad_alloc();
    HostTree tree;
    Counts counts;
    for (const Counts& c : context.counts) {
        counts.nodes += c.nodes;
        counts.references += c.references;
    }
    // Analytic primitives have leaves of their own: at most one more leaf and node each.
    tree.nodes.reserve(counts.nodes + 2 * scene.analytics.size());
    tree.primitives.reserve(counts.references);
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

HostTree build_host_tree(const Scene& scene, int threads, const std::function<void(double)>& progress) {
    if (scene.triangles.empty() && scene.analytics.empty()) return {};
    HostTree tree;
    tbb::task_arena arena(threads > 0 ? threads : tbb::task_arena::automatic);
    arena.execute([&] {
        tree = build_embree_tree(scene, true, progress);
        if (!fits(tree)) tree = build_embree_tree(scene, false, progress);
    });
    if (!fits(tree)) tree = build_median_tree(scene);
    return tree;
}

}  // namespace irradia::accel
