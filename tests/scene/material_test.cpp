// Colours and pictures of materials. Everything else of a <bsdf>: bsdf_test.cpp.
#include "bsdf_test.h"

namespace irradia::test {
namespace {

class Material : public BsdfTest {
protected:
    Scene textured(const std::string& file, const std::string& extra = "", const LoadOptions& options = {}) {
        return with_bsdf(
            "<bsdf type=\"diffuse\"><texture type=\"bitmap\" name=\"reflectance\"><string name=\"filename\" value=\"" +
                file + "\"/>" + extra + "</texture></bsdf>",
            options);
    }
};

TEST_F(Material, DiffuseTwosidedAndTheDefault) {
    const Scene s = load(sensor + lamp + R"(
        <bsdf type="diffuse" id="one"><rgb name="reflectance" value="0.1 0.2 0.3"/></bsdf>
        <bsdf type="twosided" id="two"><ref id="one"/></bsdf>
        <shape type="rectangle"><ref id="two"/></shape><shape type="rectangle"><ref id="two"/></shape><shape type="rectangle"><ref id="one"/></shape>)");
    const auto& lamp_material = s.materials[s.triangles[0].material];
    expect_near({lamp_material.r, lamp_material.g, lamp_material.b}, {0.0, 0.0, 0.0},
                0.0);  // Mitsuba's default for emitters
    EXPECT_EQ(lamp_material.back, IR_NO_MATERIAL);
    EXPECT_EQ(s.triangles[2].material, s.triangles[4].material);
    const auto& two = s.materials[s.triangles[2].material];
    EXPECT_EQ(two.back, static_cast<int>(s.triangles[2].material));
    expect_near({two.r, two.g, two.b}, {0.1, 0.2, 0.3}, 1e-7);
    EXPECT_EQ(s.materials[s.triangles[6].material].back, IR_NO_MATERIAL);
    EXPECT_EQ(s.materials.size(), 3u);
}

TEST_F(Material, WaysToWriteAColour) {
    const auto colour = [&](const std::string& value) {
        const Scene s = with_bsdf("<bsdf type=\"diffuse\">" + value + "</bsdf>");
        const auto& m = s.materials[s.triangles[2].material];
        return Vec{m.r, m.g, m.b};
    };
    expect_near(colour(R"(<rgb name="reflectance" value="0.3"/>)"), {0.3, 0.3, 0.3}, 1e-7);
    expect_near(colour(R"(<float name="reflectance" value="0.3"/>)"), {0.3, 0.3, 0.3}, 1e-7);
    expect_near(colour(R"(<spectrum name="reflectance" value="0.3"/>)"), {0.3, 0.3, 0.3}, 1e-7);
    // IEC 61966-2-1: 0x80 -> 0.2158605, 0x40 -> 0.0512695, 0x05 -> 5/255/12.92
    expect_near(colour(R"(<rgb name="reflectance" value="#804005"/>)"), {0.2158605, 0.0512695, 5.0 / 255.0 / 12.92},
                1e-7);
}

TEST_F(Material, EightBitPicturesStayEncoded) {
    // Row 0 of the texels is the top row of the picture and lies at v = 0 (Mitsuba: uv (.25, .25) reads the top left
    // texel).
    write_picture<std::uint8_t>("t.png", 2, 2, 3, OIIO::TypeDesc::UINT8, {255, 0, 0, 0, 255, 0, 0, 0, 255, 1, 2, 3});
    const Scene s = textured("t.png");
    ASSERT_EQ(s.textures.size(), 1u);
    EXPECT_EQ(s.textures[0].format, IR_TEXTURE_RGBA8_SRGB);
    EXPECT_EQ(s.textures[0].width, 2u);
    EXPECT_EQ(s.texels, (std::vector<std::uint32_t>{0xff0000ffu, 0xff00ff00u, 0xffff0000u, 0xff030201u}));
    EXPECT_EQ(s.materials[s.triangles[2].material].texture, 0);
    EXPECT_EQ(s.materials[s.triangles[0].material].texture, IR_NO_TEXTURE);
    EXPECT_EQ(s.features, IR_FEATURE_TEXTURES);
    EXPECT_EQ(textured("t.png", R"(<boolean name="raw" value="true"/>)").textures[0].format, IR_TEXTURE_RGBA8_LINEAR);
}

TEST_F(Material, GreyAndAlphaChannels) {
    write_picture<std::uint8_t>("g.png", 1, 1, 1, OIIO::TypeDesc::UINT8, {77});
    EXPECT_EQ(textured("g.png").texels, (std::vector<std::uint32_t>{0xff4d4d4du}));
    write_picture<std::uint8_t>("a.png", 1, 1, 4, OIIO::TypeDesc::UINT8, {10, 20, 30, 255});
    EXPECT_EQ(textured("a.png").texels, (std::vector<std::uint32_t>{0xff1e140au}));
}

TEST_F(Material, SixteenBitIsDecodedToFloat) {
    write_picture<std::uint16_t>("s.png", 1, 1, 3, OIIO::TypeDesc::UINT16, {65535, 32768, 0});
    const Scene s = textured("s.png");
    ASSERT_EQ(s.textures[0].format, IR_TEXTURE_RGB32F);
    const double encoded = 32768.0 / 65535.0;
    EXPECT_NEAR(std::bit_cast<float>(s.texels[0]), 1.0, 1e-6);
    EXPECT_NEAR(std::bit_cast<float>(s.texels[1]), std::pow((encoded + 0.055) / 1.055, 2.4), 1e-6);
    EXPECT_EQ(std::bit_cast<float>(s.texels[2]), 0.0f);
    const Scene raw = textured("s.png", R"(<boolean name="raw" value="true"/>)");
    EXPECT_NEAR(std::bit_cast<float>(raw.texels[1]), encoded, 1e-6);
}

TEST_F(Material, ExrIsLinear) {
    write_picture<float>("f.exr", 2, 1, 3, OIIO::TypeDesc::FLOAT, {0.25f, 0.5f, 0.75f, 0.0f, 1.5f, 1.0f});
    const Scene s = textured("f.exr");
    ASSERT_EQ(s.textures[0].format, IR_TEXTURE_RGB32F);
    ASSERT_EQ(s.texels.size(), 6u);
    EXPECT_EQ(std::bit_cast<float>(s.texels[1]), 0.5f);
    EXPECT_EQ(std::bit_cast<float>(s.texels[4]), 1.0f);  // clamped, with a warning
    ASSERT_EQ(warnings_.size(), 1u);
    expect_message(warnings_[0], {"f.exr", "1 values outside [0, 1]"});
}

TEST_F(Material, FilterWrapAndToUv) {
    write_picture<std::uint8_t>("t.png", 1, 1, 3, OIIO::TypeDesc::UINT8, {1, 2, 3});
    const Scene s =
        textured("t.png", R"(<string name="filter_type" value="nearest"/><string name="wrap_mode" value="mirror"/>
        <transform name="to_uv"><scale x="2" y="3"/><translate x="0.25" y="0.5"/></transform>)");
    const auto& t = s.textures[0];
    EXPECT_EQ(t.filter, IR_FILTER_NEAREST);
    EXPECT_EQ(t.wrap, IR_WRAP_MIRROR);
    expect_near({t.m00, t.m01, t.m02}, {2, 0, 0.25}, 0.0);
    expect_near({t.m10, t.m11, t.m12}, {0, 3, 0.5}, 0.0);
    EXPECT_EQ(textured("t.png").textures[0].filter, IR_FILTER_BILINEAR);
    EXPECT_EQ(textured("t.png").textures[0].wrap, IR_WRAP_REPEAT);
    EXPECT_EQ(textured("t.png", R"(<string name="wrap_mode" value="clamp"/>)").textures[0].wrap, IR_WRAP_CLAMP);
}

TEST_F(Material, OneReadForTheSamePicture) {
    write_picture<std::uint8_t>("t.png", 1, 1, 3, OIIO::TypeDesc::UINT8, {1, 2, 3});
    const Scene s = load(sensor + lamp + R"(
        <texture type="bitmap" id="t"><string name="filename" value="t.png"/></texture>
        <shape type="rectangle"><bsdf type="diffuse"><ref id="t" name="reflectance"/></bsdf></shape>
        <shape type="rectangle"><bsdf type="twosided"><bsdf type="diffuse"><ref id="t" name="reflectance"/></bsdf></bsdf></shape>
        <shape type="rectangle"><bsdf type="diffuse"><texture type="bitmap" name="reflectance"><string name="filename" value="t.png"/>
            <string name="wrap_mode" value="clamp"/></texture></bsdf></shape>)");
    EXPECT_EQ(s.textures.size(), 2u);  // two wrap modes
    EXPECT_EQ(s.texels.size(), 1u);    // one picture
    EXPECT_EQ(s.textures[1].offset, s.textures[0].offset);
    EXPECT_EQ(s.textures[1].width, 1u);
}

TEST_F(Material, UnreadableTextures) {
    write("broken.png", "this is not a picture");
    expect_message(error_of([&] { textured("broken.png"); }), {"scene.xml:3:", "broken.png", "cannot be read"});
    expect_message(error_of([&] { textured("absent.jpg"); }), {"scene.xml:3:", "absent.jpg", "does not exist"});
    write_picture<float>("nan.exr", 1, 2, 3, OIIO::TypeDesc::FLOAT, {0, 0, 0, 0, NAN, 0});
    expect_message(error_of([&] { textured("nan.exr"); }), {"nan.exr", "not finite", "pixel (0, 1)"});
}

TEST_F(Material, TruncatedPicture) {
    std::vector<std::uint8_t> noise;
    for (unsigned i = 0, x = 1; i < 64 * 64 * 3; ++i)
        noise.push_back(static_cast<std::uint8_t>((x = x * 1664525u + 1013904223u) >> 24));
    write_picture<std::uint8_t>("t.png", 64, 64, 3, OIIO::TypeDesc::UINT8, noise);
    std::filesystem::resize_file(path("t.png"), std::filesystem::file_size(path("t.png")) / 2);
    expect_message(error_of([&] { textured("t.png"); }), {"t.png", "cannot be read"});
}

TEST_F(Material, ValuesOutOfRange) {
    expect_message(
        error_of([&] { with_bsdf(R"(<bsdf type="diffuse"><rgb name="reflectance" value="0.5, 1.5, 0.5"/></bsdf>)"); }),
        {"scene.xml:3:", "reflectance (0.5, 1.5, 0.5)", "[0, 1]"});
    expect_message(
        error_of([&] { with_bsdf(R"(<bsdf type="diffuse"><rgb name="reflectance" value="#12345"/></bsdf>)"); }),
        {"#12345", "#rrggbb"});
    expect_message(
        error_of([&] { with_bsdf(R"(<bsdf type="diffuse"><rgb name="reflectance" value="1, 2"/></bsdf>)"); }),
        {"2 numbers", "1 or 3"});
    expect_message(error_of([&] { with_bsdf(R"(<bsdf type="twosided"/>)"); }), {"needs a nested bsdf"});
    expect_message(error_of([&] { textured("t.png", R"(<string name="wrap_mode" value="repaet"/>)"); }), {"t.png"});
}

TEST_F(Material, BadTextureSettings) {
    write_picture<std::uint8_t>("t.png", 1, 1, 3, OIIO::TypeDesc::UINT8, {1, 2, 3});
    expect_message(error_of([&] { textured("t.png", R"(<string name="wrap_mode" value="repaet"/>)"); }),
                   {"wrap_mode", "repaet", "clamp"});
    expect_message(error_of([&] { textured("t.png", R"(<string name="filter_type" value="cubic"/>)"); }),
                   {"filter_type", "cubic", "bilinear"});
    expect_message(error_of([&] { textured("t.png", R"(<string name="wrap_mod" value="clamp"/>)"); }),
                   {"wrap_mod", "did you mean 'wrap_mode'"});
}

}  // namespace
}  // namespace irradia::test
