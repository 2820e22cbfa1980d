// Radiance caching: the picture against path tracing, in every representation; what a constant surrounding must give;
// many views with one cache; settings out of range.
#include <algorithm>
#include <cmath>

#include "irradia/Error.h"
#include "room.h"

namespace irradia::test {
namespace {

std::string conductor(const std::string& alpha, const std::string& material = "Cu") {
    return R"(<bsdf type="twosided"><bsdf type="roughconductor"><string name="material" value=")" + material +
           R"("/><string name="distribution" value="ggx"/><float name="alpha" value=")" + alpha +
           R"("/></bsdf></bsdf>)";
}
std::string plastic(const std::string& alpha, const std::string& distribution = "ggx") {
    return R"(<bsdf type="twosided"><bsdf type="roughplastic"><rgb name="diffuse_reflectance" value=".5,.3,.2"/>
        <string name="distribution" value=")" +
           distribution + R"("/><float name="alpha" value=")" + alpha + R"("/></bsdf></bsdf>)";
}
std::string ball(const std::string& bsdf) {
    return R"(<shape type="sphere"><point name="center" value="0,-.6,0"/><float name="radius" value=".4"/>)" + bsdf +
           "</shape>";
}

RenderSettings radiance(GlossyRule rule) {
    RenderSettings s;
    s.method = Method::radiance;
    s.glossy = rule;
    return s;
}

// ---- against path tracing ------------------------------------------------------------------------------------------

struct Glossy {
    const char* name;
    std::string floor, things;
    GlossyRule rule;
    double bias, rmse;  // bounds, about 1.5 times what was measured when the test was written
};
void PrintTo(const Glossy& g, std::ostream* out) { *out << g.name; }

class CachedLobes : public ::testing::TestWithParam<Glossy> {};

TEST_P(CachedLobes, AgreeWithPathTracing) {
    const Comparison c = compare(load_text(room(GetParam().floor, GetParam().things)), radiance(GetParam().rule));
    std::printf("%-18s bias %+.2f %% +- %.2f %%, RMSE %.1f %%, %llu records\n", GetParam().name, 100 * c.bias,
                100 * c.noise, 100 * c.rmse, static_cast<unsigned long long>(c.radiance_records));
    EXPECT_NEAR(c.bias, 0.0, GetParam().bias + 3 * c.noise);
    EXPECT_LT(c.rmse, GetParam().rmse);
    EXPECT_EQ(c.radiance_records > 0, GetParam().rule != GlossyRule::traced);
}

INSTANTIATE_TEST_SUITE_P(
    Rooms, CachedLobes,
    ::testing::Values(
        Glossy{"metal_samples", conductor(".3"), "", GlossyRule::samples, 0.005, 0.018},
        Glossy{"metal_harmonics", conductor(".3"), "", GlossyRule::harmonics, 0.005, 0.029},
        Glossy{"metal_traced", conductor(".3"), "", GlossyRule::traced, 0.005, 0.035},
        Glossy{"plastic_samples", plastic(".2"), ball(plastic(".2")), GlossyRule::samples, 0.005, 0.02},
        Glossy{"plastic_harmonics", plastic(".4"), ball(plastic(".4")), GlossyRule::harmonics, 0.005, 0.017},
        Glossy{"beckmann_samples", plastic(".3", "beckmann"), "", GlossyRule::samples, 0.005, 0.018},
        Glossy{"curved_samples", grey_floor, ball(conductor(".25", "Al")), GlossyRule::samples, 0.005, 0.015},
        Glossy{"textured_roughness",
               R"(<bsdf type="twosided"><bsdf type="roughconductor"><string name="material" value="Al"/>
                <texture name="alpha" type="checkerboard"><rgb name="color0" value=".2"/><rgb name="color1" value=".5"/>
                <transform name="to_uv"><scale value="3"/></transform></texture></bsdf></bsdf>)",
               "", GlossyRule::samples, 0.005, 0.029}),
    [](const auto& tested) { return std::string(tested.param.name); });

// ---- a constant surrounding ----------------------------------------------------------------------------------------

