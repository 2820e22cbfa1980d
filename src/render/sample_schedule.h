// Which pixels take more samples. All take the same number at first; then a pixel goes on, in passes that double its
// samples, until its error is estimated below what is allowed or it has all of them.
#pragma once
#include <cstdint>
#include <vector>

#include "render/film.h"

namespace irradia {

class SampleSchedule {
public:
    /// `spp`: the most samples a pixel takes. `pixel_error`: the standard error allowed of a pixel's luminance,
    /// relative to the picture's mean; 0: every pixel takes all samples, in one pass.
    SampleSchedule(int width, int height, std::uint32_t spp, double pixel_error);

    /// The present pass: samples [first, end) of `pixels`. No pixels: all is done.
    [[nodiscard]] const std::vector<std::uint32_t>& pixels() const noexcept { return pixels_; }
    [[nodiscard]] std::uint32_t first() const noexcept { return first_; }
    [[nodiscard]] std::uint32_t end() const noexcept { return end_; }

    /// After a pass, whose samples are in `film`: chooses the next one.
    void advance(const Film& film);

private:
    /// Of the present pass's pixels, from their luminances now and a pass ago.
    [[nodiscard]] std::vector<double> squared_errors(const std::vector<double>& now);

    int width_, height_;
    std::uint32_t spp_, first_ = 0, end_;
    double pixel_error_, allowed_ = 0;  // allowed_: squared error of a pixel, once the picture's mean is known
    std::vector<std::uint32_t> pixels_;
    std::vector<double> before_;  // luminance of each of pixels_ a pass ago
    std::vector<double> map_;     // of the picture: squared errors of pixels_, else negative
};

}  // namespace irradia
