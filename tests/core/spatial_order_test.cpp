#include "core/spatial_order.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <random>

namespace irradia {
namespace {

using Point = std::array<float, 3>;

TEST(SpatialOrder, HasEveryPointOnce) {
    std::mt19937 random(1);
    std::uniform_real_distribution<float> u(-3, 5);
    for (const std::size_t count : {0u, 1u, 2u, 1000u}) {
        std::vector<Point> points(count);
        for (Point& p : points) p = {u(random), u(random), u(random)};
        std::vector<std::uint32_t> order = spatial_order(points), all(count);
        std::sort(order.begin(), order.end());
        std::iota(all.begin(), all.end(), 0u);
        EXPECT_EQ(order, all) << count;
    }
}

// The curve visits the eight corners of a cube as their coordinates' bits count, x first, and every smaller cube before
// it goes on to the next one.
TEST(SpatialOrder, GoesAlongTheCurve) {
    std::vector<Point> points;
    for (const int i : {5, 2, 7, 0, 3, 6, 1, 4})
        for (const float shift : {0.1f, 0.0f})
            points.push_back(
                {static_cast<float>(i & 1) + shift, static_cast<float>(i >> 1 & 1), static_cast<float>(i >> 2)});
    const std::vector<std::uint32_t> order = spatial_order(points);
    for (std::size_t i = 0; i < order.size(); ++i) {
        const Point& p = points[order[i]];
        EXPECT_EQ(std::floor(p[0]) + 2 * p[1] + 4 * p[2], static_cast<float>(i / 2)) << i;
        EXPECT_EQ(p[0] > std::floor(p[0]), i % 2 == 1) << i;
    }
}

TEST(SpatialOrder, KeepsPointsOfOnePlaceAsTheyAre) {
    const std::vector<Point> points(100, Point{1, 2, 3});
    std::vector<std::uint32_t> all(points.size());
    std::iota(all.begin(), all.end(), 0u);
    EXPECT_EQ(spatial_order(points), all);
}

// Extents beyond what a float holds: no step is beyond the last.
TEST(SpatialOrder, TakesCoordinatesOfAnySize) {
    const std::vector<Point> points{{3e38f, 0, 0}, {-3e38f, 0, 0}, {0, 0, 0}, {1e-40f, 0, 0}};
    EXPECT_EQ(spatial_order(points), (std::vector<std::uint32_t>{1, 2, 3, 0}));
}

// A step leads to a near neighbour in most cases: of n points in a square the mean step is a few times n^-1/2, where
// that of an order by chance is half of the square's edge (0.52, the mean distance of two points in a unit square).
TEST(SpatialOrder, LeadsToNeighbours) {
    std::mt19937 random(2);
    std::uniform_real_distribution<float> u(0, 1);
    std::vector<Point> points(10000);
    for (Point& p : points) p = {u(random), u(random), 0};
    const std::vector<std::uint32_t> order = spatial_order(points);
    double way = 0;
    for (std::size_t i = 1; i < order.size(); ++i)
        way += std::hypot(points[order[i]][0] - points[order[i - 1]][0], points[order[i]][1] - points[order[i - 1]][1]);
    EXPECT_LT(way / static_cast<double>(points.size()), 2 * 0.01);
}

}  // namespace
}  // namespace irradia