// A small rough ball in a large lamp of reflectance 1/2 and radiance 1, seen to the first reflection at the lamp's
// wall: indirect light of radiance 1/2 comes from everywhere (but for what the ball hides of the lamp, its solid angle
// there), so that the ball's indirect light is half its albedo. The records' noise is that of light sampling alone,
// which the lamp being all around makes large; but the mean over records that look the same way has to agree with the
// albedo, which path tracing of the direct light measures: direct light is the albedo itself.
TEST(GlossyFurnace, ReflectsHalfItsDirectLight) {
    const std::string text =
        R"(<scene version="3.0.0">)" + sensor(24, "0,0,.5", "0,0,0", 10) +
        R"(<shape type="sphere"><float name="radius" value="1"/><boolean name="flip_normals" value="true"/>
        <bsdf type="diffuse"><rgb name="reflectance" value=".5"/></bsdf>
        <emitter type="area"><rgb name="radiance" value="1"/></emitter></shape>
        <shape type="sphere"><float name="radius" value=".03"/>)" +
        conductor(".4", "none") + "</shape></scene>";
    const Scene scene = load_text(text);
    for (const GlossyRule rule : {GlossyRule::samples, GlossyRule::harmonics}) {
        RenderSettings s = radiance(rule);
        s.max_depth = 3;
        s.spp = 64;
        s.aovs = {"direct", "indirect", "depth"};
        const RenderResult r = run(scene, s);
        double direct = 0, indirect = 0, pixels = 0, worst = 0;
        const auto &d = r.image.layers[1].data, &i = r.image.layers[2].data, &z = r.image.layers[3].data;
        for (std::size_t p = 0; p < z.size(); ++p) {
            if (z[p] > .475f) continue;  // the ball's middle
            ++pixels;
            direct += static_cast<double>(d[3 * p + 1]);
            indirect += static_cast<double>(i[3 * p + 1]);
            worst = std::max(worst, std::abs(static_cast<double>(i[3 * p + 1]) - .5));
        }
        ASSERT_GT(pixels, 50);
        ASSERT_GT(r.statistics.radiance_records, 0u);
        EXPECT_NEAR(indirect / direct, 0.5, 0.005);
        EXPECT_LT(worst, 0.15);
    }
}

// ---- views ---------------------------------------------------------------------------------------------------------

double luminance_at(const Image& image, std::size_t layer, std::size_t p) {
    const auto& d = image.layers[layer].data;
    return (static_cast<double>(d[3 * p]) + static_cast<double>(d[3 * p + 1]) + static_cast<double>(d[3 * p + 2])) / 3;
}

// Root mean square of b - a over the mean of a, of the pixels for which use(p).
double change(const Image& a, const Image& b, const std::vector<bool>& use) {
    double square = 0, mean = 0;
    for (std::size_t p = 0; p < use.size(); ++p) {
        if (!use[p]) continue;
        const double x = luminance_at(a, 1, p), y = luminance_at(b, 1, p);
        mean += x;
        square += (x - y) * (x - y);
    }
    const auto n = static_cast<double>(std::count(use.begin(), use.end(), true));
    return std::sqrt(square / n) / (mean / n);
}

// A camera on an arc of 30 frames through a room with a glossy floor, one cache. Records of earlier views answer later
// ones. After every third frame the view of the start is rendered again: nothing in it moves, and its indirect light
// changes from one time to the next only by what records added on the flight change. That has to be less than the
// picture's own error, which two pictures with caches of their own show: they differ by root 2 times it.
TEST(Views, ShareOneCacheWithoutFlicker) {
    std::vector<shared::Camera> cameras;
    const std::string plain = room(conductor(".3"), ball(grey_floor));
    const std::string origin = "0,0.2,2.9";
    std::vector<std::size_t> still;
    for (int i = 0; i < 30; ++i) {
        const double angle = 0.012 * i;
        std::string text = plain;
        const std::string moved =
            std::to_string(2.9 * std::sin(angle)) + ",0.2," + std::to_string(2.9 * std::cos(angle));
        text.replace(text.find(origin), origin.size(), moved);
        cameras.push_back(load_text(text).info.camera);
        if (i % 3 != 0) continue;
        if (i > 0) cameras.push_back(cameras.front());
        still.push_back(cameras.size() - 1);
    }
    RenderSettings s = radiance(GlossyRule::samples);
    s.spp = 16;
    s.aovs = {"indirect", "albedo"};
    const Scene scene = load_text(plain);
    Device device({});
    std::vector<Image> frames;
    std::vector<std::uint64_t> records;
    render_views(scene, device, s, cameras, [&](std::size_t, RenderResult r) {
        frames.push_back(std::move(r.image));
        records.push_back(r.statistics.records + r.statistics.radiance_records);
    });
    ASSERT_EQ(frames.size(), cameras.size());
    // The first view makes most records; each later one, those of what it shows anew.
    std::uint64_t later = 0;
    for (std::size_t i = 1; i < records.size(); ++i) later = std::max(later, records[i] - records[i - 1]);
    EXPECT_LT(later, records[0] / 4);
    EXPECT_GT(records.back(), records[0]);
    const std::size_t pixels = frames[0].layers[1].data.size() / 3;
    std::vector<bool> diffuse(pixels), all(pixels, true);
    for (std::size_t p = 0; p < pixels; ++p) diffuse[p] = luminance_at(frames[0], 2, p) > 0;
    ASSERT_LT(std::count(diffuse.begin(), diffuse.end(), true), static_cast<std::ptrdiff_t>(pixels * 9 / 10));
    double flicker = 0, flicker_diffuse = 0;
    for (std::size_t i = 1; i < still.size(); ++i) {
        flicker = std::max(flicker, change(frames[still[i - 1]], frames[still[i]], all));
        flicker_diffuse = std::max(flicker_diffuse, change(frames[still[i - 1]], frames[still[i]], diffuse));
    }
    // What a cache and random numbers of its own would change.
    s.seed = 1;
    const double separate = change(frames[0], render(scene, device, s).image, all);
    std::printf(
        "same view, from one time to the next: diffuse %.2f %%, all %.2f %%; separate caches %.2f %%; records first "
        "%llu, later views at most %llu each\n",
        100 * flicker_diffuse, 100 * flicker, 100 * separate, static_cast<unsigned long long>(records[0]),
        static_cast<unsigned long long>(later));
    EXPECT_LT(flicker_diffuse, separate / std::sqrt(2));
    EXPECT_LT(flicker, separate / std::sqrt(2));
    EXPECT_LT(separate, 0.03);
}

