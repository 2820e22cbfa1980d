// Mistakes in <bsdf> and <texture>: one line with the place, what was found and what was expected.
#include "bsdf_test.h"

namespace irradia::test {
namespace {

class BadBsdf : public BsdfTest {
protected:
    /// `inside` is on line 4.
    std::string refused(const std::string& type, const std::string& inside) {
        return error_of([&] { with_bsdf("<bsdf type=\"" + type + "\">\n" + inside + "</bsdf>"); });
    }
};

TEST_F(BadBsdf, Roughness) {
    for (const std::string type : {"roughconductor", "roughdielectric", "roughplastic"}) {
        SCOPED_TRACE(type);
        expect_message(refused(type, R"(<float name="alpha" value="0"/>)"),
                       {"scene.xml:4:", type, "alpha is 0", "above 0 was expected", "smooth surface"});
        expect_message(refused(type, R"(<float name="alpha" value="-0.5"/>)"), {"scene.xml:4:", "alpha is -0.5"});
        expect_message(refused(type, R"(<float name="alpha" value="rough"/>)"),
                       {"scene.xml:4:", "'rough' is not a number"});
        expect_message(refused(type, R"(<string name="distribution" value="phong"/>)"),
                       {"scene.xml:4:", "'phong'", "beckmann or ggx was expected"});
    }
    const std::string u = R"(<float name="alpha_u" value=".2"/>)", v = R"(<float name="alpha_v" value="-.2"/>)";
    expect_message(refused("roughconductor", u), {"scene.xml:3:", "both alpha_u and alpha_v"});
    expect_message(refused("roughconductor", u + "\n" + v), {"scene.xml:5:", "alpha_v is -0.2", "above 0"});
    expect_message(refused("roughdielectric", u + v + "\n<float name=\"alpha\" value=\".1\"/>"),
                   {"scene.xml:5:", "either alpha or alpha_u and alpha_v"});
    expect_message(refused("roughplastic", u), {"scene.xml:4:", "alpha_u"});  // it has no direction
    expect_message(refused("roughconductor", u + "\n<texture name=\"alpha_v\" type=\"checkerboard\"/>"),
                   {"scene.xml:5:", "alpha_u and alpha_v as textures are not supported"});
    expect_message(refused("roughplastic", R"(<texture name="alpha" type="checkerboard"/>)"),
                   {"scene.xml:4:", "alpha"});
}

TEST_F(BadBsdf, IndicesOfRefraction) {
    for (const std::string type : {"dielectric", "roughdielectric", "thindielectric", "plastic", "roughplastic"}) {
        SCOPED_TRACE(type);
        for (const std::string name : {"int_ior", "ext_ior"}) {
            expect_message(refused(type, "<float name=\"" + name + "\" value=\"0\"/>"),
                           {"scene.xml:4:", name + " is 0", "above 0 was expected"});
            expect_message(refused(type, "<float name=\"" + name + "\" value=\"-1.5\"/>"), {name + " is -1.5"});
            expect_message(refused(type, "<string name=\"" + name + "\" value=\"diamonds\"/>"),
                           {"scene.xml:4:", name + " names no known medium: 'diamonds'", "did you mean 'diamond'?"});
        }
    }
    expect_message(refused("plastic", R"(<float name="int_ior" value="0.9"/>)"),
                   {"scene.xml:3:", "int_ior over ext_ior is 0.89", "more than 1"});
    expect_message(refused("roughdielectric", R"(<string name="int_ior" value="air"/>)"),
                   {"scene.xml:3:", "int_ior and ext_ior are alike"});
    expect_message(refused("dielectric", R"(<texture name="specular_transmittance" type="checkerboard"/>)"),
                   {"scene.xml:4:", "specular_transmittance has to be a colour"});
}

TEST_F(BadBsdf, Conductors) {
    expect_message(refused("conductor", R"(<string name="material" value="Alu"/>)"),
                   {"scene.xml:4:", "there is no conductor 'Alu'", "did you mean 'Al'?"});
    expect_message(refused("roughconductor", R"(<string name="material" value="gold"/>)"),
                   {"scene.xml:4:", "there is no conductor 'gold'"});
    expect_message(
        refused("conductor",
                R"(<rgb name="eta" value="1"/><rgb name="k" value="1"/><string name="material" value="Al"/>)"),
        {"scene.xml:4:", "either material or eta and k"});
    expect_message(refused("conductor", "<rgb name=\"eta\" value=\"1\"/>\n<rgb name=\"k\" value=\"1, -2, 1\"/>"),
                   {"scene.xml:5:", "negative", "-2"});
    expect_message(refused("conductor", "<rgb name=\"eta\" value=\"-1\"/>\n<rgb name=\"k\" value=\"1\"/>"),
                   {"scene.xml:4:", "negative", "-1"});
    expect_message(refused("conductor", R"(<texture name="eta" type="checkerboard"/><rgb name="k" value="1"/>)"),
                   {"scene.xml:4:", "a colour was expected"});
}

TEST_F(BadBsdf, Factors) {
    const std::pair<std::string, std::string> factors[] = {{"diffuse", "reflectance"},
                                                           {"conductor", "specular_reflectance"},
                                                           {"roughconductor", "specular_reflectance"},
                                                           {"dielectric", "specular_reflectance"},
                                                           {"dielectric", "specular_transmittance"},
                                                           {"plastic", "diffuse_reflectance"},
                                                           {"roughplastic", "specular_reflectance"}};
    for (const auto& [type, name] : factors) {
        SCOPED_TRACE(type + " " + name);
        expect_message(refused(type, "<rgb name=\"" + name + "\" value=\"0.5, 1.5, 0\"/>"),
                       {"scene.xml:4:", name + " (0.5, 1.5, 0) is outside [0, 1]"});
        expect_message(refused(type, "<float name=\"" + name + "\" value=\"-0.1\"/>"), {"outside [0, 1]"});
        expect_message(refused(type, "<float name=\"" + name + "s\" value=\"0.1\"/>"),
                       {"scene.xml:4:", name + "s", "did you mean '" + name + "'"});
    }
    expect_message(refused("mask", R"(<float name="opacity" value="1.01"/><bsdf type="diffuse"/>)"),
                   {"scene.xml:4:", "opacity (1.01, 1.01, 1.01) is outside [0, 1]"});
    expect_message(refused("mask", R"(<float name="opacity" value="-1"/><bsdf type="diffuse"/>)"),
                   {"scene.xml:4:", "opacity (-1", "outside [0, 1]"});
}

TEST_F(BadBsdf, Nesting) {
    for (const std::string type : {"twosided", "mask", "bumpmap", "normalmap"})
        expect_message(refused(type, ""), {"scene.xml:3:", type, "needs a nested bsdf"});
    for (const std::string type : {"dielectric", "thindielectric", "roughdielectric", "null"}) {
        expect_message(refused("twosided", "<bsdf type=\"" + type + "\"/>"),
                       {"scene.xml:4:", type, "lets light through", "inside twosided"});
        expect_message(refused("twosided", "<bsdf type=\"diffuse\"/>\n<bsdf type=\"" + type + "\"/>"),
                       {"scene.xml:5:", type, "lets light through"});
    }
    expect_message(refused("twosided", R"(<bsdf type="mask"><bsdf type="diffuse"/></bsdf>)"),
                   {"scene.xml:4:", "mask", "lets light through"});
    expect_message(refused("twosided", R"(<bsdf type="diffuse"/><bsdf type="diffuse"/><bsdf type="diffuse"/>)"),
                   {"scene.xml:3:", "3 nested bsdfs, one or two were expected"});
    const std::string board = R"(<texture type="checkerboard"/>)", diffuse = R"(<bsdf type="diffuse"/>)";
    expect_message(refused("mask", diffuse + diffuse), {"scene.xml:3:", "mask", "2 nested bsdfs, one was expected"});
    expect_message(refused("bumpmap", board + diffuse + diffuse), {"scene.xml:3:", "2 nested bsdfs"});
    for (const std::string type : {"bumpmap", "normalmap"}) {
        expect_message(refused(type, board + board + diffuse),
                       {"scene.xml:3:", type, "2 nested textures, one was expected"});
        expect_message(refused(type, diffuse), {"scene.xml:3:", type, "0 nested textures"});
        expect_message(refused(type, board + "<bsdf type=\"bumpmap\">" + board + diffuse + "</bsdf>"),
                       {"scene.xml:3:", "inside another is not supported"});
    }
    const std::string textured = R"(<texture type="checkerboard" name="opacity"/>)";
    expect_message(refused("mask", textured + "<bsdf type=\"mask\">" + diffuse + "</bsdf>"),
                   {"scene.xml:3:", "a mask around another"});
    expect_message(refused("mask", "<bsdf type=\"mask\">" + textured + diffuse + "</bsdf>"),
                   {"scene.xml:3:", "a mask around another"});
    expect_message(refused("twosided", diffuse + "\n<bsdf type=\"bumpmap\">" + board + diffuse + "</bsdf>"),
                   {"scene.xml:5:", "both sides need the same bump or normal map"});
}

TEST_F(BadBsdf, UnknownParameters) {
    for (const std::string type : {"conductor", "roughconductor", "dielectric", "roughdielectric", "thindielectric",
                                   "plastic", "roughplastic", "null", "diffuse"})
        expect_message(refused(type, R"(<float name="shininess" value="3"/>)"), {"scene.xml:4:", type, "shininess"});
    expect_message(refused("roughplastic", R"(<float name="alpah" value=".3"/>)"), {"did you mean 'alpha'"});
    expect_message(refused("dielectric", R"(<float name="int_iro" value="1.3"/>)"), {"did you mean 'int_ior'"});
    expect_message(refused("plastic", R"(<boolean name="non_linear" value="true"/>)"), {"did you mean 'nonlinear'"});
    expect_message(refused("conductor", R"(<float name="alpha" value=".3"/>)"), {"scene.xml:4:", "alpha"});  // smooth
    expect_message(refused("mask", R"(<float name="opacitty" value=".3"/><bsdf type="diffuse"/>)"),
                   {"did you mean 'opacity'"});
    expect_message(refused("twosided", R"(<float name="opacity" value=".3"/><bsdf type="diffuse"/>)"), {"opacity"});
    expect_message(
        refused("bumpmap", R"(<float name="scal" value=".3"/><texture type="checkerboard"/><bsdf type="diffuse"/>)"),
        {"scene.xml:4:", "did you mean 'scale'"});
}

TEST_F(BadBsdf, Textures) {
    const auto texture = [&](const std::string& type, const std::string& inside) {
        return refused("diffuse", "<texture name=\"reflectance\" type=\"" + type + "\">\n" + inside + "</texture>");
    };
    const std::string missing = texture("bitmap", R"(<string name="filename" value="textures/wood.png"/>)");
    expect_message(missing, {"scene.xml:4:", path("textures/wood.png"), "does not exist"});
    expect_message(texture("bitmap", ""), {"scene.xml:4:", "filename"});
    for (const std::string name : {"color0", "color1"})
        for (const std::string value : {"0.5, 1.01, 0", "0.5, -0.01, 0"})
            expect_message(texture("checkerboard", "<rgb name=\"" + name + "\" value=\"" + value + "\"/>"),
                           {"scene.xml:5:", name + " (" + value + ") is outside [0, 1]"});
    expect_message(texture("checkerboard", R"(<float name="color2" value=".1"/>)"),
                   {"scene.xml:5:", "color2", "did you mean 'color"});
    expect_message(texture("mesh_attribute", R"(<string name="name" value="face_color"/>)"),
                   {"scene.xml:5:", "attribute 'face_color' is not supported, vertex_color is"});
    expect_message(texture("mesh_attribute", ""), {"scene.xml:4:", "needs <string name=\"name\">"});
    expect_message(texture("mesh_attribute",
                           "<string name=\"name\" value=\"vertex_color\"/>\n"
                           "<float name=\"scale\" value=\"2\"/>"),
                   {"scene.xml:6:", "scale is not supported"});
    expect_message(texture("mesh_attribute",
                           "<string name=\"name\" value=\"vertex_color\"/>\n"
                           "<float name=\"scael\" value=\"2\"/>"),
                   {"scene.xml:6:", "did you mean 'scale'"});
}

}  // namespace
}  // namespace irradia::test
