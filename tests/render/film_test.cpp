// What pixels gather, and which of many go on, whatever the number of threads.
#include "render/film.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <numeric>
#include <vector>

#include "render/sample_schedule.h"

namespace irradia::test {
namespace {

// Several ranges of in_ranges(), the last one not whole.
constexpr int width = 211, height = 97;
constexpr std::size_t pixel_count = std::size_t{width} * height;

std::vector<std::uint32_t> all_pixels() {
    std::vector<std::uint32_t> all(pixel_count);
    std::iota(all.begin(), all.end(), 0u);
    return all;
}

/// Sums of six channels: `value` in each, times the pixel's number in the list and one.
std::vector<float> sums_of(float value, std::size_t count) {
    std::vector<float> sums(6 * count);
    for (std::size_t i = 0; i < sums.size(); ++i) sums[i] = value * static_cast<float>(i / 6 + 1);
    return sums;
}

TEST(Film, MeansAreOfWhatWasAddedSinceTheLastClearing) {
    for (const int threads : {1, 3}) {
        Film film(width, height, false, threads);
        EXPECT_EQ(film.samples(), 0u);
        EXPECT_EQ(film.mean(5, 0), 0);  // nothing yet
        film.add(sums_of(8, pixel_count), all_pixels(), 4);
        film.add(sums_of(4, pixel_count), 0, pixel_count, 2);
        for (std::size_t i = 0; i < pixel_count; ++i)
            ASSERT_EQ(film.mean(i, i % 6), 2.0 * static_cast<double>(i + 1)) << i;
        EXPECT_EQ(film.samples(), 6 * pixel_count);
        film.clear(7);
        EXPECT_EQ(film.mean(7, 0), 0);
        film.add(sums_of(3, 1), std::vector<std::uint32_t>{7}, 1);
        EXPECT_EQ(film.mean(7, 5), 3);
        film.clear_indirect(7);
        film.add_indirect(sums_of(5, 1), std::vector<std::uint32_t>{7});
        EXPECT_EQ(film.mean(7, 2), 3);
        EXPECT_EQ(film.mean(7, 3), 5);
        film.clear();
        EXPECT_EQ(film.samples(), 0u);
        EXPECT_EQ(film.luminance(7), 0);
        film.add(sums_of(1, pixel_count), all_pixels(), 1);
        for (std::size_t i = 0; i < pixel_count; ++i) ASSERT_EQ(film.mean(i, 5), static_cast<double>(i + 1)) << i;
    }
}

// Pixels whose second samples differ from their first want more, with the eight around them; in ascending order.
TEST(SampleSchedule, ChoosesTheSamePixelsOnAnyNumberOfThreads) {
    const auto noisy = [](std::uint32_t pixel) { return pixel % 1009 == 13; };
    std::vector<std::uint32_t> expected;
    for (std::uint32_t i = 0; i < pixel_count; ++i) {
        const int x = static_cast<int>(i) % width, y = static_cast<int>(i) / width;
        bool near = false;
        for (int v = std::max(y - 1, 0); v <= std::min(y + 1, height - 1); ++v)
            for (int u = std::max(x - 1, 0); u <= std::min(x + 1, width - 1); ++u)
                near = near || noisy(static_cast<std::uint32_t>(v * width + u));
        if (near) expected.push_back(i);
    }
    ASSERT_GT(expected.size(), 100u);
    for (const int threads : {1, 2, 5}) {
        Film film(width, height, false, threads);
        SampleSchedule schedule(width, height, 64, .1, threads);
        for (int pass = 0; pass < 2; ++pass) {
            ASSERT_TRUE(std::ranges::equal(schedule.pixels(), all_pixels())) << threads;
            const std::uint32_t n = schedule.end() - schedule.first();
            std::vector<float> sums(6 * pixel_count);
            for (std::uint32_t i = 0; i < pixel_count; ++i)
                std::fill_n(&sums[std::size_t{6} * i], 6, static_cast<float>(n) * (pass > 0 && noisy(i) ? 9.0f : 0.5f));
            film.add(sums, schedule.pixels(), n);
            schedule.advance(film);
        }
        EXPECT_TRUE(std::ranges::equal(schedule.pixels(), expected)) << threads;
    }
}

}  // namespace
}  // namespace irradia::test
