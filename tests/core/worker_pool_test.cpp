#include "core/worker_pool.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <functional>
#include <numeric>
#include <random>
#include <set>
#include <utility>
#include <vector>

#include "core/in_ranges.h"

namespace irradia {
namespace {

// Work that does not end before all have begun: they run at the same time, each once.
TEST(WorkerPool, HelpersWorkAtTheSameTime) {
    WorkerPool pool;
    for (const std::size_t helpers : {0u, 1u, 7u, 3u, 7u}) {
        std::atomic<std::size_t> begun = 0;
        std::mutex lock;
        std::set<std::thread::id> threads;
        pool.run(helpers, [&] {
            {
                const std::lock_guard guard(lock);
                threads.insert(std::this_thread::get_id());
            }
            for (++begun; begun <= helpers;) std::this_thread::yield();
        });
        EXPECT_EQ(begun, helpers + 1);
        EXPECT_EQ(threads.size(), helpers + 1);
        EXPECT_TRUE(threads.contains(std::this_thread::get_id()));
    }
}

// Work that ends at once is not waited for by threads that wake late, nor called with what has gone out of scope.
TEST(WorkerPool, ManyShortRuns) {
    WorkerPool pool;
    for (int i = 0; i < 20000; ++i) {
        std::atomic<int> left = 5, done = 0;
        pool.run(4, [&] {
            while (left.fetch_sub(1) > 0) ++done;
        });
        ASSERT_EQ(done, 5) << "run " << i;
    }
}

TEST(WorkerPool, WorkWithinWorkIsDoneWhereItIs) {
    WorkerPool pool;
    std::atomic<int> outer = 0, inner = 0, elsewhere = 0;
    pool.run(3, [&] {
        const std::thread::id here = std::this_thread::get_id();
        pool.run(3, [&] {
            ++inner;
            if (std::this_thread::get_id() != here) ++elsewhere;
        });
        for (++outer; outer < 4;) std::this_thread::yield();
    });
    EXPECT_EQ(outer, 4);
    EXPECT_EQ(inner, 4);
    EXPECT_EQ(elsewhere, 0);
}

TEST(WorkerPool, SeveralThreadsMayAskForIt) {
    WorkerPool pool;
    std::atomic<int> sum = 0;
    std::vector<std::jthread> threads;
    for (int t = 0; t < 4; ++t)
        threads.emplace_back([&] {
            for (int i = 0; i < 500; ++i) {
                std::atomic<int> left = 10;
                pool.run(2, [&] {
                    while (left.fetch_sub(1) > 0) ++sum;
                });
            }
        });
    threads.clear();
    EXPECT_EQ(sum, 4 * 500 * 10);
}

TEST(InRanges, ReachEveryElementOnce) {
    for (const std::size_t count : {std::size_t{0}, std::size_t{1}, range_elements, 5 * range_elements + 3})
        for (const int threads : {0, 1, 2, 16}) {
            std::vector<int> touched(count);
            in_ranges(threads, count, [&](std::size_t range, std::size_t begin, std::size_t end) {
                EXPECT_EQ(begin, range * range_elements);
                for (std::size_t i = begin; i < end; ++i) ++touched[i];
            });
            EXPECT_EQ(std::accumulate(touched.begin(), touched.end(), std::size_t{0}), count);
            EXPECT_EQ(std::count(touched.begin(), touched.end(), 1), static_cast<std::ptrdiff_t>(count));
        }
}

// By any number of threads, also where there are more of them than ranges, few elements, or many that are alike.
TEST(InRanges, SortLikeOneThread) {
    std::mt19937 random(4);
    for (const std::size_t count :
         {std::size_t{0}, std::size_t{1}, std::size_t{7}, range_elements + 1, 5 * range_elements + 3})
        for (const unsigned values : {3u, 1u << 30}) {
            std::vector<std::pair<unsigned, std::size_t>> elements;
            for (std::size_t i = 0; i < count; ++i) elements.emplace_back(random() % values, i);
            std::vector<std::pair<unsigned, std::size_t>> expected = elements;
            std::stable_sort(expected.begin(), expected.end(), [](auto& a, auto& b) { return a.first < b.first; });
            for (const int threads : {0, 1, 2, 3, 16}) {
                std::vector<std::pair<unsigned, std::size_t>> sorted = elements;
                sort_in_parts(threads, sorted, std::less<>{});
                EXPECT_EQ(sorted, expected) << count << " elements, " << threads << " threads";
            }
        }
}

}  // namespace
}  // namespace irradia
