#include "render/sample_schedule.h"

#include <algorithm>
#include <cmath>
#include <limits>
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
      taken_(filled(threads, pixels_.size(), 0u)),
      errors_(filled(threads, pixels_.size(), -1.0f)) {
    end_ = pixel_error > 0 ? std::min(spp, halves_ ? 2 * first_half : first_half) : spp;
    in_ranges(threads, pixels_.size(), [&](std::size_t, std::size_t begin, std::size_t end) {
        std::iota(pixels_.data() + begin, pixels_.data() + end, static_cast<std::uint32_t>(begin));
    });
}

// Two means a and b, of n0 and n1 independent samples, estimate the squared error of their common mean by
// (a - b)^2 n0 n1 / (n0 + n1)^2, on average without bias; of stratified samples it is too large, which is safe. One
// such estimate has one degree of freedom only: it is averaged over those of the 3x3 pixels around that take as many
// samples, which also lets an edge be found that a pixel's own samples have missed.
void SampleSchedule::estimate_errors(std::uint32_t first) {
    constexpr float none = -1;
    if (map_.empty()) map_ = filled(threads_, taken_.size(), none);
    const double n0 = first, n1 = end_ - first, n = end_, scale = std::sqrt(n0 * n1) / n;
    for_pixels([&](std::size_t k, std::uint32_t i) {
        const double before = static_cast<double>(before_[k]);
        const double later = (static_cast<double>(now_[k]) * n - before * n0) / n1;
        map_[i] = static_cast<float>(std::abs(later - before) * scale);
    });
    for_pixels([&](std::size_t, std::uint32_t i) {
        const int x = static_cast<int>(i) % width_, y = static_cast<int>(i) / width_;
        double sum = 0, places = 0;
        for (int v = std::max(y - 1, 0); v <= std::min(y + 1, height_ - 1); ++v)
            for (int u = std::max(x - 1, 0); u <= std::min(x + 1, width_ - 1); ++u) {
                const auto e = static_cast<double>(
                    map_[static_cast<std::size_t>(v) * static_cast<std::size_t>(width_) + static_cast<std::size_t>(u)]);
                if (e < 0) continue;
                sum += e * e;
                ++places;
            }
        errors_[i] = static_cast<float>(std::sqrt(sum / places));
    });
    for_pixels([&](std::size_t, std::uint32_t i) { map_[i] = none; });
}

// The mean of now_, without what lamps in view add.
double SampleSchedule::typical_luminance() const {
    const auto count = static_cast<double>(now_.size());
    double mean = std::numeric_limits<double>::infinity();
    for (int round = 0; round < 4; ++round) {
        const double most = 4 * mean;
        mean = sum_in_ranges<double>(threads_, now_.size(),
                                     [&](std::size_t k) { return std::min(static_cast<double>(now_[k]), most); }) /
               count;
    }
    return mean;
}

void SampleSchedule::find_luminances(const Film& film, UntouchedVector<float>& luminances) const {
    luminances.resize(pixels_.size());
    for_pixels([&](std::size_t k, std::uint32_t i) { luminances[k] = static_cast<float>(film.luminance(i)); });
}

void SampleSchedule::advance(const Film& film) {
    find_luminances(film, now_);
    if (first_ == 0) {
        mean_ = typical_luminance();
        if (halves_) {
            before_.resize(pixels_.size());
            for_pixels([&](std::size_t k, std::uint32_t i) {
                before_[k] = static_cast<float>(static_cast<double>(now_[k]) + film.halves(i) / end_);
            });
            estimate_errors(end_ / 2);
        }  // else one mean, nothing to compare it with
    } else {
        estimate_errors(first_);
    }
    for_pixels([&](std::size_t, std::uint32_t i) { taken_[i] = end_; });
    choose(film);
}

bool SampleSchedule::wants_more(std::uint32_t pixel) const {
    const std::uint32_t most = counted_.empty() || counted_[pixel] != 0 ? spp_ : std::min(spp_, spared_spp_);
    const auto error = static_cast<double>(errors_[pixel]);
    return taken_[pixel] < most && (error < 0 || error > pixel_error_ * mean_);
}

// The next pass: of the pixels that want more samples those that have fewest.
void SampleSchedule::choose(const Film& film) {
    constexpr std::uint32_t none = 0xffffffffu;
    struct Wanting {
        std::uint32_t fewest = none, count = 0;  // of the range's pixels; so many have them
        std::size_t first = 0;                   // of these, in pixels_
    };
    std::vector<Wanting> ranges(range_count(taken_.size()));
    in_ranges(threads_, taken_.size(), [&](std::size_t range, std::size_t begin, std::size_t end) {
        Wanting w;
        for (std::size_t i = begin; i < end; ++i) {
            if (taken_[i] > w.fewest || !wants_more(static_cast<std::uint32_t>(i))) continue;
            if (taken_[i] < w.fewest) w = {taken_[i], 0, 0};
            ++w.count;
        }
        ranges[range] = w;
    });
    std::uint32_t fewest = none;
    for (const Wanting& w : ranges) fewest = std::min(fewest, w.fewest);
    std::size_t count = 0;
    for (Wanting& w : ranges) {
        w.first = count;
        if (w.fewest == fewest) count += w.count;
    }
    pixels_.resize(count);
    in_ranges(threads_, pixels_.empty() ? 0 : taken_.size(),
              [&](std::size_t range, std::size_t begin, std::size_t end) {
                  if (ranges[range].fewest != fewest) return;
                  std::size_t at = ranges[range].first;
                  for (std::size_t i = begin; i < end; ++i)
                      if (taken_[i] == fewest && wants_more(static_cast<std::uint32_t>(i)))
                          pixels_[at++] = static_cast<std::uint32_t>(i);
              });
    if (fewest == none) return;
    first_ = fewest;
    end_ = static_cast<std::uint32_t>(std::min<std::uint64_t>(std::uint64_t{2} * fewest, spp_));
    find_luminances(film, before_);
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
        const double error = std::max(static_cast<double>(errors_[i]), 0.0);
        sum += error * error;
    }
    return count > 0 && mean_ > 0 ? sum / count / (mean_ * mean_) : 0;
}

}  // namespace irradia
