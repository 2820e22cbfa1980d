// The order in which the pixels of a 16x16 block are visited: coarse to fine, so that the first records are far apart
// and later ones fill in between. Closed form of the thesis's table 3.1 (which lists 64 of the 256 entries).
#pragma once
#include <cstddef>
#include <cstdint>

namespace irradia {

constexpr std::uint32_t block_edge = 16;        ///< pixels
constexpr std::uint32_t iteration_count = 256;  ///< one pixel of every block each

constexpr std::size_t block_count(std::uint32_t width, std::uint32_t height) {
    return std::size_t{(width + block_edge - 1) / block_edge} * ((height + block_edge - 1) / block_edge);
}

/// The first of them are those of even coordinates; records of the very first are there when nearly all others are
/// looked at.
constexpr std::uint32_t lattice_iterations = 64, sparse_iterations = 16;

struct BlockPixel {
    std::uint32_t x, y;
};

/// Pixel of a block in iteration `it` (0..255): two bits of `it` a level choose one of four offsets, halving each time.
constexpr BlockPixel block_pixel(std::uint32_t it) {
    constexpr int offset_x[4] = {0, 1, 0, 1}, offset_y[4] = {0, 1, 1, 0}, step[4] = {-8, 4, -2, 1};
    int x = 8, y = 8;
    for (unsigned level = 0; level < 4; ++level) {
        const std::uint32_t digit = (it >> (2 * level)) & 3u;
        x += step[level] * offset_x[digit];
        y += step[level] * offset_y[digit];
    }
    return {static_cast<std::uint32_t>(x + 16) % 16u, static_cast<std::uint32_t>(y + 16) % 16u};
}

/// Iterations are taken in steps: [it, step_end(it)) at once. The first records are one a block each, far apart. Then
/// each step has as many iterations as came before, and later ones 16 and 64: few of their pixels want a record, and
/// those of many iterations together keep a device busy where those of one would not.
constexpr std::uint32_t step_end(std::uint32_t it) {
    return it == 0 ? 1 : it < 16 ? 2 * it : it < 64 ? it + 16 : it + 64;
}

/// Edge in pixels of the tiles of which one pixel gets a record at once, where iterations before `end` have begun.
constexpr std::uint32_t step_tile(std::uint32_t end) { return end <= 16 ? block_edge : 8; }
/// The same after the last step, of the pixels left: where they are few, most want a record of their own, in creases.
constexpr std::uint32_t rest_tile(std::size_t left, std::size_t blocks) { return 4 * left <= blocks ? 2 : 4; }

}  // namespace irradia
