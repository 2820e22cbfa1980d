#include "render/shared_order.h"

#include <gtest/gtest.h>

#include <numeric>

namespace irradia {
namespace {

std::vector<std::uint32_t> numbers(std::size_t count) {
    std::vector<std::uint32_t> all(count);
    std::iota(all.begin(), all.end(), 100u);
    return all;
}

TEST(SharedOrder, HasEveryPixelOnce) {
    for (const std::size_t count : {0u, 1u, 15u, 16u, 17u, 31u, 33u, 1000u, 1024u, 16384u, 16383u}) {
        const std::vector<std::uint32_t> pixels = numbers(count);
        std::vector<std::uint32_t> order = shared_order(pixels, 16);
        std::sort(order.begin(), order.end());
        EXPECT_EQ(order, pixels) << count;
    }
}

// Groups are launched as pixels lie in the list: all but one hold neighbours only.
TEST(SharedOrder, KeepsGroupsWhole) {
    const std::vector<std::uint32_t> order = shared_order(numbers(1000), 16);
    int broken = 0;
    for (std::size_t g = 0; g + 16 <= order.size(); g += 16)
        if (order[g + 15] != order[g] + 15) ++broken;
    EXPECT_EQ(order.size(), 1000u);
    EXPECT_LE(broken, 0);
}

// A thread that takes half of what is left, then half of that, ... gets an even share of any slope of costs along the
// list: here pixel i costs i, so that in the list's own order the first half would cost a quarter of the whole.
TEST(SharedOrder, ThePartsThatThreadsTakeCostAlike) {
    const std::size_t count = 16384;
    const std::vector<std::uint32_t> order = shared_order(numbers(count), 16);
    std::size_t begin = 0;
    for (std::size_t left = count; left > 1024; left -= left / 2) {
        const std::size_t part = left / 2;
        double cost = 0;
        for (std::size_t i = begin; i < begin + part; ++i) cost += order[i] - 100.0;
        EXPECT_NEAR(cost / static_cast<double>(part), count / 2.0, 0.07 * count / 2.0) << "from " << begin;
        begin += part;
    }
}

}  // namespace
}  // namespace irradia
