// Defaults, -D, includes, ids.
#include "scene_test.h"

namespace irradia::test {
namespace {

class Xml : public SceneTest {
protected:
    static double reflectance(const Scene& s) { return s.materials[s.triangles.back().material].r; }
};
const std::string grey =
    R"(<shape type="rectangle"><bsdf type="diffuse"><rgb name="reflectance" value="$rho"/></bsdf></shape>)";

TEST_F(Xml, DefaultsAndDefines) {
    const std::string body = R"(<default name="rho" value="0.25"/>)" + sensor + lamp + grey;
    EXPECT_FLOAT_EQ(static_cast<float>(reflectance(load(body))), 0.25f);
    LoadOptions options;
    options.defines["rho"] = "0.75";
    EXPECT_FLOAT_EQ(static_cast<float>(reflectance(load(body, options))), 0.75f);
    EXPECT_FLOAT_EQ(static_cast<float>(reflectance(load(sensor + lamp + grey, options))), 0.75f);  // no default needed
}

TEST_F(Xml, NamesAreReplacedInsideText) {
    write("m_low.ply", tetrahedron);
    LoadOptions options;
    options.defines = {{"mesh", "m"}, {"mesh_quality", "low"}, {"q", "low"}};
    // the longest name that fits: $mesh_quality, not $mesh; and $mesh before "_", as there is no $mesh_
    const Scene s =
        load(sensor + lamp + R"(<shape type="ply"><string name="filename" value="$mesh_$mesh_quality.ply"/></shape>
        <shape type="ply"><string name="filename" value="m_$q.ply"/></shape>)",
             options);
    EXPECT_EQ(s.triangles.size(), 10u);
}

TEST_F(Xml, IncludesAreSplicedIn) {
    write("parts/room.xml",
          R"(<scene version="3.0.0"><shape type="ply"><string name="filename" value="m.ply"/></shape></scene>)");
    write("parts/m.ply", tetrahedron);  // found beside the file that names it
    write(
        "materials.xml",
        R"(<scene version="3.0.0"><default name="rho" value="0.125"/><bsdf type="diffuse" id="m"><rgb name="reflectance" value="$rho"/></bsdf></scene>)");
    const Scene s = load(
        sensor + lamp +
        R"(<include filename="materials.xml"/><include filename="parts/room.xml"/><shape type="rectangle"><ref id="m"/></shape>)");
    EXPECT_EQ(s.triangles.size(), 2u + 4u + 2u);
    EXPECT_FLOAT_EQ(static_cast<float>(reflectance(s)), 0.125f);
}

TEST_F(Xml, PathsAreSearched) {
    write("meshes/m.ply", tetrahedron);
    EXPECT_EQ(load(sensor + lamp +
                   R"(<path value="meshes"/><shape type="ply"><string name="filename" value="m.ply"/></shape>)")
                  .triangles.size(),
              6u);
    expect_message(error(sensor + lamp + R"(<path value="absent"/>)"), {"absent", "not a folder"});
}

TEST_F(Xml, AliasesAndForwardReferences) {
    const Scene s = load(sensor + lamp + R"(<shape type="rectangle"><ref id="other"/></shape>
        <bsdf type="diffuse" id="m"><rgb name="reflectance" value="0.75"/></bsdf><alias id="m" as="other"/>)");
    EXPECT_FLOAT_EQ(static_cast<float>(reflectance(s)), 0.75f);
}

TEST_F(Xml, IntegratorIsAcceptedAndIgnored) {
    EXPECT_EQ(
        load(
            R"(<integrator type="path"><integer name="max_depth" value="65"/><integer name="rr_depth" value="5"/></integrator>)" +
            sensor + lamp)
            .triangles.size(),
        2u);
    EXPECT_TRUE(warnings_.empty());
}

// ---- what is wrong with a file ----------------------------------------------------------------------------------
class BadXml : public Xml {};

TEST_F(BadXml, MissingFile) {
    expect_message(error_of([&] { load_file(path("absent.xml")); }), {"absent.xml", "does not exist"});
    expect_message(error_of([&] { load_file(folder_.string()); }), {"cannot be read"});
}

TEST_F(BadXml, Malformed) {
    expect_message(error_of([&] { load_file(write("a.xml", "<scene version=\"3.0.0\">\n\n<shape></scene>")); }),
                   {"a.xml:3:", "malformed XML"});
    expect_message(error_of([&] { load_file(write("b.xml", "")); }), {"b.xml:1:", "malformed XML"});
    expect_message(error_of([&] { load_file(write("c.xml", "<scene version=\"3.0.0\"/>\n<scene/>")); }),
                   {"c.xml:2:", "second root"});
    expect_message(error(lamp + "\nhello"), {"scene.xml:", "stray text", "hello"});
}

TEST_F(BadXml, WrongRoot) {
    expect_message(error_of([&] { load_file(write("a.xml", "<bsdf type=\"diffuse\"/>")); }),
                   {"a.xml:1:", "<bsdf>", "<scene> was expected"});
    expect_message(error_of([&] { load_file(write("b.xml", "<html/>")); }),
                   {"b.xml:1:", "<html>", "<scene> was expected"});
    expect_message(
        error_of([&] { load_file(write("c.xml", "<scene version=\"0.6.0\">" + sensor + lamp + "</scene>")); }),
        {"c.xml:1:", "version 0.6.0", "2 and 3"});
}

TEST_F(BadXml, Ids) {
    const std::string bsdf = R"(<bsdf type="diffuse" id="WallBSDF"/>)";
    expect_message(error(sensor + lamp + bsdf + "\n<shape type=\"rectangle\"><ref id=\"WallBSFD\"/></shape>"),
                   {"scene.xml:3:", "unknown id 'WallBSFD'", "did you mean 'WallBSDF'"});
    expect_message(error(sensor + lamp + bsdf + "\n" + bsdf),
                   {"scene.xml:3:", "'WallBSDF' is already used at", "scene.xml:2"});
    expect_message(error(sensor + lamp + "<alias id=\"none\" as=\"b\"/>"), {"unknown id 'none'"});
}

TEST_F(BadXml, UnknownNames) {
    expect_message(error(sensor + lamp + "\n<shap type=\"cube\"/>"),
                   {"scene.xml:3:", "unknown element <shap>", "did you mean 'shape'"});
    expect_message(error(sensor + lamp + "\n<shape typ=\"cube\"/>"),
                   {"scene.xml:3:", "unknown attribute 'typ'", "did you mean 'type'"});
    expect_message(error(sensor + lamp + "\n<shape type=\"sphere\">\n<float name=\"raduis\" value=\"1\"/></shape>"),
                   {"scene.xml:4:", "no parameter 'raduis'", "did you mean 'radius'"});
    expect_message(error(sensor + lamp + "<shape type=\"sphere\" type=\"cube\"/>"), {"'type' is given twice"});
    expect_message(
        error(sensor + lamp +
              R"(<shape type="sphere"><float name="radius" value="1"/><float name="radius" value="1"/></shape>)"),
        {"'radius' is given twice"});
    expect_message(error(sensor + lamp + R"(<shape type="sphere"><rfilter type="box"/></shape>)"),
                   {"rfilter", "cannot stand inside"});
    expect_message(error(sensor + lamp + R"(<float name="fov" value="3"/>)"), {"cannot stand directly inside <scene>"});
}

TEST_F(BadXml, Numbers) {
    const auto radius = [&](const std::string& value) {
        return error(sensor + lamp + "\n<shape type=\"sphere\"><float name=\"radius\" value=\"" + value +
                     "\"/></shape>");
    };
    expect_message(radius("1,5"), {"scene.xml:3:", "radius", "'1,5' is not a number"});
    expect_message(radius(""), {"'' is not a number"});
    expect_message(radius("one"), {"'one' is not a number"});
    expect_message(radius("nan"), {"'nan' is not a finite number"});
    expect_message(radius("inf"), {"'inf' is not a finite number"});
    expect_message(radius("1e999"), {"'1e999' is not a finite number"});
    expect_message(radius("-1"), {"radius is -1", "positive"});
    expect_message(radius("0"), {"radius is 0", "positive"});
    expect_message(error(sensor + lamp + R"(<shape type="sphere"><string name="radius" value="1"/></shape>)"),
                   {"'radius' has to be a <float>", "<string>"});
    expect_message(error(sensor + lamp + R"(<shape type="sphere"><boolean name="flip_normals" value="1"/></shape>)"),
                   {"'1' is not true or false"});
}

TEST_F(BadXml, Transforms) {
    const auto transform = [&](const std::string& inside) {
        return error(sensor + lamp + "\n<shape type=\"cube\"><transform name=\"to_world\">" + inside +
                     "</transform></shape>");
    };
    expect_message(transform("<matrix value=\"1 0 0\"/>"), {"scene.xml:3:", "3 numbers", "16 or 9"});
    expect_message(transform("<matrix value=\"1 0 0 0 0 1 0 0 0 0 1 0 1 0 0 1\"/>"), {"last row"});
    expect_message(transform("<rotate angle=\"3\"/>"), {"needs an axis"});
    expect_message(transform("<rotate x=\"1\"/>"), {"'angle'"});
    expect_message(transform("<translate value=\"1 2\"/>"), {"2 numbers, 3 expected"});
    expect_message(transform("<lookat origin=\"1 2 3\" target=\"1 2 3\"/>"), {"same point"});
    expect_message(transform("<lookat origin=\"0 0 0\" target=\"0 1 0\" up=\"0 2 0\"/>"), {"parallel"});
    expect_message(transform("<scale x=\"0\"/>"), {"singular"});
    expect_message(transform("<float name=\"x\" value=\"1\"/>"), {"<float> inside <transform>"});
}

TEST_F(BadXml, Defines) {
    expect_message(error(sensor + lamp + "\n" + grey), {"scene.xml:3:", "$rho", "-D rho="});
    LoadOptions options;
    options.defines["roh"] = "1";
    expect_message(error(R"(<default name="rho" value="0.25"/>)" + sensor + lamp + grey, options),
                   {"-D roh", "no $roh", "did you mean 'rho'"});
}

TEST_F(BadXml, Includes) {
    write("a.xml", "<scene version=\"3.0.0\">\n<include filename=\"b.xml\"/></scene>");
    write("b.xml", "<scene version=\"3.0.0\">\n\n<include filename=\"a.xml\"/></scene>");
    expect_message(error_of([&] { load_file(path("a.xml")); }), {"b.xml:3:", "includes itself"});
    expect_message(error(sensor + lamp + "<include filename=\"absent.xml\"/>"),
                   {"scene.xml:2:", "absent.xml", "does not exist"});
    write("broken.xml", "<scene version=\"3.0.0\">\n<shape type=\"cub\"/></scene>");
    expect_message(error(sensor + lamp + "<include filename=\"broken.xml\"/>"), {"broken.xml:2:", "cub"});
}

}  // namespace
}  // namespace irradia::test
