#include "render/iteration_order.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <set>
#include <utility>
#include <vector>

namespace irradia {
namespace {

using Pixel = std::pair<unsigned, unsigned>;
Pixel at(unsigned it) {
    const BlockPixel p = block_pixel(it);
    return {p.x, p.y};
}

// Entries of the thesis's table 3.1 as the algorithm's description quotes them.
TEST(IterationOrder, AgreesWithTheTablesQuotedEntries) {
    EXPECT_EQ(at(0), Pixel(8, 8));
    EXPECT_EQ(at(1), Pixel(0, 0));
    EXPECT_EQ(at(2), Pixel(8, 0));
    EXPECT_EQ(at(3), Pixel(0, 8));
    EXPECT_EQ(at(4), Pixel(12, 12));
    EXPECT_EQ(at(16), Pixel(6, 6));
    EXPECT_EQ(at(42), Pixel(8, 2));
    EXPECT_EQ(at(63), Pixel(2, 8));
}

// All 64 entries of the table: its level l takes steps (-8, +4, -2) along the digits' offsets. Computed here digit by
// digit from the text, without the loop under test.
TEST(IterationOrder, AgreesWithAll64EntriesOfTheTable) {
    for (unsigned it = 0; it < 64; ++it) {
        const unsigned a = it % 4, b = it / 4 % 4, c = it / 16;
        const auto dx = [](unsigned d) { return d == 1 || d == 3 ? 1 : 0; };
        const auto dy = [](unsigned d) { return d == 1 || d == 2 ? 1 : 0; };
        const int x = 8 - 8 * dx(a) + 4 * dx(b) - 2 * dx(c), y = 8 - 8 * dy(a) + 4 * dy(b) - 2 * dy(c);
        EXPECT_EQ(at(it), Pixel((x + 16) % 16, (y + 16) % 16)) << "iteration " << it;
    }
}

TEST(IterationOrder, VisitsEveryPixelOnce) {
    std::set<Pixel> seen;
    for (unsigned it = 0; it < iteration_count; ++it) seen.insert(at(it));
    EXPECT_EQ(seen.size(), 256u);
}

// Coarse to fine: the first 4, 16 and 64 pixels fill the lattices of spacing 8, 4 and 2.
TEST(IterationOrder, GoesFromCoarseToFine) {
    for (const auto& [count, spacing] : {std::pair{4u, 8u}, std::pair{16u, 4u}, std::pair{64u, 2u}}) {
        std::set<Pixel> seen;
        for (unsigned it = 0; it < count; ++it) {
            EXPECT_EQ(at(it).first % spacing, 0u);
            EXPECT_EQ(at(it).second % spacing, 0u);
            seen.insert(at(it));
        }
        EXPECT_EQ(seen.size(), count);
    }
}

// Steps are all iterations, each once; the first fill the lattices of spacing 16 and 8 by halves, and from 16
// iterations on none looks at pixels of two levels of the order.
TEST(IterationOrder, StepsAreAllIterationsInOrder) {
    std::vector<unsigned> ends;
    for (unsigned it = 0; it < iteration_count; it = step_end(it)) {
        ASSERT_GT(step_end(it), it);
        ends.push_back(step_end(it));
    }
    EXPECT_EQ(ends.back(), iteration_count);
    EXPECT_EQ(std::vector(ends.begin(), ends.begin() + 5), (std::vector{1u, 2u, 4u, 8u, 16u}));
    EXPECT_TRUE(std::find(ends.begin(), ends.end(), 64u) != ends.end());
    EXPECT_EQ(ends.size(), 11u);
}

// Coarse to fine, and all of a block's tiles are whole.
TEST(IterationOrder, TilesShrinkAsStepsGetFiner) {
    unsigned before = block_edge;
    for (unsigned it = 0; it < iteration_count; it = step_end(it)) {
        const unsigned tile = step_tile(step_end(it));
        EXPECT_LE(tile, before);
        EXPECT_EQ(block_edge % tile, 0u);
        before = tile;
    }
    EXPECT_EQ(step_tile(1), block_edge);
    for (const std::size_t left : {1000u, 251u, 250u, 1u}) {  // 250: a quarter as many as blocks
        const unsigned tile = rest_tile(left, 1000);
        EXPECT_LT(tile, 8u);
        EXPECT_LE(tile, before);
        EXPECT_EQ(block_edge % tile, 0u);
        before = tile;
    }
    EXPECT_GT(rest_tile(251, 1000), rest_tile(250, 1000));
}

}  // namespace
}  // namespace irradia
