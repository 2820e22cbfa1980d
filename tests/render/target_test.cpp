// Searches for a picture of at most a given error: what they find has it, and they end.
#include <cmath>

#include "irradia/Error.h"
#include "render/methods.h"
#include "truth.h"

namespace irradia::test {
namespace {

TEST(TargetError, IsMet) {
    const Scene scene = load_text(room(grey_floor, ""));
    Device device({});
    const Truth truth(scene, device, 4096);
    for (const Method method : {Method::irradiance, Method::path}) {
        RenderSettings s;
        s.method = method;
        s.target_error = method == Method::path ? .06f : .025f;
        const RenderResult result = render(scene, device, s);
        ASSERT_TRUE(result.error.has_value());
        EXPECT_TRUE(result.error->reached);
        EXPECT_GE(result.error->steps, 1);
        EXPECT_LE(result.error->rel_rmse.high, static_cast<double>(s.target_error));
        EXPECT_LE(truth.error(result.image), static_cast<double>(s.target_error));
        EXPECT_GE(truth.error(result.image), .2 * static_cast<double>(s.target_error));  // not by far too much
    }
}

// Few probes of a good picture may say that it is not: another look is worth more of them, as a better picture costs
// more than all that could be looked at. Of these seeds searches went on to the highest level, and gave up there.
TEST(TargetError, GoodPicturesAreLookedAtAgain) {
    const Scene scene = load_text(room(grey_floor, ""));
    Device device({});
    const Truth truth(scene, device, 4096);  // whose noise makes the error uncertain by a twentieth
    for (const unsigned seed : {5u, 10u}) {
        RenderSettings s;
        s.target_error = .004f;
        s.seed = seed;
        const RenderResult result = render(scene, device, s);
        EXPECT_TRUE(result.error->reached) << seed;
        EXPECT_LE(result.error->steps, 3) << seed;
        EXPECT_LE(truth.error(result.image), .004) << seed;
    }
}

// What a search makes and says depends on the seed alone, not on how long anything took.
TEST(TargetError, DoesNotGoByTheClock) {
    const Scene scene = load_text(room(grey_floor, ""));
    for (const Method method : {Method::irradiance, Method::path}) {
        RenderSettings s;
        s.method = method;
        s.target_error = method == Method::path ? .03f : .008f;
        std::vector<RenderResult> results;
        for (const int threads : {1, 2}) {
            DeviceOptions options;
            options.threads = threads;
            Device device(options);
            results.push_back(render(scene, device, s));
        }
        const ErrorReport &one = *results[0].error, &two = *results[1].error;
        EXPECT_EQ(one.steps, two.steps);
        EXPECT_EQ(one.probes, two.probes);
        EXPECT_EQ(one.paths, two.paths);
        EXPECT_EQ(one.rel_rmse.high, two.rel_rmse.high);
        EXPECT_EQ(results[0].image.layers[0].data, results[1].image.layers[0].data);
    }
}

// As the target goes to 0 the picture goes to the etalon: nothing of caching's error stays.
TEST(TargetError, ErrorsFollowTheTargetDown) {
    const Scene scene = load_text(room(grey_floor, ""));
    Device device({});
    const Truth truth(scene, device, 4096);  // at 1 % within a hundredth of what four times as many say
    double before = 1;
    for (const float target : {.05f, .02f, .01f}) {
        RenderSettings s;
        s.target_error = target;
        const double error = truth.error(render(scene, device, s).image);
        EXPECT_LE(error, static_cast<double>(target));
        EXPECT_LT(error, before);
        before = error;
    }
}

TEST(TargetError, TimeLimitsEndTheSearchAndSaySo) {
    const Scene scene = load_text(room(grey_floor, ""));
    Device device({});
    RenderSettings s;
    s.target_error = 1e-4f;  // out of reach
    s.time_limit = 3;
    const RenderResult result = render(scene, device, s);
    EXPECT_TRUE(result.error->time_is_up);
    EXPECT_FALSE(result.error->reached);
    EXPECT_GT(result.error->rel_rmse.high, 1e-4);
    // Over as soon as the first picture is there: its error is known all the same.
    s.time_limit = 1e-3f;
    const RenderResult first = render(scene, device, s);
    EXPECT_TRUE(first.error->time_is_up);
    EXPECT_GE(first.error->probes, 256u);
    EXPECT_GT(first.error->rel_rmse.high, .001);
    EXPECT_LT(first.error->rel_rmse.value, .5);
    EXPECT_LT(std::abs(first.error->mean_bias.value), .1);
    s.time_limit = 3;
    s.target_error = 0;  // as good as can be had in this time
    const RenderResult best = render(scene, device, s);
    EXPECT_TRUE(best.error->time_is_up);
    EXPECT_GE(best.error->steps, 1);
    EXPECT_GT(best.error->rel_rmse.high, 0);
}

// When records change, a film's samples keep their direct light to the last bit, and their indirect light becomes what
// the new records make of them.
TEST(TargetError, RefinedFilmsShowTheNewRecords) {
    const Scene scene = load_text(room(grey_floor, ""));
    Device device({});
    for (const Method method : {Method::irradiance, Method::radiance}) {
        RenderSettings s;
        s.method = method;
        s.accuracy = .6f;
        s.spp = 24;
        irradia::Run run(scene, device, s, no_progress);
        CachingRenderer caching(run);
        Film refined(64, 64, false);
        caching.render(refined);
        const std::uint64_t few = run.statistics.records;
        const Film before = refined;
        s.accuracy = .2f;
        caching.refine(refined, .2f / .6f);
        EXPECT_GT(run.statistics.records, 2 * few);
        Film anew(64, 64, false);
        caching.render(anew);  // the same records: none is missing any more
        double changed = 0, different = 0, sum = 0;
        for (std::size_t i = 0; i < refined.pixels(); ++i) {
            ASSERT_EQ(refined.samples(static_cast<std::uint32_t>(i)), 24u);
            for (std::size_t c = 0; c < 3; ++c) {
                ASSERT_EQ(refined.mean(i, c), before.mean(i, c));
                changed += std::abs(refined.mean(i, 3 + c) - before.mean(i, 3 + c));
                different += std::abs(refined.mean(i, 3 + c) - anew.mean(i, 3 + c));
                sum += anew.mean(i, 3 + c);
            }
        }
        EXPECT_GT(changed / sum, .003);                  // there is something to see
        EXPECT_LT(different / sum, .1 * changed / sum);  // records that shading made last serve pixels done before, too
    }
}

TEST(TargetError, EveryViewMeetsIt) {
    const Scene scene = load_text(room(grey_floor, ""));
    Device device({});
    RenderSettings s;
    s.target_error = .05f;
    shared::Camera moved = scene.info.camera;
    moved.ox += .2f;
    render_views(scene, device, s, {scene.info.camera, moved}, [](std::size_t, const RenderResult& r) {
        ASSERT_TRUE(r.error.has_value());
        EXPECT_TRUE(r.error->reached);
        EXPECT_LE(r.error->rel_rmse.high, .05);
    });
    s.target_error = -1;
    EXPECT_THROW(render(scene, device, s), Error);
}

}  // namespace
}  // namespace irradia::test
