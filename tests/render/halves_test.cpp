// A first pass that tells the luminances of its two halves apart, so that it needs no second one to know its noise.
#include <cmath>
#include <random>
#include <string>
#include <vector>

#include "render/film.h"
#include "render/methods.h"
#include "render/run.h"
#include "render/sample_schedule.h"
#include "room.h"

namespace irradia::test {
namespace {

const ProgressCallback no_progress;

double luminance_of(const float* sums) {
    const auto channel = [&](int c) { return static_cast<double>(sums[c]) + static_cast<double>(sums[3 + c]); };
    return 0.2126 * channel(0) + 0.7152 * channel(1) + 0.0722 * channel(2);
}

// The same numbers in one pass of 16 and in two of 8: the same pixels go on, and the noise is estimated alike.
TEST(Halves, OnePassChoosesAsTwoPassesDo) {
    constexpr int edge = 48;
    constexpr std::size_t pixels = edge * edge;
    std::mt19937 random(3);
    std::normal_distribution<double> normal;
    std::vector<std::vector<float>> halves(2);
    for (std::vector<float>& sums : halves)
        for (std::size_t i = 0; i < pixels; ++i) {
            const double deviation = i % edge < edge / 2 ? .05 : .8;
            for (int c = 0; c < 6; ++c)
                sums.push_back(static_cast<float>(4 + std::sqrt(8.0) * deviation * normal(random)));
        }
    Film one(edge, edge, false), two(edge, edge, false);
    SampleSchedule at_once(edge, edge, 1024, .1, 1, true), in_two(edge, edge, 1024, .1);

    EXPECT_FALSE(in_two.halves());
    for (const std::uint32_t end : {8u, 16u}) {
        EXPECT_EQ(in_two.first(), end - 8);
        EXPECT_EQ(in_two.end(), end);
        EXPECT_EQ(in_two.pixels().size(), pixels);
        two.add(halves[end / 8 - 1], in_two.pixels(), 8);
        in_two.advance(two);
    }

    EXPECT_TRUE(at_once.halves());
    EXPECT_EQ(at_once.first(), 0u);
    EXPECT_EQ(at_once.end(), 16u);
    std::vector<float> sums, differences;
    for (std::size_t i = 0; i < pixels; ++i) {
        for (std::size_t c = 0; c < 6; ++c) sums.push_back(halves[0][6 * i + c] + halves[1][6 * i + c]);
        differences.push_back(static_cast<float>(luminance_of(&halves[0][6 * i]) - luminance_of(&halves[1][6 * i])));
    }
    one.add(sums, at_once.pixels(), 16);
    one.set_halves(differences, at_once.pixels());
    at_once.advance(one);

    EXPECT_FALSE(at_once.halves());
    EXPECT_GT(at_once.pixels().size(), pixels / 3);
    EXPECT_LT(at_once.pixels().size(), pixels * 2 / 3);
    EXPECT_EQ(at_once.pixels(), in_two.pixels());
    EXPECT_EQ(at_once.first(), 16u);
    EXPECT_EQ(at_once.end(), 32u);
    // The picture's mean is that of 16 samples for one, of 8 for the other.
    EXPECT_NEAR(at_once.squared_noise(), in_two.squared_noise(), .02 * in_two.squared_noise());
}

TEST(Halves, FewerSamplesThanTwoHalvesAreOnePassOfEight) {
    for (const auto& [spp, end] : {std::pair{4u, 4u}, {8u, 8u}, {15u, 8u}, {16u, 16u}, {100u, 16u}}) {
        SampleSchedule schedule(8, 8, spp, .1, 1, true);
        EXPECT_EQ(schedule.end(), end);
        EXPECT_EQ(schedule.halves(), spp >= 16);
    }
    EXPECT_FALSE(SampleSchedule(8, 8, 64, 0, 1, true).halves());
}

Film film_of(const Scene& scene, Device& device, RenderSettings settings) {
    Run run(scene, device, settings, no_progress);
    Film film(static_cast<int>(scene.info.width), static_cast<int>(scene.info.height), run.aovs(),
              device.host_threads());
    CachingRenderer(run).render(film);
    return film;
}

struct HalvesOf {
    const char* name;
    std::string floor, things;
    Method method;
    int max_depth;
    bool aovs;
    double bound;  ///< of the mean difference (root of squares), relative to the mean luminance
};

class HalvesOfPictures : public ::testing::TestWithParam<HalvesOf> {};

// The first half of 16 samples is what a picture of 8 samples has: to rounding where no record is asked. Where records
// answer, a pixel's samples share look-ups at their centroid, which is another for 8 of them.
TEST_P(HalvesOfPictures, TheFirstIsThePictureOfHalfTheSamples) {
    const HalvesOf& h = GetParam();
    const Scene scene = load_text(room(h.floor, h.things));
    Device device({});
    if (device.tile() == 1) GTEST_SKIP() << "takes samples one by one";
    RenderSettings s;
    s.method = h.method;
    s.max_depth = h.max_depth;
    if (h.aovs) s.aovs = {"albedo", "normal", "depth"};
    s.spp = 16;
    s.pixel_error = .05f;
    const Film both = film_of(scene, device, s);
    s.pixel_error = 0;
    const Film whole = film_of(scene, device, s);
    s.spp = 8;
    const Film first = film_of(scene, device, s);

    double mean = 0, square = 0, apart = 0;
    for (std::size_t i = 0; i < both.pixels(); ++i) {
        const double luminance = both.luminance(i);
        ASSERT_EQ(both.samples(static_cast<std::uint32_t>(i)), 16u);
        ASSERT_NEAR(luminance, whole.luminance(i), 2e-6 * luminance);  // to the rounding of two sums
        const double difference = luminance + both.halves(i) / 16 - first.luminance(i);
        square += difference * difference;
        apart += std::pow(both.halves(i) / 16, 2);
        mean += luminance / static_cast<double>(both.pixels());
    }
    EXPECT_GT(std::sqrt(apart), 20 * std::sqrt(square));  // there is something to tell
    EXPECT_LT(std::sqrt(square / static_cast<double>(both.pixels())), h.bound * mean);
}

const std::string metal = R"(<bsdf type="twosided"><bsdf type="roughconductor"><string name="material" value="Cu"/>
    <float name="alpha" value=".3"/></bsdf></bsdf>)";

INSTANTIATE_TEST_SUITE_P(Scenes, HalvesOfPictures,
                         ::testing::Values(HalvesOf{"direct", grey_floor, "", Method::irradiance, 2, false, 1e-6},
                                           HalvesOf{"layers", grey_floor, "", Method::irradiance, 2, true, 1e-6},
                                           HalvesOf{"irradiance", grey_floor, "", Method::irradiance, -1, false, 2e-3},
                                           HalvesOf{"radiance", metal, "", Method::radiance, -1, false, 2e-3}),
                         [](const auto& p) { return std::string(p.param.name); });

}  // namespace
}  // namespace irradia::test
