#include "render/error_probes.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <random>
#include <span>

#include "core/in_ranges.h"
#include "render/lamps.h"

namespace irradia {
namespace {

constexpr std::uint32_t samples_a_batch = 32;  // on one set of Sobol points
constexpr std::size_t strata = 64;
constexpr std::size_t first_waves_cpu = 4, first_waves_gpu = 64;  // GPUs take as long for either
constexpr std::uint32_t most_batches = 256;
constexpr std::size_t items_a_launch_cpu = 1u << 12, items_a_launch_gpu = 1u << 17;

/// How a pixel's luminance differs from those around it.
struct Contrast {
    double stands_out, range;  // from the mean of its eight neighbours; of all within two pixels
};

Contrast contrast(std::span<const double> luminance, int width, int height, int x, int y) {
    const auto at = [&](int u, int v) {
        return luminance[static_cast<std::size_t>(v) * static_cast<std::size_t>(width) + static_cast<std::size_t>(u)];
    };
    double around = 0, places = 0, lowest = at(x, y), highest = lowest;
    for (int v = std::max(y - 2, 0); v <= std::min(y + 2, height - 1); ++v)
        for (int u = std::max(x - 2, 0); u <= std::min(x + 2, width - 1); ++u) {
            const double l = at(u, v);
            lowest = std::min(lowest, l);
            highest = std::max(highest, l);
            if (std::abs(u - x) > 1 || std::abs(v - y) > 1 || (u == x && v == y)) continue;
            around += l;
            places += 1;
        }
    return {places > 0 ? std::abs(at(x, y) - around / places) : 0, highest - lowest};
}

}  // namespace

double ErrorProbes::picture_mean(const Film& film) const {
    const auto of_pixel = [&](std::size_t i) {
        double sum = 0;
        for (std::size_t c = 0; counted_[i] != 0 && c < 3; ++c) sum += film.mean(i, c) + film.mean(i, 3 + c);
        return sum;
    };
    return sum_in_ranges<double>(run_.device.host_threads(), counted_.size(), of_pixel) / (3 * counted_pixels_);
}

// Where errors of noise and of interpolation are likely: a mixture of even density, of pixels that stand out from
// their neighbours, and of pixels near edges. A lamp next to a pixel counts as an edge, but as no brighter one.
StratifiedPixels ErrorProbes::places(const Film& film) const {
    const int width = static_cast<int>(run_.scene.info.width), height = static_cast<int>(run_.scene.info.height);
    const int threads = run_.device.host_threads();
    const double brightest = 4 * picture_mean(film);
    UntouchedVector<double> luminance(film.pixels());
    in_ranges(threads, luminance.size(), [&](std::size_t, std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) luminance[i] = std::min(film.luminance(i), brightest);
    });
    UntouchedVector<Contrast> contrasts(film.pixels());
    in_ranges(threads, contrasts.size(), [&](std::size_t, std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i)
            contrasts[i] = counted_[i] != 0 ? contrast(luminance, width, height, static_cast<int>(i) % width,
                                                       static_cast<int>(i) / width)
                                            : Contrast{0, 0};
    });
    const auto sum = [&](const auto& f) {
        return sum_in_ranges<double>(threads, contrasts.size(), [&](std::size_t i) { return f(contrasts[i]); });
    };
    const double stands_out = sum([](const Contrast& c) { return c.stands_out; });
    const double square = sum([](const Contrast& c) { return c.stands_out * c.stands_out; });
    const double range = sum([](const Contrast& c) { return c.range; });
    UntouchedVector<double> weights(film.pixels());
    in_ranges(threads, weights.size(), [&](std::size_t, std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) {
            const Contrast& c = contrasts[i];
            weights[i] = counted_[i] != 0 ? 1 / counted_pixels_ : 0;
            if (counted_[i] != 0 && stands_out > 0)
                weights[i] = 0.3 * weights[i] + 0.2 * c.stands_out / stands_out +
                             0.25 * c.stands_out * c.stands_out / square + 0.25 * c.range / range;
        }
    });
    return {std::span<const double>(weights), strata, threads};
}

ErrorProbes::ErrorProbes(Run& run, const Film& film)
    : run_(run),
      counted_(pixels_without_lamps(run)),
      counted_pixels_(static_cast<double>(std::count(counted_.begin(), counted_.end(), 1))),
      places_(places(film)) {}

void ErrorProbes::state(Checkpoint& c) {
    c(counted_)(counted_pixels_)(probes_)(batches_)(traced_)(seconds_)(effort_);
    places_.state(c);
}

std::size_t ErrorProbes::first_waves() const {
    return run_.device.description().is_cpu ? first_waves_cpu : first_waves_gpu;
}

