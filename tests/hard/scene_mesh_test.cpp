// Meshes that are hard on traversals: rays at shared edges and vertices, needles, triangles without area, surfaces in
// one place. Both traversal headers, single rays and packets, against Embree's robust mode and double precision.
#include <random>

#include "../accel/reference.h"
#include "scene_double.h"
#include "scene_fixture.h"

namespace irradia::test {
namespace {

using irradia::testing::DeviceHit;
using irradia::testing::EmbreeScene;
using irradia::testing::Ray;
using irradia::testing::Traversal;

constexpr float kFar = 1e30f;

class Mesh : public ::testing::TestWithParam<bool> {
protected:
    static bool cpu() { return GetParam(); }
    static std::string name() { return cpu() ? "8-wide and packets" : "binary"; }
};

// Rays that miss a closed mesh around their origins.
struct Leaks {
    std::size_t single = 0, tiles = 0, shadows = 0, embree = 0, embree_fast = 0, rays = 0;
};
Leaks leaks(const Scene& scene, const std::vector<Ray>& rays, bool cpu) {
    Traversal traversal(scene, cpu);
    const EmbreeScene robust(scene), fast(scene, false);
    const std::vector<DeviceHit> single = traversal.closest(rays), tiles = traversal.tiles(rays, 16);
    const std::vector<std::uint32_t> shadow = traversal.occluded(rays),
                                     tile_shadow = traversal.occluded_tiles(rays, 16);
    Leaks l;
    l.rays = rays.size();
    for (std::size_t i = 0; i < rays.size(); ++i) {
        l.single += single[i].primitive == IR_NO_PRIMITIVE;
        l.tiles += tiles[i].primitive == IR_NO_PRIMITIVE;
        l.shadows += static_cast<std::size_t>(shadow[i] == 0) + static_cast<std::size_t>(tile_shadow[i] == 0);
        l.embree += robust.closest(rays[i]).primitive == IR_NO_PRIMITIVE;
        l.embree_fast += fast.closest(rays[i]).primitive == IR_NO_PRIMITIVE;
    }
    return l;
}

// A closed sphere of 6400 triangles, those at its poles needles of 1 : 400, rays from within at its vertices and edges.
TEST_P(Mesh, NoLeaksAtAnyScale) {
    constexpr std::uint32_t around = 80, along = 40;
    Leaks all;
    std::mt19937 random(5);
    std::uniform_real_distribution<double> unit(0, 1);
    for (const double scale : {1e-4, 1.0, 1e6})
        for (const double away : {0.0, 100.0}) {
            Scene scene;
            shapes::add_bumpy_sphere(scene, {0, 0, 0}, 1, around, along, 0.05f);
            for (const std::uint32_t ring : {0u, around * along})
                for (std::uint32_t i = 1; i + 1 < around; ++i)
                    shapes::add_triangle(scene, ring, ring + i, ring + i + 1);
            place_scene(scene, scale, away * scale);
            build_accel(scene);
            std::vector<Ray> rays;
            for (std::size_t tile = 0; tile < 1024; ++tile) {
                float o[3];
                for (float& x : o) x = static_cast<float>(scale * (away + 0.4 * (unit(random) - 0.5)));
                const auto first =
                    static_cast<std::size_t>(unit(random) * static_cast<double>(scene.triangles.size() - 16));
                for (std::size_t i = 0; i < 16; ++i) {
                    const shared::Triangle& t = scene.triangles[first + i];
                    const shared::Vertex &a = scene.vertices[t.v0], &b = scene.vertices[i % 2 ? t.v1 : t.v2];
                    const float s =
                        i % 4 < 2 ? static_cast<float>(unit(random)) : 0;  // half at edges, half at vertices
                    rays.push_back({o[0], o[1], o[2], 0, a.px + s * (b.px - a.px) - o[0],
                                    a.py + s * (b.py - a.py) - o[1], a.pz + s * (b.pz - a.pz) - o[2], kFar});
                }
            }
            const Leaks l = leaks(scene, rays, cpu());
            EXPECT_EQ(l.single, 0u) << "scale " << scale << " away " << away;
            EXPECT_EQ(l.tiles, 0u) << "scale " << scale << " away " << away;
            EXPECT_EQ(l.shadows, 0u) << "scale " << scale << " away " << away;
            all.single += l.single, all.tiles += l.tiles, all.shadows += l.shadows, all.rays += l.rays;
            all.embree += l.embree, all.embree_fast += l.embree_fast;
        }
    hard_case("edges and vertices of a closed mesh, scale 1e-4 to 1e6, at 0 and 100 sizes from the origin, " + name() +
                  " (" + std::to_string(all.rays) + " rays)",
              "closed mesh: none (Embree, robust: " + std::to_string(all.embree) + ")", "rays that leak out",
              static_cast<double>(all.single + all.tiles + all.shadows), 0,
              "Embree without robust: " + std::to_string(all.embree_fast));
}

// A unit square of strips, of which every second is a needle 2e-6 wide and 2 long, and triangles without area along
// their edges, turned to some plane: rays at it from 1 above.
TEST_P(Mesh, NeedlesAndTrianglesWithoutArea) {
    constexpr int strips = 64;
    Scene scene;
    const real3 u = normalize(real3{1, 0.3, -0.2}), n = normalize(cross(u, real3{0.1, 1, 0.4})), v = cross(n, u);
    const auto at = [&](double x, double y) {
        const real3 p = x * u + y * v;
        return shapes::add_vertex(scene, {static_cast<float>(p.x), static_cast<float>(p.y), static_cast<float>(p.z)});
    };
    std::vector<double> xs{-1};
    for (int i = 1; i <= strips; ++i) {
        xs.push_back(-1 + 2.0 * i / strips - 2e-6);
        xs.push_back(-1 + 2.0 * i / strips);
    }
    std::size_t flat = 0;
    std::vector<bool> wide;  // by triangle: a strip between needles
    for (std::size_t i = 0; i < xs.size(); ++i) {
        const std::uint32_t low = at(xs[i], -1), high = at(xs[i], 1);
        const std::uint32_t middle = at(xs[i], 0.1);
        shapes::add_triangle(scene, low, middle, high);  // in line, up to rounding
        shapes::add_triangle(scene, low, low, high);     // two corners in one place
        shapes::add_triangle(scene, middle, middle, middle);
        flat += 3;
        wide.insert(wide.end(), 3, false);
        if (i == 0) continue;
        shapes::add_triangle(scene, low - 3, low, high);
        shapes::add_triangle(scene, low - 3, high, high - 3);
        wide.insert(wide.end(), 2, i % 2 == 1);
    }
    place_scene(scene, 1, 0);
    build_accel(scene);
    Traversal traversal(scene, cpu());
    std::mt19937 random(7);
    std::uniform_real_distribution<double> unit(-0.98, 0.98);
    std::vector<Ray> rays;
    for (std::size_t tile = 0; tile < 1024; ++tile) {
        const real3 o = 0.3 * unit(random) * u + 0.3 * unit(random) * v + n;
        for (int i = 0; i < 16; ++i) {
            // At needles, at their edges and corners, and anywhere.
            const double x = i % 4 == 0 ? unit(random) : xs[1 + random() % (xs.size() - 3)] + (i % 4 - 1) * 1e-6;
            const real3 d = x * u + unit(random) * v - o;
            rays.push_back({static_cast<float>(o.x), static_cast<float>(o.y), static_cast<float>(o.z), 0,
                            static_cast<float>(d.x), static_cast<float>(d.y), static_cast<float>(d.z), kFar});
        }
    }
    const Leaks l = leaks(scene, rays, cpu());
    const std::size_t missed = l.single + l.tiles + l.shadows;
    EXPECT_EQ(missed, 0u);
    double worst = 0;
    std::size_t at_needles = 0;
    for (const std::vector<DeviceHit>& hits : {traversal.closest(rays), traversal.tiles(rays, 16)})
        for (std::size_t i = 0; i < rays.size(); ++i) {
            if (hits[i].primitive == IR_NO_PRIMITIVE) continue;
            ASSERT_TRUE(std::isfinite(hits[i].t) && std::isfinite(hits[i].u) && std::isfinite(hits[i].v)) << i;
            if (!wide[hits[i].primitive]) {
                ++at_needles;
                continue;
            }
            const Ray& r = rays[i];
            const real3 o{static_cast<double>(r.ox), static_cast<double>(r.oy), static_cast<double>(r.oz)},
                d{static_cast<double>(r.dx), static_cast<double>(r.dy), static_cast<double>(r.dz)};
            const double t = -dot(n, o) / dot(n, d);
            worst = std::max(worst, std::abs(static_cast<double>(hits[i].t) - t) / t);
        }
    EXPECT_GT(at_needles, rays.size() / 4);
    // Corners are within 2^-24 of the plane each, hits on well-shaped triangles within 4e-6 (test_traversal) of t = 1,
    // and cosines 1/2 at least. Hits on needles are known along them to 2^-24 of their slenderness only.
    EXPECT_LE(worst, 8e-6);
    hard_case("plane of needles 1 : 1e6 and " + std::to_string(flat) + " triangles without area, " + name() + " (" +
                  std::to_string(l.rays) + " rays; t on the strips between is good to " + figure(worst) + ")",
              "closed mesh: none (Embree, robust: " + std::to_string(l.embree) + ")", "rays that pass through",
              static_cast<double>(missed), 0, "division by the determinant of a triangle without area: 0/0 = NaN");
}

INSTANTIATE_TEST_SUITE_P(Headers, Mesh, ::testing::Bool(),
                         [](const auto& parameter) { return parameter.param ? "cpu" : "gpu"; });

}  // namespace
}  // namespace irradia::test
