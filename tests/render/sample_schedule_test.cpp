// Which pixels take more samples: on films of numbers whose noise is known, and in pictures.
#include "render/sample_schedule.h"

#include <cmath>
#include <random>

#include "room.h"

namespace irradia::test {
namespace {

constexpr int edge = 48;

/// Runs a schedule over a film whose pixel i draws samples of mean[i], standard deviation[i]; returns the film and the
/// samples that each pixel took.
struct Outcome {
    std::vector<double> luminance, samples;
    int passes = 0;
};

Outcome run(const std::vector<double>& mean, const std::vector<double>& deviation, std::uint32_t spp, double error,
            unsigned seed) {
    std::mt19937 random(seed);
    std::normal_distribution<double> normal;
    Film film(edge, edge, false);
    Outcome o;
    o.samples.assign(mean.size(), 0.0);
    SampleSchedule schedule(edge, edge, spp, error);
    for (; !schedule.pixels().empty(); schedule.advance(film), ++o.passes) {
        const std::uint32_t n = schedule.end() - schedule.first();
        std::vector<float> sums;
        for (const std::uint32_t i : schedule.pixels()) {
            const double sum = n * mean[i] + std::sqrt(double{1} * n) * deviation[i] * normal(random);
            for (const double share : {.75, .75, .75, .25, .25, .25}) sums.push_back(static_cast<float>(sum * share));
            o.samples[i] += n;
        }
        film.add(sums, schedule.pixels(), n);
    }
    for (std::size_t i = 0; i < mean.size(); ++i) o.luminance.push_back(film.luminance(i));
    return o;
}

TEST(SampleSchedule, WithoutAnErrorAllPixelsTakeAllSamplesAtOnce) {
    const std::vector<double> ones(edge * edge, 1.0);
    const Outcome o = run(ones, ones, 100, 0, 1);
    EXPECT_EQ(o.passes, 1);
    for (const double n : o.samples) EXPECT_EQ(n, 100);
}

// Pixels of standard deviation s want (s / E)^2 samples; a pass doubles them, so they take up to twice as many, and the
// estimate of nine pixels scatters.
TEST(SampleSchedule, SamplesGoWhereTheNoiseIsAndTheErrorIsWhatWasAllowed) {
    std::vector<double> mean(edge * edge, 2.0), deviation(edge * edge);
    for (std::size_t i = 0; i < deviation.size(); ++i) deviation[i] = i % edge < edge / 2 ? .02 : 1.6;
    constexpr double allowed = .05;  // of the mean 2: .1, so 256 samples on the right
    double squares = 0, quiet = 0, noisy = 0, count = 0;
    for (unsigned seed = 1; seed <= 4; ++seed) {
        const Outcome o = run(mean, deviation, 1 << 16, allowed, seed);
        for (std::size_t i = 0; i < mean.size(); ++i) {
            const std::size_t x = i % edge;
            if (x < edge / 2 - 2) quiet = std::max(quiet, o.samples[i]);
            if (x <= edge / 2 + 1) continue;
            noisy += o.samples[i];
            squares += std::pow(o.luminance[i] - 2, 2);
            ++count;
        }
    }
    EXPECT_EQ(quiet, 16);  // the least
    EXPECT_GT(noisy / count, 256 * .6);
    EXPECT_LT(noisy / count, 256 * 2.);
    EXPECT_LE(std::sqrt(squares / count), 1.15 * allowed * 2);  // pixels stop where the estimate happens to be low
    EXPECT_GE(std::sqrt(squares / count), .5 * allowed * 2);
}

TEST(SampleSchedule, NoPixelTakesMoreThanAllSamples) {
    const std::vector<double> mean(edge * edge, 1.0), deviation(edge * edge, 100.0);
    const Outcome o = run(mean, deviation, 100, .01, 5);
    for (const double n : o.samples) EXPECT_EQ(n, 100);
}

// One pixel whose noise is seen draws those around it along, also where theirs was not.
TEST(SampleSchedule, NeighboursOfANoisyPixelGoOn) {
    std::vector<double> mean(edge * edge, 1.0), deviation(edge * edge, 0.0);
    const std::size_t centre = edge * edge / 2 + edge / 2;
    deviation[centre] = 10;
    int all = 0, neighbours = 0;  // a pixel's halves may agree by chance, once in twenty
    for (unsigned seed = 1; seed <= 40; ++seed) {
        const Outcome o = run(mean, deviation, 1024, .01, seed);
        all += o.samples[centre] == 1024;
        for (const std::ptrdiff_t step : {-1, 1, -edge, edge})
            neighbours += o.samples[static_cast<std::size_t>(static_cast<std::ptrdiff_t>(centre) + step)] >= 64;
        EXPECT_EQ(o.samples[centre + 5], 16);
    }
    EXPECT_GE(all, 30);
    EXPECT_GE(neighbours, 4 * 30);
}

// A lamp in view, 1000 times as bright as the rest, does not make the rest's error look small.
TEST(SampleSchedule, ALampInViewDoesNotCount) {
    std::vector<double> mean(edge * edge, 1.0), deviation(edge * edge, 1.0);
    for (std::size_t i = 0; i < 16; ++i) mean[i] = 1000;
    const Outcome with = run(mean, deviation, 1 << 14, .1, 9);
    for (std::size_t i = 0; i < 16; ++i) mean[i] = 1;
    const Outcome without = run(mean, deviation, 1 << 14, .1, 9);
    double a = 0, b = 0;
    for (std::size_t i = edge * 4; i < mean.size(); ++i) a += with.samples[i], b += without.samples[i];
    EXPECT_GT(a, .8 * b);  // by the plain mean, 7.9, it would be the least, an eighth
}

// What is allowed later on is taken from the samples that are there: the same numbers as if it had been allowed at
// once.
TEST(SampleSchedule, LessMayBeAllowedLaterOn) {
    std::vector<double> deviation(edge * edge);
    for (std::size_t i = 0; i < deviation.size(); ++i) deviation[i] = i % edge < edge / 2 ? .05 : .8;
    std::mt19937 random(5);
    std::normal_distribution<double> normal;
    Film film(edge, edge, false);
    SampleSchedule schedule(edge, edge, 1 << 12, .1);
    std::vector<double> taken(deviation.size(), 0.0);
    const auto sample = [&] {
        for (; !schedule.pixels().empty(); schedule.advance(film)) {
            const std::uint32_t n = schedule.end() - schedule.first();
            std::vector<float> sums;
            for (const std::uint32_t i : schedule.pixels()) {
                EXPECT_EQ(taken[i], schedule.first());  // no sample is taken twice, none is left out
                taken[i] += n;
                const double sum = n + std::sqrt(double{1} * n) * deviation[i] * normal(random);
                for (const double share : {1., 1., 1., 0., 0., 0.}) sums.push_back(static_cast<float>(sum * share));
            }
            film.add(sums, schedule.pixels(), n);
        }
    };
    const auto noise = [&] {  // true mean squared error of the film's pixels
        double square = 0;
        for (std::size_t i = 0; i < taken.size(); ++i) square += (film.luminance(i) - 1) * (film.luminance(i) - 1);
        return square / static_cast<double>(taken.size());
    };
    sample();
    EXPECT_LE(std::sqrt(noise()), .1);
    // Too low: pixels stop where they are estimated so by chance.
    EXPECT_LT(schedule.squared_noise(), noise());
    EXPECT_GT(schedule.squared_noise(), .4 * noise());
    const std::vector<double> before = taken;
    schedule.allow(film, 1 << 12, .025);
    sample();
    EXPECT_LE(std::sqrt(noise()), .025);
    // Too low: pixels stop where they are estimated so by chance.
    EXPECT_LT(schedule.squared_noise(), noise());
    EXPECT_GT(schedule.squared_noise(), .4 * noise());
    double quiet = 0, noisy = 0;
    for (std::size_t i = 0; i < taken.size(); ++i) {
        EXPECT_GE(taken[i], before[i]);
        (i % edge < edge / 2 ? quiet : noisy) += taken[i] / (edge * edge / 2);
    }
    EXPECT_LT(quiet, 64);
    EXPECT_GT(noisy, 500);  // (.8 / .025)^2 = 1024, doubled at most, and stopped early by chance
}

// In a picture: the error against one with all samples is what was allowed, at a fraction of the samples, and the mean
// is the same. (The records are the same too: what differs is samples alone.)
TEST(SampleSchedule, PicturesTakeFewerSamplesAtTheErrorAllowed) {
    const Scene scene = load_text(room(grey_floor, ""));
    Device device({});
    RenderSettings s;
    s.spp = 512;
    const RenderResult all = render(scene, device, s);
    EXPECT_EQ(all.statistics.mean_spp, 512);
    for (const float error : {.05f, .02f}) {
        s.pixel_error = error;
        const RenderResult some = render(scene, device, s);
        EXPECT_LT(some.statistics.mean_spp, 512 * .4);
        EXPECT_GE(some.statistics.mean_spp, 16);
        const auto &a = some.image.layers[0].data, &b = all.image.layers[0].data;
        double square = 0, difference = 0, clipped = 0, n = 0, sum = 0;
        for (const float x : b) sum += static_cast<double>(x) / static_cast<double>(b.size());
        for (std::size_t i = 0; i < a.size(); ++i) {
            const double x = static_cast<double>(a[i]), y = static_cast<double>(b[i]);
            clipped += std::min(y, sum);
            if (y > 4 * sum) continue;  // the lamp and its edge
            square += (x - y) * (x - y);
            difference += x - y;
            ++n;
        }
        const double mean = clipped / static_cast<double>(a.size());
        EXPECT_LE(std::sqrt(square / n) / mean, static_cast<double>(error)) << error;
        EXPECT_LE(std::abs(difference / n) / mean, .1 * static_cast<double>(error)) << error;
    }
}

}  // namespace
}  // namespace irradia::test
