// Error measures against what they are by definition.
#include <cmath>

#include "irradia/Error.h"
#include "irradia/Metrics.h"
#include "pictures.h"

namespace irradia {
namespace {

using test::noisy;
using test::picture;

// A reference with structure: mean 0.5 by symmetry.
Image wave(int width = 128, int height = 96) {
    return picture(width, height, [=](int x, int y, int c) {
        return 0.5 + 0.3 * std::sin(2 * M_PI * (x + 0.5) / width) * std::cos(2 * M_PI * (2 * y + 1) / height) +
               0.1 * (c - 1);
    });
}

Image flat(double value) {
    return picture(32, 32, [=](int, int, int) { return value; });
}

TEST(Metrics, EqualPicturesHaveNoError) {
    const Metrics m = compare_images(wave(), wave());
    EXPECT_EQ(m.mse, 0);
    EXPECT_EQ(m.rel_rmse, 0);
    EXPECT_EQ(m.rel_mse, 0);
    EXPECT_EQ(m.mean_bias, 0);
    EXPECT_EQ(m.mean_bias_interval, 0);
    EXPECT_EQ(m.max_error, 0);
    EXPECT_NEAR(m.ssim, 1, 1e-12);
    EXPECT_EQ(m.pixels, 128u * 96u);
    EXPECT_NEAR(m.mean_reference, 0.5, 1e-6);
}

// x = 1.1 ref with ref = 0.4: every measure in closed form.
TEST(Metrics, ConstantFactor) {
    const Metrics m = compare_images(flat(0.44), flat(0.4));
    EXPECT_NEAR(m.rel_rmse, 0.1, 1e-6);
    EXPECT_NEAR(m.rel_rmse_raw, 0.1, 1e-6);
    EXPECT_NEAR(m.mean_bias, 0.1, 1e-6);
    EXPECT_NEAR(m.rel_mse, 0.04 * 0.04 / (0.16 + 0.01), 1e-8);
    EXPECT_NEAR(m.max_error, 0.04, 1e-6);
    EXPECT_NEAR(m.mean_bias_interval, 0, 1e-6);  // the same everywhere
    // Both constant: SSIM is its luminance term of the sRGB codes of 0.18 and 0.198.
    const double y = 1.055 * std::pow(0.18, 1 / 2.4) - 0.055, x = 1.055 * std::pow(0.198, 1 / 2.4) - 0.055;
    EXPECT_NEAR(m.ssim, (2 * x * y + 1e-4) / (x * x + y * y + 1e-4), 1e-6);
}

TEST(Metrics, OneWrongChannelOfOnePixel) {
    Image x = flat(1);
    x.layers[0].data[(7 * 32 + 5) * 3 + 2] = 3;  // off by 2 in one of 3072 values
    const Metrics m = compare_images(x, flat(1));
    EXPECT_NEAR(m.mse, 4.0 / 3072, 1e-12);
    EXPECT_NEAR(m.mean_bias, 2.0 / 3072, 1e-12);
    EXPECT_NEAR(m.rel_mse, 4.0 / 1.01 / 3072, 1e-12);
    EXPECT_EQ(m.max_error, 2);
    EXPECT_EQ(m.max_x, 5);
    EXPECT_EQ(m.max_y, 7);
}

TEST(Metrics, MaskLeavesPixelsOutOfEveryMeasure) {
    const Image ref = wave();
    const Image mask = picture(128, 96, [](int x, int, int) { return x < 64 ? 1 : 0; });
    Image x = ref;
    for (int y = 0; y < 96; ++y)
        for (int i = 64 * 3; i < 128 * 3; ++i) x.layers[0].data[static_cast<std::size_t>(y * 128 * 3 + i)] = NAN;
    MetricsOptions options;
    options.mask = &mask;
    const Metrics m = compare_images(x, ref, options);
    EXPECT_EQ(m.pixels, 64u * 96u);
    EXPECT_EQ(m.rel_rmse, 0);
    EXPECT_NEAR(m.ssim, 1, 1e-12);  // and no NaN comes in through a window

    EXPECT_THROW(compare_images(x, ref), Error);  // without the mask the NaN is found
}

// Two halves a = ref + n1, b = ref + n2 of known noise: (x−a)(x−b) is free of it, (a+b)/2 has deviation s/√2.
TEST(Metrics, HalvesTakeTheReferencesNoiseOut) {
    const Image truth = wave(256, 256);
    Image x = truth;
    for (float& v : x.layers[0].data) v *= 1.02f;
    const double s = 0.05;  // five times the error that is to be seen
    const Image a = noisy(truth, s, 1), b = noisy(truth, s, 2);
    MetricsOptions options;
    options.reference_b = &b;
    const Metrics m = compare_images(x, a, options);
    const Metrics exact = compare_images(x, truth);
    // Standard error of mean((x−a)(x−b)) over n values: sqrt(s⁴ + 2 s² mse) / sqrt(n).
    const double n = 3.0 * 256 * 256, sigma = std::sqrt(s * s * s * s + 2 * s * s * exact.mse) / std::sqrt(n);
    EXPECT_NEAR(m.mse, exact.mse, 4 * sigma);
    EXPECT_LT(4 * sigma, 0.5 * exact.mse);  // the test can tell
    EXPECT_NEAR(m.reference_rel_rmse, s / std::sqrt(2.0) / 0.5, 4 * s / std::sqrt(2.0) / 0.5 / std::sqrt(2 * n));
    EXPECT_GT(m.rel_rmse_raw, 3 * m.rel_rmse);
    EXPECT_EQ(m.reference_rel_rmse, relative_rmse_of_halves(a, b));
    // Bias is 2 %, known to within its interval (1.96 standard errors; three of them here).
    EXPECT_NEAR(m.mean_bias, 0.02, 1.5 * m.mean_bias_interval);
    EXPECT_LT(m.mean_bias_interval, 0.002);
}

TEST(Metrics, KnownErrorOfASingleReferenceIsSubtracted) {
    const Image truth = wave(256, 256);
    Image x = truth;
    for (float& v : x.layers[0].data) v += 0.05f;
    MetricsOptions options;
    options.reference_rel_rmse = 0.04;
    const Metrics m = compare_images(x, truth, options);
    EXPECT_NEAR(m.rel_rmse_raw, 0.1, 1e-5);
    EXPECT_NEAR(m.rel_rmse, std::sqrt(0.1 * 0.1 - 0.04 * 0.04), 1e-5);
}

// Independent noise of deviation s a channel: the interval is 1.96 s / sqrt(n) / mean, up to its own uncertainty
// (192 tiles: 5 % a standard deviation).
TEST(Metrics, BiasIntervalIsThatOfTheNoise) {
    const Image ref = wave(256, 192);
    const Metrics m = compare_images(noisy(ref, 0.2, 3), ref);
    const double expected = 1.96 * 0.2 / std::sqrt(3.0 * 256 * 192) / 0.5;
    EXPECT_NEAR(m.mean_bias_interval, expected, 0.2 * expected);
    EXPECT_LT(std::abs(m.mean_bias), 2 * expected);
}

TEST(Metrics, SsimFallsWithNoiseAndDoesNotSeeExposure) {
    const Image ref = wave();
    const auto brighter = [](Image image) {
        for (float& v : image.layers[0].data) v *= 8;
        return image;
    };
    const Image x = noisy(ref, 0.05, 4);
    const double little = compare_images(x, ref).ssim, much = compare_images(noisy(ref, 0.2, 4), ref).ssim;
    EXPECT_LT(little, 0.999);
    EXPECT_LT(much, little - 0.1);
    EXPECT_NEAR(compare_images(brighter(x), brighter(ref)).ssim, little, 1e-6);
}

TEST(Metrics, WhatCannotBeComparedIsSaid) {
    const auto error_of = [](const Image& x, const Image& ref, const MetricsOptions& options = {}) -> std::string {
        try {
            compare_images(x, ref, options);
        } catch (const Error& error) {
            return error.what();
        }
        return "no Error";
    };
    EXPECT_NE(error_of(wave(), flat(1)).find("128 x 96 pixels, the reference 32 x 32"), std::string::npos);
    EXPECT_NE(error_of(flat(1), flat(0)).find("mean is 0"), std::string::npos);
    const Image nothing = flat(0);
    MetricsOptions options;
    options.mask = &nothing;
    EXPECT_NE(error_of(flat(1), flat(1), options).find("counts no pixel"), std::string::npos);
    Image bad = flat(1);
    bad.layers[0].data[(3 * 32 + 2) * 3] = NAN;
    EXPECT_NE(error_of(flat(1), bad).find("reference is nan at pixel (2, 3)"), std::string::npos);
    EXPECT_NE(error_of(bad, flat(1)).find("picture is nan at pixel (2, 3)"), std::string::npos);
}

}  // namespace
}  // namespace irradia
