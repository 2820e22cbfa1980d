// Loops over large arrays on several threads, plain ones (worker_pool.h): the minimal build has no library for them.
#pragma once
#include <algorithm>
#include <atomic>
#include <cstddef>
#include <memory>
#include <utility>
#include <vector>

#include "core/worker_pool.h"

namespace irradia {

/// Elements of one range: of fewer no loop is worth a thread.
inline constexpr std::size_t range_elements = std::size_t{1} << 13;

inline std::size_t range_count(std::size_t count) { return (count + range_elements - 1) / range_elements; }

/// Calls f(range, begin, end) for every range of [0, count), on up to `threads` threads; returns when all are done.
/// Ranges are the same whatever the number of threads: sums that are taken by range do not depend on it. f must not
/// throw.
template <class F>
void in_ranges(int threads, std::size_t count, const F& f) {
    const std::size_t ranges = range_count(count);
    std::atomic<std::size_t> next = 0;
    const auto work = [&] {
        for (std::size_t r = next++; r < ranges; r = next++)
            f(r, r * range_elements, std::min(count, (r + 1) * range_elements));
    };
    const std::size_t most = std::min<std::size_t>(ranges, static_cast<std::size_t>(std::max(threads, 1)));
    if (most > 1)
        WorkerPool::shared().run(most - 1, work);
    else
        work();
}

/// Leaves elements that resize() adds as they are: the thread that first writes them gets their pages.
template <class T>
struct Untouched : std::allocator<T> {
    template <class U>
    struct rebind {
        using other = Untouched<U>;
    };
    template <class U>
    void construct(U* at) {
        ::new (static_cast<void*>(at)) U;
    }
    template <class U, class... Arguments>
    void construct(U* at, Arguments&&... arguments) {
        ::new (static_cast<void*>(at)) U(std::forward<Arguments>(arguments)...);
    }
};

template <class T>
using UntouchedVector = std::vector<T, Untouched<T>>;

/// A vector of `count` times `value`.
template <class T>
UntouchedVector<T> filled(int threads, std::size_t count, T value) {
    UntouchedVector<T> v(count);
    in_ranges(threads, count, [&](std::size_t, std::size_t begin, std::size_t end) {
        std::fill(v.data() + begin, v.data() + end, value);
    });
    return v;
}

}  // namespace irradia
