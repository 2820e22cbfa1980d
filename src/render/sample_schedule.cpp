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
std::vector<double> SampleSchedule::squared_errors(const std::vector<double>& now) const {
    constexpr double none = -1;  // of pixels that are done
    std::vector<double> own(now.size(), none);
    const double n0 = first_, n1 = end_ - first_, n = end_;
    for (const std::uint32_t i : pixels_) {
        const double later = (now[i] * n - before_[i] * n0) / n1;
        own[i] = (later - before_[i]) * (later - before_[i]) * n0 * n1 / (n * n);
    }
    std::vector<double> errors;
    for (const std::uint32_t i : pixels_) {
        const int x = static_cast<int>(i) % width_, y = static_cast<int>(i) / width_;
        double sum = 0, places = 0;
        for (int v = std::max(y - 1, 0); v <= std::min(y + 1, height_ - 1); ++v)
            for (int u = std::max(x - 1, 0); u <= std::min(x + 1, width_ - 1); ++u) {
                const double e =
                    own[static_cast<std::size_t>(v) * static_cast<std::size_t>(width_) + static_cast<std::size_t>(u)];
                if (e == none) continue;
                sum += e;
                ++places;
            }
        errors.push_back(sum / places);
    }
    return errors;
}

void SampleSchedule::advance(const Film& film) {
    if (end_ >= spp_) {
        pixels_.clear();
        return;
    }
    std::vector<double> now(film.pixels());
    for (std::size_t i = 0; i < now.size(); ++i) now[i] = film.luminance(i);
    if (first_ > 0) {  // else it is one mean, nothing to compare it with
        // The picture's mean, without what lamps in view add to it.
        const double count = static_cast<double>(now.size());
        const double all = std::accumulate(now.begin(), now.end(), 0.0) / count;
        double mean = 0;
        for (const double l : now) mean += std::min(l, all) / count;
        const double allowed = pixel_error_ * mean * pixel_error_ * mean;
        const std::vector<double> errors = squared_errors(now);
        std::vector<std::uint32_t> left;
        for (std::size_t k = 0; k < errors.size(); ++k)
            if (errors[k] > allowed) left.push_back(pixels_[k]);
        pixels_ = std::move(left);
    }
    before_ = std::move(now);
    first_ = end_;
    end_ = std::min(2 * end_, spp_);
}

}  // namespace irradia
