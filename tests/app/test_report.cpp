// Parts of the page that --report writes.
#include <gtest/gtest.h>

#include <cmath>

#include "app/report_chart.h"
#include "app/report_html.h"
#include "app/report_pictures.h"
#include "app/report_records.h"

namespace irradia::app {
namespace {

TEST(ReportHtml, EscapesWhatCouldBreakOut) {
    EXPECT_EQ(html::escape("a<b>&\"c'"), "a&lt;b&gt;&amp;&quot;c&#39;");
    EXPECT_EQ(html::escape("\xC3\xA4 \xE2\x82\xAC \xF0\x9F\x98\x80"), "\xC3\xA4 \xE2\x82\xAC \xF0\x9F\x98\x80");
    const std::string bad = "\xEF\xBF\xBD";
    EXPECT_EQ(html::escape(std::string("a\0b", 3)), "a" + bad + "b");  // no character of XML
    EXPECT_EQ(html::escape("\x1b"), bad);                              // neither
    EXPECT_EQ(html::escape("\xff<"), bad + "&lt;");                    // never in UTF-8
    EXPECT_EQ(html::escape("\xC0\xBC"), bad + bad);                    // '<', overlong
    EXPECT_EQ(html::escape("\xED\xA0\x80"), bad + bad + bad);          // a surrogate
    EXPECT_EQ(html::escape("\xE2\x82"), bad + bad);                    // cut off
    EXPECT_EQ(html::escape("\xF4\x90\x80\x80").substr(0, 3), bad);     // beyond U+10FFFF
    EXPECT_EQ(html::table("<", {{"<", "&", true}}).find("<<"), std::string::npos);
}

TEST(ReportHtml, Base64IsThatOfTheStandard) {  // RFC 4648, section 10
    const auto of = [](const std::string& text) { return html::base64({text.begin(), text.end()}); };
    EXPECT_EQ(of(""), "");
    EXPECT_EQ(of("f"), "Zg==");
    EXPECT_EQ(of("fo"), "Zm8=");
    EXPECT_EQ(of("foo"), "Zm9v");
    EXPECT_EQ(of("foobar"), "Zm9vYmFy");
    EXPECT_EQ(html::base64({0xfb, 0xff, 0xfe}), "+//+");
}

TEST(ReportHtml, NumbersAreReadable) {
    EXPECT_EQ(html::number(0.012345), "0.0123");
    EXPECT_EQ(html::number(2580.4), "2580");
    EXPECT_EQ(html::number(-1.5), "-1.5");
    EXPECT_EQ(html::percent(0.01234), "1.23 %");
}

TEST(ReportPictures, LayersAreShownAsTheirCaptionsSay) {
    // Columns of four: ends of the colour map viridis are #440154 and #fde725 (matplotlib).
    const LayerView depth = layer_view({"depth", 1, {2, 3, 4, 0}}, 4, 1, 0);
    const auto pixel = [](const LayerView& v, std::size_t i) {
        return std::vector<int>(v.picture.rgb.begin() + 3 * i, v.picture.rgb.begin() + 3 * i + 3);
    };
    EXPECT_EQ(depth.scale.low, 2);
    EXPECT_EQ(depth.scale.high, 4);
    EXPECT_EQ(pixel(depth, 0), (std::vector<int>{0x44, 0x01, 0x54}));
    EXPECT_EQ(pixel(depth, 2), (std::vector<int>{0xfd, 0xe7, 0x25}));
    EXPECT_EQ(pixel(depth, 3), (std::vector<int>{40, 40, 40}));  // no surface
    EXPECT_EQ(depth.scale.colours.front(), "#440154");
    EXPECT_EQ(depth.scale.colours.back(), "#fde725");

    const LayerView normal = layer_view({"normal", 3, {0, 0, 1, -1, 0, 0}}, 2, 1, 0);
    EXPECT_EQ(pixel(normal, 0), (std::vector<int>{128, 128, 255}));
    EXPECT_EQ(pixel(normal, 1), (std::vector<int>{0, 128, 128}));
    const LayerView counted = layer_view({"counted", 1, {0, 1}}, 2, 1, 0);
    EXPECT_EQ(pixel(counted, 0), (std::vector<int>{0, 0, 0}));
    EXPECT_EQ(pixel(counted, 1), (std::vector<int>{255, 255, 255}));
    // Exposure is of light: sRGB's code of 0.25 is 137, of 0.5 is 188 (IEC 61966-2-1).
    EXPECT_EQ(pixel(layer_view({"direct", 3, {0.25f, 0.5f, 4}}, 1, 1, 0), 0), (std::vector<int>{137, 188, 255}));
    EXPECT_EQ(pixel(layer_view({"indirect", 3, {0.25f, 0, 0}}, 1, 1, 1), 0), (std::vector<int>{188, 0, 0}));
    EXPECT_EQ(pixel(layer_view({"albedo", 3, {0.25f, 0, 0}}, 1, 1, 1), 0), (std::vector<int>{137, 0, 0}));
    // A record is seen against none, two are brighter than one.
    const LayerView records = layer_view({"records", 1, {0, 1, 2}}, 3, 1, 0);
    EXPECT_LT(pixel(records, 0)[0] + 50, pixel(records, 1)[0]);
    EXPECT_LT(pixel(records, 1)[1] + 50, pixel(records, 2)[1]);
    EXPECT_EQ(records.scale.high, 2);
    // Nothing at all.
    EXPECT_EQ(pixel(layer_view({"depth", 1, {0, 0}}, 2, 1, 0), 1), (std::vector<int>{40, 40, 40}));
    EXPECT_TRUE(layer_view({"records", 1, {0, 0}}, 2, 1, 0).scale.colours.empty());
}

shared::Camera some_camera() {
    shared::Camera c{};
    c.ox = 1, c.oy = 2, c.oz = 3;
    c.cornerx = -1, c.cornery = 1, c.cornerz = -1;  // film of 2 x 1.5 at unit depth along -z
    c.dxx = 2;
    c.dyy = -1.5f;
    c.forwardz = -1;
    c.pixel_size = 0.02f;
    return c;
}

TEST(ReportRecords, ProjectionInvertsTheCameraRay) {
    const shared::Camera c = some_camera();
    // o + 4 (corner + 0.25 dx + 0.5 dy)
    const auto p = project(c, 200, 100, {1 + 4 * -0.5f, 2 + 4 * 0.25f, 3 - 4});
    ASSERT_TRUE(p);
    EXPECT_NEAR(p->x, 50, 1e-9);
    EXPECT_NEAR(p->y, 50, 1e-9);
    EXPECT_NEAR(p->distance, 4 * std::sqrt(0.25 + 0.0625 + 1), 1e-6);
    EXPECT_FALSE(project(c, 200, 100, {1, 2, 7}));  // behind the camera
    EXPECT_FALSE(project(c, 200, 100, {1, 2, 3}));  // in it
}

TEST(ReportRecords, ThoseBehindSurfacesAndOutsideAreNotShown) {
    Image image{
        20, 10, {{"", 3, UntouchedVector<float>(600, 0.5f)}, {"depth", 1, UntouchedVector<float>(200, 2.0f)}}, {}};
    shared::SceneInfo info{};
    info.camera = some_camera();
    Records records;
    const auto add = [&](float x, float z, float support) {
        shared::RecordKey key{};
        key.px = x, key.py = 2.25f, key.pz = z;
        key.support1 = support;
        key.support2 = 4 * support;
        records.keys.push_back(key);
        records.values.emplace_back();
    };
    add(1, 1.1f, 0.1f);  // 1.9 away: in front of the surface
    add(1, -3, 0.1f);    // 6 away: behind it
    add(50, 1, 0.1f);    // outside
    add(1, 9, 0.1f);     // behind the camera
    add(0.5f, 1.1f, 1);
    const RecordsPlot plot = plot_records(image, info.camera, records, 0);
    EXPECT_EQ(plot.shown, 2u);
    EXPECT_EQ(plot.hidden, 1u);
    EXPECT_EQ(plot.outside, 2u);
    EXPECT_NEAR(plot.least, 0.2, 1e-6);  // sqrt(0.1 * 0.4)
    EXPECT_NEAR(plot.most, 2, 1e-6);
    EXPECT_EQ(plot.scale.low, plot.least);
    EXPECT_EQ(plot.scale.high, plot.most);
    const Picture& p = plot.picture;
    EXPECT_EQ(p.width, 20 * plot.enlarged);
    // The dots have the colours of the scale's ends.
    const auto colour = [&](double x, double y) {
        const std::size_t at =
            3 * (static_cast<std::size_t>(plot.enlarged * y) * p.width + static_cast<std::size_t>(plot.enlarged * x));
        char text[8];
        std::snprintf(text, sizeof text, "#%02x%02x%02x", p.rgb[at], p.rgb[at + 1], p.rgb[at + 2]);
        return std::string(text);
    };
    const auto small = project(info.camera, 20, 10, {1, 2.25f, 1.1f});
    const auto large = project(info.camera, 20, 10, {0.5f, 2.25f, 1.1f});
    EXPECT_EQ(colour(small->x, small->y), plot.scale.colours.front());
    EXPECT_EQ(colour(large->x, large->y), plot.scale.colours.back());
    // None at all is no error.
    EXPECT_EQ(plot_records(image, info.camera, {}, 0).shown, 0u);
}

TEST(ReportChart, BarsAreAsLongAsTheirValues) {
    const std::string chart = bar_chart("Time", {{"a<b", 4, "4 s"}, {"c", 1, "1 s"}});
    EXPECT_NE(chart.find("width=\"100.000%\""), std::string::npos);
    EXPECT_NE(chart.find("width=\"25.000%\""), std::string::npos);
    EXPECT_NE(chart.find("aria-label=\"Time: a&lt;b 4 s; c 1 s\""), std::string::npos) << chart;
    EXPECT_EQ(bar_chart("Time", {}), "");
    EXPECT_EQ(bar_chart("Time", {{"a", 0, "0 s"}}).find("nan"), std::string::npos);
}

TEST(ReportChart, LegendsHaveNumbers) {
    const std::string text = legend("x", {0.02, 5, true, "m", {"#000000", "#ffffff"}});
    for (const char* label : {">0.02<", ">5 m<", ">0.1<", ">1<"})
        EXPECT_NE(text.find(label), std::string::npos) << label << " in " << text;
    // 0.1 on the logarithmic axis: log(5) / log(250) = 29.15 %.
    EXPECT_NE(text.find("x=\"29.15%\""), std::string::npos) << text;
    EXPECT_EQ(legend("x", {2, 2, true, "m", {"#000000"}}).find("nan"), std::string::npos);
}

}  // namespace
}  // namespace irradia::app
