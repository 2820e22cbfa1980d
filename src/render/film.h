// What the pixels have gathered: sums in double, so that 100 000 samples a pixel lose no precision.
#pragma once
#include <cstdint>
#include <span>
#include <vector>

#include "core/in_ranges.h"
#include "irradia/Checkpoint.h"
#include "irradia/Image.h"
#include "irradia/Renderer.h"

namespace irradia {

/// Pixels of a picture, by number: row by row.
using PixelList = UntouchedVector<std::uint32_t>;

class Film {
public:
    /// `threads`: of the host, for what is done to all pixels.
    Film(int width, int height, bool aovs, int threads = 1);
    /// Forgets everything.
    void clear();

    [[nodiscard]] std::size_t pixels() const noexcept { return count_.size(); }
    /// Floats a pixel of a kernel's film buffer: IR_FILM_CHANNELS of cl/film.h.
    [[nodiscard]] std::size_t channels() const noexcept { return channels_; }

    /// Adds a kernel's sums over `samples` samples: slot i of `sums` belongs to pixel first + i ...
    void add(std::span<const float> sums, std::size_t first, std::size_t count, std::uint32_t samples);
    /// ... or to pixel pixels[i].
    void add(std::span<const float> sums, std::span<const std::uint32_t> pixels, std::uint32_t samples);
    /// Indirect light of samples whose other channels the film holds already, after clear_indirect().
    void add_indirect(std::span<const float> sums, std::span<const std::uint32_t> pixels);
    void clear_indirect(std::uint32_t pixel);
    /// Of pixel pixels[i], whose samples were added in one launch: the luminances that the first half of them sum up to
    /// less those of the second.
    void set_halves(std::span<const float> differences, std::span<const std::uint32_t> pixels);
    [[nodiscard]] double halves(std::size_t pixel) const { return static_cast<double>(halves_[pixel]); }
    /// Samples that pixel i has gathered.
    [[nodiscard]] std::uint32_t samples(std::uint32_t pixel) const { return count_[pixel]; }
    /// Forgets what pixel i has gathered.
    void clear(std::uint32_t pixel);

    /// Mean of one channel of what pixel i has gathered: 0-2 direct, 3-5 indirect radiance.
    [[nodiscard]] double mean(std::size_t pixel, std::size_t channel) const {
        return count_[pixel] > 0 ? sum_[pixel * channels_ + channel] / static_cast<double>(count_[pixel]) : 0.0;
    }
    /// Mean luminance of what pixel i has gathered.
    [[nodiscard]] double luminance(std::size_t pixel) const;
    /// Samples that all pixels have gathered together.
    [[nodiscard]] std::uint64_t samples() const;

    /// The picture and the layers asked for ("records" is left empty: the cache knows where they lie).
    [[nodiscard]] Image image(const RenderSettings& settings) const;
    /// Of a film of the same size and channels.
    void state(Checkpoint& checkpoint);

private:
    void add_pixel(const float* sums, std::size_t pixel, std::uint32_t samples);

    int width_, height_, threads_;
    std::size_t channels_;
    UntouchedVector<double> sum_;           // of pixels that have gathered anything
    UntouchedVector<std::uint32_t> count_;  // samples
    UntouchedVector<float> halves_;         // of the picture, once any are known
};

}  // namespace irradia
