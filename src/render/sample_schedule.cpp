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
      pixels_(static_cast<std::size_t>(width) * static_cast<std::size_t>(height)) {
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
    if (end_ >= spp_) {
        pixels_.clear();
        return;
    }
    std::vector<double> now(pixels_.size());
    for (std::size_t k = 0; k < now.size(); ++k) now[k] = film.luminance(pixels_[k]);
    if (first_ == 0) {  // one mean, nothing to compare it with; but the picture's mean, without what lamps in view add
        double mean = std::accumulate(now.begin(), now.end(), 0.0) / static_cast<double>(now.size());
        for (int round = 0; round < 3; ++round) {
            double sum = 0;
            for (const double l : now) sum += std::min(l, 4 * mean);
            mean = sum / static_cast<double>(now.size());
        }
        allowed_ = pixel_error_ * mean * pixel_error_ * mean;
        before_ = std::move(now);
    } else {
        const std::vector<double> errors = squared_errors(now);
        std::size_t left = 0;
        for (std::size_t k = 0; k < errors.size(); ++k)
            if (errors[k] > allowed_) {
                pixels_[left] = pixels_[k];
                now[left++] = now[k];
            }
        pixels_.resize(left);
        now.resize(left);
        before_ = std::move(now);
    }
    first_ = end_;
    end_ = std::min(2 * end_, spp_);
}

}  // namespace irradia
