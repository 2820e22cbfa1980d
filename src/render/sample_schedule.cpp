#include "render/sample_schedule.h"

#include <algorithm>
#include <numeric>

namespace irradia {
namespace {
constexpr std::uint32_t first_half = 8;  // samples: with as many again the first estimate is made
}

SampleSchedule::SampleSchedule(int width, int height, std::uint32_t spp, double pixel_error, int threads, bool halves)
    : width_(width),
      height_(height),
      threads_(threads),
      spp_(spp),
      halves_(halves && pixel_error > 0 && spp >= 2 * first_half),
      pixel_error_(pixel_error),
      pixels_(static_cast<std::size_t>(width) * static_cast<std::size_t>(height)),
      before_(filled(threads, pixels_.size(), 0.0)),
      taken_(filled(threads, pixels_.size(), 0u)),
      errors_(filled(threads, pixels_.size(), -1.0)) {
    end_ = pixel_error > 0 ? std::min(spp, halves_ ? 2 * first_half : first_half) : spp;
    std::iota(pixels_.begin(), pixels_.end(), 0u);
}

// Two means a and b, of n0 and n1 independent samples, estimate the squared error of their common mean by
// (a - b)^2 n0 n1 / (n0 + n1)^2, on average without bias; of stratified samples it is too large, which is safe. One
// such estimate has one degree of freedom only: it is averaged over those of the 3x3 pixels around that take as many
// samples, which also lets an edge be found that a pixel's own samples have missed.
void SampleSchedule::estimate_errors(const UntouchedVector<double>& now, std::uint32_t first) {
    constexpr double none = -1;
    if (map_.empty()) map_ = filled(threads_, taken_.size(), none);
    const double n0 = first, n1 = end_ - first, n = end_;
    for_pixels([&](std::size_t k, std::uint32_t i) {
        const double later = (now[k] * n - before_[k] * n0) / n1;
        map_[i] = (later - before_[k]) * (later - before_[k]) * n0 * n1 / (n * n);
    });
    for_pixels([&](std::size_t, std::uint32_t i) {
        const int x = static_cast<int>(i) % width_, y = static_cast<int>(i) / width_;
        double sum = 0, places = 0;
        for (int v = std::max(y - 1, 0); v <= std::min(y + 1, height_ - 1); ++v)
            for (int u = std::max(x - 1, 0); u <= std::min(x + 1, width_ - 1); ++u) {
                const double e =
                    map_[static_cast<std::size_t>(v) * static_cast<std::size_t>(width_) + static_cast<std::size_t>(u)];
                if (e < 0) continue;
                sum += e;
                ++places;
            }
        errors_[i] = sum / places;
    });
    for_pixels([&](std::size_t, std::uint32_t i) { map_[i] = none; });
}

namespace {

// Sum of f(now[k]), taken by range.
template <class F>
double sum_of(int threads, const UntouchedVector<double>& now, const F& f) {
    std::vector<double> sums(range_count(now.size()), 0.0);
    in_ranges(threads, now.size(), [&](std::size_t range, std::size_t begin, std::size_t end) {
        double sum = 0;
        for (std::size_t k = begin; k < end; ++k) sum += f(now[k]);
        sums[range] = sum;
    });
    return std::accumulate(sums.begin(), sums.end(), 0.0);
}

}  // namespace

// Mean luminances of pixels_.
UntouchedVector<double> SampleSchedule::luminances(const Film& film) const {
    UntouchedVector<double> now(pixels_.size());
    for_pixels([&](std::size_t k, std::uint32_t i) { now[k] = film.luminance(i); });
    return now;
}

void SampleSchedule::advance(const Film& film) {
    const UntouchedVector<double> now = luminances(film);
    if (first_ == 0) {  // the picture's mean, without what lamps in view add
        const auto count = static_cast<double>(now.size());
        double mean = sum_of(threads_, now, [](double l) { return l; }) / count;
        for (int round = 0; round < 3; ++round)
            mean = sum_of(threads_, now, [mean](double l) { return std::min(l, 4 * mean); }) / count;
        mean_ = mean;
        if (halves_) {
            for_pixels([&](std::size_t k, std::uint32_t i) { before_[k] = now[k] + film.halves(i) / end_; });
            estimate_errors(now, end_ / 2);
        }  // else one mean, nothing to compare it with
    } else {
        estimate_errors(now, first_);
    }
    for_pixels([&](std::size_t, std::uint32_t i) { taken_[i] = end_; });
    choose(film);
}

bool SampleSchedule::wants_more(std::uint32_t pixel) const {
    const std::uint32_t most = counted_.empty() || counted_[pixel] != 0 ? spp_ : std::min(spp_, spared_spp_);
    const double allowed = pixel_error_ * mean_ * pixel_error_ * mean_;
    return taken_[pixel] < most && (errors_[pixel] < 0 || errors_[pixel] > allowed);
}

// The next pass: of the pixels that want more samples those that have fewest.
void SampleSchedule::choose(const Film& film) {
    constexpr std::uint32_t none = 0xffffffffu;
    struct Wanting {
        std::uint32_t fewest = none;
        std::vector<std::uint32_t> pixels;
    };
    std::vector<Wanting> ranges(range_count(taken_.size()));
    in_ranges(threads_, taken_.size(), [&](std::size_t range, std::size_t begin, std::size_t end) {
        Wanting w;
        for (std::size_t i = begin; i < end; ++i) {
            const auto pixel = static_cast<std::uint32_t>(i);
            if (taken_[i] > w.fewest || !wants_more(pixel)) continue;
            if (taken_[i] < w.fewest) w.pixels.clear();
            w.fewest = taken_[i];
            w.pixels.push_back(pixel);
        }
        ranges[range] = std::move(w);
    });
    std::uint32_t fewest = none;
    for (const Wanting& w : ranges) fewest = std::min(fewest, w.fewest);
    pixels_.clear();
    for (const Wanting& w : ranges)
        if (w.fewest == fewest) pixels_.insert(pixels_.end(), w.pixels.begin(), w.pixels.end());
    if (fewest == none) return;
    first_ = fewest;
    end_ = static_cast<std::uint32_t>(std::min<std::uint64_t>(std::uint64_t{2} * fewest, spp_));
    before_ = luminances(film);
}

void SampleSchedule::allow(const Film& film, std::uint32_t spp, double pixel_error) {
    spp_ = spp;
    pixel_error_ = pixel_error;
    choose(film);
}

void SampleSchedule::spare(std::vector<std::uint8_t> counted, std::uint32_t spp) {
    counted_ = std::move(counted);
    spared_spp_ = spp;
}

void SampleSchedule::state(Checkpoint& c) {
    c(width_)(height_)(spp_)(first_)(end_)(spared_spp_)(halves_)(pixel_error_)(mean_);
    c(pixels_)(before_)(map_)(taken_)(errors_)(counted_);
}

double SampleSchedule::squared_noise() const {
    double sum = 0, count = 0;
    for (std::size_t i = 0; i < errors_.size(); ++i) {
        if (!counted_.empty() && counted_[i] == 0) continue;
        count += 1;
        sum += std::max(errors_[i], 0.0);
    }
    return count > 0 && mean_ > 0 ? sum / count / (mean_ * mean_) : 0;
}

}  // namespace irradia
