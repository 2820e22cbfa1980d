// Both traversal headers (the GPU one runs on CPU devices too) against Embree and brute force.
#include <gtest/gtest.h>

#include "irradia/Accel.h"
#include "reference.h"
#include "shapes.h"
#include "traversal.h"

namespace irradia {
namespace {

using testing::DeviceHit;
using testing::Ray;

constexpr float kFar = 1e30f;

class TraversalTest : public ::testing::TestWithParam<bool> {
protected:
    static bool cpu() { return GetParam(); }
};

std::vector<Ray> random_rays(std::size_t count, float extent, float t_min, float t_max, std::uint32_t seed) {
    std::mt19937 random(seed);
    std::uniform_real_distribution<float> s(-extent, extent);
    std::normal_distribution<float> g;
    std::vector<Ray> rays;
    while (rays.size() < count) {
        Ray r{s(random), s(random), s(random), t_min, g(random), g(random), g(random), t_max};
        const float l = std::hypot(r.dx, r.dy, r.dz);
        r.dx /= l, r.dy /= l, r.dz /= l;
        rays.push_back(r);
    }
    return rays;
}

// Tiles of 16 rays from one origin each.
std::vector<Ray> tiled(std::vector<Ray> rays) {
    for (std::size_t i = 0; i < rays.size(); ++i) {
        const Ray& first = rays[i / 16 * 16];
        rays[i].ox = first.ox, rays[i].oy = first.oy, rays[i].oz = first.oz;
    }
    return rays;
}

// Rays on which float32 and double may rightly disagree (an edge or an end of the interval is nearer than this) are
// few, and are left out where a test looks at hit or miss. 1e-5 is some hundred float32 roundings at extent 1.
constexpr double kGrazing = 1e-5;

void expect_same(const Scene& scene, const std::vector<Ray>& rays, const std::vector<DeviceHit>& hits) {
    std::size_t compared = 0, hit = 0;
    for (std::size_t i = 0; i < rays.size(); ++i) {
        const testing::ExactHit exact = testing::brute_force(scene, rays[i]);
        if (exact.margin < kGrazing) continue;
        ++compared;
        ASSERT_EQ(hits[i].primitive == IR_NO_PRIMITIVE, exact.primitive == IR_NO_PRIMITIVE) << "ray " << i;
        if (exact.primitive == IR_NO_PRIMITIVE) {
            ASSERT_EQ(hits[i].t, kFar);
            continue;
        }
        ++hit;
        ASSERT_NEAR(hits[i].t, exact.t, 4e-6 * (1 + exact.t)) << "ray " << i;
    }
    EXPECT_GT(compared, rays.size() * 9 / 10);
    EXPECT_GT(hit, rays.size() / 10);
}

TEST_P(TraversalTest, SoupClosestMatchesBruteForce) {
    for (const auto& [count, size] : {std::pair{40u, 1.0f}, {2000u, 0.3f}}) {
        Scene scene = shapes::triangle_soup(count, size, count);
        build_accel(scene);
        testing::Traversal device(scene, cpu());
        const std::vector<Ray> rays = tiled(random_rays(2048, 1.5f, 0, kFar, 3));
        expect_same(scene, rays, device.closest(rays));
        expect_same(scene, rays, device.tiles(rays, 16));
    }
}

TEST(Traversal, QuickBlocksMatchBruteForce) {
    Scene scene = shapes::triangle_soup(2000, 0.3f, 5);
    for (int i = 0; i < 20; ++i) shapes::add_sphere(scene, {0.1f * static_cast<float>(i) - 1, 0, 0.2f}, 0.05f);
    build_accel(scene, 0, {}, AccelLayouts::bvh8, AccelQuality::quick);
    testing::Traversal device(scene, true);
    const std::vector<Ray> rays = tiled(random_rays(2048, 1.5f, 0, kFar, 3));
    expect_same(scene, rays, device.closest(rays));
    expect_same(scene, rays, device.tiles(rays, 16));
}

TEST_P(TraversalTest, CornellBoxMatchesBruteForce) {
    Scene scene = shapes::cornell_box();
    build_accel(scene);
    testing::Traversal device(scene, cpu());
    const std::vector<Ray> rays = tiled(random_rays(4096, 0.99f, 0, kFar, 5));
    expect_same(scene, rays, device.closest(rays));
    expect_same(scene, rays, device.tiles(rays, 16));
}

TEST_P(TraversalTest, SpheresAndDisksMatchBruteForce) {
    Scene scene = shapes::triangle_soup(50, 0.5f, 9);
    std::mt19937 random(11);
    std::uniform_real_distribution<float> s(-1, 1);
    for (int i = 0; i < 20; ++i) {
        shapes::add_sphere(scene, {s(random), s(random), s(random)}, 0.01f + 0.2f * std::abs(s(random)));
        const shapes::Point u{0.3f * s(random), 0.3f * s(random), 0.3f * s(random)}, w{s(random), s(random), s(random)};
        const float k = 0.5f;  // v = k u x w is perpendicular to u
        shapes::add_disk(
            scene, {s(random), s(random), s(random)}, u,
            {k * (u[1] * w[2] - u[2] * w[1]), k * (u[2] * w[0] - u[0] * w[2]), k * (u[0] * w[1] - u[1] * w[0])});
    }
    build_accel(scene);
    testing::Traversal device(scene, cpu());
    const std::vector<Ray> rays = tiled(random_rays(4096, 1.2f, 0, kFar, 13));
    expect_same(scene, rays, device.closest(rays));
    expect_same(scene, rays, device.tiles(rays, 16));
}

// A small sphere seen from 1000 radii away, and a ray that starts inside: t from geometry.
TEST_P(TraversalTest, SphereIsHitFromFarAndFromInside) {
    Scene scene;
    shapes::add_sphere(scene, {0, 0, 0}, 0.01f);
    build_accel(scene);
    testing::Traversal device(scene, cpu());
    const std::vector<Ray> rays{{-10, 0, 0, 0, 1, 0, 0, kFar},        {0, 0, 0, 0, 0, 1, 0, kFar},
                                {-10, 0.00999f, 0, 0, 1, 0, 0, kFar}, {-10, 0.01001f, 0, 0, 1, 0, 0, kFar},
                                {-10, 0, 0, 9.995f, 1, 0, 0, kFar},   {-10, 0, 0, 0, 2, 0, 0, kFar}};
    const std::vector<DeviceHit> hits = device.closest(rays);
    EXPECT_NEAR(hits[0].t, 9.99f, 1e-6f);
    EXPECT_NEAR(hits[1].t, 0.01f, 1e-8f);
    EXPECT_NEAR(hits[2].t, 10 - std::sqrt(1e-4 - 0.00999 * 0.00999), 2e-6);
    EXPECT_EQ(hits[3].primitive, IR_NO_PRIMITIVE);
    EXPECT_NEAR(hits[4].t, 10.01f, 1e-6f);  // t_min lies within: the far side
    EXPECT_NEAR(hits[5].t, 4.995f, 1e-6f);  // t counts directions, not lengths
}

TEST_P(TraversalTest, CylindersMatchBruteForce) {
    Scene scene = shapes::triangle_soup(50, 0.3f, 61);
    std::mt19937 random(67);
    std::uniform_real_distribution<float> s(-1, 1);
    for (int i = 0; i < 40; ++i) {
        shapes::Point axis{s(random), s(random), s(random)};
        if (i % 4 == 0) axis = {0, i % 8 ? 1.0f : -1.0f, 0};  // boxes that fit snugly
        const float l = std::hypot(axis[0], axis[1], axis[2]);
        shapes::add_cylinder(scene, {s(random), s(random), s(random)}, {axis[0] / l, axis[1] / l, axis[2] / l},
                             0.01f + 0.15f * std::abs(s(random)), 0.05f + std::abs(s(random)));
    }
    build_accel(scene);
    testing::Traversal device(scene, cpu());
    const std::vector<Ray> rays = tiled(random_rays(8192, 1.2f, 0, kFar, 71));
    expect_same(scene, rays, device.closest(rays));
    expect_same(scene, rays, device.tiles(rays, 16));
}

// A tube of radius 1 from z = 0 to 3: from outside, from inside, through the open ends, along the axis, past the rims.
TEST_P(TraversalTest, CylindersAreOpenTubes) {
    Scene scene;
    shapes::add_cylinder(scene, {0, 0, 0}, {0, 0, 1}, 1, 3);
    build_accel(scene);
    testing::Traversal device(scene, cpu());
    const std::vector<Ray> rays{
        {-5, 0, 1, 0, 1, 0, 0, kFar},         // outside
        {0.5f, 0, 1, 0, 1, 0, 0, kFar},       // the inner side
        {-5, 0, 1, 4.5f, 1, 0, 0, kFar},      // t_min within: the far wall
        {0, 0, -2, 0, 0, 0, 1, kFar},         // along the axis, through both ends
        {0.5f, 0.25f, -2, 0, 0, 0, 1, kFar},  // beside the axis
        {0, 0, -1, 0, 0.6f, 0, 0.8f, kFar},   // in at the end, z = 1/3 at the wall
        {0, 0, -3, 0, 0.6f, 0, 0.8f, kFar},   // the wall only at z < 0
        {-5, 0, 3.001f, 0, 1, 0, 0, kFar},    // past the upper rim
        {-5, 0, 2.999f, 0, 1, 0, 0, kFar},    // below it
        {-2, 0, 5, 0, 0.6f, 0, -0.8f, kFar},  // over the rim: the wall met first is too high, the second is hit
        {-5, 1.001f, 1, 0, 1, 0, 0, kFar},    // beside
        {1000, 0, 1, 0, -2, 0, 0, kFar}};     // far, t counts directions
    const double miss = kFar;
    const std::vector<double> t{4, 0.5, 6, miss, miss, 1 / 0.6, miss, miss, 4, 3 / 0.6, miss, 999.0 / 2};
    for (const std::vector<DeviceHit>& hits : {device.closest(rays), device.tiles({rays[0]}, 1)})
        for (std::size_t i = 0; i < hits.size(); ++i) {
            if (t[i] == miss)
                EXPECT_EQ(hits[i].primitive, IR_NO_PRIMITIVE) << "ray " << i;
            else
                EXPECT_NEAR(hits[i].t, t[i], 1e-6 * (1 + t[i])) << "ray " << i;
        }
    const std::vector<std::uint32_t> occluded = device.occluded(rays);
    for (std::size_t i = 0; i < rays.size(); ++i) EXPECT_EQ(occluded[i], t[i] == miss ? 0u : 1u) << "ray " << i;
}

// Packets of every size from inside of a sphere and nothing else: each lane hits at the t of geometry, and is occluded
// from there on.
TEST_P(TraversalTest, PacketsInsideASphere) {
    Scene scene;
    constexpr float kRadius = 2;
    shapes::add_sphere(scene, {0, 0, 0}, kRadius);
    build_accel(scene);
    testing::Traversal device(scene, cpu());
    for (std::uint32_t size = 1; size <= 16; ++size) {
        std::vector<Ray> rays = tiled(random_rays(size, 1, 0, kFar, 53 + size));
        const std::vector<DeviceHit> hits = device.tiles(rays, size);
        std::vector<double> t;
        for (const Ray& r : rays) {
            const testing::Double3 o{r.ox, r.oy, r.oz}, d{r.dx, r.dy, r.dz};
            const double a = testing::dot(d, d), b = testing::dot(o, d), c = testing::dot(o, o) - kRadius * kRadius;
            t.push_back((std::sqrt(b * b - a * c) - b) / a);
        }
        for (std::size_t i = 0; i < size; ++i) {
            EXPECT_EQ(hits[i].primitive, 0u) << "ray " << i << " of " << size;
            EXPECT_NEAR(hits[i].t, t[i], 4e-6 * (1 + t[i])) << "ray " << i << " of " << size;
            rays[i].t_max = static_cast<float>(t[i] * (i % 3 == 0 ? 1.001 : 0.999));
        }
        const std::vector<std::uint32_t> occluded = device.occluded_tiles(rays, size);
        for (std::size_t i = 0; i < size; ++i)
            EXPECT_EQ(occluded[i], i % 3 == 0 ? 1u : 0u) << "ray " << i << " of " << size;
    }
}

// Occlusion over random intervals, against brute force.
TEST_P(TraversalTest, OcclusionRespectsTheInterval) {
    Scene scene = shapes::triangle_soup(500, 0.4f, 17);
    for (int i = 0; i < 10; ++i) shapes::add_sphere(scene, {0.2f * static_cast<float>(i) - 1, 0, 0.3f}, 0.1f);
    build_accel(scene);
    testing::Traversal device(scene, cpu());
    std::vector<Ray> rays = random_rays(4096, 1, 0, 0, 19);
    std::mt19937 random(23);
    std::uniform_real_distribution<float> length(0, 0.5f);
    for (Ray& r : rays) r.t_min = length(random), r.t_max = r.t_min + length(random);
    const std::vector<std::uint32_t> occluded = device.occluded(rays);
    const std::vector<DeviceHit> closest = device.closest(rays);
    std::size_t blocked = 0;
    for (std::size_t i = 0; i < rays.size(); ++i) {
        const testing::ExactHit exact = testing::brute_force(scene, rays[i]);
        if (exact.margin < kGrazing) continue;
        ASSERT_EQ(occluded[i] != 0, exact.primitive != IR_NO_PRIMITIVE) << "ray " << i;
        ASSERT_EQ(closest[i].primitive != IR_NO_PRIMITIVE, exact.primitive != IR_NO_PRIMITIVE) << "ray " << i;
        blocked += occluded[i];
    }
    EXPECT_GT(blocked, rays.size() / 10);
    EXPECT_LT(blocked, rays.size() * 9 / 10);
}

// Packets of shadow rays with origins and ends of their own give what single rays give, whatever their number.
TEST_P(TraversalTest, OcclusionOfTilesMatchesBruteForce) {
    Scene scene = shapes::triangle_soup(500, 0.4f, 41);
    for (int i = 0; i < 10; ++i) shapes::add_sphere(scene, {0.2f * static_cast<float>(i) - 1, 0, 0.3f}, 0.1f);
    build_accel(scene);
    testing::Traversal device(scene, cpu());
    for (const std::uint32_t size : {16u, 11u, 1u}) {
        std::vector<Ray> rays = random_rays(2048, 0.8f, 0.01f, 0, 43 + size);
        std::mt19937 random(47);
        std::uniform_real_distribution<float> s(-1, 1);
        for (std::size_t i = 0; i < rays.size(); ++i) {
            if (i % 128 < 64) {  // half the tiles: neighbouring points, one way
                const Ray& first = rays[i / size * size];
                rays[i].ox = first.ox + 0.05f * s(random), rays[i].oy = first.oy + 0.05f * s(random);
                rays[i].oz = first.oz, rays[i].dx = first.dx, rays[i].dy = first.dy, rays[i].dz = first.dz;
            }
            rays[i].t_max = 0.5f + 0.45f * s(random);
        }
        const std::vector<std::uint32_t> occluded = device.occluded_tiles(rays, size);
        std::size_t blocked = 0;
        for (std::size_t i = 0; i < rays.size(); ++i) {
            const testing::ExactHit exact = testing::brute_force(scene, rays[i]);
            if (exact.margin < kGrazing) continue;
            ASSERT_EQ(occluded[i] != 0, exact.primitive != IR_NO_PRIMITIVE) << "ray " << i << " of tiles of " << size;
            blocked += occluded[i];
        }
        EXPECT_GT(blocked, rays.size() / 10);
        EXPECT_LT(blocked, rays.size() * 9 / 10);
    }
}

// A hit at exactly t = 2 is outside of the open intervals (0, 2) and (2, far).
TEST_P(TraversalTest, IntervalIsOpen) {
    Scene scene;
    shapes::add_quad(scene, {-1, -1, 2}, {2, 0, 0}, {0, 2, 0});
    build_accel(scene);
    testing::Traversal device(scene, cpu());
    const float above = std::nextafter(2.0f, 3.0f), below = std::nextafter(2.0f, 1.0f);
    std::vector<Ray> rays;
    for (const auto& [lo, hi] : {std::pair{0.0f, 2.0f}, {2.0f, kFar}, {0.0f, above}, {below, kFar}})
        rays.push_back({0.25f, 0.125f, 0, lo, 0, 0, 1, hi});
    const std::vector<std::uint32_t> occluded = device.occluded(rays);
    const std::vector<DeviceHit> hits = device.closest(rays);
    for (std::size_t i = 0; i < rays.size(); ++i) {
        EXPECT_EQ(occluded[i], i < 2 ? 0u : 1u) << i;
        EXPECT_EQ(hits[i].t, i < 2 ? kFar : 2.0f) << i;
    }
    EXPECT_EQ(device.tiles({rays[1]}, 16)[0].primitive, IR_NO_PRIMITIVE);
}

// Packets of every size give what single rays give, and barycentrics that lead to the point hit.
TEST_P(TraversalTest, TileEqualsSingleRays) {
    Scene scene = shapes::mesh_room(5000);
    build_accel(scene);
    testing::Traversal device(scene, cpu());
    for (std::uint32_t size = 1; size <= 16; ++size) {
        std::vector<Ray> rays = random_rays(64 * size, 1, 1e-4f, kFar, 29 + size);
        for (std::size_t i = 0; i < rays.size(); ++i) {
            const Ray& first = rays[i / size * size];
            rays[i].ox = first.ox, rays[i].oy = first.oy, rays[i].oz = first.oz;
        }
        const std::vector<DeviceHit> single = device.closest(rays), tile = device.tiles(rays, size);
        for (std::size_t i = 0; i < rays.size(); ++i) {
            ASSERT_NEAR(single[i].t, tile[i].t, 4e-6f * (1 + single[i].t)) << "ray " << i << " of tiles of " << size;
            for (const DeviceHit& h : {single[i], tile[i]}) {
                const shared::Triangle& t = scene.triangles.at(h.primitive);
                const shared::Vertex &a = scene.vertices[t.v0], &b = scene.vertices[t.v1], &c = scene.vertices[t.v2];
                const float w = 1 - h.u - h.v;
                // Rounding of a barycentric is that of the point (1e-6) over the triangle's size: compare points.
                ASSERT_NEAR(w * a.px + h.u * b.px + h.v * c.px, rays[i].ox + h.t * rays[i].dx, 2e-5f);
                ASSERT_NEAR(w * a.py + h.u * b.py + h.v * c.py, rays[i].oy + h.t * rays[i].dy, 2e-5f);
                ASSERT_NEAR(w * a.pz + h.u * b.pz + h.v * c.pz, rays[i].oz + h.t * rays[i].dz, 2e-5f);
            }
        }
    }
}

// A mesh in a closed room against Embree: every ray hits, at the same t.
TEST_P(TraversalTest, MeshMatchesEmbree) {
    Scene scene = shapes::mesh_room(30000);
    build_accel(scene);
    testing::Traversal device(scene, cpu());
    const testing::EmbreeScene embree(scene);
    const std::vector<Ray> rays = tiled(random_rays(1 << 15, 1.2f, 0, kFar, 31));
    for (const std::vector<DeviceHit>& hits : {device.closest(rays), device.tiles(rays, 16)}) {
        std::size_t different = 0;
        for (std::size_t i = 0; i < rays.size(); ++i) {
            ASSERT_NE(hits[i].primitive, IR_NO_PRIMITIVE) << "ray " << i;
            if (std::abs(hits[i].t - embree.closest(rays[i]).t) > 1e-5f * (1 + hits[i].t)) ++different;
        }
        // Rays that graze a silhouette within rounding may fall either side of it.
        EXPECT_LE(different, rays.size() / 10000);
    }
    std::vector<Ray> shadows = rays;
    for (Ray& r : shadows) r.t_max = 1;
    const std::vector<std::uint32_t> occluded = device.occluded(shadows);
    std::size_t different = 0;
    for (std::size_t i = 0; i < shadows.size(); ++i) different += (occluded[i] != 0) != embree.occluded(shadows[i]);
    EXPECT_LE(different, rays.size() / 10000);
}

// Rays from inside of closed meshes at vertices and at points of edges: none may leak out.
TEST_P(TraversalTest, NoLeaksAtEdgesAndVertices) {
    Scene scene;
    shapes::add_bumpy_sphere(scene, {0.1f, -0.2f, 0.3f}, 1, 160, 80, 0.05f);
    // Close the rings at the poles.
    for (const std::uint32_t ring : {0u, 160u * 80u})
        for (std::uint32_t i = 1; i + 1 < 160; ++i) shapes::add_triangle(scene, ring, ring + i, ring + i + 1);
    build_accel(scene);
    testing::Traversal device(scene, cpu());
    std::mt19937 random(37);
    std::uniform_real_distribution<float> unit(0, 1);
    std::vector<Ray> rays;
    for (std::size_t tile = 0; tile < 8192; ++tile) {
        const shapes::Point o{0.1f + 0.4f * (unit(random) - 0.5f), -0.2f + 0.4f * (unit(random) - 0.5f),
                              0.3f + 0.4f * (unit(random) - 0.5f)};
        const auto first = static_cast<std::size_t>(unit(random) * static_cast<float>(scene.triangles.size() - 16));
        for (std::size_t i = 0; i < 16; ++i) {
            const shared::Triangle& t = scene.triangles[first + i];
            const shared::Vertex &a = scene.vertices[t.v0], &b = scene.vertices[i % 2 ? t.v1 : t.v2];
            const float s = i % 4 < 2 ? unit(random) : 0;  // half of them at edges, half at vertices
            rays.push_back({o[0], o[1], o[2], 0, a.px + s * (b.px - a.px) - o[0], a.py + s * (b.py - a.py) - o[1],
                            a.pz + s * (b.pz - a.pz) - o[2], kFar});
        }
    }
    const testing::EmbreeScene robust(scene), fast(scene, false);
    const std::vector<std::uint32_t> single_shadows = device.occluded(rays),
                                     tile_shadows = device.occluded_tiles(rays, 16);
    std::size_t shadows = 0, single = 0, tiles = 0, embree_robust = 0, embree_fast = 0;
    const std::vector<DeviceHit> s = device.closest(rays), t = device.tiles(rays, 16);
    for (std::size_t i = 0; i < rays.size(); ++i) {
        shadows += !single_shadows[i] + !tile_shadows[i];
        single += s[i].primitive == IR_NO_PRIMITIVE;
        tiles += t[i].primitive == IR_NO_PRIMITIVE;
        embree_robust += robust.closest(rays[i]).primitive == IR_NO_PRIMITIVE;
        embree_fast += fast.closest(rays[i]).primitive == IR_NO_PRIMITIVE;
    }
    EXPECT_EQ(single, 0u);
    EXPECT_EQ(tiles, 0u);
    EXPECT_EQ(shadows, 0u);
    RecordProperty("embree_robust_leaks", static_cast<int>(embree_robust));
    RecordProperty("embree_fast_leaks", static_cast<int>(embree_fast));
}

// Directions with zero components (also -0) from origins in the planes of boxes: no NaN, the wall behind is hit.
TEST_P(TraversalTest, AxisParallelRaysInBoxPlanes) {
    Scene scene;
    for (int i = 0; i < 16; ++i)  // plates in the rays' own planes, which they cannot hit
        for (int j = 0; j < 16; ++j)
            shapes::add_quad(scene, {static_cast<float>(i), 0, static_cast<float>(j)}, {0.5f, 0, 0}, {0, 0, 0.5f});
    for (int i = 0; i < 20; ++i)  // walls at x = 20 and x = -4, their edges away from y = 0
        for (const float x : {20.0f, -4.0f})
            shapes::add_quad(scene, {x, -0.5f, static_cast<float>(i) - 0.25f}, {0, 1, 0}, {0, 0, 1});
    build_accel(scene);
    testing::Traversal device(scene, cpu());
    std::vector<Ray> rays;
    for (int j = 0; j < 16; ++j)
        for (const float zero : {0.0f, -0.0f})
            for (const float sign : {1.0f, -1.0f})
                for (const float offset : {0.0f, 0.5f})  // along the plates' edges
                    rays.push_back(
                        {sign > 0 ? -1.0f : 17.0f, 0, static_cast<float>(j) + offset, 0, sign, zero, zero, kFar});
    const std::vector<DeviceHit> hits = device.closest(rays);
    const std::vector<std::uint32_t> occluded = device.occluded(rays);
    for (std::size_t i = 0; i < rays.size(); ++i) {
        EXPECT_EQ(hits[i].t, 21.0f) << "ray " << i;
        EXPECT_EQ(occluded[i], 1u) << "ray " << i;
        EXPECT_EQ(device.tiles({rays[i]}, 16)[0].t, 21.0f) << "ray " << i;
    }
}

// All six axis directions and the diagonals of each plane in one packet, from the centre of a cube of half edge 1.
TEST_P(TraversalTest, PacketOfAxisParallelRays) {
    Scene scene;
    shapes::add_box(scene, {0, 0, 0}, {1, 1, 1});
    build_accel(scene);
    testing::Traversal device(scene, cpu());
    std::vector<Ray> rays;
    for (int k = 0; k < 3; ++k)
        for (const float sign : {1.0f, -1.0f}) {
            float d[3] = {0, 0, 0};
            d[k] = sign;
            rays.push_back({0, 0, 0, 0, d[0], d[1], d[2], kFar});
            d[(k + 1) % 3] = -0.5f;
            rays.push_back({0, 0, 0, 0, d[0], d[1], d[2], kFar});
        }
    for (const std::vector<DeviceHit>& hits : {device.closest(rays), device.tiles(rays, 12)})
        for (std::size_t i = 0; i < rays.size(); ++i) EXPECT_EQ(hits[i].t, 1.0f) << "ray " << i;
}

INSTANTIATE_TEST_SUITE_P(Headers, TraversalTest, ::testing::Bool(),
                         [](const auto& parameter) { return parameter.param ? "cpu" : "gpu"; });

}  // namespace
}  // namespace irradia
