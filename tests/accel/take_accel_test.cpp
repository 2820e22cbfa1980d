// A hierarchy that is taken over is the one that would have been built; where it would not, it stays.
#include <gtest/gtest.h>

#include <cstring>

#include "irradia/Accel.h"
#include "shapes.h"

namespace irradia {
namespace {

template <class T>
bool same_bytes(const std::vector<T>& a, const std::vector<T>& b) {
    return a.size() == b.size() && (a.empty() || std::memcmp(a.data(), b.data(), a.size() * sizeof(T)) == 0);
}

void expect_same(const Accel& a, const Accel& b) {
    EXPECT_TRUE(same_bytes(a.bvh8_nodes, b.bvh8_nodes));
    EXPECT_TRUE(same_bytes(a.bvh8_triangles, b.bvh8_triangles));
    EXPECT_TRUE(same_bytes(a.bvh2_nodes, b.bvh2_nodes));
    EXPECT_TRUE(same_bytes(a.bvh2_triangles, b.bvh2_triangles));
}

Scene some_scene() {
    Scene scene;
    for (int i = 0; i < 200; ++i) {
        const auto t = static_cast<float>(i);
        shapes::add_box(scene, {std::sin(1.3f * t) * 9, std::cos(2.1f * t) * 7, 0.1f * t}, {0.4f, 0.3f, 0.2f},
                        0.1f * t);
    }
    shared::Analytic sphere{};
    sphere.kind = IR_ANALYTIC_SPHERE;
    sphere.px = 3, sphere.radius = 0.5f, sphere.ux = sphere.vz = 1, sphere.sign = 1;
    sphere.light = IR_NO_LIGHT;
    scene.analytics.push_back(sphere);
    scene.info.analytic_count = 1;
    return scene;
}

TEST(TakeAccel, IsWhatBuildingYields) {
    Scene first = some_scene(), second = some_scene(), built = some_scene();
    // What the builder doesn't look at.
    second.triangles[5].material = 3;
    second.triangles[7].light = 2;
    second.vertices[9].nz = 1;
    second.vertices[9].u = 0.5f;
    second.analytics[0].material = 1;
    second.analytics[0].sign = -1;
    build_accel(first);
    build_accel(built);
    ASSERT_TRUE(take_accel(second, first));
    expect_same(second.accel, built.accel);
    EXPECT_TRUE(first.accel.bvh8_nodes.empty() && first.accel.bvh8_triangles.empty() &&
                first.accel.bvh2_nodes.empty() && first.accel.bvh2_triangles.empty());
    EXPECT_FALSE(take_accel(first, built, AccelLayouts::both) && take_accel(second, built));  // one of them only
}

TEST(TakeAccel, OnlyTheLayoutAskedFor) {
    for (const AccelLayouts layouts : {AccelLayouts::bvh8, AccelLayouts::bvh2}) {
        Scene from = some_scene(), to = some_scene(), built = some_scene();
        build_accel(from);
        build_accel(built, 0, {}, layouts);
        ASSERT_TRUE(take_accel(to, from, layouts));
        expect_same(to.accel, built.accel);
        Scene next = some_scene();
        EXPECT_FALSE(take_accel(next, to, AccelLayouts::both));
        expect_same(to.accel, built.accel);
        EXPECT_TRUE(take_accel(next, to, layouts));
    }
}

TEST(TakeAccel, OnlyTheQualityAskedFor) {
    Scene from = some_scene(), to = some_scene(), built = some_scene();
    build_accel(from, 0, {}, AccelLayouts::both, AccelQuality::quick);
    build_accel(built, 0, {}, AccelLayouts::both, AccelQuality::quick);
    EXPECT_FALSE(take_accel(to, from));
    expect_same(from.accel, built.accel);
    ASSERT_TRUE(take_accel(to, from, AccelLayouts::both, AccelQuality::quick));
    expect_same(to.accel, built.accel);
    EXPECT_EQ(to.accel.quality, AccelQuality::quick);
}

/// `change` makes the hierarchy another one, and nothing is moved then.
template <class F>
void expect_not_taken(const F& change) {
    Scene from = some_scene(), to = some_scene(), built = some_scene();
    build_accel(from);
    build_accel(built);
    change(to);
    EXPECT_FALSE(take_accel(to, from));
    EXPECT_TRUE(to.accel.bvh8_nodes.empty() && to.accel.bvh2_nodes.empty());
    expect_same(from.accel, built.accel);
}

TEST(TakeAccel, NotOfOtherGeometry) {
    expect_not_taken([](Scene& s) { s.vertices.back().pz = std::nextafter(s.vertices.back().pz, 1e9f); });
    expect_not_taken([](Scene& s) { s.vertices.front().px += 1; });
    expect_not_taken([](Scene& s) { std::swap(s.triangles[0].v1, s.triangles[0].v2); });
    expect_not_taken([](Scene& s) { std::swap(s.triangles[0], s.triangles[20]); });
    expect_not_taken([](Scene& s) { s.triangles.pop_back(); });
    expect_not_taken([](Scene& s) { shapes::add_vertex(s, {0, 0, 0}); });
    expect_not_taken([](Scene& s) { s.analytics[0].radius *= 2; });
    expect_not_taken([](Scene& s) { s.analytics[0].kind = IR_ANALYTIC_DISK; });
    expect_not_taken([](Scene& s) { s.analytics.clear(); });
}

}  // namespace
}  // namespace irradia
