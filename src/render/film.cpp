#include "render/film.h"

#include <algorithm>

namespace irradia {
namespace {

// Adds up what a launch gives back for `count` pixels, f(i) for each. CPU devices' launches are short, and the first
// touch the film's pages: all threads are to have a part.
template <class F>
void for_each_pixel(int threads, std::size_t count, const F& f) {
    const auto shares = static_cast<std::size_t>(4 * std::max(threads, 1));
    in_ranges(
        threads, count,
        [&](std::size_t, std::size_t begin, std::size_t end) {
            for (std::size_t i = begin; i < end; ++i) f(i);
        },
        std::clamp<std::size_t>(count / shares, 1024, range_elements));
}

}  // namespace

Film::Film(int width, int height, bool aovs, int threads)
    : width_(width), height_(height), threads_(threads), channels_(aovs ? 13 : 6) {
    const std::size_t n = static_cast<std::size_t>(width) * static_cast<std::size_t>(height);
    sum_.resize(n * channels_);
    count_ = filled(threads, n, 0u);
}

void Film::clear() { fill(threads_, count_, 0u); }

void Film::clear(std::uint32_t pixel) { count_[pixel] = 0; }

// The first to add anything writes over what is left of the sums.
void Film::add_pixel(const float* sums, std::size_t pixel, std::uint32_t samples) {
    double* to = &sum_[pixel * channels_];
    if (count_[pixel] == 0)
        for (std::size_t c = 0; c < channels_; ++c) to[c] = static_cast<double>(sums[c]);
    else
        for (std::size_t c = 0; c < channels_; ++c) to[c] += static_cast<double>(sums[c]);
    count_[pixel] += samples;
}

void Film::add(std::span<const float> sums, std::size_t first, std::size_t count, std::uint32_t samples) {
    for_each_pixel(threads_, count, [&](std::size_t i) { add_pixel(&sums[i * channels_], first + i, samples); });
}

void Film::add(std::span<const float> sums, std::span<const std::uint32_t> pixels, std::uint32_t samples) {
    for_each_pixel(threads_, pixels.size(),
                   [&](std::size_t i) { add_pixel(&sums[i * channels_], pixels[i], samples); });
}

void Film::add_indirect(std::span<const float> sums, std::span<const std::uint32_t> pixels) {
    for_each_pixel(threads_, pixels.size(), [&](std::size_t i) {
        for (std::size_t c = 3; c < 6; ++c)
            sum_[pixels[i] * channels_ + c] += static_cast<double>(sums[i * channels_ + c]);
    });
}

void Film::set_halves(std::span<const float> differences, std::span<const std::uint32_t> pixels) {
    if (halves_.empty()) halves_ = filled(threads_, count_.size(), 0.0f);
    for_each_pixel(threads_, pixels.size(), [&](std::size_t i) { halves_[pixels[i]] = differences[i]; });
}

void Film::clear_indirect(std::uint32_t pixel) { std::fill_n(&sum_[pixel * channels_ + 3], 3, 0.0); }

double Film::luminance(std::size_t pixel) const {
    if (count_[pixel] == 0) return 0;
    const double* sum = &sum_[pixel * channels_];
    const auto channel = [&](std::size_t c) { return sum[c] + sum[3 + c]; };  // direct and indirect
    return (0.2126 * channel(0) + 0.7152 * channel(1) + 0.0722 * channel(2)) / static_cast<double>(count_[pixel]);
}

std::uint64_t Film::samples() const {
    return sum_in_ranges<std::uint64_t>(threads_, pixels(), [&](std::size_t i) { return count_[i]; });
}

void Film::state(Checkpoint& checkpoint) {
    if (!checkpoint.reading())  // nothing of what the memory held before gets into a file
        for (std::size_t i = 0; i < pixels(); ++i)
            if (count_[i] == 0) std::fill_n(&sum_[i * channels_], channels_, 0.0);
    checkpoint(sum_)(count_)(halves_);
}

Image Film::image(const RenderSettings& settings) const {
    Image image;
    image.width = width_;
    image.height = height_;
    const auto layer = [&](const std::string& name, int channels, std::size_t first, bool beauty) {
        Layer l;
        l.name = name;
        l.channels = channels;
        const auto n = static_cast<std::size_t>(channels);
        l.data.resize(pixels() * n);
        in_ranges(threads_, pixels(), [&](std::size_t, std::size_t begin, std::size_t end) {
            for (std::size_t i = begin; i < end; ++i)
                for (std::size_t c = 0; c < n; ++c)
                    l.data[i * n + c] = static_cast<float>(mean(i, first + c) + (beauty ? mean(i, 3 + c) : 0.0));
        });
        image.layers.push_back(std::move(l));
    };
    layer("", 3, 0, true);
    for (const std::string& name : settings.aovs) {
        if (name == "direct") layer(name, 3, 0, false);
        if (name == "indirect") layer(name, 3, 3, false);
        if (name == "albedo") layer(name, 3, 6, false);
        if (name == "normal") layer(name, 3, 9, false);
        if (name == "depth") layer(name, 1, 12, false);
    }
    return image;
}

}  // namespace irradia
