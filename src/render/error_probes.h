// Probes: pixels at which the truth is estimated by paths that the picture knows nothing of, so that the picture's
// error can be estimated without bias (theory 8): for n independent estimates of mean x and variance s² of what pixel I
// ought to be, (I - x)² - s²/n is on average the pixel's squared error. What probes have found stays true when the
// picture is refined.
#pragma once
#include <array>
#include <cstdint>
#include <vector>

#include "irradia/ErrorReport.h"
#include "render/film.h"
#include "render/run.h"
#include "render/stratified_estimate.h"

namespace irradia {

class ErrorProbes {
public:
    /// Finds out where the present view shows lamps, and where `film` is likely to be wrong.
    ErrorProbes(Run& run, const Film& film);

    /// More pixels: `waves` times one in every stratum, each with as many batches of paths as the others have.
    void add_waves(std::size_t waves);
    /// More truth at the pixels that are there: until each has `batches`.
    void raise_batches(std::uint32_t batches);

    /// Those of a pilot, from which the rest is decided.
    [[nodiscard]] std::size_t first_waves() const;
    [[nodiscard]] std::size_t waves() const noexcept { return probes_.size() / places_.strata(); }
    [[nodiscard]] std::uint32_t batches() const noexcept { return batches_; }
    /// Mean variance of one batch's estimate, to the square of the truth's mean.
    [[nodiscard]] double batch_variance() const;
    /// What a batch has taken, on average, and all: of Run::effort().
    [[nodiscard]] double batch_effort() const;
    [[nodiscard]] double effort() const noexcept { return effort_; }

    /// 1 where a pixel counts: it shows no lamp.
    [[nodiscard]] const std::vector<std::uint8_t>& counted() const noexcept { return counted_; }

    /// The error of `film`, of the view that the probes were made for.
    [[nodiscard]] ErrorReport report(const Film& film) const;
    /// The mean squared error of report() and its standard error, both relative to the squared mean.
    [[nodiscard]] std::array<double, 2> squared_error(const Film& film) const;

    /// Of the same run's.
    void state(Checkpoint& checkpoint);

private:
    struct Probe {
        std::uint32_t pixel, stratum;
        double weight;                   // 1 / (number of counted pixels x density)
        std::array<double, 6> sum{};     // over batches: of means of direct, indirect RGB
        std::array<double, 9> square{};  // over batches: of squares of the same, and of both parts' sum
    };
    struct Residuals;

    /// Of the picture, over the pixels that count.
    [[nodiscard]] double picture_mean(const Film& film) const;
    [[nodiscard]] StratifiedPixels places(const Film& film) const;
    void trace(std::size_t first_probe, std::size_t count, std::uint32_t first_batch, std::uint32_t batches);
    [[nodiscard]] Residuals residuals(const Film& film) const;

    Run& run_;
    std::vector<std::uint8_t> counted_;
    double counted_pixels_;
    StratifiedPixels places_;  // made with those above
    std::vector<Probe> probes_;
    std::uint32_t batches_ = 2;
    std::uint64_t traced_ = 0;         // batches
    double seconds_ = 0, effort_ = 0;  // wall seconds; of Run::effort()
};

/// Probes of a finished picture for about `effort`: a few at first, from which it is chosen how the rest is divided
/// between more pixels and more paths a pixel (theory 8). `error`: relative error expected; 0 = what the first probes
/// find.
void spend(ErrorProbes& probes, const Film& film, double effort, double error = 0);

}  // namespace irradia
