// Which pixels need not be asked whether they want records: by hand, and by the kernel's word in a render.
#include "render/plain_pixels.h"

#include <gtest/gtest.h>

#include <bit>
#include <functional>
#include <vector>

#include "irradia/shared/record_types.h"
#include "render_fixture.h"

namespace irradia {
namespace {

constexpr std::uint32_t plain_code = 0x80000001u;
constexpr float apart = 1e-3f;

class PlainPixelsTest : public ::testing::Test {
protected:
    Device device_{DeviceOptions{}};

    /// Of all pixels but those that the first iterations look at, those that stay; `code` and `plane` of column, row of
    /// the others.
    PixelList left(std::uint32_t width, std::uint32_t height,
                   const std::function<std::uint32_t(std::uint32_t, std::uint32_t)>& code,
                   const std::function<float(std::uint32_t, std::uint32_t)>& plane,
                   const std::vector<std::uint32_t>& disturbed = {}) {
        PlainPixels plain(device_, width, height);
        plain.forget();
        std::vector<std::uint32_t> words;
        for (std::uint32_t y = 0; y < height; y += 2)
            for (std::uint32_t x = 0; x < width; x += 2)
                words.insert(words.end(), {code(x, y), std::bit_cast<std::uint32_t>(plane(x, y))});
        EXPECT_EQ(words.size() * sizeof words[0], plain.words().bytes());
        device_.write(const_cast<Buffer&>(plain.words()), words.data(), words.size() * sizeof words[0]);
        for (const std::uint32_t pixel : disturbed) plain.disturb(pixel);
        PixelList pixels;
        for (std::uint32_t i = 0; i < width * height; ++i)
            if (i % width % 2 != 0 || i / width % 2 != 0) pixels.push_back(i);
        plain.drop(pixels, apart);
        return pixels;
    }
};

std::uint32_t all_plain(std::uint32_t, std::uint32_t) { return plain_code; }
float one_plane(std::uint32_t, std::uint32_t) { return -2.5f; }

// Sizes with and without pixels beyond the last even ones; more pixels than one range.
TEST_F(PlainPixelsTest, NoneIsAskedOfOnePlane) {
    for (const auto& [w, h] : {std::pair{5u, 4u}, {4u, 5u}, {1u, 2u}, {2u, 1u}, {301u, 200u}})
        EXPECT_TRUE(left(w, h, all_plain, one_plane).empty()) << w << " x " << h;
}

TEST_F(PlainPixelsTest, AllAreAskedBeforeAnythingIsKnown) {
    EXPECT_EQ(left(
                  301, 200, [](auto, auto) { return 0u; }, [](auto, auto) { return 0.0f; })
                  .size(),
              301u * 200u - 151u * 100u);
}

TEST_F(PlainPixelsTest, AroundOneThatIsNotPlainAllEightAreAsked) {
    const PixelList asked = left(
        16, 12, [](std::uint32_t x, std::uint32_t y) { return x == 6 && y == 4 ? 0u : plain_code; }, one_plane);
    const std::vector<std::uint32_t> around{53, 54, 55, 69, 71, 85, 86, 87};  // (5..7, 3..5) of rows of 16
    EXPECT_EQ(std::vector<std::uint32_t>(asked.begin(), asked.end()), around);
}

// Two normals; two coplanar by rounding, then not.
TEST_F(PlainPixelsTest, BetweenTwoPlanesAllAreAsked) {
    const auto turned = [](std::uint32_t x, std::uint32_t) { return x < 8 ? plain_code : plain_code + 1; };
    const auto step = [](float by) {
        return [by](std::uint32_t x, std::uint32_t) { return x < 8 ? -2.5f : by - 2.5f; };
    };
    for (const PixelList& asked : {left(16, 4, turned, one_plane), left(16, 4, all_plain, step(2 * apart))}) {
        ASSERT_EQ(asked.size(), 4u);
        for (std::uint32_t y = 0; y < 4; ++y) EXPECT_EQ(asked[y], 16 * y + 7);
    }
    EXPECT_TRUE(left(16, 4, all_plain, step(0.5f * apart)).empty());
}

// Five pairs of columns and rows, of which the record's pixel is in the middle one.
TEST_F(PlainPixelsTest, NearNewRecordsAllAreAsked) {
    const PixelList asked = left(40, 40, all_plain, one_plane, {21 * 40 + 18, 0});
    for (const std::uint32_t pixel : asked) {
        const std::uint32_t x = pixel % 40, y = pixel / 40;
        EXPECT_TRUE((x >= 14 && x < 24 && y >= 16 && y < 26) || (x < 6 && y < 6)) << x << ", " << y;
    }
    EXPECT_EQ(asked.size(), 3u * (100 + 36) / 4);
}

// By what the kernel tells. The sphere, which fills the picture, is nowhere plane; of the room most is. One camera ray
// a pixel is its sample.
TEST_F(PlainPixelsTest, PlanesAreLookedAtOnlyInPart) {
    RenderSettings settings;
    settings.method = Method::irradiance;
    settings.spp = 1;
    settings.max_depth = 3;  // whose samples are never paths
    settings.min_spacing = 4;
    settings.accuracy = 0.5f;
    const auto looks_a_pixel = [&](const Scene& scene) {
        const RenderResult result = render(scene, device_, settings);
        const double pixels = static_cast<double>(scene.info.width) * scene.info.height;
        return static_cast<double>(result.statistics.rays.at("camera")) / pixels - 1;
    };
    EXPECT_LT(looks_a_pixel(test::load(test::project_scene("cornell-box.xml"), {}, 256, 256)), 0.6);
    EXPECT_GE(looks_a_pixel(test::load_text(R"(<scene version="3.0.0"><sensor type="perspective">
<transform name="to_world"><lookat origin="0, 0, -4" target="0, 0, 0" up="0, 1, 0"/></transform><float name="fov" value="20"/>
<film type="hdrfilm"><integer name="width" value="64"/><integer name="height" value="64"/></film></sensor>
<shape type="sphere"/><emitter type="constant"/></scene>)")),
              0.95);
}

}  // namespace
}  // namespace irradia
