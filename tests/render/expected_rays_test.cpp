// How many rays a render is expected to trace, against how many it does.
#include <gtest/gtest.h>

#include <limits>

#include "render_fixture.h"

namespace irradia {
namespace {

struct Case {
    const char* name;
    const char* scene;
    Method method;
    Quality quality;
    int spp;  // 0: the quality's
};

class ExpectedRays : public ::testing::TestWithParam<Case> {};

TEST_P(ExpectedRays, AreRightWithinAFactorOfFour) {
    const Case& c = GetParam();
    const Scene scene = test::load(test::project_scene(c.scene), {}, 96, 96);
    RenderSettings settings;
    apply_quality(settings, c.quality);
    settings.method = c.method;
    if (c.spp > 0) settings.spp = c.spp, settings.pixel_error = 0;
    Device device{DeviceOptions{}};
    const RenderResult result = render(scene, device, settings);
    const double ratio = expected_rays(scene, settings) / static_cast<double>(result.statistics.total_rays());
    EXPECT_GT(ratio, 0.25);
    EXPECT_LT(ratio, 4);
}

INSTANTIATE_TEST_SUITE_P(Methods, ExpectedRays,
                         ::testing::Values(Case{"path", "cornell-box.xml", Method::path, Quality::draft, 16},
                                           Case{"draft", "cornell-box.xml", Method::irradiance, Quality::draft, 0},
                                           Case{"medium", "cornell-box.xml", Method::irradiance, Quality::medium, 0},
                                           Case{"gather", "cornell-box.xml", Method::gather, Quality::draft, 1},
                                           Case{"radiance", "glossy-box.xml", Method::radiance, Quality::draft, 16}),
                         [](const auto& tested) { return std::string(tested.param.name); });

TEST(ExpectedRaysOfSearches, AreMany) {
    RenderSettings settings;
    settings.target_error = 0.01f;
    EXPECT_EQ(expected_rays(Scene{}, settings), std::numeric_limits<double>::infinity());
}

}  // namespace
}  // namespace irradia
