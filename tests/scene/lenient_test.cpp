// --lenient: what is not supported becomes a warning with a stated substitute.
#include <bit>
#include <cstring>

#include "scene_test.h"

namespace irradia::test {
namespace {

class Lenient : public SceneTest {
protected:
    /// Material of a rectangle with this bsdf.
    shared::Material material(const std::string& bsdf) {
        const Scene s = load(sensor + lamp + "\n<shape type=\"rectangle\">" + bsdf + "</shape>", lenient());
        return s.materials[s.triangles.at(2).material];
    }
    void expect_warning(const std::vector<std::string>& parts) {
        ASSERT_FALSE(warnings_.empty());
        expect_message(warnings_[0], parts);
    }
};

TEST_F(Lenient, MaterialsThatAreNotSupported) {
    const auto principled = material(
        R"(<bsdf type="principled"><rgb name="base_color" value=".1"/><float name="metallic" value="1"/></bsdf>)");
    EXPECT_EQ(principled.kind, IR_MATERIAL_DIFFUSE);
    EXPECT_FLOAT_EQ(principled.r, 0.1f);
    EXPECT_EQ(warnings_.size(), 1u);
    expect_warning({"scene.xml:3:", "principled", "substituted: diffuse with base_color"});
    const auto blend = material(
        R"(<bsdf type="twosided"><bsdf type="blendbsdf"><float name="weight" value="0.5"/>
            <bsdf type="conductor"/><bsdf type="diffuse"/></bsdf></bsdf>)");
    EXPECT_EQ(blend.kind, IR_MATERIAL_CONDUCTOR);
    EXPECT_NE(blend.back, IR_NO_MATERIAL);
    expect_warning({"scene.xml:3:", "blendbsdf", "its (first) nested bsdf"});
    const auto unknown = material(R"(<bsdf type="measured"><string name="filename" value="x"/></bsdf>)");
    EXPECT_EQ(unknown.kind, IR_MATERIAL_DIFFUSE);
    EXPECT_FLOAT_EQ(unknown.r, 0.5f);
    expect_warning({"scene.xml:3:", "measured", "diffuse with reflectance 0.5"});
    EXPECT_EQ(warnings_.size(), 1u);
}

// What strict loading takes is the same material, without a word.
TEST_F(Lenient, SupportedMaterialsAreLeftAlone) {
    for (const std::string type : {"conductor", "roughconductor", "dielectric", "roughdielectric", "thindielectric",
                                   "plastic", "roughplastic", "null"}) {
        const auto soft = material("<bsdf type=\"" + type + "\"/>");
        EXPECT_TRUE(warnings_.empty()) << type << ": " << warnings_[0];
        const Scene s = load(sensor + lamp + "<shape type=\"rectangle\"><bsdf type=\"" + type + "\"/></shape>");
        const shared::Material strict = s.materials[s.triangles.at(2).material];
        EXPECT_EQ(std::memcmp(&soft, &strict, sizeof soft), 0) << type;
        EXPECT_TRUE(type == "null" ? soft.opacity == 0.0f : soft.kind != IR_MATERIAL_DIFFUSE) << type;
    }
}

TEST_F(Lenient, UnknownTextures) {
    const Scene s = load(sensor + lamp + R"(
<shape type="rectangle"><bsdf type="diffuse"><texture type="volume" name="reflectance"/></bsdf></shape>)",
                         lenient());
    const auto& m = s.materials[s.triangles.at(2).material];
    ASSERT_EQ(m.texture, 0);
    EXPECT_EQ(s.textures.at(0).format, IR_TEXTURE_CHECKERBOARD);
    ASSERT_EQ(s.texels.size(), 6u);
    for (const std::uint32_t word : s.texels) EXPECT_EQ(std::bit_cast<float>(word), 0.5f);
    expect_warning({"scene.xml:3:", "volume", "constant 0.5"});
}

TEST_F(Lenient, OneBumpMapForBothSides) {
    const std::string bump =
        R"(<bsdf type="bumpmap"><texture type="checkerboard"/><float name="scale" value="2"/><bsdf type="diffuse"/></bsdf>)";
    const auto m = material("<bsdf type=\"twosided\"><bsdf type=\"diffuse\"/>" + bump + "</bsdf>");
    EXPECT_EQ(m.map, IR_NO_TEXTURE);
    expect_warning({"scene.xml:3:", "bumpmap", "both sides need the same", "that of the front is used"});
    material("<bsdf type=\"twosided\">" + bump + bump + "</bsdf>");
    EXPECT_TRUE(warnings_.empty());
}

TEST_F(Lenient, UnknownThingsAreLeftOut) {
    const Scene s = load(sensor + lamp + R"(
        <shape type="sdfgrid"/><emitter type="sunsky"/><medium type="homogeneous"/><shap type="cube"/>
        <shape type="sphere"><float name="raduis" value="3"/></shape>)",
                         lenient());
    EXPECT_EQ(s.triangles.size(), 2u);
    EXPECT_EQ(s.analytics.size(), 1u);
    EXPECT_EQ(s.lights.size(), 1u);
    EXPECT_EQ(warnings_.size(), 5u);
}