// Progress is reported, which may end the search, only where nothing is half done.
void ErrorProbes::add_waves(std::size_t waves) {
    run_.rest();
    run_.report("probes", 1);
    const std::size_t first = probes_.size();
    // A generator of its own a wave, so that probes do not depend on how many are asked for at once.
    for (std::size_t wave = 0; wave < waves; ++wave) {
        std::mt19937_64 random(run_.settings.seed * 0x9e3779b97f4a7c15ull + (first / strata + wave + 1));
        std::uniform_real_distribution<double> uniform(0.0, 1.0);
        for (std::size_t s = 0; s < strata; ++s) {
            const StratifiedPixels::Pixel p = places_.draw(s, uniform(random));
            probes_.push_back({p.index, static_cast<std::uint32_t>(s), 1 / (counted_pixels_ * p.density), {}, {}});
        }
    }
    trace(first, probes_.size() - first, 0, batches_);
}

void ErrorProbes::raise_batches(std::uint32_t batches) {
    if (batches <= batches_) return;
    run_.rest();
    run_.report("probes", 1);
    trace(0, probes_.size(), batches_, batches - batches_);
    batches_ = batches;
}

void ErrorProbes::trace(std::size_t first_probe, std::size_t count, std::uint32_t first_batch, std::uint32_t batches) {
    const auto began = std::chrono::steady_clock::now();
    const double spent = run_.effort();
    std::vector<std::uint32_t> pixels;
    for (const Probe& p : probes_) pixels.push_back(p.pixel);
    const Buffer list = run_.device.upload(pixels);
    const std::size_t items = run_.device.cpu_traversal() ? items_a_launch_cpu : items_a_launch_gpu;
    const std::size_t chunk = std::max<std::size_t>(items / batches, 1), group = run_.device.pixel_group();
    const Buffer buffer = run_.device.allocate(std::min(chunk, count) * batches * 6 * sizeof(float));
    std::vector<float> sums(std::min(chunk, count) * batches * 6);
    for (std::size_t first = 0; first < count; first += chunk) {
        const std::size_t n = std::min(chunk, count - first);
        run_.scene_kernel("probe_pixels.cl", "probe_pixels", {})
            .arg(list)
            .arg(buffer)
            .arg(run_.ray_counters())
            .arg(static_cast<std::uint32_t>(n * batches))
            .arg(static_cast<std::uint32_t>(first_probe + first))
            .arg(first_batch)
            .arg(batches)
            .arg(samples_a_batch)
            .arg(run_.edges_beyond_camera())
            .arg(run_.seed())
            .run(group_count(n * batches, group), group);
        run_.device.read(buffer, sums.data(), n * batches * 6 * sizeof(float));
        run_.collect_rays();
        for (std::size_t i = 0; i < n; ++i) {
            Probe& p = probes_[first_probe + first + i];
            for (std::size_t b = 0; b < batches; ++b) {
                const float* from = &sums[(i * batches + b) * 6];
                double x[9];
                for (std::size_t c = 0; c < 6; ++c) x[c] = static_cast<double>(from[c]) / samples_a_batch;
                for (std::size_t c = 0; c < 3; ++c) x[6 + c] = x[c] + x[3 + c];
                for (std::size_t c = 0; c < 6; ++c) p.sum[c] += x[c];
                for (std::size_t c = 0; c < 9; ++c) p.square[c] += x[c] * x[c];
            }
        }
    }
    traced_ += count * batches;
    seconds_ += std::chrono::duration<double>(std::chrono::steady_clock::now() - began).count();
    effort_ += run_.effort() - spent;
}

double ErrorProbes::batch_effort() const { return traced_ > 0 ? effort_ / static_cast<double>(traced_) : 0; }

// What all figures are made of, a draw a probe: squared errors of the whole and of both parts, errors, and variances of
// the probes' means.
struct ErrorProbes::Residuals {
    std::vector<Draw> square, direct, indirect, difference, variance;
};

