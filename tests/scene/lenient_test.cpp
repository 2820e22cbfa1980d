// --lenient: what is not supported becomes a warning with a stated substitute.
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

TEST_F(Lenient, Conductors) {
    const auto plain = material(
        R"(<bsdf type="roughconductor"><string name="material" value="none"/><rgb name="specular_reflectance" value=".2,.3,.4"/><float name="alpha" value=".1"/></bsdf>)");
    expect_warning({"scene.xml:3:", "roughconductor", "substituted", "specular_reflectance"});
    expect_near({plain.r, plain.g, plain.b}, {0.2, 0.3, 0.4}, 1e-7);
    // ((eta-1)^2 + k^2) / ((eta+1)^2 + k^2) with eta 1.5, k 2: (.25 + 4) / (6.25 + 4)
    const auto metal =
        material(R"(<bsdf type="conductor"><rgb name="eta" value="1.5"/><rgb name="k" value="2"/></bsdf>)");
    expect_near({metal.r, metal.g, metal.b}, {4.25 / 10.25, 4.25 / 10.25, 4.25 / 10.25}, 1e-7);
    const auto gold = material(R"(<bsdf type="conductor"><string name="material" value="Au"/></bsdf>)");
    EXPECT_GT(gold.r, gold.g);
    EXPECT_GT(gold.g, gold.b);
}

TEST_F(Lenient, PlasticsAndGlass) {
    const auto plastic = material(
        R"(<bsdf type="roughplastic"><rgb name="diffuse_reflectance" value=".2,.3,.4"/><boolean name="nonlinear" value="true"/></bsdf>)");
    expect_near({plastic.r, plastic.g, plastic.b}, {0.2, 0.3, 0.4}, 1e-7);
    expect_warning({"roughplastic", "diffuse_reflectance"});
    const auto glass = material(R"(<bsdf type="dielectric"><float name="int_ior" value="1.5"/></bsdf>)");
    EXPECT_FLOAT_EQ(glass.r, 0.8f);
    EXPECT_NE(glass.back, IR_NO_MATERIAL);
    expect_warning({"dielectric", "0.8"});
    const auto unknown = material(R"(<bsdf type="measured"><string name="filename" value="x"/></bsdf>)");
    EXPECT_FLOAT_EQ(unknown.r, 0.5f);
    const auto principled = material(
        R"(<bsdf type="principled"><rgb name="base_color" value=".1"/><float name="metallic" value="1"/></bsdf>)");
    EXPECT_FLOAT_EQ(principled.r, 0.1f);
}

TEST_F(Lenient, WrappersGiveWhatTheyWrap) {
    for (const char* type : {"mask", "bumpmap", "normalmap", "blendbsdf"}) {
        const auto m = material("<bsdf type=\"twosided\"><bsdf type=\"" + std::string(type) +
                                R"("><float name="opacity" value="0.5"/>
            <texture type="bitmap"/><bsdf type="diffuse"><rgb name="reflectance" value="0.3"/></bsdf></bsdf></bsdf>)");
        EXPECT_FLOAT_EQ(m.r, 0.3f) << type;
        EXPECT_NE(m.back, IR_NO_MATERIAL) << type;
        expect_warning({type, "nested bsdf"});
    }
}

TEST_F(Lenient, ThinGlassIsLeftOut) {
    const Scene s =
        load(sensor + lamp + R"(<bsdf type="thindielectric" id="pane"/><shape type="cube"><ref id="pane"/></shape>)",
             lenient());
    EXPECT_EQ(s.triangles.size(), 2u);
    expect_warning({"thindielectric", "left out"});
}

TEST_F(Lenient, TexturesBecomeTheirMean) {
    const auto m = material(
        R"(<bsdf type="diffuse"><texture type="checkerboard" name="reflectance"><rgb name="color0" value=".8"/><rgb name="color1" value=".2"/></texture></bsdf>)");
    EXPECT_FLOAT_EQ(m.r, 0.5f);
    expect_warning({"checkerboard", "mean of color0 and color1"});
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
            R"(<bsdf type="dielectric" id="g"/><bsdf type="twosided" id="a"><ref id="g"/></bsdf><bsdf type="twosided" id="b"><ref id="g"/></bsdf>
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