// ---- what is kept apart, what is refused ---------------------------------------------------------------------------

TEST(RadianceRecords, TakeTheBytesThatTheirKindNeeds) {
    const Scene scene = load_text(room(conductor(".4"), ""));
    const auto bytes = [&](GlossyRule rule, int order, float from) {
        RenderSettings s = radiance(rule);
        s.spp = 1;
        s.harmonics_order = order;
        s.harmonics_from = from;
        s.hemisphere_m = 4;
        s.hemisphere_n = 13;
        return run(scene, s).statistics.radiance_record_bytes;
    };
    const std::uint64_t key_and_value = 48 + 96;
    EXPECT_EQ(bytes(GlossyRule::samples, 5, 2), key_and_value + 10 * 4 * 56);
    EXPECT_EQ(bytes(GlossyRule::harmonics, 5, 2), key_and_value + 9 * 4 * 25);
    EXPECT_EQ(bytes(GlossyRule::automatic, 3, 0.3f), key_and_value + 9 * 4 * 9);
    EXPECT_EQ(bytes(GlossyRule::automatic, 5, 0.5f), key_and_value + 10 * 4 * 56);
}

// Lobes below the threshold are traced; surfaces without a lobe never ask.
TEST(RadianceRecords, AreMadeForLobesAlone) {
    RenderSettings s = radiance(GlossyRule::automatic);
    s.spp = 1;
    const auto records = [&](const std::string& floor) {
        return run(load_text(room(floor, "")), s).statistics.radiance_records;
    };
    EXPECT_EQ(records(grey_floor), 0u);
    EXPECT_EQ(records(conductor(".3")) > 0, true);
    s.trace_below = 0.35f;
    EXPECT_EQ(records(conductor(".3")), 0u);
    s.trace_below = 0.1f;
    EXPECT_EQ(records(R"(<bsdf type="twosided"><bsdf type="roughconductor"><string name="material" value="Cu"/>
        <float name="alpha_u" value=".2"/><float name="alpha_v" value=".4"/></bsdf></bsdf>)"),
              0u);
}

TEST(RadianceSettings, AreRefusedOutOfRange) {
    const Scene scene = load_text(room(conductor(".3"), ""));
    const auto message = [&](const std::function<void(RenderSettings&)>& change) -> std::string {
        RenderSettings s = radiance(GlossyRule::automatic);
        change(s);
        try {
            run(scene, s);
        } catch (const Error& e) {
            return e.what();
        }
        return "nothing thrown";
    };
    EXPECT_NE(message([](RenderSettings& s) { s.harmonics_order = 13; }).find("1"), std::string::npos);
    EXPECT_NE(message([](RenderSettings& s) { s.harmonics_order = 13; }).find("12"), std::string::npos);
    EXPECT_NE(message([](RenderSettings& s) { s.trace_below = -1; }).find("expected 0"), std::string::npos);
    EXPECT_NE(message([](RenderSettings& s) { s.harmonics_from = NAN; }).find("expected 0"), std::string::npos);
    EXPECT_NE(message([](RenderSettings& s) { s.lobe_table = 3; }).find("1024"), std::string::npos);
    EXPECT_NE(message([](RenderSettings& s) { s.glossy_accuracy = 0; }).find("positive"), std::string::npos);
    EXPECT_NE(message([](RenderSettings& s) { s.glossy_spread = -1; }).find("positive"), std::string::npos);
    EXPECT_NE(message([](RenderSettings& s) { s.glossy_reach = 2; }).find("expected 0"), std::string::npos);
}

}  // namespace
}  // namespace irradia::test
