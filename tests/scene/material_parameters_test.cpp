// Bsdfs: Mitsuba's parameters and defaults, nesting, coats that are shared; mistakes in them. Numbers of named metals
// and media are what mi.traverse() and the text of Mitsuba 3.9.1's plugins say (scalar_rgb).
#include <OpenImageIO/imageio.h>

#include <bit>

#include "scene_test.h"

namespace irradia::test {
namespace {

class MaterialParameters : public SceneTest {
protected:
    shared::Material material(const std::string& bsdf, const LoadOptions& options = {}) {
        scene_ = load(sensor + lamp + "\n<shape type=\"rectangle\">" + bsdf + "</shape>", options);
        return scene_.materials.at(index());
    }
    [[nodiscard]] std::uint32_t index() const { return scene_.triangles.at(2).material; }
    std::string mistake(const std::string& bsdf) {
        return error(sensor + lamp + "\n<shape type=\"rectangle\">" + bsdf + "</shape>");
    }
    static std::string bsdf(const std::string& type, const std::string& inside = "") {
        return "<bsdf type=\"" + type + "\">" + inside + "</bsdf>";
    }
    static std::string number(const std::string& name, const std::string& value) {
        return "<float name=\"" + name + "\" value=\"" + value + "\"/>";
    }
    static std::string text(const std::string& name, const std::string& value) {
        return "<string name=\"" + name + "\" value=\"" + value + "\"/>";
    }
    static std::string rgb(const std::string& name, const std::string& value) {
        return "<rgb name=\"" + name + "\" value=\"" + value + "\"/>";
    }
    /// A bitmap of one texel, 2 x 1 if `wide`.
    std::string picture(const std::string& name, bool wide = false) {
        const std::vector<std::uint8_t> data{255, 0, 0, 0, 255, 0};
        auto out = OIIO::ImageOutput::create(path("p.png"));
        out->open(path("p.png"), OIIO::ImageSpec(wide ? 2 : 1, 1, 3, OIIO::TypeDesc::UINT8));
        out->write_image(OIIO::TypeDesc::UINT8, data.data());
        out->close();
        return "<texture type=\"bitmap\" name=\"" + name + "\">" + text("filename", "p.png") +
               "<boolean name=\"raw\" value=\"true\"/></texture>";
    }
    Scene scene_;
};

TEST_F(MaterialParameters, Conductors) {
    const auto mirror = material(bsdf("conductor"));
    EXPECT_EQ(mirror.kind, IR_MATERIAL_CONDUCTOR);
    EXPECT_EQ(mirror.back, IR_NO_MATERIAL);
    expect_near({mirror.eta_r, mirror.eta_g, mirror.eta_b}, {0, 0, 0}, 0.0);
    expect_near({mirror.k_r, mirror.k_g, mirror.k_b}, {1, 1, 1}, 0.0);
    EXPECT_TRUE(scene_.features & IR_FEATURE_BSDFS);
    const auto gold =
        material(bsdf("roughconductor", text("material", "Au") + rgb("specular_reflectance", ".2 .3 .4")));
    EXPECT_EQ(gold.kind, IR_MATERIAL_ROUGH_CONDUCTOR);
    EXPECT_EQ(gold.flags, IR_MATERIAL_BECKMANN);
    EXPECT_FLOAT_EQ(gold.alpha_u, 0.1f);
    EXPECT_FLOAT_EQ(gold.alpha_v, 0.1f);
    expect_near({gold.eta_r, gold.eta_g, gold.eta_b}, {0.143036, 0.375307, 1.44205}, 1e-5);
    expect_near({gold.k_r, gold.k_g, gold.k_b}, {3.983, 2.38556, 1.60336}, 1e-5);
    expect_near({gold.specular_r, gold.specular_g, gold.specular_b}, {0.2, 0.3, 0.4}, 1e-7);
    const auto birefringent = material(bsdf("conductor", text("material", "TiO2-e_palik")));
    EXPECT_GT(birefringent.eta_r, 3.0f);
    const auto own = material(bsdf("roughconductor", rgb("eta", "1 2 3") + number("k", "4") + number("alpha_u", ".2") +
                                                         number("alpha_v", ".3") + text("distribution", "ggx")));
    expect_near({own.eta_r, own.eta_g, own.eta_b}, {1, 2, 3}, 0.0);
    expect_near({own.k_r, own.k_g, own.k_b}, {4, 4, 4}, 0.0);
    EXPECT_EQ(own.flags, 0u);
    EXPECT_FLOAT_EQ(own.alpha_u, 0.2f);
    EXPECT_FLOAT_EQ(own.alpha_v, 0.3f);
    EXPECT_FLOAT_EQ(material(bsdf("conductor", number("eta", "2"))).k_g, 1.0f);                 // each has its default
    EXPECT_FLOAT_EQ(material(bsdf("roughconductor", number("alpha", "1e-6"))).alpha_u, 1e-4f);  // Mitsuba's least
}

TEST_F(MaterialParameters, Dielectrics) {
    for (const char* type : {"dielectric", "roughdielectric", "thindielectric"}) {
        const auto m = material(bsdf(type, rgb("specular_transmittance", ".1 .2 .3")));
        EXPECT_NEAR(m.eta, 1.50418, 5e-6) << type;  // bk7 in air
        EXPECT_EQ(m.back, static_cast<int>(index())) << type;
        expect_near({m.transmittance_r, m.transmittance_g, m.transmittance_b}, {0.1, 0.2, 0.3}, 1e-7);
    }
    EXPECT_EQ(material(bsdf("roughdielectric")).flags, IR_MATERIAL_BECKMANN);
    EXPECT_NEAR(material(bsdf("dielectric", text("int_ior", "Water Ice") + text("ext_ior", "diamond"))).eta,
                1.31 / 2.419, 1e-7);
    EXPECT_FLOAT_EQ(material(bsdf("dielectric", number("int_ior", "1.5") + number("ext_ior", "1.5"))).eta, 1.0f);
}

TEST_F(MaterialParameters, PlasticsShareCoats) {
    const auto smooth = material(bsdf("plastic", rgb("diffuse_reflectance", ".1 .2 .3")));
    EXPECT_EQ(smooth.kind, IR_MATERIAL_PLASTIC);
    EXPECT_NEAR(smooth.eta, 1.48959, 5e-6);  // polypropylene in air
    EXPECT_EQ(smooth.back, IR_NO_MATERIAL);
    EXPECT_EQ(smooth.coat, 1u);
    EXPECT_EQ(smooth.flags & IR_MATERIAL_NONLINEAR, 0u);
    expect_near({smooth.r, smooth.g, smooth.b}, {0.1, 0.2, 0.3}, 1e-7);
    const Scene s = load(sensor + lamp + bsdf("roughplastic") + bsdf("roughplastic", rgb("diffuse_reflectance", ".1")) +
                         bsdf("roughplastic", text("distribution", "ggx")) + bsdf("plastic") +
                         bsdf("roughplastic", number("alpha", ".2")) +
                         bsdf("roughplastic", "<boolean name=\"nonlinear\" value=\"true\"/>") + bsdf("diffuse"));
    std::vector<std::uint32_t> coats, tables;
    for (std::size_t i = 0; i < 7; ++i) {
        coats.push_back(s.materials.at(i).coat);
        tables.push_back(s.materials.at(i).coat_table);
    }
    EXPECT_EQ(coats, (std::vector<std::uint32_t>{1, 1, 2, 3, 4, 1, 0}));
    EXPECT_EQ(tables[0], tables[1]);
    EXPECT_EQ(tables[0], tables[5]);
    EXPECT_EQ(s.texels.size(), 3u * IR_COAT_TABLE);
    EXPECT_TRUE(s.materials[5].flags & IR_MATERIAL_NONLINEAR);
    // A texture counts by the mean of its luminance: a red texel, .2126.
    EXPECT_NEAR(material(bsdf("plastic", picture("diffuse_reflectance"))).specular_weight, 1.0 / 1.2126, 1e-6);
    EXPECT_NEAR(material(bsdf("plastic", picture("diffuse_reflectance", true))).specular_weight,
                1.0 / (1.0 + (0.2126 + 0.7152) / 2), 1e-6);
}

TEST_F(MaterialParameters, TwoSides) {
    const auto both = material(bsdf("twosided", bsdf("roughconductor")));
    EXPECT_EQ(both.back, static_cast<int>(index()));
    const auto front = material(bsdf(
        "twosided", bsdf("diffuse", rgb("reflectance", ".1")) + bsdf("plastic", rgb("diffuse_reflectance", ".2"))));
    EXPECT_FLOAT_EQ(front.r, 0.1f);
    const auto& back = scene_.materials.at(static_cast<std::size_t>(front.back));
    EXPECT_EQ(back.kind, IR_MATERIAL_PLASTIC);
    EXPECT_FLOAT_EQ(back.r, 0.2f);
    EXPECT_TRUE(scene_.features & IR_FEATURE_BSDFS);
    const auto twice = material(bsdf("twosided", bsdf("twosided", bsdf("diffuse"))));
    EXPECT_EQ(twice.back, static_cast<int>(index()));
    for (const std::string& inside : {bsdf("dielectric"), bsdf("thindielectric"), bsdf("mask", bsdf("diffuse")),
                                      bsdf("null"), bsdf("bumpmap", picture("x") + bsdf("roughdielectric"))})
        expect_message(mistake(bsdf("twosided", inside)), {"scene.xml:3:", "lets light through", "twosided"});
    expect_message(mistake(bsdf("twosided", bsdf("diffuse") + bsdf("diffuse") + bsdf("diffuse"))),
                   {"3 nested bsdfs", "one or two"});
}

TEST_F(MaterialParameters, MasksAndMaps) {
    EXPECT_FLOAT_EQ(material(bsdf("mask", bsdf("twosided", bsdf("diffuse")))).opacity, 0.5f);
    EXPECT_EQ(scene_.materials[index()].back, static_cast<int>(index()));
    EXPECT_TRUE(scene_.features & IR_FEATURE_MASKS);
    const auto leaf = material(bsdf("mask", picture("opacity") + bsdf("twosided", bsdf("diffuse"))));
    EXPECT_EQ(leaf.opacity_texture, 0);
    EXPECT_FLOAT_EQ(leaf.opacity, 1.0f);
    EXPECT_FLOAT_EQ(material(bsdf("null")).opacity, 0.0f);
    EXPECT_FLOAT_EQ(material(bsdf("mask", rgb("opacity", ".1 .2 .9") + bsdf("diffuse"))).opacity, 0.4f);
    const auto bumpy =
        material(bsdf("bumpmap", picture("any") + number("scale", "3") +
                                     bsdf("twosided", bsdf("roughplastic", picture("diffuse_reflectance")))));
    EXPECT_EQ(bumpy.kind, IR_MATERIAL_ROUGH_PLASTIC);
    EXPECT_GE(bumpy.map, 0);
    EXPECT_GE(bumpy.texture, 0);
    EXPECT_FLOAT_EQ(bumpy.map_scale, 3.0f);
    EXPECT_EQ(bumpy.flags & IR_MATERIAL_NORMAL_MAP, 0u);
    EXPECT_TRUE(scene_.features & IR_FEATURE_BUMPS);
    const auto normals =
        material(bsdf("mask", number("opacity", ".25") +
                                  bsdf("twosided", bsdf("normalmap", picture("normalmap") + bsdf("conductor")))));
    EXPECT_TRUE(normals.flags & IR_MATERIAL_NORMAL_MAP);
    EXPECT_FLOAT_EQ(normals.opacity, 0.25f);
    EXPECT_EQ(normals.back, static_cast<int>(index()));
    expect_message(mistake(bsdf("bumpmap", picture("a") + bsdf("normalmap", picture("normalmap") + bsdf("diffuse")))),
                   {"bump or normal map inside another"});
    expect_message(mistake(bsdf("bumpmap", "<texture type=\"mesh_attribute\">" + text("name", "vertex_color") +
                                               "</texture>" + bsdf("diffuse"))),
                   {"scene.xml:3:", "vertex colours can be reflectances only"});
    expect_message(mistake(bsdf("bumpmap", bsdf("diffuse"))), {"0 nested textures"});
    expect_message(mistake(bsdf("mask")), {"needs a nested bsdf"});
}

TEST_F(MaterialParameters, TexturesWhereThereIsRoom) {
    const auto metal = material(bsdf("roughconductor", picture("alpha") + picture("specular_reflectance")));
    EXPECT_GE(metal.alpha_texture, 0);
    EXPECT_GE(metal.specular_texture, 0);
    expect_message(mistake(bsdf("mask", "<texture type=\"mesh_attribute\" name=\"opacity\">" +
                                            text("name", "vertex_color") + "</texture>" + bsdf("diffuse"))),
                   {"opacity", "vertex colours"});
    expect_message(mistake(bsdf("conductor", picture("eta"))), {"a colour was expected"});
    expect_message(mistake(bsdf("dielectric", picture("specular_transmittance"))),
                   {"specular_transmittance has to be a colour"});
    expect_message(mistake(bsdf("roughconductor", picture("alpha_u") + number("alpha_v", ".1"))),
                   {"alpha_u", "texture"});
}

TEST_F(MaterialParameters, Checkerboard) {
    const std::string inside =
        rgb("color1", ".1 .2 .3") + "<transform name=\"to_uv\"><scale x=\"4\" y=\"5\"/></transform></texture>";
    const auto m = material(bsdf("diffuse", "<texture type=\"checkerboard\" name=\"reflectance\">" + inside));
    const auto& t = scene_.textures.at(static_cast<std::size_t>(m.texture));
    EXPECT_EQ(t.format, IR_TEXTURE_CHECKERBOARD);
    EXPECT_FLOAT_EQ(t.m00, 4.0f);
    EXPECT_FLOAT_EQ(t.m11, 5.0f);
    const auto colours = [&] {
        Vec sum{};
        for (std::size_t i = 0; i < 3; ++i)
            sum[i] = static_cast<double>(std::bit_cast<float>(scene_.texels.at(scene_.textures.at(0).offset + i)));
        return sum;
    };
    expect_near(colours(), {0.4, 0.4, 0.4}, 1e-7);
    // As one number Mitsuba's has color1 first (bitmaps.json: eval_1() against eval()).
    material(bsdf("mask", bsdf("diffuse") + "<texture type=\"checkerboard\" name=\"opacity\">" + inside));
    expect_near(colours(), {0.2, 0.2, 0.2}, 1e-7);
    expect_message(mistake(bsdf("diffuse", "<texture type=\"checkerboard\" name=\"reflectance\">" + rgb("color0", "2") +
                                               "</texture>")),
                   {"color0", "outside [0, 1]"});
}

TEST_F(MaterialParameters, Mistakes) {
    expect_message(mistake(bsdf("roughplastik")),
                   {"scene.xml:3:", "roughplastik", "did you mean 'roughplastic'", "supported: diffuse, conductor"});
    expect_message(mistake(bsdf("principled")), {"principled", "not supported", "--lenient", "base_color"});
    expect_message(mistake(bsdf("roughconductor", number("alpah", ".1"))), {"'alpah'", "did you mean 'alpha'"});
    expect_message(mistake(bsdf("conductor", text("material", "Agg"))), {"no conductor 'Agg'", "did you mean 'Ag'"});
    expect_message(mistake(bsdf("conductor", text("material", "Au") + number("eta", "1"))), {"either material or eta"});
    expect_message(mistake(bsdf("conductor", rgb("k", "1 -2 1"))), {"k is negative (-2)", "0 or more"});
    expect_message(mistake(bsdf("roughconductor", number("alpha", "0"))), {"alpha is 0", "above 0"});
    expect_message(mistake(bsdf("roughconductor", number("alpha", "-.5"))), {"alpha is -0.5", "above 0"});
    expect_message(
        mistake(bsdf("roughconductor", number("alpha", ".1") + number("alpha_u", ".1") + number("alpha_v", ".1"))),
        {"either alpha or alpha_u and alpha_v"});
    expect_message(mistake(bsdf("roughconductor", number("alpha_u", ".1"))), {"both alpha_u and alpha_v"});
    expect_message(mistake(bsdf("roughconductor", text("distribution", "phong"))), {"'phong'", "beckmann or ggx"});
    expect_message(mistake(bsdf("dielectric", number("int_ior", "0"))), {"int_ior is 0", "above 0"});
    expect_message(mistake(bsdf("dielectric", text("int_ior", "bk8"))), {"'bk8'", "did you mean 'bk7'"});
    expect_message(mistake(bsdf("roughdielectric", number("int_ior", "1.5") + number("ext_ior", "1.5"))),
                   {"int_ior and ext_ior are alike"});
    expect_message(mistake(bsdf("plastic", number("int_ior", "1") + number("ext_ior", "1"))), {"more than 1"});
    expect_message(mistake(bsdf("plastic", number("int_ior", "5"))), {"int_ior over ext_ior is 4.99", "below 3.9"});
    expect_message(mistake(bsdf("plastic", rgb("specular_reflectance", "2"))),
                   {"specular_reflectance (2, 2, 2)", "outside [0, 1]"});
    expect_message(mistake(bsdf("mask", number("opacity", "1.5") + bsdf("diffuse"))), {"opacity", "outside [0, 1]"});
    expect_message(mistake(bsdf("diffuse", "<texture type=\"bitmpa\" name=\"reflectance\"/>")),
                   {"bitmpa", "did you mean 'bitmap'"});
    expect_message(mistake(bsdf("diffuse", "<texture type=\"bitmap\" name=\"reflectance\">" +
                                               text("filename", "absent.png") + "</texture>")),
                   {"scene.xml:3:", "absent.png", "does not exist"});
}

}  // namespace
}  // namespace irradia::test