TEST_F(Lenient, SaysEachThingOnce) {
    load(
        sensor + lamp +
            R"(<bsdf type="measured" id="g"/><bsdf type="twosided" id="a"><ref id="g"/></bsdf><bsdf type="twosided" id="b"><ref id="g"/></bsdf>
        <shape type="cube"><ref id="a"/></shape><shape type="cube"><ref id="b"/></shape>)",
        lenient());
    EXPECT_EQ(warnings_.size(), 1u);
}

TEST_F(Lenient, ReflectanceIsClamped) {
    const auto m = material(R"(<bsdf type="diffuse"><rgb name="reflectance" value="1.5, .5, 0"/></bsdf>)");
    expect_near({m.r, m.g, m.b}, {1, 0.5, 0}, 0.0);
    expect_warning({"(1.5, 0.5, 0)", "clamped"});
}

TEST_F(Lenient, UnusedDefineAndDegenerateMesh) {
    LoadOptions options = lenient();
    options.defines["x"] = "1";
    write("d.obj", "v 0 0 0\nv 1 0 0\nv 2 0 0\nf 1 2 3\n");
    const Scene s =
        load(sensor + lamp + R"(<shape type="obj"><string name="filename" value="d.obj"/></shape>)", options);
    EXPECT_EQ(s.triangles.size(), 2u);
    ASSERT_EQ(warnings_.size(), 2u);
    expect_message(warnings_[0], {"-D x", "ignored"});
    expect_message(warnings_[1], {"d.obj", "degenerate", "left out"});
}

TEST_F(Lenient, AxesThatAreNoRotation) {
    const Scene s = load(
        sensor + lamp +
            R"(<emitter type="spot"><transform name="to_world"><scale x="2" y="2" z="3"/><translate x="1"/></transform></emitter>)",
        lenient());
    ASSERT_EQ(s.lights.size(), 2u);
    EXPECT_EQ(s.lights[1].kind, IR_LIGHT_SPOT);
    expect_near({s.lights[1].nx, s.lights[1].ny, s.lights[1].nz}, {0, 0, 1}, 0.0);
    expect_warning({"spot", "rotation", "unit length"});
}

TEST_F(Lenient, BadInputStaysAnError) {
    expect_message(
        error(sensor + lamp + R"(<shape type="ply"><string name="filename" value="absent.ply"/></shape>)", lenient()),
        {"absent.ply"});
    expect_message(error(sensor + lamp + R"(<shape type="sphere"><float name="radius" value="x"/></shape>)", lenient()),
                   {"'x' is not a number"});
}

}  // namespace
}  // namespace irradia::test
