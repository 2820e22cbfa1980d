#include "embree_tree.h"

#if IRRADIA_EMBREE_MAJOR >= 4
#include <embree4/rtcore.h>
#else
#include <embree3/rtcore.h>
#endif
#include <tbb/enumerable_thread_specific.h>

#include <algorithm>
#include <cstddef>
#include <cstring>
#include <exception>
#include <memory>
#include <mutex>
#include <new>
#include <vector>

namespace irradia::accel {
namespace {

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
    std::uint32_t primitives[kWidth] = {};
};

struct Counts {
    std::size_t nodes = 0, references = 0;
};
struct BuildContext {
    const Scene& scene;
    const std::vector<std::uint32_t>& starts;  // the builder's primitive p is ours from starts[p] to starts[p + 1]
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
    auto& context = *static_cast<BuildContext*>(user);
    auto* leaf = new (node_memory(allocator, sizeof(BuildLeaf))) BuildLeaf;
    leaf->leaf = true;
    std::uint32_t* end = leaf->primitives;
    for (std::size_t i = 0; i < count; ++i) {
        const unsigned p = primitives[i].primID;
        for (std::uint32_t t = context.starts[p]; t < context.starts[p + 1]; ++t) *end++ = t;
    }
    // The builder's order within a leaf may depend on its threads; ours must not.
    std::sort(leaf->primitives, end);
    leaf->count = static_cast<std::uint32_t>(std::unique(leaf->primitives, end) - leaf->primitives);
    Counts& counts = context.counts.local();
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
    void add(const LaneBox& b) {
        lo = smaller(b.lo, lo);
        hi = larger(b.hi, hi);
    }
    [[nodiscard]] Box box() const { return {{lo[0], lo[1], lo[2]}, {hi[0], hi[1], hi[2]}}; }
    void store(unsigned index, RTCBuildPrimitive& out) const {
        std::memcpy(&out.lower_x, &lo, sizeof lo);
        std::memcpy(&out.upper_x, &hi, sizeof hi);
        out.geomID = 0;
        out.primID = index;
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

// What the builder sorts. Its primitive p is ours from starts[p] to starts[p + 1].
struct BuilderInput {
    std::vector<std::uint32_t> starts;
    std::unique_ptr<RTCBuildPrimitive[]> primitives;  // no vector, which would clear it
    std::size_t capacity = 0;
    LaneBox root;

    /// The next one begins at `start`.
    void add(std::uint32_t start, const LaneBox& box) {
        box.store(static_cast<unsigned>(starts.size()), primitives[starts.size()]);
        starts.push_back(start);
        root.add(box);
    }
};

LaneBox lane_box(const Scene& scene, std::uint32_t primitive) {
    LaneBox b;
    if (primitive < scene.triangles.size()) {
        const shared::Triangle& t = scene.triangles[primitive];
        for (const std::uint32_t v : {t.v0, t.v1, t.v2}) b.add(load(&scene.vertices[v].px));
    } else {
        const Box box = primitive_box(scene, primitive);
        b.add(Lanes{box.lo[0], box.lo[1], box.lo[2], 0});
        b.add(Lanes{box.hi[0], box.hi[1], box.hi[2], 0});
    }
    return b;
}

// With pairs: triangles that follow one another and lie as close as the halves of a quadrilateral, as most do, are one
// primitive to the builder, which so has little more than half of the work. Else each is one, which spatial splits may
// cut.
BuilderInput builder_input(const Scene& scene, TreeKind kind) {
    // Area of the common box, to the sum of both. Measured: where a leaf has two pairs at most those up to 1 make rays
    // take up to 1.2 times as long, in blocks 1.03 times.
    const float close = kind == TreeKind::blocks ? 0.85f : 0.75f;
    const auto triangles = static_cast<std::uint32_t>(scene.triangles.size());
    const auto end = static_cast<std::uint32_t>(triangles + scene.analytics.size());
    BuilderInput in;
    // Room for the fragments of split triangles, which costs nothing until it is used.
    in.capacity = kind == TreeKind::splits ? std::size_t{2} * end : end;
    in.primitives.reset(new RTCBuildPrimitive[in.capacity]);
    in.starts.reserve(end + std::size_t{1});
    LaneBox next = triangles > 0 ? lane_box(scene, 0) : LaneBox{};
    for (std::uint32_t i = 0; i < triangles;) {
        const std::uint32_t start = i;
        LaneBox box = next;
        if (++i < triangles) next = lane_box(scene, i);
        if (i < triangles && kind != TreeKind::splits) {
            LaneBox both = box;
            both.add(next);
            if (both.box().area() <= close * (box.box().area() + next.box().area())) {
                box = both;
                if (++i < triangles) next = lane_box(scene, i);
            }
        }
        in.add(start, box);
    }
    for (std::uint32_t i = triangles; i < end; ++i) in.add(i, lane_box(scene, i));
    in.starts.push_back(end);
    return in;
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

}  // namespace

HostTree build_embree_tree(const Scene& scene, TreeKind kind, const std::function<void(double)>& progress) {
    const bool spatial_splits = kind == TreeKind::splits;
    BuilderInput in = builder_input(scene, kind);
    const std::unique_ptr<RTCDeviceTy, decltype(&rtcReleaseDevice)> device(rtcNewDevice("set_affinity=0"),
                                                                           rtcReleaseDevice);
    const std::unique_ptr<RTCBVHTy, decltype(&rtcReleaseBVH)> bvh(rtcNewBVH(device.get()), rtcReleaseBVH);
    if (!device || !bvh) throw std::bad_alloc();
    BuildContext context{scene, in.starts, progress};
    RTCBuildArguments arguments = rtcDefaultBuildArguments();
    arguments.buildQuality = spatial_splits ? RTC_BUILD_QUALITY_HIGH : RTC_BUILD_QUALITY_MEDIUM;
    arguments.maxBranchingFactor = 2;
    arguments.maxDepth = IR_BVH2_MAX_DEPTH - 8;
    arguments.minLeafSize = 1;
    const unsigned of_one_price = kind == TreeKind::blocks ? kWidth / 2 : 1;
    arguments.sahBlockSize = of_one_price;
    arguments.maxLeafSize = spatial_splits ? kMaxLeafTriangles : std::max(of_one_price, kMaxLeafTriangles / 2);
    arguments.bvh = bvh.get();
    arguments.primitives = in.primitives.get();
    arguments.primitiveCount = in.starts.size() - 1;
    arguments.primitiveArrayCapacity = in.capacity;
    arguments.createNode = create_node;
    arguments.setNodeChildren = set_children;
    arguments.setNodeBounds = set_bounds;
    arguments.createLeaf = create_leaf;
    arguments.splitPrimitive = split_primitive;
    if (progress) arguments.buildProgress = report_progress;
    arguments.userPtr = &context;
    const auto* built = static_cast<const BuildNode*>(rtcBuildBVH(&arguments));
    in.primitives.reset();
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
    if (built) append_built(scene, tree, *built, in.root.box(), 0);
    return tree;
}

}  // namespace irradia::accel
