// `render` as a user calls it: help, messages, exit status, files.
#include <nlohmann/json.hpp>

#include "command.h"
#include "irradia/Renderer.h"

namespace irradia {
namespace {

const std::string kScene = std::string(IRRADIA_SOURCE_DIR) + "/scenes/cornell-box.xml";

class RenderCommand : public test::CommandTest {
protected:
    test::Outcome render(const std::vector<std::string>& arguments) const { return call(RENDER, arguments); }
    /// A picture of 24 x 24 pixels by path tracing: seconds at most.
    test::Outcome render_small(std::vector<std::string> arguments) const {
        arguments.insert(arguments.begin(),
                         {kScene, "--method", "path", "--spp", "1", "--width", "24", "--height", "24"});
        return render(arguments);
    }
};

TEST_F(RenderCommand, HelpExplainsEveryOption) {
    const test::Outcome help = render({"--help"});
    EXPECT_EQ(help.status, 0);
    EXPECT_EQ(help.err, "");
    const std::vector<std::string> expected = {"--output",
                                               "--exposure",
                                               "--aov",
                                               "--stats",
                                               "--pack",
                                               "--save-records",
                                               "--load-records",
                                               "--force-records",
                                               "--points",
                                               "--report",
                                               "--reference",
                                               "--frames",
                                               "--camera-path",
                                               "--overwrite",
                                               "--shard",
                                               "--batch",
                                               "--checkpoint",
                                               "--checkpoint-every",
                                               "--width",
                                               "--height",
                                               "--rfilter",
                                               "--define",
                                               "--lenient",
                                               "--method",
                                               "--quality",
                                               "--spp",
                                               "--pixel-error",
                                               "--report-error",
                                               "--error-share",
                                               "--target-error",
                                               "--time-limit",
                                               "--max-depth",
                                               "--seed",
                                               "--accuracy",
                                               "--hemisphere",
                                               "--overlap",
                                               "--min-spacing",
                                               "--max-spacing",
                                               "--gap-spacing",
                                               "--gradients",
                                               "--radius",
                                               "--weight",
                                               "--no-neighbour-clamp",
                                               "--no-gradient-limit",
                                               "--no-in-front",
                                               "--no-reach-limit",
                                               "--direct-mis",
                                               "--no-grid",
                                               "--no-learn-sky",
                                               "--grid-paths",
                                               "--firefly",
                                               "--no-share-lookups",
                                               "--glossy",
                                               "--trace-below",
                                               "--glossy-share",
                                               "--harmonics-from",
                                               "--order",
                                               "--lobe-table",
                                               "--glossy-accuracy",
                                               "--glossy-reach",
                                               "--glossy-spread",
                                               "--no-specialise",
                                               "--device",
                                               "--list-devices",
                                               "--threads",
                                               "--traversal",
                                               "--quiet",
                                               "--verbose",
                                               "--memory-limit",
                                               "--log-json",
                                               "--progress",
                                               "--help",
                                               "--version"};
    for (const std::string& option : expected) EXPECT_NE(help.out.find(option), std::string::npos) << option;
    for (const std::string& option : test::options_in(help.out))  // and this list is whole
        EXPECT_NE(std::find(expected.begin(), expected.end(), option), expected.end()) << option;
}

TEST_F(RenderCommand, HelpStatesTheDefaultsOfRenderSettings) {
    const std::string help = render({"--help"}).out;
    const RenderSettings defaults;
    const auto default_of = [&](const std::string& option) {
        const std::size_t at = help.find(option + " "), open = help.find('[', at), close = help.find(']', open);
        return help.substr(open + 1, close - open - 1);
    };
    EXPECT_FLOAT_EQ(std::stof(default_of("  --accuracy")), defaults.accuracy);
    EXPECT_FLOAT_EQ(std::stof(default_of("  --overlap")), defaults.overlap);
    EXPECT_FLOAT_EQ(std::stof(default_of("  --min-spacing")), defaults.min_spacing);
    EXPECT_FLOAT_EQ(std::stof(default_of("  --max-spacing")), defaults.max_spacing);
    EXPECT_FLOAT_EQ(std::stof(default_of("  --gap-spacing")), defaults.gap_spacing);
    EXPECT_EQ(default_of("  --hemisphere"),
              std::to_string(defaults.hemisphere_m) + "x" + std::to_string(defaults.hemisphere_n));
    EXPECT_EQ(std::stoi(default_of("  --max-depth")), defaults.max_depth);
    EXPECT_EQ(default_of("  --method"), "irradiance");
    EXPECT_EQ(default_of("  --glossy"), "auto");
    EXPECT_FLOAT_EQ(std::stof(default_of("  --trace-below")), defaults.trace_below);
    EXPECT_FLOAT_EQ(std::stof(default_of("  --glossy-share")), defaults.glossy_share);
    EXPECT_FLOAT_EQ(std::stof(default_of("  --harmonics-from")), defaults.harmonics_from);
    EXPECT_EQ(std::stoi(default_of("  --order")), defaults.harmonics_order);
    EXPECT_EQ(std::stoi(default_of("  --lobe-table")), defaults.lobe_table);
    EXPECT_FLOAT_EQ(std::stof(default_of("  --glossy-accuracy")), defaults.glossy_accuracy);
    EXPECT_FLOAT_EQ(std::stof(default_of("  --glossy-reach")), defaults.glossy_reach);
    EXPECT_FLOAT_EQ(std::stof(default_of("  --glossy-spread")), defaults.glossy_spread);
}

TEST_F(RenderCommand, ReadmeTablesNameOnlyOptionsThatExist) {
    const std::string readme = test::file_text(std::string(IRRADIA_SOURCE_DIR) + "/README.md");
    const std::string help = render({"--help"}).out + call(COMPARE, {"--help"}).out;
    std::istringstream lines(readme);
    std::string line;
    int rows = 0;
    while (std::getline(lines, line)) {
        if (line.empty() || line[0] != '|') continue;
        for (const std::string& option : test::options_in(line)) {
            if (option.find_first_not_of('-') == std::string::npos) continue;
            ++rows;
            EXPECT_NE(help.find(option), std::string::npos) << option << " in: " << line;
        }
    }
    EXPECT_GT(rows, 15);
}

TEST_F(RenderCommand, WrongCommandLinesExitWithTwo) {
    const std::vector<std::pair<std::vector<std::string>, std::string>> wrong = {
        {{}, "no SCENE"},
        {{kScene}, "-o"},
        {{kScene, "-o", "a.exr", "--frobnicate"}, "--frobnicate"},
        {{kScene, "-o", "a.exr", "--spp", "0"}, "--spp"},
        {{kScene, "-o", "a.exr", "--spp", "many"}, "--spp"},
        {{kScene, "-o", "a.exr", "--width", "0"}, "--width"},
        {{kScene, "-o", "a.exr", "--height", "-3"}, "--height"},
        {{kScene, "-o", "a.exr", "--rfilter", "mitchell"}, "--rfilter"},
        {{kScene, "-o", "a.exr", "--accuracy", "0"}, "--accuracy"},
        {{kScene, "-o", "a.exr", "--accuracy", "nan"}, "'nan' is not a number above 0"},
        {{kScene, "-o", "a.exr", "--exposure", "nan"}, "'nan' is not a number from -60 to 60"},
        {{kScene, "-o", "a.exr", "--overlap", "0.9"}, "'0.9' is not a number of at least 1"},
        {{kScene, "-o", "a.exr", "--max-depth", "0"}, "--max-depth"},
        {{kScene, "-o", "a.exr", "--hemisphere", "16"}, "'16' is not MxN"},
        {{kScene, "-o", "a.exr", "--glossy", "wavelets"}, "auto|samples|harmonics|traced"},
        {{kScene, "-o", "a.exr", "--trace-below", "1.5"}, "from 0 to 1"},
        {{kScene, "-o", "a.exr", "--harmonics-from", "-1"}, "from 0 to 2"},
        {{kScene, "-o", "a.exr", "--glossy-share", "nan"}, "from 0 to 1"},
        {{kScene, "-o", "a.exr", "--order", "13"}, "12"},
        {{kScene, "-o", "a.exr", "--order", "0"}, "1 to 12"},
        {{kScene, "-o", "a.exr", "--lobe-table", "2"}, "4 to 1024"},
        {{kScene, "-o", "a.exr", "--glossy-accuracy", "0"}, "above 0"},
        {{kScene, "-o", "a.exr", "--glossy-spread", "-1"}, "at least 0"},
        {{kScene, "-o", "a.exr", "--hemisphere", "16x"}, "'16x' is not MxN"},
        {{kScene, "-o", "a.exr", "--hemisphere", "0x4"}, "'0x4' is not MxN"},
        {{kScene, "-o", "a.exr", "--method", "photon"}, "irradiance|radiance|gather|path"},
        {{kScene, "-o", "a.exr", "--radius", "mean"}, "harmonic|minimum|hessian"},
        {{kScene, "-o", "a.exr", "--aov", "direct,shadow"}, "'shadow'"},
        {{kScene, "-o", "a.exr", "--traversal", "tpu"}, "--traversal"},
        {{kScene, "-o", "a.exr", "--min-spacing", "50"}, "--min-spacing 50"},
        {{kScene, "-o", "a.exr", "-D", "spp"}, "NAME=VALUE"},
        {{kScene, "-o", "a.exr", "-D", "=4"}, "NAME=VALUE"},
        {{kScene, "-o", "a.exr", "--quiet", "--verbose"}, "--quiet"},
        {{kScene, "extra.xml", "-o", "a.exr"}, "extra.xml"},
    };
    for (const auto& [arguments, what] : wrong) {
        SCOPED_TRACE(what);
        expect_one_line(render(arguments), 2, "render", what);
    }
    EXPECT_EQ(files(), 0u);
}

TEST_F(RenderCommand, MissingSceneIsOneLine) {
    expect_one_line(render({"none.xml", "-o", "a.exr"}), 1, "render", "none.xml");
    EXPECT_EQ(files(), 0u);
}

// The scene does not exist either, so a message about the output shows that it was looked at first.
TEST_F(RenderCommand, UnwritableOutputIsFoundBeforeTheSceneIsRead) {
    std::filesystem::create_directory(in_folder("folder.exr"));
    for (const char* output : {"none/a.exr", "folder.exr", "a.jpeg", "a", "/proc/a.exr"}) {
        SCOPED_TRACE(output);
        expect_one_line(render({"none.xml", "-o", "good.exr", "-o", output}), 1, "render", std::string(output) + ": ");
    }
    expect_one_line(render({"none.xml", "-o", "a.exr", "--stats", "none/s.json"}), 1, "render", "none/s.json: ");
    expect_one_line(render({"none.xml", "--pack", "none/s.bin"}), 1, "render", "none/s.bin: ");
    EXPECT_EQ(files(), 1u);  // folder.exr alone
}

TEST_F(RenderCommand, UnknownDeviceIsOneLine) {
    expect_one_line(render_small({"-o", "a.exr", "--device", "abacus"}), 1, "render", "abacus");
    expect_one_line(render_small({"-o", "a.exr", "--device", "99"}), 1, "render", "99");
    // It is what is told though the scene is not there either, whichever thread is first, and tried once.
    for (const char* threads : {"0", "1"})
        expect_one_line(render({"none.xml", "-o", "a.exr", "--device", "99", "--threads", threads}), 1, "render",
                        "'99'");
    expect_one_line(render_small({"-o", "a.#.exr", "--frames", "1-3", "--device", "99"}), 1, "render", "'99'");
    std::ofstream(in_folder("mesh.xml"))  // whose files are read while it is opened
        << R"(<scene version="3.0.0"><shape type="ply"><string name="filename" value="none.ply"/></shape></scene>)";
    expect_one_line(render({"mesh.xml", "-o", "a.exr", "--device", "99"}), 1, "render", "'99'");
    std::filesystem::remove(in_folder("mesh.xml"));
    EXPECT_EQ(files(), 0u);
}

TEST_F(RenderCommand, ListDevicesNumbersThem) {
    const test::Outcome list = render({"--list-devices"});
    EXPECT_EQ(list.status, 0) << list.err;
    EXPECT_EQ(list.out.rfind("0: ", 0), 0u) << list.out;
}

TEST_F(RenderCommand, WritesEveryKindWithMetadataAndStatistics) {
    const test::Outcome outcome =
        render_small({"-o", "a.exr", "-o", "a b.png", "-o", "a.pfm", "--seed", "7", "--stats", "s.json"});
    ASSERT_EQ(outcome.status, 0) << outcome.err;
    EXPECT_EQ(outcome.out, "");
    EXPECT_NE(outcome.err.find("wrote a.exr, a b.png, a.pfm"), std::string::npos) << outcome.err;
    EXPECT_EQ(files(), 4u);

    const Image exr = read_image(in_folder("a.exr"));
    EXPECT_EQ(exr.width, 24);
    EXPECT_EQ(exr.height, 24);
    EXPECT_EQ(exr.layers[0].data, read_image(in_folder("a.pfm")).layers[0].data);
    EXPECT_EQ(exr.metadata.at("irradia.method"), "path");
    EXPECT_EQ(exr.metadata.at("irradia.seed"), "7");
    EXPECT_EQ(exr.metadata.at("irradia.spp"), "1");
    for (const char* key : {"irradia.device", "irradia.version", "irradia.rays"})
        EXPECT_TRUE(exr.metadata.count(key)) << key;

    const nlohmann::json stats = nlohmann::json::parse(test::file_text(in_folder("s.json")));
    EXPECT_EQ(stats["scene"]["width"], 24);
    EXPECT_EQ(stats["settings"]["method"], "path");
    EXPECT_EQ(stats["settings"]["seed"], 7);
    EXPECT_EQ(stats["rays"]["camera"], 24 * 24);
    EXPECT_GT(stats["stages"].size(), 0u);
    EXPECT_GT(stats["memory"]["host_peak_bytes"], 1 << 20);
    EXPECT_GT(stats["memory"]["device_peak_bytes"], 0);
    EXPECT_GE(stats["wall_seconds"]["total"], stats["wall_seconds"]["render"]);
}

TEST_F(RenderCommand, QuietSaysNothing) {
    const test::Outcome outcome = render_small({"-o", "a.pfm", "--quiet"});
    EXPECT_EQ(outcome.status, 0);
    EXPECT_EQ(outcome.out + outcome.err, "");
    EXPECT_EQ(files(), 1u);
}

TEST_F(RenderCommand, VerboseTellsSceneDeviceAndStages) {
    const std::string err = render_small({"-o", "a.pfm", "--verbose"}).err;
    for (const char* what : {"triangles", "device 0", "device time", "rays", "peak memory"})
        EXPECT_NE(err.find(what), std::string::npos) << what << " in:\n" << err;
}

TEST_F(RenderCommand, AovLayersGoIntoTheExr) {
    ASSERT_EQ(render_small({"-o", "a.exr", "--aov", "albedo,depth"}).status, 0);
    const Image image = read_image(in_folder("a.exr"));
    std::vector<std::string> names;
    for (const Layer& layer : image.layers) names.push_back(layer.name);
    std::sort(names.begin(), names.end());
    EXPECT_EQ(names, (std::vector<std::string>{"", "albedo", "depth"}));
}

TEST_F(RenderCommand, SeedDecidesThePicture) {
    ASSERT_EQ(render_small({"-o", "a.pfm", "--seed", "1"}).status, 0);
    ASSERT_EQ(render_small({"-o", "b.pfm", "--seed", "1", "--threads", "1"}).status, 0);
    ASSERT_EQ(render_small({"-o", "c.pfm", "--seed", "2"}).status, 0);
    EXPECT_EQ(test::file_text(in_folder("a.pfm")), test::file_text(in_folder("b.pfm")));
    EXPECT_NE(test::file_text(in_folder("a.pfm")), test::file_text(in_folder("c.pfm")));
}

// By default the host's threads share launches out (src/device/launch.h); where POCL_DEVICES names it, PoCL's own do.
TEST_F(RenderCommand, DriversOfPoclGiveTheSamePicture) {
    const std::string devices = render({"--list-devices"}).out;
    if (devices.find("Portable Computing Language") == std::string::npos) GTEST_SKIP() << "needs PoCL";
    ASSERT_EQ(render_small({"-o", "a.pfm", "--device", "portable"}).status, 0);
    EXPECT_NE(call("env", {"POCL_DEVICES=pthread", RENDER, "--list-devices"}).out, devices);
    const test::Outcome outcome =
        call("env", {"POCL_DEVICES=pthread", RENDER, kScene, "--method", "path", "--spp", "1", "--width", "24",
                     "--height", "24", "-o", "b.pfm", "--device", "portable"});
    ASSERT_EQ(outcome.status, 0) << outcome.err;
    EXPECT_EQ(test::file_text(in_folder("a.pfm")), test::file_text(in_folder("b.pfm")));
}

// scenes/cornell-box.xml has a box filter: naming it changes nothing, a wide one does, also on a packed scene.
TEST_F(RenderCommand, FilterReplacesTheScenes) {
    ASSERT_EQ(render_small({"-o", "a.pfm"}).status, 0);
    ASSERT_EQ(render_small({"-o", "box.pfm", "--rfilter", "box"}).status, 0);
    ASSERT_EQ(render_small({"-o", "tent.pfm", "--rfilter", "tent", "--stats", "s.json"}).status, 0);
    EXPECT_EQ(test::file_text(in_folder("a.pfm")), test::file_text(in_folder("box.pfm")));
    EXPECT_NE(test::file_text(in_folder("a.pfm")), test::file_text(in_folder("tent.pfm")));
    EXPECT_EQ(nlohmann::json::parse(test::file_text(in_folder("s.json")))["scene"]["rfilter"], "tent");

    ASSERT_EQ(render({kScene, "--pack", "scene.bin", "--width", "24", "--height", "24"}).status, 0);
    ASSERT_EQ(render({"scene.bin", "-o", "packed.pfm", "--method", "path", "--spp", "1", "--rfilter", "tent"}).status,
              0);
    EXPECT_EQ(test::file_text(in_folder("tent.pfm")), test::file_text(in_folder("packed.pfm")));
}

TEST_F(RenderCommand, PackedSceneGivesTheSamePicture) {
    const test::Outcome packed = render({kScene, "--pack", "scene.bin", "--width", "24", "--height", "24"});
    ASSERT_EQ(packed.status, 0) << packed.err;
    EXPECT_EQ(files(), 1u);  // packed, not rendered
    ASSERT_EQ(render_small({"-o", "a.pfm"}).status, 0);
    ASSERT_EQ(render({"scene.bin", "-o", "b.pfm", "--method", "path", "--spp", "1"}).status, 0);
    EXPECT_EQ(test::file_text(in_folder("a.pfm")), test::file_text(in_folder("b.pfm")));

    ASSERT_EQ(render({"scene.bin", "-o", "c.pfm", "--method", "path", "--spp", "1", "--width", "12"}).status, 0);
    EXPECT_EQ(read_image(in_folder("c.pfm")).height, 12);
    expect_one_line(render({"scene.bin", "-o", "d.pfm", "--width", "12", "--height", "6"}), 1, "render",
                    "packed for 24 x 24");
    expect_one_line(render({"scene.bin", "-o", "d.pfm", "-D", "spp=4"}), 2, "render", "-D");

    std::filesystem::resize_file(in_folder("scene.bin"), 1000);
    expect_one_line(render({"scene.bin", "-o", "d.pfm"}), 1, "render", "scene.bin");
}

}  // namespace
}  // namespace irradia
