#include "render/sample_schedule.h"

#include <algorithm>
#include <numeric>

namespace irradia {
namespace {
constexpr std::uint32_t first_pass = 8;  // samples: with as many again the first estimate is made
}

SampleSchedule::SampleSchedule(int width, int height, std::uint32_t spp, double pixel_error)
    : width_(width),
      height_(height),
      spp_(spp),
      end_(pixel_error > 0 ? std::min(spp, first_pass) : spp),
      pixel_error_(pixel_error),
      pixels_(static_cast<std::size_t>(width) * static_cast<std::size_t>(height)),
      before_(pixels_.size(), 0.0),
      taken_(pixels_.size(), 0),
      errors_(pixels_.size(), -1.0) {
    std::iota(pixels_.begin(), pixels_.end(), 0u);
}

// Two means a and b, of n0 and n1 independent samples, estimate the squared error of their common mean by
// (a - b)^2 n0 n1 / (n0 + n1)^2, on average without bias; of stratified samples it is too large, which is safe. One
// such estimate has one degree of freedom only: it is averaged over those of the 3x3 pixels around that take as many
// samples, which also lets an edge be found that a pixel's own samples have missed.
std::vector<double> SampleSchedule::squared_errors(const std::vector<double>& now) {
    constexpr double none = -1;
    map_.resize(static_cast<std::size_t>(width_) * static_cast<std::size_t>(height_), none);
    const double n0 = first_, n1 = end_ - first_, n = end_;
    for (std::size_t k = 0; k < pixels_.size(); ++k) {
        const double later = (now[k] * n - before_[k] * n0) / n1;
        map_[pixels_[k]] = (later - before_[k]) * (later - before_[k]) * n0 * n1 / (n * n);
    }
    std::vector<double> errors;
    errors.reserve(pixels_.size());
    for (const std::uint32_t i : pixels_) {
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
        errors.push_back(sum / places);
    }
    for (const std::uint32_t i : pixels_) map_[i] = none;
    return errors;
}

void SampleSchedule::advance(const Film& film) {
    std::vector<double> now(pixels_.size());
    for (std::size_t k = 0; k < now.size(); ++k) now[k] = film.luminance(pixels_[k]);
    if (first_ == 0) {  // one mean, nothing to compare it with; but the picture's mean, without what lamps in view add
        double mean = std::accumulate(now.begin(), now.end(), 0.0) / static_cast<double>(now.size());
        for (int round = 0; round < 3; ++round) {
            double sum = 0;
            for (const double l : now) sum += std::min(l, 4 * mean);
            mean = sum / static_cast<double>(now.size());
        }
        mean_ = mean;
    } else {
        const std::vector<double> errors = squared_errors(now);
        for (std::size_t k = 0; k < errors.size(); ++k) errors_[pixels_[k]] = errors[k];
    }
    for (const std::uint32_t i : pixels_) taken_[i] = end_;
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
    std::uint32_t fewest = none;
    pixels_.clear();
    for (std::uint32_t i = 0; i < taken_.size(); ++i) {
        if (taken_[i] > fewest || !wants_more(i)) continue;
        if (taken_[i] < fewest) pixels_.clear();
        fewest = taken_[i];
        pixels_.push_back(i);
    }
    if (fewest == none) return;
    first_ = fewest;
    end_ = static_cast<std::uint32_t>(std::min<std::uint64_t>(std::uint64_t{2} * fewest, spp_));
    before_.resize(pixels_.size());
    for (std::size_t k = 0; k < pixels_.size(); ++k) before_[k] = film.luminance(pixels_[k]);
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
    c(width_)(height_)(spp_)(first_)(end_)(spared_spp_)(pixel_error_)(mean_);
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
