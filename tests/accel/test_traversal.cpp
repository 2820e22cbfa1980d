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

INSTANTIATE_TEST_SUITE_P(Headers, TraversalTest, ::testing::Bool(),
                         [](const auto& info) { return info.param ? "cpu" : "gpu"; });

}  // namespace
}  // namespace irradia
