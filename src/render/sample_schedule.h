// Which pixels take more samples. All take the same number at first; then a pixel goes on, in passes that double its
// samples, until its error is estimated below what is allowed or it has all of them. Less may be allowed later on.
#pragma once
#include <cstdint>
#include <vector>

#include "render/film.h"

namespace irradia {

class SampleSchedule {
public:
    /// `spp`: the most samples a pixel takes. `pixel_error`: the standard error allowed of a pixel's luminance,
    /// relative to the picture's mean; 0: every pixel takes all samples, in one pass.
    /// `threads`: of the host. `halves`: launches can tell the luminances of two halves apart, so that the first pass
    /// has an estimate already.
    SampleSchedule(int width, int height, std::uint32_t spp, double pixel_error, int threads = 1, bool halves = false);

    /// The present pass: samples [first, end) of `pixels`. No pixels: all is done.
    [[nodiscard]] const PixelList& pixels() const noexcept { return pixels_; }
    [[nodiscard]] std::uint32_t first() const noexcept { return first_; }
    [[nodiscard]] std::uint32_t end() const noexcept { return end_; }
    /// Is the film to be given the halves of the present pass? (Film::set_halves)
    [[nodiscard]] bool halves() const noexcept { return halves_ && first_ == 0; }

    /// After a pass, whose samples are in `film`: chooses the next one.
    void advance(const Film& film);

    /// From now on pixels take up to `spp` samples, to an error of `pixel_error` (> 0), both as above: chooses the next
    /// pass. Samples that are in `film` stay.
    void allow(const Film& film, std::uint32_t spp, double pixel_error);
    /// Pixels where `counted` is 0 take no more than `spp` samples, whatever their error is.
    void spare(std::vector<std::uint8_t> counted, std::uint32_t spp);

    /// Mean over pixels, those not spared, of the squared standard errors, relative to the squared mean of the picture;
    /// 0 as long as no pixel has taken two passes. Up to a half too low: pixels stop where they are estimated so by
    /// chance.
    [[nodiscard]] double squared_noise() const;
    void state(Checkpoint& checkpoint);

private:
    /// Calls f(k, pixels_[k]) for all of them.
    template <class F>
    void for_pixels(const F& f) const {
        in_ranges(threads_, pixels_.size(), [&](std::size_t, std::size_t begin, std::size_t end) {
            for (std::size_t k = begin; k < end; ++k) f(k, pixels_[k]);
        });
    }
    /// Sets luminances[k] of pixels_[k].
    void find_luminances(const Film& film, UntouchedVector<float>& luminances) const;
    /// Sets errors_ of the present pass's pixels, from their luminances now_ and (before_) after `first` samples.
    void estimate_errors(std::uint32_t first);
    [[nodiscard]] double typical_luminance() const;
    [[nodiscard]] bool wants_more(std::uint32_t pixel) const;
    void choose(const Film& film);

    int width_, height_, threads_;
    std::uint32_t spp_, first_ = 0, end_ = 0, spared_spp_ = 0;
    bool halves_;
    double pixel_error_, mean_ = 0;  // mean_: luminance of the picture, once known
    PixelList pixels_;
    UntouchedVector<float> now_, before_;  // luminance of each of pixels_; a pass ago, or after half of the first one
    UntouchedVector<float> map_;  // of the picture: a pixel's own estimate of its error, of pixels_, else negative
    UntouchedVector<std::uint32_t> taken_;  // samples of each pixel
    UntouchedVector<float> errors_;         // standard error of each pixel's luminance; negative: not known yet
    std::vector<std::uint8_t> counted_;     // empty: all
};

}  // namespace irradia
