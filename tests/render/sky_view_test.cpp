// Light samples of a sky by what is seen of it, in whole pictures: the same means as without, and less noise. A room
// with a window against path tracing, which does not learn.
#include "room.h"

namespace irradia::test {
namespace {

RenderSettings settings_of(Method method, bool learn, int spp) {
    RenderSettings s;
    s.method = method;
    s.learn_sky = learn;
    s.spp = spp;
    return s;
}

/// Means of the green of `parts` pictures of other seeds, and half of the mean square of the difference of neighbours
/// among them: the variance of a picture.
struct Pictures {
    double mean = 0, error = 0, variance = 0;
};
Pictures pictures(const Scene& scene, RenderSettings s, int parts) {
    Pictures p;
    std::vector<double> means;
    Image before;
    for (int i = 0; i < parts; ++i) {
        s.seed = static_cast<unsigned>(7 + i);
        Image image = run(scene, s).image;
        means.push_back(channel_mean(image, 1).mean);
        p.mean += means.back() / parts;
        if (i % 2 == 1) {
            const auto &a = before.layers[0].data, &b = image.layers[0].data;
            for (std::size_t k = 0; k < a.size(); ++k) {
                const double d = static_cast<double>(a[k]) - static_cast<double>(b[k]);
                p.variance += 0.5 * d * d / (static_cast<double>(a.size()) * (parts / 2));
            }
        }
        before = std::move(image);
    }
    for (const double m : means) p.error += (m - p.mean) * (m - p.mean) / (parts * (parts - 1.0));
    p.error = std::sqrt(p.error);
    return p;
}

// Direct light alone, which is unbiased by every method.
TEST(SkyView, DirectLightThroughAWindowHasTheSameMeanAndLessNoise) {
    const Scene scene = load_text(window_room(48));
    const auto direct = [](RenderSettings s) {
        s.max_depth = 2;
        return s;
    };
    const Pictures path = pictures(scene, direct(settings_of(Method::path, false, 256)), 8);
    const Pictures plain = pictures(scene, direct(settings_of(Method::irradiance, false, 64)), 8);
    const Pictures learned = pictures(scene, direct(settings_of(Method::irradiance, true, 64)), 8);
    std::printf("direct: path %.5f +- %.5f, plain %.5f +- %.5f, learned %.5f +- %.5f; variance %.3g, learned %.3g\n",
                path.mean, path.error, plain.mean, plain.error, learned.mean, learned.error, plain.variance,
                learned.variance);
    EXPECT_NEAR(learned.mean, path.mean, 4 * std::hypot(learned.error, path.error));
    EXPECT_NEAR(plain.mean, path.mean, 4 * std::hypot(plain.error, path.error));
    EXPECT_LT(learned.error, 0.005 * path.mean);  // or the above says little
    EXPECT_LT(learned.variance, 0.6 * plain.variance);
}

// All light: hemispheres, the grid's paths, and what goes on as paths sample the same sky. 1 %: what the cache may err
// by.
TEST(SkyView, AllLightThroughAWindowHasTheSameMean) {
    const Scene scene = load_text(window_room(48));
    const Pictures path = pictures(scene, settings_of(Method::path, false, 256), 4);
    const Pictures learned = pictures(scene, settings_of(Method::irradiance, true, 64), 4);
    std::printf("all: path %.5f +- %.5f, learned %.5f +- %.5f\n", path.mean, path.error, learned.mean, learned.error);
    EXPECT_NEAR(learned.mean, path.mean, 4 * std::hypot(learned.error, path.error) + 0.01 * path.mean);
}

// Whatever is switched off, or cannot be learned: the pictures without.
TEST(SkyView, ChangesNothingWhereNothingIsLearned) {
    const Scene scene = load_text(window_room(24));
    RenderSettings path = settings_of(Method::path, true, 8);
    const auto by_path = run(scene, path).image.layers[0].data;
    path.learn_sky = false;
    EXPECT_EQ(by_path, run(scene, path).image.layers[0].data);
    const RenderResult off = run(scene, settings_of(Method::irradiance, false, 64));
    const RenderResult on = run(scene, settings_of(Method::irradiance, true, 64));
    EXPECT_EQ(off.statistics.stages.count("learn_sky"), 0u);
    EXPECT_EQ(on.statistics.stages.count("learn_sky"), 1u);
    EXPECT_NE(off.image.layers[0].data, on.image.layers[0].data);
    const Scene box = load(project_scene("cornell-box.xml"), {}, 24, 24);
    const RenderResult lamp = run(box, settings_of(Method::irradiance, true, 4));
    EXPECT_EQ(lamp.statistics.stages.count("learn_sky"), 0u);
}

}  // namespace
}  // namespace irradia::test
