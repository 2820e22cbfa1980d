// The structure itself: valid, deterministic, of bounded depth, and able to take degenerate scenes.
#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <cmath>
#include <cstring>
#include <set>
#include <vector>

#include "accel/collapse.h"
#include "accel/flatten.h"
#include "irradia/Accel.h"
#include "irradia/Error.h"
#include "reference.h"
#include "shapes.h"
#include "traversal.h"

namespace irradia {
namespace {

using testing::DeviceHit;
using testing::Ray;

struct Walk {
    std::uint32_t depth = 0;
    std::set<std::uint32_t> primitives;
};

void enter_leaf(const Scene& scene, std::uint32_t ref, bool wide, Walk& walk) {
    const std::uint32_t count = IR_LEAF_COUNT(ref), first = IR_LEAF_FIRST(ref);
    const auto triangles = static_cast<std::uint32_t>(scene.triangles.size());
    ASSERT_GT(count, 0u);
    for (std::uint32_t i = 0; i < count; ++i) {
        if (ref & IR_LEAF_ANALYTIC) {
            ASSERT_LT(first + i, scene.analytics.size());
            walk.primitives.insert(triangles + first + i);
        } else {
            ASSERT_LE(count, wide ? 8u : 4u);
            const std::uint32_t p = wide ? scene.accel.bvh8_triangles.at(first).primitive[i]
                                         : scene.accel.bvh2_triangles.at(first + i).primitive;
            ASSERT_LT(p, triangles);
            walk.primitives.insert(p);
        }
    }
}

void walk8(const Scene& scene, std::uint32_t ref, std::uint32_t depth, Walk& walk) {
    walk.depth = std::max(walk.depth, depth);
    const shared::Bvh8Node& n = scene.accel.bvh8_nodes.at(ref);
    ASSERT_LE(n.count, 8u);
    for (std::uint32_t i = 0; i < 8; ++i) {
        ASSERT_EQ(n.child[i] == IR_EMPTY, i >= n.count);
        ASSERT_EQ(n.lo_x[i] > n.hi_x[i], i >= n.count);
        if (i >= n.count) continue;
        if (n.child[i] & IR_LEAF)
            enter_leaf(scene, n.child[i], true, walk);
        else
            walk8(scene, n.child[i], depth + 1, walk);
    }
}

void walk2(const Scene& scene, std::uint32_t ref, std::uint32_t depth, Walk& walk) {
    walk.depth = std::max(walk.depth, depth);
    const shared::Bvh2Node& n = scene.accel.bvh2_nodes.at(ref);
    for (const std::uint32_t child : {n.child0, n.child1}) {
        if (child == IR_EMPTY) continue;
        if (child & IR_LEAF)
            enter_leaf(scene, child, false, walk);
        else
            walk2(scene, child, depth + 1, walk);
    }
}

void expect_valid_bvh8(const Scene& scene) {
    Walk wide;
    walk8(scene, 0, 1, wide);
    EXPECT_LE(wide.depth, std::uint32_t{IR_BVH8_MAX_DEPTH});
    EXPECT_EQ(wide.primitives.size(), scene.triangles.size() + scene.analytics.size());
}

void expect_valid(const Scene& scene) {
    expect_valid_bvh8(scene);
    Walk binary;
    walk2(scene, 0, 1, binary);
    EXPECT_LE(binary.depth, std::uint32_t{IR_BVH2_MAX_DEPTH});
    EXPECT_EQ(binary.primitives.size(), scene.triangles.size() + scene.analytics.size());
}

template <class T>
bool same_bytes(const std::vector<T>& a, const std::vector<T>& b) {
    return a.size() == b.size() && (a.empty() || std::memcmp(a.data(), b.data(), a.size() * sizeof(T)) == 0);
}

std::vector<DeviceHit> trace(const Scene& scene, bool cpu, const std::vector<Ray>& rays) {
    return testing::Traversal(scene, cpu).closest(rays);
}

TEST(BuildAccel, IsValidForMeshesSoupsAndAnalyticPrimitives) {
    Scene room = shapes::mesh_room(20000), soup = shapes::triangle_soup(5000, 0.5f, 1),
          mixed = shapes::triangle_soup(100, 0.5f, 2);
    for (int i = 0; i < 50; ++i) shapes::add_sphere(mixed, {0.1f * static_cast<float>(i), 0, 0}, 0.3f);
    for (Scene* scene : {&room, &soup, &mixed}) {
        build_accel(*scene);
        expect_valid(*scene);
    }
    // Long thin triangles across each other are what spatial splits are for: some triangle lies in more than one leaf.
    EXPECT_GT(soup.accel.bvh2_triangles.size(), soup.triangles.size());
}

// Without splits every triangle lies in one leaf.
TEST(BuildAccel, QuicklyWithoutSplits) {
    Scene soup = shapes::triangle_soup(20000, 0.2f, 3);
    build_accel(soup, 0, {}, AccelLayouts::both, AccelQuality::quick);
    expect_valid(soup);
    EXPECT_EQ(soup.accel.bvh2_triangles.size(), soup.triangles.size());
    EXPECT_EQ(soup.accel.quality, AccelQuality::quick);
}

// Halves of a quadrilateral lie in one leaf, where hierarchies are built quickly; neighbours in the list that are none
// in space do not.
TEST(BuildAccel, QuicklyByQuadrilaterals) {
    Scene scene;
    const auto quadrilaterals = [&](float x, float size) {  // apart by more than their size; turned against the axes
        for (int i = 0; i < 5000; ++i) {
            const float y = 3.0f * size * static_cast<float>(i), t = 0.1f * static_cast<float>(i);
            const float u[3]{size * std::cos(t), size * std::sin(t), 0}, v[3]{0, 0, size};
            shapes::add_triangle(scene, {x, y, 0}, {x + u[0], y + u[1], 0}, {x + u[0], y + u[1], v[2]});
            shapes::add_triangle(scene, {x, y, 0}, {x + u[0], y + u[1], v[2]}, {x, y, v[2]});
        }
    };
    quadrilaterals(0, 1);
    for (int i = 0; i < 5000; ++i) {  // one here, the next one there
        const float x = i % 2 == 0 ? -50.0f : 50.0f, y = 3.0f * static_cast<float>(i);
        shapes::add_triangle(scene, {x, y, 0}, {x + 1, y, 0}, {x, y, 1});
    }
    quadrilaterals(10, 0.5f);
    shapes::add_sphere(scene, {0, 0, 5}, 1);
    build_accel(scene, 0, {}, AccelLayouts::both, AccelQuality::quick);
    expect_valid(scene);
    std::vector<std::uint32_t> leaf(scene.triangles.size(), 0);
    for (const shared::Bvh2Node& n : scene.accel.bvh2_nodes)
        for (const std::uint32_t child : {n.child0, n.child1}) {
            if (child == IR_EMPTY || !(child & IR_LEAF) || (child & IR_LEAF_ANALYTIC)) continue;
            for (std::uint32_t i = 0; i < IR_LEAF_COUNT(child); ++i)
                leaf.at(scene.accel.bvh2_triangles.at(IR_LEAF_FIRST(child) + i).primitive) = IR_LEAF_FIRST(child) + 1;
        }
    for (std::uint32_t i = 0; i < leaf.size(); i += 2) {
        const bool halves = i < 10000 || i >= 15000;
        ASSERT_EQ(leaf[i] == leaf[i + 1], halves) << i;
    }
    std::vector<Ray> rays;  // each at the middle of a triangle, upright as all are, from near by
    for (const shared::Triangle& t : scene.triangles) {
        const shared::Vertex &a = scene.vertices[t.v0], &b = scene.vertices[t.v1], &c = scene.vertices[t.v2];
        const float nx = b.py - a.py, ny = a.px - b.px, scale = 1 / std::hypot(nx, ny);
        const float dx = nx * scale, dy = ny * scale;
        rays.push_back({(a.px + b.px + c.px) / 3 - 0.2f * dx, (a.py + b.py + c.py) / 3 - 0.2f * dy,
                        (a.pz + b.pz + c.pz) / 3, 0, dx, dy, 0, 1e30f});
    }
    for (const bool cpu : {true, false}) {
        const std::vector<DeviceHit> hits = trace(scene, cpu, rays);
        for (std::uint32_t i = 0; i < hits.size(); ++i) ASSERT_EQ(hits[i].primitive, i) << "traversal " << cpu;
    }
}

// Triangles of all leaves, and how many leaves there are.
std::pair<std::size_t, std::size_t> in_blocks(const Scene& scene) {
    std::size_t triangles = 0;
    for (const shared::TriangleBlock& b : scene.accel.bvh8_triangles)
        for (const std::uint32_t p : b.primitive) triangles += p != IR_NO_PRIMITIVE;
    return {triangles, scene.accel.bvh8_triangles.size()};
}

// Eight-wide nodes alone, built quickly: the builder takes leaves of up to eight triangles for one, as traversals do.
// So they are fuller than those that are collapsed of a tree which is traversed itself.
TEST(BuildAccel, QuicklyInBlocks) {
    Scene room = shapes::mesh_room(100000), soup = shapes::triangle_soup(20000, 0.2f, 3);
    for (int i = 0; i < 50; ++i) shapes::add_sphere(soup, {0.1f * static_cast<float>(i), 0, 0}, 0.3f);
    for (Scene* scene : {&room, &soup}) {
        build_accel(*scene, 0, {}, AccelLayouts::both, AccelQuality::quick);
        const auto [all, collapsed] = in_blocks(*scene);
        build_accel(*scene, 0, {}, AccelLayouts::bvh8, AccelQuality::quick);
        expect_valid_bvh8(*scene);
        const auto [triangles, blocks] = in_blocks(*scene);
        EXPECT_EQ(triangles, scene->triangles.size());  // each in one leaf
        EXPECT_EQ(all, triangles);
        EXPECT_LT(blocks, collapsed);
        EXPECT_LT(blocks, triangles / 4);  // more than half full
    }
}

TEST(BuildAccel, QualityFollowsTheWork) {
    const Scene small = shapes::mesh_room(10000), large = shapes::mesh_room(100000);
    EXPECT_EQ(accel_quality_for(small, 1000, AccelLayouts::bvh8), AccelQuality::best);
    EXPECT_EQ(accel_quality_for(large, 1000000, AccelLayouts::bvh8), AccelQuality::quick);
    EXPECT_EQ(accel_quality_for(large, 100000000, AccelLayouts::bvh8), AccelQuality::best);
    EXPECT_EQ(accel_quality_for(large, 100000000, AccelLayouts::bvh2), AccelQuality::quick);
    EXPECT_EQ(accel_quality_for(large, 1000, AccelLayouts::both), AccelQuality::best);
}

TEST(BuildAccel, DoesNotDependOnThreads) {
    const tbb::global_control more(tbb::global_control::max_allowed_parallelism, 8);  // also on machines of few cores
    const std::pair<AccelLayouts, AccelQuality> kinds[] = {{AccelLayouts::both, AccelQuality::best},
                                                           {AccelLayouts::bvh2, AccelQuality::quick},
                                                           {AccelLayouts::bvh8, AccelQuality::quick}};
    for (const Scene& scene : {shapes::mesh_room(100000), shapes::triangle_soup(30000, 0.2f, 3)})
        for (const auto& [layouts, quality] : kinds) {
            Scene one = scene;
            build_accel(one, 1, {}, layouts, quality);
            for (const int threads : {2, 3, 8, 8, 0}) {
                Scene many = scene;
                build_accel(many, threads, {}, layouts, quality);
                EXPECT_TRUE(same_bytes(one.accel.bvh8_nodes, many.accel.bvh8_nodes)) << threads << " threads";
                EXPECT_TRUE(same_bytes(one.accel.bvh8_triangles, many.accel.bvh8_triangles)) << threads << " threads";
                EXPECT_TRUE(same_bytes(one.accel.bvh2_nodes, many.accel.bvh2_nodes)) << threads << " threads";
                EXPECT_TRUE(same_bytes(one.accel.bvh2_triangles, many.accel.bvh2_triangles)) << threads << " threads";
            }
        }
}

TEST(BuildAccel, EmptyScene) {
    Scene scene;
    build_accel(scene);
    for (const bool cpu : {true, false}) {
        testing::Traversal device(scene, cpu);
        const std::vector<Ray> rays{{0, 0, 0, 0, 1, 0, 0, 1e30f}};
        EXPECT_EQ(device.closest(rays)[0].primitive, IR_NO_PRIMITIVE);
        EXPECT_EQ(device.tiles(rays, 16)[0].primitive, IR_NO_PRIMITIVE);
        EXPECT_EQ(device.occluded(rays)[0], 0u);
    }
}

TEST(BuildAccel, OnePrimitive) {
    Scene triangle, sphere;
    shapes::add_triangle(triangle, {-1, -1, 1}, {1, -1, 1}, {0, 1, 1});
    shapes::add_sphere(sphere, {0, 0, 2}, 1);
    for (Scene* scene : {&triangle, &sphere}) {
        build_accel(*scene);
        expect_valid(*scene);
        for (const bool cpu : {true, false}) {
            const std::vector<DeviceHit> hits =
                trace(*scene, cpu, {{0, 0, 0, 0, 0, 0, 1, 1e30f}, {0, 0, 0, 0, 0, 0, -1, 1e30f}});
            EXPECT_FLOAT_EQ(hits[0].t, 1);
            EXPECT_EQ(hits[0].primitive, 0u);
            EXPECT_EQ(hits[1].primitive, IR_NO_PRIMITIVE);
        }
    }
}

TEST(BuildAccel, ThousandsOfCoincidentTriangles) {
    Scene scene;
    for (int i = 0; i < 20000; ++i) shapes::add_triangle(scene, {-1, -1, 1}, {1, -1, 1}, {0, 1, 1});
    build_accel(scene);
    expect_valid(scene);
    for (const bool cpu : {true, false}) EXPECT_FLOAT_EQ(trace(scene, cpu, {{0, 0, 0, 0, 0, 0, 1, 1e30f}})[0].t, 1);
}

TEST(BuildAccel, DegenerateTrianglesAreNeverHit) {
    Scene scene;
    for (int i = 0; i < 100; ++i) {
        const auto x = static_cast<float>(i % 10), y = static_cast<float>(i / 10);
        shapes::add_triangle(scene, {x, y, 1}, {x, y, 1}, {x, y, 1});             // a point
        shapes::add_triangle(scene, {x, y, 2}, {x + 1, y, 2}, {x + 0.5f, y, 2});  // a line
    }
    shapes::add_quad(scene, {-1, -1, 3}, {20, 0, 0}, {0, 20, 0});
    build_accel(scene);
    expect_valid(scene);
    std::vector<Ray> rays;
    for (int i = 0; i < 100; ++i)
        rays.push_back({static_cast<float>(i % 10), static_cast<float>(i / 10), 0, 0, 0, 0, 1, 1e30f});
    for (const bool cpu : {true, false})
        for (const DeviceHit& h : trace(scene, cpu, rays)) EXPECT_FLOAT_EQ(h.t, 3);
}

// Each triangle half the size of the one before, all at one corner: as deep as a surface area tree gets.
TEST(BuildAccel, DepthStaysWithinTheStacks) {
    Scene scene;
    for (int i = 0; i < 3000; ++i) {
        const float s = std::ldexp(1.0f, -(i % 100)) * (1 + 1e-3f * static_cast<float>(i / 100));
        shapes::add_triangle(scene, {s, 0, 0}, {2 * s, 0, 0}, {s, s, s});
    }
    build_accel(scene);
    expect_valid(scene);
    const std::vector<Ray> rays{{1.25f, 0.1f, -1, 0, 0, 0, 1, 1e30f}};
    const testing::ExactHit exact = testing::brute_force(scene, rays[0]);
    for (const bool cpu : {true, false}) EXPECT_NEAR(trace(scene, cpu, rays)[0].t, exact.t, 1e-6);
}

// The ways out for deep trees give the same hits as the best tree.
TEST(BuildAccel, MedianTreeAndLevelCollapseTraceTheSame) {
    Scene scene = shapes::mesh_room(3000), best = scene;
    build_accel(best);
    const accel::HostTree tree = accel::build_median_tree(scene);
    EXPECT_LE(tree.depth, 12u);  // 2^12 leaves for 3000 triangles, at most
    accel::flatten_bvh8(scene, tree, 1e-6f, scene.accel);
    accel::flatten_bvh2(scene, tree, 1e-6f, scene.accel);
    expect_valid(scene);

    const accel::Collapse level = accel::Collapse::by_level(scene, tree);
    std::vector<std::pair<std::uint32_t, std::uint32_t>> todo{{0, 1}};
    std::uint32_t depth = 0, leaves = 0;
    while (!todo.empty()) {
        const auto [node, d] = todo.back();
        todo.pop_back();
        depth = std::max(depth, d);
        const accel::Children children = level.children(node);
        ASSERT_LE(children.count, 8u);
        for (std::uint32_t i = 0; i < children.count; ++i) {
            const std::uint32_t c = children.nodes[i];
            if (level.leaf(c))
                leaves += accel::gather(scene, tree, c).count;
            else
                todo.push_back({c, d + 1});
        }
    }
    EXPECT_LE(depth, (tree.depth + 2) / 3);
    EXPECT_EQ(leaves, scene.triangles.size());

    std::vector<Ray> rays;
    std::mt19937 random(5);
    std::uniform_real_distribution<float> s(-1, 1);
    for (int i = 0; i < 2000; ++i)
        rays.push_back({s(random), s(random), s(random), 0, s(random), s(random), s(random), 1e30f});
    for (const bool cpu : {true, false}) {
        const std::vector<DeviceHit> a = trace(best, cpu, rays), b = trace(scene, cpu, rays);
        for (std::size_t i = 0; i < rays.size(); ++i) ASSERT_EQ(a[i].t, b[i].t) << "ray " << i;
    }
}

TEST(BuildAccel, TooManyPrimitives) {
    EXPECT_NO_THROW(accel::check_primitive_count(std::size_t{1} << 24, "a.xml"));
    try {
        accel::check_primitive_count((std::size_t{1} << 24) + 1, "a.xml");
        FAIL() << "no error";
    } catch (const Error& e) {
        EXPECT_EQ(std::string(e.what()),
                  "a.xml: 16777217 triangles, spheres, disks and cylinders; the acceleration structure holds at most "
                  "16777216");
    }
}

}  // namespace
}  // namespace irradia
