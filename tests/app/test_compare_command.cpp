// `compare` as a user calls it.
#include <nlohmann/json.hpp>

#include "command.h"

namespace irradia {
namespace {

class CompareCommand : public test::CommandTest {
protected:
    void SetUp() override {
        CommandTest::SetUp();
        const Image reference =
            test::picture(40, 30, [](int x, int y, int c) { return 1.0 + 0.01 * x + 0.02 * y + 0.1 * c; });
        Image picture = reference;
        for (float& v : picture.layers[0].data) v *= 1.1f;
        write_image(in_folder("ref.exr"), reference);
        write_image(in_folder("x.exr"), picture);
        write_image(in_folder("a.exr"), test::noisy(reference, 0.05, 1));
        write_image(in_folder("b.exr"), test::noisy(reference, 0.05, 2));
        write_image(in_folder("small.exr"), test::picture(8, 8, [](int, int, int) { return 1; }));
        write_image(in_folder("left.exr"), test::picture(40, 30, [](int x, int, int) { return x < 10 ? 1 : 0; }));
    }
    test::Outcome compare(const std::vector<std::string>& arguments) const { return call(COMPARE, arguments); }
};

TEST_F(CompareCommand, HelpExplainsEveryOption) {
    const test::Outcome help = compare({"--help"});
    EXPECT_EQ(help.status, 0);
    for (const char* option : {"--mask", "--json", "--heatmap", "--heatmap-scale", "--ref-a", "--ref-b", "--ref-error"})
        EXPECT_NE(help.out.find(option), std::string::npos) << option;
}

TEST_F(CompareCommand, JsonHoldsTheMeasures) {
    const test::Outcome outcome = compare({"x.exr", "ref.exr", "--json"});
    ASSERT_EQ(outcome.status, 0) << outcome.err;
    const nlohmann::json j = nlohmann::json::parse(outcome.out);
    EXPECT_NEAR(j["mean_bias"].get<double>(), 0.1, 1e-6);  // x = 1.1 ref
    // rel_rmse = 0.1 sqrt(mean(ref²)) / mean(ref); ref's mean is 1.585 and its variance that of three uniform grids.
    const double mean = 1 + 0.01 * 19.5 + 0.02 * 14.5 + 0.1;
    const double variance = 1e-4 * (40 * 40 - 1) / 12 + 4e-4 * (30 * 30 - 1) / 12 + 1e-2 * (3 * 3 - 1) / 12;
    EXPECT_NEAR(j["rel_rmse"].get<double>(), 0.1 * std::sqrt(mean * mean + variance) / mean, 1e-6);
    EXPECT_NEAR(j["mean_reference"].get<double>(), mean, 1e-6);
    EXPECT_EQ(j["pixels"], 1200);
    EXPECT_EQ(j["max_pixel"], (std::vector<int>{39, 29}));
    for (const char* key : {"relmse", "ssim", "max_error", "mean_bias_interval_95"})
        EXPECT_TRUE(j[key].is_number()) << key;
}

TEST_F(CompareCommand, TableAndErrorPicture) {
    const test::Outcome outcome = compare({"x.exr", "ref.exr", "--mask", "left.exr", "--heatmap", "e.png"});
    ASSERT_EQ(outcome.status, 0) << outcome.err;
    for (const char* what :
         {"relative RMSE", "relMSE", "mean bias       +10.0", "maximum", "SSIM", "300 pixels", "e.png"})
        EXPECT_NE(outcome.out.find(what), std::string::npos) << what << " in:\n" << outcome.out;
    EXPECT_EQ(read_image(in_folder("e.png")).width, 40);
}

TEST_F(CompareCommand, HalvesOfANoisyReference) {
    const test::Outcome outcome = compare({"x.exr", "--ref-a", "a.exr", "--ref-b", "b.exr", "--json"});
    ASSERT_EQ(outcome.status, 0) << outcome.err;
    const nlohmann::json halves = nlohmann::json::parse(outcome.out);
    const nlohmann::json exact = nlohmann::json::parse(compare({"x.exr", "ref.exr", "--json"}).out);
    // mse = 0.0258, each value's (x−a)(x−b) deviates by sqrt(s⁴ + 2 s² mse) = 0.0116, and there are 3600 of them.
    EXPECT_NEAR(halves["mse"].get<double>(), exact["mse"].get<double>(), 4 * 0.0116 / 60);
    EXPECT_GT(halves["reference_rel_rmse"].get<double>(), 0.015);
}

TEST_F(CompareCommand, BadInputExitsWithOne) {
    expect_one_line(compare({"x.exr", "small.exr"}), 1, "compare", "40 x 30 pixels, the reference 8 x 8");
    expect_one_line(compare({"x.exr", "ref.exr", "--mask", "small.exr"}), 1, "compare", "the mask 8 x 8");
    expect_one_line(compare({"none.exr", "ref.exr"}), 1, "compare", "none.exr");
    expect_one_line(compare({"x.exr", "none.exr"}), 1, "compare", "none.exr");
    expect_one_line(compare({"x.exr", "ref.exr", "--heatmap", "none/e.png"}), 1, "compare", "none/e.png");
    expect_one_line(compare({"x.exr", "ref.exr", "--heatmap", "e.gif"}), 1, "compare", "'.gif'");
}

TEST_F(CompareCommand, WrongCommandLineExitsWithTwo) {
    expect_one_line(compare({}), 2, "compare", "PICTURE");
    expect_one_line(compare({"x.exr"}), 2, "compare", "REFERENCE");
    expect_one_line(compare({"x.exr", "ref.exr", "--frobnicate"}), 2, "compare", "--frobnicate");
    expect_one_line(compare({"x.exr", "--ref-a", "a.exr"}), 2, "compare", "--ref-b");
    expect_one_line(compare({"x.exr", "ref.exr", "--ref-a", "a.exr", "--ref-b", "b.exr"}), 2, "compare", "REFERENCE");
    expect_one_line(compare({"x.exr", "ref.exr", "--heatmap-scale", "-1"}), 2, "compare", "--heatmap-scale");
}

}  // namespace
}  // namespace irradia
