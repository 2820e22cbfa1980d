// The points on which pixels (cl/sobol.h) and hemispheres (cl/strata.h) are sampled: how evenly they lie, which is what
// their constructions promise exactly, whatever the scramble.
#include <array>
#include <map>
#include <random>
#include <set>
#include <span>

#include "device.h"

namespace irradia::test {
namespace {
using namespace irradia::host;

template <std::size_t N>
using Points = std::vector<std::array<float, N>>;

Points<4> sobol_points(std::uint32_t seeds, std::uint32_t count) {
    Points<4> points(std::size_t{seeds} * count);
    Buffer out = device().upload(points);
    Kernel kernel = device().kernel("points_test.cl", "test_sobol_points", {});
    kernel.arg(out).arg(seeds).arg(count).run((seeds + 15) / 16, 16);
    device().read(out, points.data(), points.size() * sizeof points[0]);
    return points;
}

/// Of each stratum xi1, xi2, direction; hemispheres one after the other.
Points<5> strata_points(std::uint32_t seeds, std::uint32_t m, std::uint32_t n) {
    Points<5> points(std::size_t{seeds} * m * n);
    Buffer out = device().upload(points);
    Kernel kernel = device().kernel("points_test.cl", "test_strata_points", {});
    kernel.arg(out).arg(seeds).arg(m).arg(n).run((seeds + 15) / 16, 16);
    device().read(out, points.data(), points.size() * sizeof points[0]);
    return points;
}

/// Which of 2^bits equal parts of [0, 1) holds x.
std::uint64_t part(double x, unsigned bits) {
    EXPECT_GE(x, 0);
    EXPECT_LT(x, 1);
    return static_cast<std::uint64_t>(std::ldexp(x, static_cast<int>(bits)));
}

/// Do the points lie in as many different boxes? bits[d]: dimensions[d] is cut into 2^bits[d] parts.
template <class Point>
bool one_each(std::span<const Point> points, const std::vector<unsigned>& bits,
              const std::vector<std::size_t>& dimensions) {
    std::set<std::uint64_t> boxes;
    for (const Point& p : points) {
        std::uint64_t box = 0;
        for (std::size_t d = 0; d < bits.size(); ++d)
            box = box << bits[d] | part(static_cast<double>(p[dimensions[d]]), bits[d]);
        if (!boxes.insert(box).second) return false;
    }
    return true;
}

constexpr std::uint32_t kSeeds = 16;

// Film positions and light samples, each by itself: a (0, 2)-sequence (Sobol's first two dimensions; Niederreiter
// 1992).
TEST(DevicePoints, PairsOfDimensionsAreNets) {
    constexpr std::uint32_t count = 512;
    const Points<4> points = sobol_points(kSeeds, count);
    for (std::uint32_t seed = 0; seed < kSeeds; ++seed)
        for (const std::size_t pair : {std::size_t{0}, std::size_t{2}})
            for (unsigned m = 1; m <= 8; ++m)
                for (std::uint32_t block = 0; block < count >> m; ++block)
                    for (unsigned a = 0; a <= m; ++a) {
                        const std::span some(&points[seed * count + (block << m)], std::size_t{1} << m);
                        const bool held = one_each<std::array<float, 4>>(some, {a, m - a}, {pair, pair + 1});
                        EXPECT_TRUE(held) << "dimensions from " << pair << ", 2^" << m << " points, block " << block;
                    }
}

// Of all ways to cut the cube of four dimensions into 2^m boxes: how many have a point in each. By the ranks of the
// matrices' rows, which do not depend on the scramble; Sobol's own directions have 13, 26 and 41.
TEST(DevicePoints, FourDimensionsTogether) {
    const Points<4> points = sobol_points(kSeeds, 32);
    const std::map<unsigned, int> wanted{{3, 16}, {4, 29}, {5, 40}};
    for (std::uint32_t seed = 0; seed < kSeeds; ++seed)
        for (const auto& [m, number] : wanted) {
            int held = 0;
            const std::span first(&points[seed * 32], std::size_t{1} << m);
            for (unsigned a = 0; a <= m; ++a)
                for (unsigned b = 0; a + b <= m; ++b)
                    for (unsigned c = 0; a + b + c <= m; ++c)
                        held += one_each<std::array<float, 4>>(first, {a, b, c, m - a - b - c}, {0, 1, 2, 3});
            EXPECT_EQ(held, number) << "2^" << m << " points, scramble " << seed;
        }
}

/// Of rings [r0, r0 + rings) and sectors [s0, s0 + sectors), both powers of two: does every box hold one ray that is a
/// ring's and sectors' height and width times any power of two and its inverse?
void expect_net(const Points<5>& points, std::size_t seed, std::uint32_t m, std::uint32_t n, std::uint32_t r0,
                unsigned ring_bits, std::uint32_t s0, unsigned sector_bits) {
    std::vector<std::array<double, 2>> unit;  // of the block of strata
    for (std::uint32_t j = 0; j < 1u << ring_bits; ++j)
        for (std::uint32_t k = 0; k < 1u << sector_bits; ++k) {
            const auto& p = points[seed * m * n + (r0 + j) * n + s0 + k];
            unit.push_back({(j + static_cast<double>(p[0])) / (1u << ring_bits),
                            (k + static_cast<double>(p[1])) / (1u << sector_bits)});
        }
    const unsigned bits = ring_bits + sector_bits;
    for (unsigned a = 0; a <= bits; ++a) {
        const bool held = one_each<std::array<double, 2>>(unit, {a, bits - a}, {0, 1});
        EXPECT_TRUE(held) << m << "x" << n << ", rings from " << r0 << ", sectors from " << s0 << ", 2^" << a
                          << " parts";
    }
}

TEST(DevicePoints, RaysOfAHemisphereAreANet) {
    const Points<5> whole = strata_points(kSeeds, 16, 64), blocks = strata_points(kSeeds, 24, 96);
    for (std::size_t seed = 0; seed < kSeeds; ++seed) {
        expect_net(whole, seed, 16, 64, 0, 4, 0, 6);
        for (const std::uint32_t ring : {0u, 8u, 16u})
            for (const std::uint32_t sector : {0u, 32u, 64u}) expect_net(blocks, seed, 24, 96, ring, 3, sector, 5);
    }
}

// Each ray is uniform in its stratum: chi-square over 4x4 parts of it, 15 degrees of freedom, of a few strata.
TEST(DevicePoints, RaysAreUniformInTheirStrata) {
    constexpr std::uint32_t seeds = 8192, m = 8, n = 32;
    const Points<5> points = strata_points(seeds, m, n);
    for (const std::uint32_t cell : {0u, 1u, 77u, 100u, 255u}) {
        std::array<double, 16> counts{};
        for (std::size_t seed = 0; seed < seeds; ++seed) {
            const auto& p = points[seed * m * n + cell];
            ++counts[4 * part(static_cast<double>(p[0]), 2) + part(static_cast<double>(p[1]), 2)];
        }
        double chi2 = 0;
        for (const double c : counts) chi2 += (c - seeds / 16.0) * (c - seeds / 16.0) / (seeds / 16.0);
        EXPECT_LT(chi2, 44.3) << "stratum " << cell;  // exceeded once in 10 000
    }
}

// Tolerances: those of DeviceSampling.Strata.
TEST(DevicePoints, RaysGoWhereTheirNumbersSay) {
    constexpr std::uint32_t m = 16, n = 64;
    const Points<5> points = strata_points(2, m, n);
    for (std::size_t i = 0; i < points.size(); ++i) {
        const auto& p = points[i];
        const auto cell = static_cast<uint>(i % (m * n));
        const real3 want =
            stratum_direction(cell / n, cell % n, m, n, static_cast<double>(p[0]), static_cast<double>(p[1]));
        EXPECT_NEAR(static_cast<double>(p[2]), want.x, 1.2e-6);
        EXPECT_NEAR(static_cast<double>(p[3]), want.y, 1.2e-6);
        EXPECT_NEAR(static_cast<double>(p[4] * p[4]), want.z * want.z, 2e-7);
    }
}

// What it is for. Light that changes smoothly over the hemisphere, here as exp(2 x) over the disk of projected
// directions, turned at random, whose mean there is I_1(2) (modified Bessel function): the mean squared error of 256
// rays is less than a tenth of that of rays placed in their strata independently (.07). At an edge across the disk, as
// of a wall that ends, whose share is that of a segment of a circle, it is little more than half (.54).
TEST(DevicePoints, RaysOfANetHaveLessVariance) {
    constexpr std::uint32_t seeds = 8192, m = 8, n = 32;
    constexpr double mean = 1.5906368546373291;
    const Points<5> points = strata_points(seeds, m, n);
    std::mt19937 random(11);
    std::uniform_real_distribution<double> uniform(0, 1);
    double smooth[2] = {}, edge[2] = {};  // of the net, of independent rays
    for (std::size_t seed = 0; seed < seeds; ++seed) {
        const double t = 2 * kPi * uniform(random), c = 1.6 * uniform(random) - 0.8;
        const double share = 1 - (std::acos(c) - c * std::sqrt(1 - c * c)) / kPi;
        double sum[2] = {}, within[2] = {};
        for (uint cell = 0; cell < m * n; ++cell) {
            const auto& p = points[seed * m * n + cell];
            const real3 rays[2] = {{static_cast<double>(p[2]), static_cast<double>(p[3]), 0},
                                   stratum_direction(cell / n, cell % n, m, n, uniform(random), uniform(random))};
            for (std::size_t i = 0; i < 2; ++i) {
                const double x = rays[i].x * std::cos(t) + rays[i].y * std::sin(t);
                sum[i] += std::exp(2 * x);
                within[i] += x < c;
            }
        }
        for (std::size_t i = 0; i < 2; ++i) {
            smooth[i] += std::pow(sum[i] / (m * n) - mean, 2);
            edge[i] += std::pow(within[i] / (m * n) - share, 2);
        }
    }
    EXPECT_LT(smooth[0], 0.1 * smooth[1]);
    EXPECT_LT(edge[0], 0.65 * edge[1]);
    RecordProperty("smooth", std::to_string(smooth[0] / smooth[1]));
    RecordProperty("edge", std::to_string(edge[0] / edge[1]));
}

}  // namespace
}  // namespace irradia::test
