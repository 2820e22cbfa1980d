#include "core/pfm.h"

#include <gtest/gtest.h>

#include <bit>
#include <cmath>
#include <cstring>
#include <limits>
#include <string>

#include "small_scene.h"

namespace {

using irradia::Image;
using irradia::read_pfm;
using irradia::write_pfm;
using namespace irradia::test;

Image picture(int width, int height, int channels) {
    Image image{width, height, {{"", channels, {}}}, {}};
    for (int i = 0; i < width * height * channels; ++i)
        image.layers[0].data.push_back(0.25f * static_cast<float>(i) - 1.0f);
    return image;
}

std::string float_bytes(float v, bool big) {
    std::string s(4, '\0');
    std::memcpy(s.data(), &v, 4);
    return big == (std::endian::native == std::endian::big) ? s : std::string(s.rbegin(), s.rend());
}

TEST(Pfm, RoundTrip) {
    TemporaryFolder folder;
    const Image image = picture(7, 5, 3);
    write_pfm(folder.file("a.pfm"), image);
    const Image back = read_pfm(folder.file("a.pfm"));
    EXPECT_EQ(back.width, 7);
    EXPECT_EQ(back.height, 5);
    EXPECT_EQ(back.layers.at(0).channels, 3);
    EXPECT_EQ(back.layers.at(0).data, image.layers[0].data);
    EXPECT_EQ(folder.count(), 1u);
}

TEST(Pfm, BytesAreThoseOfTheFormat) {
    TemporaryFolder folder;
    write_pfm(folder.file("a.pfm"), picture(1, 2, 3));
    const bool big = std::endian::native == std::endian::big;
    std::string expected = big ? "PF\n1 2\n1.0\n" : "PF\n1 2\n-1.0\n";
    for (const float v : {-0.25f, 0.0f, 0.25f, -1.0f, -0.75f, -0.5f})
        expected += float_bytes(v, big);  // bottom row first
    EXPECT_EQ(read_file(folder.file("a.pfm")), expected);
}

TEST(Pfm, OneChannelAndOtherByteOrder) {
    TemporaryFolder folder;
    for (const bool big : {false, true}) {
        write_file(folder.file("a.pfm"), std::string("Pf 2 1 ") + (big ? "1" : "-1") + "\n" + float_bytes(0.5f, big) +
                                             float_bytes(3.0f, big));
        EXPECT_EQ(read_pfm(folder.file("a.pfm")).layers[0].data,
                  (irradia::UntouchedVector<float>{0.5f, 0.5f, 0.5f, 3, 3, 3}));
    }
    write_pfm(folder.file("b.pfm"), picture(2, 1, 1));
    EXPECT_EQ(read_pfm(folder.file("b.pfm")).layers[0].data,
              (irradia::UntouchedVector<float>{-1, -1, -1, -0.75f, -0.75f, -0.75f}));
}

TEST(Pfm, NonFiniteIsNotWritten) {
    TemporaryFolder folder;
    Image image = picture(4, 3, 3);
    image.layers[0].data[3 * (1 * 4 + 2) + 1] = std::numeric_limits<float>::quiet_NaN();
    std::string message = error_of([&] { write_pfm(folder.file("a.pfm"), image); });
    EXPECT_TRUE(one_line(message) && has(message, "pixel (2, 1), channel 1 is not a number")) << message;
    image.layers[0].data[3] = -std::numeric_limits<float>::infinity();
    message = error_of([&] { write_pfm(folder.file("a.pfm"), image); });
    EXPECT_TRUE(one_line(message) && has(message, "pixel (1, 0), channel 0 is infinite")) << message;
    EXPECT_EQ(folder.count(), 0u);
}

TEST(Pfm, BadFilesAreOneLine) {
    TemporaryFolder folder;
    const std::string path = folder.file("a.pfm");
    write_pfm(path, picture(4, 3, 3));
    const std::string whole = read_file(path);
    for (std::size_t n = 0; n < whole.size(); ++n) {
        write_file(path, whole.substr(0, n));
        EXPECT_TRUE(one_line(error_of([&] { read_pfm(path); }))) << n;
    }
    for (const std::string text : {"P6 1 1 1\n", "PF 0 1 -1\n", "PF -1 1 -1\n", "PF 1 1 0\n", "PF 1 1 nan\n",
                                   "PF 2000000000 2000000000 -1\n", "PF 99999999999 1 -1\n"}) {
        write_file(path, text + std::string(100, '\0'));
        EXPECT_TRUE(one_line(error_of([&] { read_pfm(path); }))) << text;
    }
    EXPECT_TRUE(has(error_of([&] { read_pfm(folder.file("missing")); }), "No such file"));
    EXPECT_TRUE(has(error_of([&] { write_pfm(folder.file("no/a.pfm"), picture(1, 1, 3)); }),
                    "cannot be written: No such file"));
    EXPECT_TRUE(has(error_of([&] { write_pfm(path, Image{}); }), "empty"));
    Image wrong = picture(2, 2, 3);
    wrong.layers[0].data.pop_back();
    EXPECT_TRUE(has(error_of([&] { write_pfm(path, wrong); }), "11 values"));
}

}  // namespace
