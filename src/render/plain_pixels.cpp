#include "render/plain_pixels.h"

#include <algorithm>
#include <bit>
#include <cmath>

#include "cache/buffer_state.h"
#include "core/in_ranges.h"
#include "irradia/shared/record_types.h"

namespace irradia {

void PlainPixels::forget() {
    const std::size_t bytes = sizeof(std::uint32_t) * IR_PLAIN_WORDS * columns() * rows();
    if (words_.bytes() != bytes) words_ = device_.allocate(bytes);
    device_.fill(words_, 0, bytes);
    read_.clear();
    disturbed_.assign(std::size_t{columns()} * rows(), 0);
}

void PlainPixels::disturb(std::uint32_t pixel) {
    constexpr std::uint32_t far = 2;
    const std::uint32_t x = pixel % width_ / 2, y = pixel / width_ / 2;
    for (std::uint32_t v = std::max(y, far) - far; v <= std::min(y + far, rows() - 1); ++v)
        for (std::uint32_t u = std::max(x, far) - far; u <= std::min(x + far, columns() - 1); ++u)
            disturbed_[std::size_t{v} * columns() + u] = 1;
}

void PlainPixels::drop(PixelList& pixels, float apart) {
    const int threads = device_.host_threads();
    if (read_.empty()) {
        read_.resize(words_.bytes() / sizeof(std::uint32_t));
        device_.read(words_, read_.data(), words_.bytes());
    }
    const auto place = [&](std::uint32_t x, std::uint32_t y) {
        return &read_[IR_PLAIN_WORDS * (std::size_t{std::min(y, rows() - 1)} * columns() + std::min(x, columns() - 1))];
    };
    const auto alike = [&](const std::uint32_t* a, const std::uint32_t* b) {
        return a[0] == b[0] && std::abs(std::bit_cast<float>(a[1]) - std::bit_cast<float>(b[1])) <= apart;
    };
    const auto between_plain = [&](std::uint32_t pixel) {
        const std::uint32_t x = pixel % width_, y = pixel / width_;
        const std::uint32_t* const first = place(x / 2, y / 2);
        if (first[0] == 0 || disturbed_[std::size_t{y / 2} * columns() + x / 2] != 0) return false;
        const bool to_right = x % 2 != 0, down = y % 2 != 0;
        return (!to_right || alike(first, place(x / 2 + 1, y / 2))) &&
               (!down || alike(first, place(x / 2, y / 2 + 1))) &&
               (!to_right || !down || alike(first, place(x / 2 + 1, y / 2 + 1)));
    };
    // Each range moves those that stay to its front.
    std::vector<std::size_t> stay(range_count(pixels.size()));
    in_ranges(threads, pixels.size(), [&](std::size_t range, std::size_t begin, std::size_t end) {
        std::size_t to = begin;
        for (std::size_t i = begin; i < end; ++i)
            if (!between_plain(pixels[i])) pixels[to++] = pixels[i];
        stay[range] = to - begin;
    });
    std::size_t kept = 0;
    for (std::size_t range = 0; range < stay.size(); ++range) {
        const std::uint32_t* const from = pixels.data() + range * range_elements;
        std::copy(from, from + stay[range], pixels.data() + kept);
        kept += stay[range];
    }
    pixels.resize(kept);
}

void PlainPixels::state(Checkpoint& checkpoint) {
    exchange(checkpoint, device_, words_, words_.bytes());
    checkpoint(disturbed_);
    if (checkpoint.reading()) read_.clear();
}

}  // namespace irradia
