// Pictures to files and back; what is refused leaves nothing behind.
#include <chrono>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <limits>
#include <thread>

#include "irradia/Error.h"
#include "pictures.h"

namespace irradia {
namespace {

using test::picture;
using ImageFile = test::InFolder;

// Every float differs, so that a swapped row, column or channel shows.
Image layered() {
    Image image = picture(5, 3, [](int x, int y, int c) { return 0.01 * x + 0.1 * y + c + 1e-7; });
    Layer direct{"direct", 3, {}}, normal{"normal", 3, {}}, depth{"depth", 1, {}}, records{"records", 1, {}};
    for (int i = 0; i < 15; ++i) {
        for (int c = 0; c < 3; ++c) direct.data.push_back(static_cast<float>(100 * c + i));
        for (int c = 0; c < 3; ++c) normal.data.push_back(static_cast<float>(-0.5 + c + 0.01 * i));
        depth.data.push_back(1e6f + static_cast<float>(i));
        records.data.push_back(i % 2 ? 1.0f : 0.0f);
    }
    for (Layer& layer : {std::ref(direct), std::ref(normal), std::ref(depth), std::ref(records)})
        image.layers.push_back(layer);
    image.metadata = {{"irradia.method", "irradiance"}, {"irradia.seed", "7"}};
    return image;
}

std::string error_of(const std::function<void()>& action) {
    try {
        action();
    } catch (const Error& error) {
        EXPECT_EQ(error.exit_status(), 1);
        EXPECT_EQ(std::string(error.what()).find('\n'), std::string::npos) << error.what();
        return error.what();
    }
    ADD_FAILURE() << "no Error";
    return "";
}

TEST_F(ImageFile, ExrKeepsEveryFloatLayerAndMetadata) {
    const Image written = layered();
    write_image(in_folder("a.exr"), written);
    const Image read = read_image(in_folder("a.exr"));
    EXPECT_EQ(read.width, 5);
    EXPECT_EQ(read.height, 3);
    ASSERT_EQ(read.layers.size(), written.layers.size());
    EXPECT_EQ(read.layers[0].name, "");
    for (const Layer& layer : written.layers) {
        const auto same = [&](const Layer& l) { return l.name == layer.name; };
        const auto found = std::find_if(read.layers.begin(), read.layers.end(), same);
        ASSERT_NE(found, read.layers.end()) << layer.name;
        EXPECT_EQ(found->channels, layer.channels) << layer.name;
        EXPECT_EQ(found->data, layer.data) << layer.name;  // bit for bit: float in, float out
    }
    for (const auto& [key, value] : written.metadata) {
        ASSERT_TRUE(read.metadata.count(key)) << key;
        EXPECT_EQ(read.metadata.at(key), value) << key;
    }
}

TEST_F(ImageFile, ExrOfOneImageIsTheSameBytes) {
    const auto bytes = [](const std::string& path) {
        std::ifstream in(path, std::ios::binary);
        return std::string(std::istreambuf_iterator<char>(in), {});
    };
    write_image(in_folder("a.exr"), layered());
    std::this_thread::sleep_for(std::chrono::milliseconds(1100));  // no second of the clock's is in it
    write_image(in_folder("b.exr"), layered());
    EXPECT_GT(bytes(in_folder("a.exr")).size(), 500u);
    EXPECT_EQ(bytes(in_folder("a.exr")), bytes(in_folder("b.exr")));
}

// Up to a megabyte: there is little to gain, and it takes time. Each colour in a row of its own, so that a large
// picture shrinks to almost nothing where it is compressed.
TEST_F(ImageFile, OnlyLargeExrsAreCompressed) {
    for (const auto& [edge, compressed] : {std::pair{256, false}, {512, true}}) {
        const Image written = picture(edge, edge, [](int, int y, int c) { return y + 1000 * c; });
        write_image(in_folder("a.exr"), written);
        const auto raw = static_cast<std::uintmax_t>(edge * edge * 3) * sizeof(float);
        const std::uintmax_t size = std::filesystem::file_size(in_folder("a.exr"));
        EXPECT_EQ(size < raw / 10, compressed) << size;
        EXPECT_EQ(size > raw, !compressed) << size;
        EXPECT_EQ(read_image(in_folder("a.exr")).layers.at(0).data, written.layers[0].data);
    }
}

TEST_F(ImageFile, ExrByAnyThreadsIsTheSameBytes) {
    Image image{300, 200, {{"", 3, {}}}, {}};  // of which five threads have enough to do
    for (int i = 0; i < 3 * 300 * 200; ++i)
        image.layers[0].data.push_back(std::sin(0.01f * static_cast<float>(i)) * static_cast<float>(i % 7));
    const auto bytes = [&](int threads) {
        const std::string path = in_folder(std::to_string(threads) + ".exr");
        write_image(path, image, 0.0, threads);
        std::ifstream in(path, std::ios::binary);
        return std::string(std::istreambuf_iterator<char>(in), {});
    };
    const std::string one = bytes(1);
    EXPECT_GT(one.size(), 10000u);
    for (const int threads : {0, 2, 3, 5, 64}) EXPECT_EQ(one, bytes(threads)) << threads;
    EXPECT_EQ(read_image(in_folder("3.exr")).layers[0].data, image.layers[0].data);
}

// IEC 61966-2-1: 255 (1.055 x^(1/2.4) - 0.055), or 255 * 12.92 x up to 0.0031308, evaluated in Python:
// 3.295 10.315 25.462 117.646 187.516; times 4: 12.931 29.343 56.334 220.586.
TEST_F(ImageFile, PngIsSrgbOfTheExposedValue) {
    const double linear[] = {-1.0, 0.0, 0.001, 0.0031308, 0.01, 0.18, 0.5, 1.0, 7.0};
    const int plain[] = {0, 0, 3, 10, 25, 118, 188, 255, 255};
    const int brighter[] = {0, 0, 13, 29, 56, 221, 255, 255, 255};  // two stops: times 4
    const Image image = picture(9, 2, [&](int x, int, int) { return linear[x]; });
    for (const bool exposed : {false, true}) {
        write_image(in_folder("a.png"), image, exposed ? 2.0 : 0.0);
        const Image read = read_image(in_folder("a.png"));  // decodes; coding it again gives the stored byte
        for (int x = 0; x < 9; ++x) {
            const double v = read.layers[0].data[static_cast<std::size_t>(x) * 3];
            const double coded = v <= 0.0031308 ? 12.92 * v : 1.055 * std::pow(v, 1 / 2.4) - 0.055;
            EXPECT_EQ(std::lround(255 * coded), (exposed ? brighter : plain)[x]) << "linear " << linear[x];
        }
    }
}

TEST_F(ImageFile, PngKeepsMetadata) {
    write_image(in_folder("a.png"), layered());
    EXPECT_EQ(read_image(in_folder("a.png")).metadata.at("irradia.method"), "irradiance");
}

TEST_F(ImageFile, PfmKeepsEveryFloatAndStoresRowsFromTheBottom) {
    const Image written = layered();
    write_image(in_folder("a.pfm"), written);
    EXPECT_EQ(read_image(in_folder("a.pfm")).layers[0].data, written.layers[0].data);

    std::ifstream in(in_folder("a.pfm"), std::ios::binary);
    std::string kind, scale;
    int width = 0, height = 0;
    in >> kind >> width >> height >> scale;
    in.get();
    float first = 0;
    in.read(reinterpret_cast<char*>(&first), sizeof first);
    EXPECT_EQ(kind, "PF");
    EXPECT_EQ(width, 5);
    EXPECT_EQ(height, 3);
    EXPECT_LT(std::stod(scale), 0);                       // little endian
    EXPECT_EQ(first, written.layers[0].data[2 * 5 * 3]);  // first pixel of the last row
}

TEST_F(ImageFile, NonFiniteValueIsRefusedByPixelAndLayerAndLeavesNoFile) {
    for (const float bad : {std::numeric_limits<float>::quiet_NaN(), -std::numeric_limits<float>::infinity()})
        for (const char* name : {"a.exr", "a.png", "a.pfm"}) {
            Image image = layered();
            image.layers[1].data[(2 * 5 + 4) * 3 + 1] = bad;
            const std::string what = error_of([&] { write_image(in_folder(name), image); });
            EXPECT_NE(what.find("'direct'"), std::string::npos) << what;
            EXPECT_NE(what.find("(4, 2)"), std::string::npos) << what;
            EXPECT_NE(what.find("direct.G"), std::string::npos) << what;
            EXPECT_EQ(files(), 0u) << name;
        }
}

TEST_F(ImageFile, UnknownExtensionNamesTheKnownOnes) {
    const std::string what = error_of([&] { write_image(in_folder("a.jpeg"), layered()); });
    EXPECT_NE(what.find("'.jpeg'"), std::string::npos) << what;
    EXPECT_NE(what.find(".exr, .png or .pfm"), std::string::npos) << what;
    EXPECT_EQ(files(), 0u);
}

TEST_F(ImageFile, MissingFolderIsNamedByThePathAskedFor) {
    for (const char* name : {"no/a.exr", "no/a.png", "no/a.pfm"}) {
        const std::string what = error_of([&] { write_image(in_folder(name), layered()); });
        EXPECT_EQ(what.rfind(in_folder(name) + ": cannot be written", 0), 0u) << what;
        EXPECT_EQ(what.find(".part"), std::string::npos) << what;
    }
}

TEST_F(ImageFile, FailedWriteKeepsTheOlderFile) {
    const Image good = layered();
    write_image(in_folder("a.exr"), good);
    Image bad = good;
    bad.layers[0].data[0] = std::numeric_limits<float>::quiet_NaN();
    error_of([&] { write_image(in_folder("a.exr"), bad); });
    EXPECT_EQ(read_image(in_folder("a.exr")).layers[0].data, good.layers[0].data);
    EXPECT_EQ(files(), 1u);
}

TEST_F(ImageFile, LayerOfTheWrongSizeIsRefused) {
    Image image = layered();
    image.layers[3].data.pop_back();
    EXPECT_NE(error_of([&] { write_image(in_folder("a.exr"), image); }).find("'depth' has 14 values"),
              std::string::npos);
}

TEST_F(ImageFile, UnreadableFilesAreOneLine) {
    EXPECT_NE(error_of([&] { read_image(in_folder("none.exr")); }).find("No such file"), std::string::npos);
    EXPECT_NE(error_of([&] { read_image(in_folder("none.pfm")); }).find("No such file"), std::string::npos);
    std::ofstream(in_folder("text.exr")) << "not a picture\n";
    error_of([&] { read_image(in_folder("text.exr")); });
    std::ofstream(in_folder("short.pfm")) << "PF\n4 4\n-1.0\nabc";
    EXPECT_NE(error_of([&] { read_image(in_folder("short.pfm")); }).find("truncated"), std::string::npos);
    write_image(in_folder("a.exr"), layered());
    std::filesystem::resize_file(in_folder("a.exr"), std::filesystem::file_size(in_folder("a.exr")) - 40);
    error_of([&] { read_image(in_folder("a.exr")); });
}

}  // namespace
}  // namespace irradia
