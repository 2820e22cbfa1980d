// <emitter type="envmap"> and "spot", textures as radiance: what becomes of them, and mistakes in them.
#include <OpenImageIO/imageio.h>

#include <bit>
#include <limits>
#include <numbers>

#include "scene_test.h"

namespace irradia::test {
namespace {

constexpr double pi = std::numbers::pi;

class Emitters : public SceneTest {
protected:
    void picture(const std::string& name, int width, int height, const std::vector<float>& data, int channels = 3,
                 OIIO::TypeDesc type = OIIO::TypeDesc::FLOAT) {
        auto out = OIIO::ImageOutput::create(path(name));
        ASSERT_TRUE(out && out->open(path(name), OIIO::ImageSpec(width, height, channels, type)));
        ASSERT_TRUE(out->write_image(OIIO::TypeDesc::FLOAT, data.data()));
        out->close();
    }
    static std::string envmap(const std::string& more = "", const std::string& file = "sky.exr") {
        return "\n<shape type=\"cube\"/><emitter type=\"envmap\"><string name=\"filename\" value=\"" + file + "\"/>" +
               more + "</emitter>";
    }
    static std::string spot(const std::string& parameters) {
        return lamp + "\n<emitter type=\"spot\">" + parameters + "</emitter>";
    }
    static std::string glow(const std::string& more = "") {
        return R"(<emitter type="area"><texture type="bitmap" name="radiance"><string name="filename" value="glow.exr"/>)" +
               more + "</texture></emitter>";
    }
    static float texel(const Scene& s, std::size_t i) { return std::bit_cast<float>(s.texels.at(i)); }
};

// Mean over the sphere of the bilinear picture, by the midpoint rule over each row of cells of polar angles a to b.
TEST_F(Emitters, EnvironmentPicture) {
    const std::vector<float> rows{1, 5, 2};  // grey, both columns alike
    std::vector<float> data;
    for (const float r : rows) data.insert(data.end(), {r, 0.5f * r, 2 * r, r, 0.5f * r, 2 * r});
    picture("sky.exr", 2, 3, data);
    const Scene s = load(sensor + envmap(R"(<float name="scale" value="2"/><transform name="to_world">
        <rotate y="1" angle="90"/></transform><boolean name="mis_compensation" value="true"/>
        <float name="sampling_weight" value="3"/>)"));
    ASSERT_EQ(s.lights.size(), 1u);
    const shared::Light& l = s.lights[0];
    EXPECT_EQ(l.kind, IR_LIGHT_ENVMAP);
    EXPECT_EQ(s.info.environment_light, 0);
    EXPECT_EQ(s.features & (IR_FEATURE_ENVIRONMENT | IR_FEATURE_ENVMAP | IR_FEATURE_TEXTURED_LIGHTS),
              IR_FEATURE_ENVIRONMENT | IR_FEATURE_ENVMAP);
    double sum = 0.0;
    for (int i = 0; i < 20000; ++i) {
        const double v = (i + 0.5) / 20000, y = 2 * v, at = y < 1 ? 1 + 4 * y : 5 - 3 * (y - 1);
        sum += at * std::sin(pi * v) * pi / 2 / 20000;
    }
    expect_near({l.r, l.g, l.b}, {2 * sum, sum, 4 * sum}, 1e-5);
    expect_near({l.e1x, l.e1y, l.e1z}, {0, 0, -1}, 1e-7);  // x turned about y
    expect_near({l.e2x, l.e2y, l.e2z}, {0, 1, 0}, 1e-7);
    expect_near({l.nx, l.ny, l.nz}, {1, 0, 0}, 1e-7);
    const shared::Texture& t = s.textures.at(static_cast<std::size_t>(l.texture));
    EXPECT_EQ(t.format, IR_TEXTURE_RGB32F);
    EXPECT_EQ(texel(s, t.offset), 2.0f);
    EXPECT_EQ(texel(s, t.offset + 6), 10.0f);
    // Tables: rows by flux, heights of the texels' rows, densities, cells (two alike).
    double upper = 0.0;
    for (int i = 0; i < 10000; ++i) {
        const double v = (i + 0.5) / 20000;
        upper += (1 + 4 * 2 * v) * std::sin(pi * v) * pi / 2 / 20000;
    }
    EXPECT_NEAR(texel(s, l.table), upper / sum, 1e-6);
    EXPECT_EQ(texel(s, l.table + 1), 1.0f);
    for (int i = 0; i < 3; ++i) EXPECT_NEAR(texel(s, l.table + 2 + static_cast<std::size_t>(i)), i == 1 ? 1 : 0, 1e-7);
    for (std::size_t i = 5; i < 7; ++i) EXPECT_NEAR(texel(s, l.table + i), 1 / pi, 1e-7);
    for (std::size_t i = 7; i < 11; ++i) EXPECT_EQ(texel(s, l.table + i), i % 2 == 1 ? 0.5f : 1.0f);
    EXPECT_EQ(s.texels.size(), l.table + 11u);
}

// However bright the sun: whatever is not black can be sampled, and what is black is not.
TEST_F(Emitters, DimPartsKeepAProbability) {
    const int width = 64, height = 33;
    std::vector<float> data(3 * width * height, 1e-6f);
    for (int x = 0; x < 20; ++x)
        for (int y = 0; y < height; ++y)
            for (int c = 0; c < 3; ++c) data[static_cast<std::size_t>(3 * (y * width + x) + c)] = 0.0f;
    for (std::size_t c = 0; c < 3; ++c) data[3 * (10 * width + 40) + c] = 1e6f;
    picture("sky.exr", width, height, data);
    const Scene s = load(sensor + envmap());
    const std::size_t cells = s.lights[0].table + 3 * (height - 1) + 1;
    for (std::size_t row = 0; row < height - 1; ++row) {
        EXPECT_GT(texel(s, s.lights[0].table + row), row == 0 ? 0.0f : texel(s, s.lights[0].table + row - 1));
        for (std::size_t column = 0; column < width; ++column) {
            const float before = column == 0 ? 0.0f : texel(s, cells + row * width + column - 1);
            if (column < 19)
                EXPECT_EQ(texel(s, cells + row * width + column), before) << row << " " << column;
            else
                EXPECT_GT(texel(s, cells + row * width + column), before) << row << " " << column;
        }
        EXPECT_EQ(texel(s, cells + row * width + width - 1), 1.0f);
    }
}

// Integer formats are sRGB-encoded, as in Mitsuba; grey is grey; one row is both poles.
TEST_F(Emitters, EightBitsGreyOneRow) {
    picture("sky.png", 2, 1, {0.5f, 0.5f}, 1, OIIO::TypeDesc::UINT8);
    const Scene s = load(sensor + envmap("", "sky.png"));
    const double value = std::pow((128.0 / 255.0 + 0.055) / 1.055, 2.4);
    expect_near({s.lights[0].r, s.lights[0].g, s.lights[0].b}, {value, value, value}, 1e-6);
    EXPECT_EQ(s.textures.at(0).height, 2u);
}

TEST_F(Emitters, EnvironmentMistakes) {
    const std::vector<float> grey(3 * 2 * 3, 0.5f);
    picture("sky.exr", 2, 3, grey);
    expect_message(error(sensor + envmap("", "absent.exr")), {"scene.xml:3:", path("absent.exr"), "does not exist"});
    expect_message(error(sensor + envmap(R"(<float name="scale" value="-1"/>)")),
                   {"scene.xml:3:", "scale is -1", "0 or"});
    write("broken.exr", "this is no picture");
    expect_message(error(sensor + envmap("", "broken.exr")), {"scene.xml:3:", path("broken.exr"), "cannot be read"});
    write("empty.hdr", "");
    expect_message(error(sensor + envmap("", "empty.hdr")), {"scene.xml:3:", path("empty.hdr"), "cannot be read"});
    for (const float bad : {std::numeric_limits<float>::quiet_NaN(), std::numeric_limits<float>::infinity()}) {
        std::vector<float> data = grey;
        data[3 * 3 + 1] = bad;  // row 1, column 1
        picture("bad.exr", 2, 3, data);
        expect_message(error(sensor + envmap("", "bad.exr")), {"scene.xml:3:", "bad.exr", "(1, 1)", "finite"});
    }
    expect_message(error(sensor + envmap(R"(<transform name="to_world"><scale x="2"/></transform>)")),
                   {"scene.xml:3:", "envmap", "scales", "rotation"});
    expect_message(error(sensor + envmap() + R"(<emitter type="constant"/>)"), {"more than one environment"});
    expect_message(error(sensor + envmap(R"(<float name="sacle" value="1"/>)")), {"sacle", "scale"});
    expect_message(error(sensor + lamp + "\n<emitter type=\"envmap\"/>"), {"scene.xml:3:", "envmap", "filename"});
    std::vector<float> data = grey;
    data[4] = -0.25f;
    picture("negative.exr", 2, 3, data);
    load(sensor + envmap("", "negative.exr"));
    ASSERT_EQ(warnings_.size(), 1u);
    expect_message(warnings_[0], {"scene.xml:3:", "negative.exr", "1 negative"});
}

TEST_F(Emitters, Spot) {
    const Scene s = load(sensor + spot(R"(<rgb name="intensity" value="3, 2, 1"/><transform name="to_world">
        <lookat origin="1,2,3" target="1,2,-4" up="0,1,0"/></transform>)") +
                         R"(<emitter type="spot"><float name="cutoff_angle" value="50"/>
        <float name="beam_width" value="50"/></emitter>)");
    ASSERT_EQ(s.lights.size(), 3u);
    const shared::Light& l = s.lights[1];
    EXPECT_EQ(l.kind, IR_LIGHT_SPOT);
    EXPECT_EQ(s.features, IR_FEATURE_DELTA_LIGHTS);
    expect_near({l.px, l.py, l.pz}, {1, 2, 3}, 1e-6);
    expect_near({l.nx, l.ny, l.nz}, {0, 0, -1}, 1e-6);
    EXPECT_NEAR(l.e2x, 20 * pi / 180, 1e-7);  // Mitsuba's defaults: 20 degrees and three quarters of that
    EXPECT_NEAR(l.e2y, 15 * pi / 180, 1e-7);
    EXPECT_NEAR(l.e1x, std::cos(20 * pi / 180), 1e-7);
    EXPECT_NEAR(l.e1y, std::cos(15 * pi / 180), 1e-7);
    EXPECT_EQ(l.area, 0.0f);
    // Chosen by power: the integral of the falloff over solid angle.
    const auto power = [](double cutoff, double beam) {
        double sum = 0.0;
        for (int i = 0; i < 100000; ++i) {
            const double angle = cutoff * (i + 0.5) / 100000;
            sum += 2 * pi * std::sin(angle) * (angle < beam ? 1 : (cutoff - angle) / (cutoff - beam)) * cutoff / 100000;
        }
        return sum;
    };
    const double first = (0.2126 * 3 + 0.7152 * 2 + 0.0722) * power(20 * pi / 180, 15 * pi / 180);
    EXPECT_NEAR(l.probability / s.lights[2].probability, first / power(50 * pi / 180, 50 * pi / 180), 1e-5);
    EXPECT_NEAR(l.probability / s.lights[0].probability, first / (4 * pi), 1e-5);
}

TEST_F(Emitters, SpotMistakes) {
    for (const char* angle : {"0", "-3", "180", "200"})
        expect_message(error(sensor + spot("<float name=\"cutoff_angle\" value=\"" + std::string(angle) + "\"/>")),
                       {"scene.xml:3:", "cutoff_angle is " + std::string(angle) + " degrees", "above 0 and below 180"});
    for (const char* width : {"0", "20.5"})
        expect_message(error(sensor + spot("<float name=\"beam_width\" value=\"" + std::string(width) + "\"/>")),
                       {"scene.xml:3:", "beam_width is " + std::string(width) + " degrees", "cutoff_angle, 20"});
    const std::string projected =
        R"(<texture type="bitmap" name="texture"><string name="filename" value="x"/></texture>)";
    expect_message(error(sensor + spot(projected)), {"scene.xml:3:", "projected texture is not supported"});
    load(sensor + spot(projected), lenient());
    ASSERT_EQ(warnings_.size(), 1u);
    expect_message(warnings_[0], {"without it"});
    expect_message(error(sensor + spot(R"(<transform name="to_world"><scale z="3"/></transform>)")),
                   {"scene.xml:3:", "rotation"});
}

TEST_F(Emitters, TextureAsRadiance) {
    picture("glow.exr", 2, 1, {4, 4, 4, 8, 8, 8});
    const Scene s = load(sensor + "<shape type=\"rectangle\">" + glow() + "</shape><shape type=\"sphere\">" + glow() +
                         "</shape><shape type=\"disk\">" + glow() + "</shape>");
    ASSERT_EQ(s.lights.size(), 3u);
    EXPECT_EQ(s.features, IR_FEATURE_TEXTURES | IR_FEATURE_TEXTURED_LIGHTS | IR_FEATURE_ANALYTIC);
    ASSERT_EQ(s.textures.size(), 1u);
    EXPECT_EQ(texel(s, s.textures[0].offset), 4.0f);  // not clamped
    for (std::size_t i = 0; i < 3; ++i) {
        EXPECT_EQ(s.lights[i].texture, 0);
        EXPECT_EQ(s.lights[i].primitive, i == 0 ? 0u : i + 1u);  // two triangles, then sphere and disk
        EXPECT_NEAR(s.lights[i].g, 6, i == 2 ? 0.5 : 1e-4);
    }
    EXPECT_EQ(s.lights[0].kind, IR_LIGHT_QUAD);
    EXPECT_TRUE(warnings_.empty());
}

// A quad whose halves are mapped apart stays two lights, each with the mean of what it shows.
TEST_F(Emitters, HalvesWithMappingsOfTheirOwn) {
    picture("glow.exr", 2, 1, {4, 4, 4, 8, 8, 8});
    write("q.obj",
          "v -1 -1 0\nv 1 -1 0\nv 1 1 0\nv -1 1 0\nvt 0.1 0.5\nvt 0.2 0.5\nvt 0.2 0.7\nvt 0.6 0.5\nvt 0.8 0.7\n"
          "vt 0.8 0.9\nf 1/1 2/2 3/3\nf 1/4 3/5 4/6\n");
    const std::string nearest = R"(<string name="filter_type" value="nearest"/>)";
    const Scene s =
        load(sensor + R"(<shape type="obj"><string name="filename" value="q.obj"/>)" + glow(nearest) + "</shape>");
    ASSERT_EQ(s.lights.size(), 2u);
    EXPECT_EQ(s.lights[0].kind, IR_LIGHT_TRIANGLE);
    EXPECT_NEAR(s.lights[0].r, 4, 1e-6);
    EXPECT_NEAR(s.lights[1].r, 8, 1e-6);
    EXPECT_EQ(s.lights[1].primitive, 1u);
}

TEST_F(Emitters, TextureMistakes) {
    const auto shape = [](const std::string& emitter) {
        return sensor + lamp + "\n<shape type=\"rectangle\">" + emitter + "</shape>";
    };
    expect_message(error(shape(glow())), {"scene.xml:3:", path("glow.exr"), "does not exist"});
    picture("glow.exr", 2, 1, {4, 4, 4, 8, -0.5f, 8});
    expect_message(error(shape(glow())), {"scene.xml:3:", "-0.5", "(1, 0)", "negative"});
    picture("glow.exr", 2, 1, {4, 4, 4, 8, std::numeric_limits<float>::quiet_NaN(), 8});
    expect_message(error(shape(glow())), {"scene.xml:3:", "glow.exr", "not finite", "(1, 0)"});
    picture("glow.exr", 2, 1, {4, 4, 4, 8, 8, 8});
    expect_message(error(shape(glow(R"(<string name="wrap_mode" value="twist"/>)"))), {"scene.xml:3:", "twist"});
    expect_message(error(shape(R"(<emitter type="area"><texture type="checkerboard" name="radiance"/></emitter>)")),
                   {"scene.xml:3:", "checkerboard", "a constant colour, bitmap"});
    picture("glow.exr", 2, 1, {0, 0, 0, 0, 0, 0});
    const Scene s = load(shape(glow()));
    EXPECT_EQ(s.lights.size(), 1u);
    ASSERT_EQ(warnings_.size(), 1u);
    expect_message(warnings_[0], {"black"});
}

}  // namespace
}  // namespace irradia::test
