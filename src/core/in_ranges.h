// Loops over large arrays on several threads, plain ones (worker_pool.h): the minimal build has no library for them.
#pragma once
#include <algorithm>
#include <atomic>
#include <bit>
#include <cstddef>
#include <numeric>
#include <span>
#include <vector>

#include "core/worker_pool.h"
#include "irradia/UntouchedVector.h"

namespace irradia {

/// Elements of one range: of fewer no loop is worth a thread.
inline constexpr std::size_t range_elements = std::size_t{1} << 13;

inline std::size_t range_count(std::size_t count, std::size_t elements = range_elements) {
    return (count + elements - 1) / elements;
}

/// Calls f(range, begin, end) for every range of [0, count), on up to `threads` threads; returns when all are done.
/// Ranges are the same whatever the number of threads: sums that are taken by range do not depend on it. f must not
/// throw. `elements`: of a range, fewer where each takes long.
template <class F>
void in_ranges(int threads, std::size_t count, const F& f, std::size_t elements = range_elements) {
    const std::size_t ranges = range_count(count, elements);
    std::atomic<std::size_t> next = 0;
    const auto work = [&] {
        for (std::size_t r = next++; r < ranges; r = next++) f(r, r * elements, std::min(count, (r + 1) * elements));
    };
    const std::size_t most = std::min<std::size_t>(ranges, static_cast<std::size_t>(std::max(threads, 1)));
    if (most > 1)
        WorkerPool::shared().run(most - 1, work);
    else
        work();
}

/// The sum of f(i) for i in [0, count), taken by range; T{} if there are none.
template <class T, class F>
T sum_in_ranges(int threads, std::size_t count, const F& f) {
    std::vector<T> sums(range_count(count));
    in_ranges(threads, count, [&](std::size_t range, std::size_t begin, std::size_t end) {
        T sum{};
        for (std::size_t i = begin; i < end; ++i) sum += f(i);
        sums[range] = sum;
    });
    return std::accumulate(sums.begin(), sums.end(), T{});
}

/// Sorts `v` by `before`, a total order, on several threads: parts, which are then merged two by two.
template <class Vector, class Before>
void sort_in_parts(int threads, Vector& v, const Before& before) {
    const std::size_t most =
        std::min<std::size_t>(range_count(v.size()), static_cast<std::size_t>(std::max(threads, 1)));
    const std::size_t parts = std::bit_ceil(std::max<std::size_t>(most, 1));
    const auto at = [&](std::size_t part) { return v.begin() + static_cast<std::ptrdiff_t>(v.size() * part / parts); };
    in_ranges(
        threads, parts, [&](std::size_t part, std::size_t, std::size_t) { std::sort(at(part), at(part + 1), before); },
        1);
    for (std::size_t merged = 1; merged < parts; merged *= 2)
        in_ranges(
            threads, parts / (2 * merged),
            [&](std::size_t pair, std::size_t, std::size_t) {
                const std::size_t first = 2 * merged * pair;
                std::inplace_merge(at(first), at(first + merged), at(first + 2 * merged), before);
            },
            1);
}

/// The same elements, copied on several threads.
template <class T>
UntouchedVector<T> copied(int threads, std::span<const T> from) {
    UntouchedVector<T> to(from.size());
    in_ranges(threads, from.size(), [&](std::size_t, std::size_t begin, std::size_t end) {
        std::copy(from.data() + begin, from.data() + end, to.data() + begin);
    });
    return to;
}

/// Sets all elements to `value`.
template <class T>
void fill(int threads, UntouchedVector<T>& v, T value) {
    in_ranges(threads, v.size(), [&](std::size_t, std::size_t begin, std::size_t end) {
        std::fill(v.data() + begin, v.data() + end, value);
    });
}

/// A vector of `count` times `value`.
template <class T>
UntouchedVector<T> filled(int threads, std::size_t count, T value) {
    UntouchedVector<T> v(count);
    fill(threads, v, value);
    return v;
}

}  // namespace irradia
