// The order in which a CPU device is given the pixels of a launch. Its threads take what is left by halves (PoCL: a
// thread as many groups as its share of those that remain), and neighbouring pixels cost alike: in the picture's order
// the first share may be twice the work of the others, and at the end one thread works alone.
#pragma once
#include <algorithm>
#include <cstdint>
#include <span>
#include <vector>

namespace irradia {

/// `pixels` in runs of whole groups of `group` pixels, the runs in bit-reversed order: any share of them in sequence
/// lies evenly over the list.
inline std::vector<std::uint32_t> shared_order(std::span<const std::uint32_t> pixels, std::size_t group) {
    constexpr unsigned most_bits = 6;  // runs are long enough for neighbours to find in caches what they share
    const std::size_t groups = (pixels.size() + group - 1) / group;
    unsigned bits = 0;
    while (bits < most_bits && (std::size_t{2} << bits) <= groups) ++bits;
    const std::size_t runs = std::size_t{1} << bits;
    std::vector<std::uint32_t> order;
    order.reserve(pixels.size());
    for (std::size_t i = 0; i < runs; ++i) {
        std::size_t run = 0;
        for (unsigned b = 0; b < bits; ++b) run |= ((i >> b) & 1u) << (bits - 1 - b);
        const std::size_t begin = run * groups / runs * group,
                          end = std::min((run + 1) * groups / runs * group, pixels.size());
        order.insert(order.end(), pixels.begin() + static_cast<std::ptrdiff_t>(begin),
                     pixels.begin() + static_cast<std::ptrdiff_t>(end));
    }
    return order;
}

}  // namespace irradia
