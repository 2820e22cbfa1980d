#pragma once
#include <tbb/parallel_for.h>

#include <cstddef>

namespace irradia::loader {

/// Calls f(i) for every i below `count`; small meshes, of which scenes have many, are not worth a task.
template <class F>
void in_parallel(std::size_t count, const F& f) {
    tbb::parallel_for(tbb::blocked_range<std::size_t>(0, count, 1 << 14), [&](const auto& range) {
        for (std::size_t i = range.begin(); i != range.end(); ++i) f(i);
    });
}

}  // namespace irradia::loader