ErrorProbes::Residuals ErrorProbes::residuals(const Film& film) const {
    Residuals r;
    const double n = batches_;
    for (const Probe& p : probes_) {
        double square[3] = {}, difference = 0, variance = 0;  // whole, direct, indirect
        for (std::size_t c = 0; c < 3; ++c) {
            const double mean[3] = {(p.sum[c] + p.sum[3 + c]) / n, p.sum[c] / n, p.sum[3 + c] / n};
            const double shown[3] = {film.mean(p.pixel, c) + film.mean(p.pixel, 3 + c), film.mean(p.pixel, c),
                                     film.mean(p.pixel, 3 + c)};
            const double squares[3] = {p.square[6 + c], p.square[c], p.square[3 + c]};
            for (std::size_t k = 0; k < 3; ++k) {
                const double of_mean = std::max(squares[k] / n - mean[k] * mean[k], 0.0) / (n - 1);  // s²/n
                square[k] += ((shown[k] - mean[k]) * (shown[k] - mean[k]) - of_mean) / 3;
                if (k == 0) variance += of_mean / 3;
            }
            difference += (shown[0] - mean[0]) / 3;
        }
        r.square.push_back({p.stratum, square[0] * p.weight});
        r.direct.push_back({p.stratum, square[1] * p.weight});
        r.indirect.push_back({p.stratum, square[2] * p.weight});
        r.difference.push_back({p.stratum, difference * p.weight});
        r.variance.push_back({p.stratum, variance * p.weight});
    }
    return r;
}

double ErrorProbes::batch_variance() const {
    double variance = 0, mean = 0;
    const double n = batches_;
    for (const Probe& p : probes_)
        for (std::size_t c = 0; c < 3; ++c) {
            const double m = (p.sum[c] + p.sum[3 + c]) / n;
            variance += p.weight * std::max(p.square[6 + c] / n - m * m, 0.0) * n / (n - 1);
            mean += p.weight * m;
        }
    const double count = 3.0 * static_cast<double>(probes_.size());
    return mean > 0 ? variance / count / (mean / count * (mean / count)) : 0;
}

std::array<double, 2> ErrorProbes::squared_error(const Film& film) const {
    const Residuals r = residuals(film);
    const double truth = std::max(picture_mean(film) - stratified_estimate(places_.strata(), r.difference).mean, 1e-30);
    const Estimate square = stratified_estimate(places_.strata(), r.square);
    return {square.mean / (truth * truth), square.deviation / (truth * truth)};
}

ErrorReport ErrorProbes::report(const Film& film) const {
    const Residuals r = residuals(film);
    const std::size_t parts = places_.strata();
    const auto estimate = [&](const std::vector<Draw>& draws) { return stratified_estimate(parts, draws); };
    ErrorReport e;
    const Estimate bias = estimate(r.difference), square = estimate(r.square), variance = estimate(r.variance);
    const double truth = std::max(picture_mean(film) - bias.mean, 1e-30);
    const auto root = [&](double x) { return std::sqrt(std::max(x, 0.0)) / truth; };
    const Interval b = interval_of(bias), s = interval_of_squares(square);
    e.mean_bias = {b.value / truth, b.low / truth, b.high / truth};
    e.rel_rmse = {root(s.value), root(s.low), root(s.high)};
    e.direct_rel_rmse = root(estimate(r.direct).mean);
    e.indirect_rel_rmse = root(estimate(r.indirect).mean);
    e.counted = counted_pixels_ / static_cast<double>(film.pixels());
    e.probes = probes_.size();
    e.paths = traced_ * samples_a_batch;
    e.seconds = seconds_;
    // A mean that hangs on one draw may well have missed others like it.
    if (square.largest_share > 0.25)
        e.doubt = "a single probe makes up most of the error: there may be rare, much larger errors";
    else if (variance.largest_share > 0.5)
        e.doubt = "at a few probes the truth itself is uncertain: light comes by rare bright paths";
    return e;
}

void spend(ErrorProbes& probes, const Film& film, double effort, double error) {
    const double began = probes.effort();
    if (probes.waves() == 0) probes.add_waves(probes.first_waves());
    for (const double share : {0.4, 1.0}) {
        // A mean's variance at a given cost is least where n batches a pixel bring the noise to a part of the error
        // looked for: n = (s/e)² sqrt(2/(kurtosis - 1)), for a kurtosis of about 10 of the errors (theory 8). The error
        // found by few probes is itself uncertain: take what it may well be.
        const std::array<double, 2> found = probes.squared_error(film);
        const double square = error > 0 ? error * error : std::max({found[0], 0.5 * found[1], 1e-12});
        const double wanted = 0.47 * probes.batch_variance() / square;
        const double left = share * effort - (probes.effort() - began);
        const double a_batch = std::max(probes.batch_effort(), 1e-9);
        const double affordable =
            left / a_batch / static_cast<double>(strata * probes.waves()) + static_cast<double>(probes.batches());
        probes.raise_batches(
            static_cast<std::uint32_t>(std::clamp(std::min(wanted, affordable), 2.0, double{most_batches})));
        const double wave = a_batch * static_cast<double>(strata) * probes.batches();
        const auto waves = static_cast<std::int64_t>((share * effort - (probes.effort() - began)) / wave);
        if (waves > 0) probes.add_waves(static_cast<std::size_t>(waves));
    }
}

}  // namespace irradia
