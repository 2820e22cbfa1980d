// Sensor, film, emitters, scene as a whole. Files: xml_test.cpp, mesh_test.cpp, material_test.cpp.
#include "scene_test.h"

namespace irradia::test {
namespace {

class BadInput : public SceneTest {};

std::string film(const std::string& width, const std::string& height) {
    return "<sensor type=\"perspective\">\n<film type=\"hdrfilm\"><integer name=\"width\" value=\"" + width +
           "\"/><integer name=\"height\" value=\"" + height + "\"/></film></sensor>" + lamp;
}

TEST_F(BadInput, FilmSizes) {
    expect_message(error(film("0", "10")), {"scene.xml:3:", "width is 0", "[1, 65536]"});
    expect_message(error(film("10", "-5")), {"scene.xml:3:", "height is -5"});
    expect_message(error(film("10", "1.5")), {"'1.5' is not an integer"});
    expect_message(error(film("100000", "10")), {"width is 100000"});
    LoadOptions options;
    options.width = -3;
    expect_message(error(film("10", "10"), options), {"width", "-3", "positive"});
    options = {};
    options.height = -1;
    expect_message(error(film("10", "10"), options), {"height", "-1", "positive"});
}

TEST_F(BadInput, Sensor) {
    expect_message(error(lamp), {"scene.xml", "no sensor"});
    const auto with = [&](const std::string& inside) {
        return error("<sensor type=\"perspective\">\n" + inside + "</sensor>" + lamp);
    };
    expect_message(with("<float name=\"fov\" value=\"180\"/>"), {"scene.xml:3:", "fov is 180", "(0, 180)"});
    expect_message(with("<float name=\"fov\" value=\"0\"/>"), {"fov is 0"});
    expect_message(with("<string name=\"fov_axis\" value=\"z\"/><float name=\"fov\" value=\"30\"/>"),
                   {"scene.xml:3:", "'z'", "diagonal"});
    expect_message(with("<float name=\"fov\" value=\"30\"/><string name=\"focal_length\" value=\"50mm\"/>"),
                   {"either fov or focal_length"});
    expect_message(with("<string name=\"focal_length\" value=\"-50mm\"/>"), {"focal_length is -50", "positive"});
    expect_message(with("<float name=\"near_clip\" value=\"2\"/><float name=\"far_clip\" value=\"1\"/>"),
                   {"near_clip 2", "far_clip 1"});
    expect_message(with("<transform name=\"to_world\"><scale x=\"0\"/></transform>"), {"singular"});
    expect_message(with("<sampler type=\"independent\"><integer name=\"sample_count\" value=\"0\"/></sampler>"),
                   {"sample_count is 0"});
    expect_message(
        with("<film type=\"hdrfilm\"><rfilter type=\"tent\"><float name=\"radius\" value=\"0\"/></rfilter></film>"),
        {"radius is 0"});
    expect_message(
        with(
            "<film type=\"hdrfilm\"><rfilter type=\"gaussian\"><float name=\"stddev\" value=\"-1\"/></rfilter></film>"),
        {"stddev is -1"});
    expect_message(with("<film type=\"hdrfilm\"><integer name=\"crop_width\" value=\"5\"/></film>"), {"crop window"});
    expect_message(error("<sensor type=\"orthographic\"/>" + lamp),
                   {"scene.xml:2:", "orthographic", "supported: perspective, thinlens"});
    expect_message(error("<sensor type=\"thinlens\"/>" + lamp), {"scene.xml:2:", "thinlens", "aperture_radius"});
    expect_message(error("<sensor type=\"thinlens\"><float name=\"aperture_radius\" value=\"1\"/>\n"
                         "<float name=\"focus_distance\" value=\"0\"/></sensor>" +
                         lamp),
                   {"scene.xml:3:", "focus_distance is 0"});
    load(sensor + "\n" + sensor + lamp);
    ASSERT_EQ(warnings_.size(), 1u);
    expect_message(warnings_[0], {"scene.xml:3:", "more than one sensor"});
}

TEST_F(BadInput, Emitters) {
    expect_message(error(sensor + "<shape type=\"cube\"/>"), {"scene.xml", "no emitter"});
    expect_message(
        error(sensor + R"(<shape type="cube"/><emitter type="constant"><rgb name="radiance" value="0"/></emitter>)"),
        {"no emitter"});
    expect_message(error(sensor + R"(<emitter type="point"/>)"), {"scene.xml", "no shapes"});
    expect_message(error(sensor + lamp + "\n<emitter type=\"area\"/>"), {"scene.xml:3:", "inside a <shape>"});
    expect_message(
        error(sensor +
              R"(<shape type="cube"><emitter type="area"><rgb name="radiance" value="1, -1, 0"/></emitter></shape>)"),
        {"radiance is negative"});
    expect_message(
        error(sensor +
              R"(<shape type="cube"><emitter type="area"><rgb name="radiance" value="1, nan, 0"/></emitter></shape>)"),
        {"'nan' is not a finite number"});
    expect_message(error(sensor + R"(<shape type="cube"><emitter type="point"/></shape>)"),
                   {"point", "supported: area on shapes"});
    expect_message(error(sensor + lamp + R"(<emitter type="constant"/>)" + "\n" + R"(<emitter type="constant"/>)"),
                   {"scene.xml:3:", "more than one environment", "scene.xml:2"});
    expect_message(
        error(sensor + lamp + R"(<emitter type="directional"><vector name="direction" x="0" y="0" z="0"/></emitter>)"),
        {"direction is zero"});
    expect_message(error(sensor + R"(<shape type="cube"><emitter type="area"/><emitter type="area"/></shape>)"),
                   {"more than one emitter"});
}

TEST_F(BadInput, ZeroAreaEmitter) {
    const auto lamp_with = [&](const std::string& type, const std::string& scale) {
        return error(sensor + "\n<shape type=\"" + type + "\"><transform name=\"to_world\">" + scale +
                     "</transform><emitter type=\"area\"/></shape>");
    };
    expect_message(lamp_with("rectangle", "<scale x=\"0\"/>"), {"scene.xml:3:", "rectangle", "no area"});
    expect_message(lamp_with("disk", "<scale y=\"0\"/>"), {"scene.xml:3:", "disk", "no area"});
    expect_message(lamp_with("sphere", "<scale value=\"0\"/>"), {"scene.xml:3:", "sphere", "no area"});
    expect_message(lamp_with("rectangle", "<scale value=\"1e-30\"/>"),
                   {"scene.xml:3:", "no area"});  // vanishes in single precision
}

TEST_F(BadInput, FlattenedRectangleHasArea) {
    // scale z="0" leaves a rectangle as it is
    const Scene s = load(
        sensor +
        R"(<shape type="rectangle"><transform name="to_world"><scale z="0"/></transform><emitter type="area"/></shape>)");
    EXPECT_FLOAT_EQ(s.lights[0].area, 4.0f);
    expect_near(normal(s.triangles[0]), {0, 0, 1}, 1e-7);
}

TEST_F(BadInput, ShapesThatNeedAnEvenScale) {
    expect_message(error(sensor + lamp +
                         "\n<shape type=\"sphere\"><transform name=\"to_world\"><scale x=\"2\"/></transform></shape>"),
                   {"scene.xml:3:", "uniform scale"});
    expect_message(error(sensor + lamp +
                         "\n<shape type=\"disk\"><transform name=\"to_world\"><matrix value=\"1 1 0 0 1 0 0 0 "
                         "1\"/></transform></shape>"),
                   {"scene.xml:3:", "shears"});
}

TEST_F(BadInput, UnsupportedNamesWhatIs) {
    const auto bsdf = [&](const std::string& type) {
        return error(sensor + lamp + "\n<bsdf type=\"" + type + "\" id=\"a\"/>");
    };
    expect_message(bsdf("measured"), {"scene.xml:3:", "<bsdf type=\"measured\" id=\"a\"> is not supported",
                                      "supported: diffuse, conductor, roughconductor, dielectric", "twosided, mask",
                                      "--lenient substitutes: diffuse with reflectance 0.5"});
    EXPECT_EQ(bsdf("measured").find("did you mean"), std::string::npos);
    expect_message(bsdf("roughplastik"), {"did you mean 'roughplastic'?"});
    expect_message(bsdf("ruoghplastic"), {"did you mean 'roughplastic'?"});
    expect_message(bsdf("RoughConductor"), {"did you mean 'roughconductor'?"});
    expect_message(bsdf("normal_map"), {"did you mean 'normalmap'?"});
    expect_message(bsdf("two-sided"), {"did you mean 'twosided'?"});
    expect_message(error(sensor + lamp + "\n<shape type=\"sphare\"/>"),
                   {"scene.xml:3:", "<shape type=\"sphare\"> is not supported; did you mean 'sphere'?",
                    "rectangle, cube, sphere", "--lenient"});
    expect_message(error(sensor + lamp + "\n<shape type=\"sdfgrid\"/>"), {"sdfgrid", "supported: rectangle"});
    expect_message(error(sensor + lamp + "\n<emitter type=\"sunsky\"/>"),
                   {"scene.xml:3:", "sunsky", "point, spot, directional, constant, envmap"});
    expect_message(error(sensor + lamp + "\n<medium type=\"homogeneous\"/>"), {"scene.xml:3:", "medium"});
    expect_message(
        error(sensor + lamp + R"(<bsdf type="diffuse"><texture name="reflectance" type="chekerboard"/></bsdf>)"),
        {"chekerboard", "supported: bitmap, checkerboard, mesh_attribute", "did you mean 'checkerboard'?"});
    expect_message(
        error(R"(<sensor type="perspective"><film type="hdrfilm"><rfilter type="mitchell"/></film></sensor>)" + lamp),
        {"mitchell", "box, tent, gaussian"});
}

TEST_F(BadInput, BsdfsInACircle) {
    expect_message(error(sensor + lamp +
                         "\n<bsdf type=\"twosided\" id=\"a\"><ref id=\"b\"/></bsdf><bsdf type=\"twosided\" "
                         "id=\"b\"><ref id=\"a\"/></bsdf>"),
                   {"scene.xml:3:", "circle"});
}

TEST_F(BadInput, TooLarge) {
    expect_message(
        error(
            sensor +
            R"(<shape type="cube"><transform name="to_world"><scale value="1e30"/></transform><emitter type="area"/></shape>)"),
        {"too large"});
}

}  // namespace
}  // namespace irradia::test
