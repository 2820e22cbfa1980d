// render --report as a user calls it: what the page holds, and that it is right.
#include "app/report_records.h"
#include "image/image_check.h"
#include "irradia/Metrics.h"
#include "irradia/Renderer.h"
#include "report_command.h"

namespace irradia {
namespace {

class ReportCommand : public test::ReportTest {
protected:
    /// 8-bit sRGB, as it stands in a PNG file.
    static std::array<int, 3> bytes_at(const Image& image, int x, int y) {
        const Layer& layer = image.layers.front();
        std::array<int, 3> out{};
        for (int c = 0; c < 3; ++c)
            out[c] = static_cast<int>(
                std::lround(255 * srgb_encode(layer.data[(static_cast<std::size_t>(y) * image.width + x) *
                                                             static_cast<std::size_t>(layer.channels) +
                                                         c])));
        return out;
    }
    static bool grey(const std::array<int, 3>& p) { return p[0] == p[1] && p[1] == p[2]; }
};

TEST_F(ReportCommand, PageIsWellFormedWholeAndAlone) {
    // A name that would break out of text and of attributes; a byte that is no UTF-8.
    const std::string name = "<b>&\"'\xff.xml";
    std::filesystem::copy_file(std::string(IRRADIA_SOURCE_DIR) + "/scenes/cornell-box.xml", in_folder(name));
    ASSERT_EQ(render({"-o", "ref.pfm", "--seed", "5"}).status, 0);
    const test::Outcome outcome = render({"-o", "a.exr", "-o", "a.png", "--aov", "albedo", "--exposure", "0.5",
                                          "--report", "a.html", "--report-error", "--reference", "ref.pfm"},
                                         name);
    ASSERT_EQ(outcome.status, 0) << outcome.err;
    const nlohmann::json page = read_page("a.html");
    EXPECT_EQ(page["faults"], nlohmann::json::array());
    EXPECT_EQ(page["sections"],
              (nlohmann::json{"picture", "error", "reference", "layers", "records", "times", "rays", "settings"}));
    EXPECT_EQ(page["h1"], "<b>&\"'\xEF\xBF\xBD.xml");
    EXPECT_EQ(test::file_text(in_folder("a.html")).find("<b>"), std::string::npos);
    for (const std::string& layer : aov_names())
        EXPECT_EQ(page["pictures"]["layer-" + layer], (nlohmann::json{size, size})) << layer;
    EXPECT_EQ(page["pictures"].size(), aov_names().size() + 4);  // picture, records, error map, reference
    // Settings that differ from their defaults, and those alone, are marked.
    const nlohmann::json marked = page["marked"];
    EXPECT_EQ(marked, (nlohmann::json{"spp4", "hemisphere m4", "hemisphere n16", "grid paths1024", "aovsalbedo",
                                      "exposure0.5 stops"}));
    const nlohmann::json stats = page["data"]["stats"];
    EXPECT_EQ(stats["settings"]["aovs"], nlohmann::json{"albedo"});
    EXPECT_GT(stats["error"]["rel_rmse"]["high"], 0);
    EXPECT_NE(page["text"].get<std::string>().find(stats["device"]["name"].get<std::string>()), std::string::npos);

    // The page's picture is the PNG file's; the EXR has the layers that were asked for, and the same picture as without
    // a page.
    EXPECT_EQ(read_image(in_folder("viewer.png")).layers[0].data, read_image(in_folder("a.png")).layers[0].data);
    const Image exr = read_image(in_folder("a.exr"));
    ASSERT_EQ(exr.layers.size(), 2u);
    EXPECT_EQ(exr.layers[1].name, "albedo");
    EXPECT_EQ(exr.metadata.at("irradia.aovs"), "[\"albedo\"]");
    ASSERT_EQ(render({"-o", "b.exr", "--aov", "albedo"}, name).status, 0);
    EXPECT_EQ(exr.layers[0].data, read_image(in_folder("b.exr")).layers[0].data);
}

TEST_F(ReportCommand, WithoutRecordsErrorOrReferenceNoSuchSection) {
    ASSERT_EQ(render({"-o", "a.pfm", "--method", "path", "--report", "a.html"}).status, 0);
    EXPECT_EQ(read_page("a.html")["sections"], (nlohmann::json{"picture", "layers", "times", "rays", "settings"}));
}

// Records remember the pixel whose lack made them, of which the plot knows nothing.
TEST_F(ReportCommand, RecordsLieWhereTheirPixelsAre) {
    ASSERT_EQ(render({"-o", "a.exr", "--report", "a.html", "--save-records", "r"}).status, 0);
    const RecordSet set = read_records(in_folder("r"));
    const std::size_t n = set.irradiance.size();
    ASSERT_GT(n, 50u);
    std::vector<bool> has_record(size * size, false);
    for (std::size_t i = 0; i < n; ++i) {
        const shared::RecordKey& key = set.irradiance.keys[i];
        const auto at = app::project(set.views.at(0).camera, size, size, {key.px, key.py, key.pz});
        ASSERT_TRUE(at);
        const std::uint32_t pixel = set.irradiance.values[i].pixel;
        EXPECT_NEAR(at->x, pixel % size + 0.5, 0.51) << i;  // the box filter: samples lie within their pixel
        EXPECT_NEAR(at->y, pixel / size + 0.5, 0.51) << i;
        has_record[pixel] = true;
    }
    const nlohmann::json page = read_page("a.html");
    const std::string all = std::to_string(n);
    EXPECT_NE(
        page["captions"]["irradiance-records"].get<std::string>().find(all + " of " + all + " records are in sight"),
        std::string::npos)
        << page["captions"]["irradiance-records"];
    // Dots are coloured, the picture behind them is grey.
    const Image plot = read_image(in_folder("irradiance-records.png"));
    const int factor = plot.width / size;
    ASSERT_GE(factor, 8);
    for (int y = 1; y + 1 < size; ++y)
        for (int x = 1; x + 1 < size; ++x) {
            bool near = false, coloured = false;
            for (int dy = -1; dy <= 1; ++dy)
                for (int dx = -1; dx <= 1; ++dx) near = near || has_record[(y + dy) * size + x + dx];
            for (int v = 0; v < factor; ++v)
                for (int u = 0; u < factor; ++u)
                    coloured = coloured || !grey(bytes_at(plot, factor * x + u, factor * y + v));
            if (has_record[y * size + x]) {
                EXPECT_TRUE(coloured) << x << ' ' << y;
            }
            if (!near) {
                EXPECT_FALSE(coloured) << x << ' ' << y;
            }
        }
}

// From the side, records of surfaces that the blocks hide now: they were made by another camera.
TEST_F(ReportCommand, HiddenRecordsAreLeftOut) {
    ASSERT_EQ(render({"-o", "a.pfm", "--save-records", "r"}).status, 0);
    std::string text = test::file_text(std::string(IRRADIA_SOURCE_DIR) + "/scenes/cornell-box.xml");
    const std::string origin = "origin=\"0, 1, 4\"";
    ASSERT_NE(text.find(origin), std::string::npos);
    text.replace(text.find(origin), origin.size(), "origin=\"0.9, 0.4, 0.9\"");
    std::ofstream(in_folder("moved.xml")) << text;
    ASSERT_EQ(render({"-o", "b.pfm", "--load-records", "r", "--report", "b.html"}, "moved.xml").status, 0);
    const std::string caption = read_page("b.html")["captions"]["irradiance-records"];
    int shown = 0, all = 0, hidden = 0, outside = 0;
    std::string plain = caption.substr(std::string("Irradiance records ").size());
    plain.erase(std::remove(plain.begin(), plain.end(), ' '), plain.end());
    ASSERT_EQ(std::sscanf(plain.c_str(), "%dof%drecordsareinsight,%dliebehindsurfaces,%doutside", &shown, &all, &hidden,
                          &outside),
              4)
        << caption;
    EXPECT_EQ(shown + hidden + outside, all);
    EXPECT_GT(hidden, 10);
    EXPECT_GT(shown, 50);
}

TEST_F(ReportCommand, ComparisonIsThatOfCompare) {
    ASSERT_EQ(render({"-o", "ref.exr", "--method", "path", "--seed", "5"}).status, 0);
    ASSERT_EQ(render({"-o", "a.exr", "--aov", "counted", "--report", "a.html", "--reference", "ref.exr"}).status, 0);
    const nlohmann::json page = read_page("a.html");
    const nlohmann::json here = page["data"]["comparison"];
    const nlohmann::json there =
        nlohmann::json::parse(call(COMPARE, {"a.exr", "ref.exr", "--json", "--heatmap", "map.png"}).out);
    for (const char* key :
         {"rel_rmse", "mean_bias", "mean_bias_interval_95", "relmse", "max_error", "max_pixel", "ssim", "pixels"})
        EXPECT_EQ(here[key], there[key]) << key;
    // In words as well, and the map is the same.
    std::istringstream lines(call(COMPARE, {"a.exr", "ref.exr"}).out);
    std::string word, rmse, bias;
    lines >> word >> word >> rmse >> word >> word >> word;  // "relative RMSE   1.2345 %", "relMSE 1.2e-3"
    lines >> word >> word >> bias;                          // "mean bias       +0.1234 % ..."
    const std::string text = page["text"];
    EXPECT_NE(text.find(rmse + " %"), std::string::npos) << rmse;
    EXPECT_NE(text.find(bias + " %"), std::string::npos) << bias;
    EXPECT_EQ(read_image(in_folder("error-map.png")).layers[0].data, read_image(in_folder("map.png")).layers[0].data);

    const Image counted = [&] {
        Image image = read_image(in_folder("a.exr"));
        image.layers = {{"", 3, {}}};
        image.metadata.clear();
        for (const Layer& layer : read_image(in_folder("a.exr")).layers)
            if (layer.name == "counted")
                for (const float x : layer.data) image.layers[0].data.insert(image.layers[0].data.end(), 3, x);
        return image;
    }();
    write_image(in_folder("mask.exr"), counted);
    const nlohmann::json masked =
        nlohmann::json::parse(call(COMPARE, {"a.exr", "ref.exr", "--json", "--mask", "mask.exr"}).out);
    EXPECT_LT(masked["pixels"], there["pixels"]);
    for (const char* key : {"rel_rmse", "mean_bias", "pixels"})
        EXPECT_EQ(page["data"]["comparison_without_lamps"][key], masked[key]) << key;
}

TEST_F(ReportCommand, WhatCannotBeIsSaidBeforeRendering) {
    write_image(in_folder("small.pfm"), test::picture(24, 24, [](int x, int, int) { return 1.0 + x; }));
    write_image(in_folder("black.pfm"), test::picture(size, size, [](int, int, int) { return 0.0; }));
    const auto refused = [&](const std::vector<std::string>& more, int status, const std::string& what) {
        SCOPED_TRACE(what);
        std::vector<std::string> arguments = {"-o", "a.exr"};
        arguments.insert(arguments.end(), more.begin(), more.end());
        expect_one_line(render(arguments), status, "render", what);
        EXPECT_EQ(files(), 2u);  // pictures are written before the page: none was rendered
    };
    refused({"--report", "a.html", "--reference", "small.pfm"}, 1,
            "small.pfm: the reference has 24 x 24 pixels, expected 48 x 48");
    refused({"--report", "a.html", "--reference", "black.pfm"}, 1, "black.pfm: cannot serve as a reference");
    refused({"--report", "a.html", "--reference", "none.exr"}, 1, "none.exr");
    refused({"--report", "none/a.html"}, 1, "none/a.html: ");
    refused({"--reference", "small.pfm"}, 2, "--reference: expected --report");
    expect_one_line(render({"--pack", "p", "--report", "a.html"}), 2, "render", "--report: nothing is rendered");
    expect_one_line(call("env", {"IRRADIA_MODULE_DIR=.", RENDER, "none.xml", "-o", "a.pfm", "--report", "a.html"}), 1,
                    "render", "libirradia_oiio.so: cannot be loaded");
    EXPECT_EQ(files(), 2u);
}

}  // namespace
}  // namespace irradia
