#include <cmath>

#include "image/image_check.h"
#include "irradia/Metrics.h"
#include "pictures.h"

namespace irradia {
namespace {

double lightness(const Image& image, int x) {  // luminance, monotone in lightness
    const float* p = &image.layers[0].data[static_cast<std::size_t>(x) * 3];
    return 0.2126 * p[0] + 0.7152 * p[1] + 0.0722 * p[2];
}

TEST(ErrorPicture, GetsLighterWithTheErrorFromBlackToTheLastColour) {
    const Image ref = test::picture(64, 4, [](int, int, int) { return 2; });
    const Image x = test::picture(64, 4, [](int column, int, int) { return 2 + 0.01 * column; });  // 0 to 31.5 %
    const ErrorPicture e = error_picture(x, ref, {}, 0.315);
    EXPECT_EQ(e.scale, 0.315);
    for (int column = 1; column < 64; ++column)
        EXPECT_GT(lightness(e.image, column), lightness(e.image, column - 1)) << column;
    // matplotlib's inferno ends: #000004 and #fcffa4.
    const float* first = &e.image.layers[0].data[0];
    const float* last = &e.image.layers[0].data[63 * 3];
    const int begin[] = {0x00, 0x00, 0x04}, end[] = {0xfc, 0xff, 0xa4};
    for (int c = 0; c < 3; ++c) {
        EXPECT_NEAR(255 * srgb_encode(first[c]), begin[c], 1.0) << c;
        EXPECT_NEAR(255 * srgb_encode(last[c]), end[c], 1.0) << c;
    }
}

TEST(ErrorPicture, ScalesByThe99thPercentileAndGreysOutTheMask) {
    const Image ref = test::picture(100, 10, [](int, int, int) { return 1; });
    Image x = test::picture(100, 10, [](int, int y, int) { return y < 5 ? 1.0 : 1.1; });
    x.layers[0].data[0] = 100;  // one wild pixel does not set the scale
    EXPECT_NEAR(error_picture(x, ref).scale, 0.1, 1e-6);

    const Image mask = test::picture(100, 10, [](int column, int, int) { return column == 3 ? 0 : 1; });
    MetricsOptions options;
    options.mask = &mask;
    const ErrorPicture e = error_picture(x, ref, options);
    const float* p = &e.image.layers[0].data[3 * 3];
    EXPECT_EQ(p[0], p[1]);
    EXPECT_EQ(p[1], p[2]);
    EXPECT_GT(p[0], 0);
    EXPECT_NE(e.image.metadata.at("irradia.colour map").find("inferno"), std::string::npos);
}

}  // namespace
}  // namespace irradia
