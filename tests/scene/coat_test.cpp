// The coats of plastics and indices of refraction against Mitsuba 3.9.1: tests/data/vectors/coats.json says what it was
// asked.
#include <bit>
#include <nlohmann/json.hpp>

#include "scene_test.h"

namespace irradia::test {
namespace {

using nlohmann::json;

class Coats : public SceneTest {
protected:
    static json vectors(const char* what) {
        std::ifstream file(std::string(IRRADIA_SOURCE_DIR) + "/tests/data/vectors/coats.json");
        json cases = json::parse(file).at(what);
        EXPECT_GT(cases.size(), 3u);
        return cases;
    }
    Scene with(const std::string& bsdf) {
        return load(sensor + lamp + "<shape type=\"rectangle\">" + bsdf + "</shape>");
    }
    static const shared::Material& material(const Scene& s) { return s.materials.at(s.triangles.at(2).material); }
    static std::string number(const char* name, double value) {
        return "<float name=\"" + std::string(name) + "\" value=\"" + std::to_string(value) + "\"/>";
    }
    static std::string colour(const char* name, const json& c) {
        return "<rgb name=\"" + std::string(name) + "\" value=\"" + c[0].dump() + " " + c[1].dump() + " " +
               c[2].dump() + "\"/>";
    }
};

TEST_F(Coats, RoughOnesAreMitsubas) {
    const json cases = vectors("coats");
    for (const json& c : cases) {
        const std::string distribution = c.at("distribution");
        SCOPED_TRACE(distribution + " " + c.at("alpha").dump() + " eta " + c.at("eta").dump());
        const Scene s = with("<bsdf type=\"roughplastic\">" + number("int_ior", c.at("eta")) + number("ext_ior", 1.0) +
                             number("alpha", c.at("alpha")) + "<string name=\"distribution\" value=\"" + distribution +
                             "\"/></bsdf>");
        const shared::Material& m = material(s);
        EXPECT_EQ(m.kind, IR_MATERIAL_ROUGH_PLASTIC);
        EXPECT_EQ(m.coat, 1u);
        EXPECT_NEAR(m.internal_reflectance, c.at("internal_reflectance").get<double>(),
                    1e-3 * c.at("internal_reflectance").get<double>());
        for (std::size_t i = 0; i < IR_COAT_TABLE; ++i) {
            const double expected = c.at("transmittance").at(i);
            EXPECT_NEAR(std::bit_cast<float>(s.texels.at(m.coat_table + i)), expected, 1e-3 * expected) << i;
        }
    }
}

TEST_F(Coats, SmoothOnesAreMitsubas) {
    const json cases = vectors("smooth");
    for (const json& c : cases) {
        const Scene s = with("<bsdf type=\"plastic\">" + number("int_ior", c[0]) + number("ext_ior", 1.0) + "</bsdf>");
        EXPECT_NEAR(material(s).internal_reflectance, c[1].get<double>(), 2e-6) << c[0];
    }
}

TEST_F(Coats, WeightsOfTheCoatAreMitsubas) {
    const json cases = vectors("weights");
    for (const json& c : cases) {
        const Scene s = with("<bsdf type=\"plastic\">" + colour("diffuse_reflectance", c.at("diffuse")) +
                             colour("specular_reflectance", c.at("specular")) + "</bsdf>");
        EXPECT_NEAR(material(s).specular_weight, c.at("weight").get<double>(), 1e-6) << c.dump();
    }
}

}  // namespace
}  // namespace irradia::test
