// Parameters and defaults of every <bsdf>: what becomes of them in shared::Material. Mistakes: bad_bsdf_test.cpp.
#include <cstring>

#include "bsdf_test.h"

namespace irradia::test {
namespace {

class Bsdf : public BsdfTest {};

TEST_F(Bsdf, DiffuseDefaults) {
    const auto m = material(R"(<bsdf type="diffuse"/>)");
    EXPECT_EQ(m.kind, IR_MATERIAL_DIFFUSE);
    expect_near({m.r, m.g, m.b}, {0.5, 0.5, 0.5}, 0);
    EXPECT_EQ(m.opacity, 1.0f);
    EXPECT_EQ(m.back, IR_NO_MATERIAL);
    EXPECT_EQ(m.coat, 0u);
    for (const int texture : {m.texture, m.specular_texture, m.opacity_texture, m.alpha_texture, m.map})
        EXPECT_EQ(texture, IR_NO_TEXTURE);
    EXPECT_EQ(scene_.features & (IR_FEATURE_BSDFS | IR_FEATURE_MASKS | IR_FEATURE_BUMPS), 0u);
}

TEST_F(Bsdf, Conductors) {
    const auto mirror = material(R"(<bsdf type="conductor"/>)");  // Mitsuba's default is material "none"
    EXPECT_EQ(mirror.kind, IR_MATERIAL_CONDUCTOR);
    EXPECT_EQ(mirror.back, IR_NO_MATERIAL);
    expect_near({mirror.eta_r, mirror.eta_g, mirror.eta_b}, {0, 0, 0}, 0);
    expect_near({mirror.k_r, mirror.k_g, mirror.k_b}, {1, 1, 1}, 0);
    expect_near({mirror.specular_r, mirror.specular_g, mirror.specular_b}, {1, 1, 1}, 0);
    EXPECT_EQ(scene_.features & IR_FEATURE_BSDFS, IR_FEATURE_BSDFS);
    const auto none = material(R"(<bsdf type="conductor"><string name="material" value="none"/></bsdf>)");
    EXPECT_EQ(std::memcmp(&none, &mirror, sizeof none), 0);
    // mi.traverse(mi.load_dict({'type': 'conductor', 'material': 'Au'})) in scalar_rgb of Mitsuba 3.9.1
    const auto gold = material(R"(<bsdf type="conductor"><string name="material" value="Au"/></bsdf>)");
    expect_near({gold.eta_r, gold.eta_g, gold.eta_b}, {0.143036, 0.375307, 1.44205}, 2e-5);
    expect_near({gold.k_r, gold.k_g, gold.k_b}, {3.983, 2.38556, 1.60336}, 2e-5);
    const auto own = material(R"(<bsdf type="conductor"><rgb name="eta" value="1.5, 0, 2"/><float name="k" value="2"/>
        <rgb name="specular_reflectance" value=".2, .3, .4"/></bsdf>)");
    expect_near({own.eta_r, own.eta_g, own.eta_b}, {1.5, 0, 2}, 0);
    expect_near({own.k_r, own.k_g, own.k_b}, {2, 2, 2}, 0);
    expect_near({own.specular_r, own.specular_g, own.specular_b}, {0.2, 0.3, 0.4}, 1e-7);
    expect_near({own.r, own.g, own.b}, {0, 0, 0}, 0);  // nothing diffuse
}

TEST_F(Bsdf, RoughnessAndDistributions) {
    const auto plain = material(R"(<bsdf type="roughconductor"/>)");
    EXPECT_EQ(plain.kind, IR_MATERIAL_ROUGH_CONDUCTOR);
    EXPECT_EQ(plain.flags, IR_MATERIAL_BECKMANN);
    EXPECT_FLOAT_EQ(plain.alpha_u, 0.1f);
    EXPECT_FLOAT_EQ(plain.alpha_v, 0.1f);
    const auto rough = [&](const std::string& inside) {
        return material("<bsdf type=\"roughconductor\">" + inside + "</bsdf>");
    };
    const auto ggx = rough(R"(<string name="distribution" value="ggx"/><float name="alpha" value=".3"/>
        <boolean name="sample_visible" value="false"/>)");
    EXPECT_EQ(ggx.flags, 0u);
    EXPECT_FLOAT_EQ(ggx.alpha_u, 0.3f);
    EXPECT_FLOAT_EQ(ggx.alpha_v, 0.3f);
    EXPECT_EQ(rough(R"(<string name="distribution" value="beckmann"/>)").flags, IR_MATERIAL_BECKMANN);
    const auto brushed = rough(R"(<float name="alpha_u" value=".2"/><float name="alpha_v" value=".4"/>)");
    EXPECT_FLOAT_EQ(brushed.alpha_u, 0.2f);
    EXPECT_FLOAT_EQ(brushed.alpha_v, 0.4f);
    // Mitsuba holds roughness at 1e-4.
    EXPECT_FLOAT_EQ(rough(R"(<float name="alpha" value="1e-6"/>)").alpha_u, 1e-4f);
    const auto textured = rough(R"(<texture type="checkerboard" name="alpha"/>)");
    EXPECT_EQ(textured.alpha_texture, 0);
    EXPECT_EQ(textured.texture, IR_NO_TEXTURE);
}

TEST_F(Bsdf, Dielectrics) {
    const auto glass = material(R"(<bsdf type="dielectric"/>)");
    EXPECT_EQ(glass.kind, IR_MATERIAL_DIELECTRIC);
    EXPECT_FLOAT_EQ(glass.eta, static_cast<float>(1.5046 / 1.000277));  // bk7 in air
    EXPECT_EQ(glass.back, index_);                                      // has both sides
    expect_near({glass.transmittance_r, glass.transmittance_g, glass.transmittance_b}, {1, 1, 1}, 0);
    const auto with = [&](const std::string& inside) {
        return material("<bsdf type=\"dielectric\">" + inside + "</bsdf>");
    };
    EXPECT_FLOAT_EQ(with(R"(<float name="int_ior" value="1.5"/>)").eta, static_cast<float>(1.5 / 1.000277));
    EXPECT_FLOAT_EQ(with(R"(<float name="int_ior" value="1.5"/><integer name="ext_ior" value="2"/>)").eta, 0.75f);
    EXPECT_FLOAT_EQ(with(R"(<string name="int_ior" value="air"/><string name="ext_ior" value="water ice"/>)").eta,
                    static_cast<float>(1.000277 / 1.31));
    EXPECT_FLOAT_EQ(with(R"(<string name="int_ior" value="diamond"/><string name="ext_ior" value="vacuum"/>)").eta,
                    2.419f);
    const auto tinted = with(R"(<rgb name="specular_reflectance" value=".1, .2, .3"/>
        <rgb name="specular_transmittance" value=".4, .5, .6"/>)");
    expect_near({tinted.specular_r, tinted.specular_g, tinted.specular_b}, {0.1, 0.2, 0.3}, 1e-7);
    expect_near({tinted.transmittance_r, tinted.transmittance_g, tinted.transmittance_b}, {0.4, 0.5, 0.6}, 1e-7);
    const auto pane = material(R"(<bsdf type="thindielectric"/>)");
    EXPECT_EQ(pane.kind, IR_MATERIAL_THIN_DIELECTRIC);
    EXPECT_EQ(pane.eta, glass.eta);
    EXPECT_EQ(pane.back, index_);
    const auto frosted = material(R"(<bsdf type="roughdielectric"><string name="distribution" value="ggx"/>
        <float name="alpha_u" value=".2"/><float name="alpha_v" value=".4"/></bsdf>)");
    EXPECT_EQ(frosted.kind, IR_MATERIAL_ROUGH_DIELECTRIC);
    EXPECT_EQ(frosted.flags, 0u);
    EXPECT_FLOAT_EQ(frosted.alpha_v, 0.4f);
    EXPECT_EQ(frosted.eta, glass.eta);
    EXPECT_EQ(frosted.back, index_);
}

TEST_F(Bsdf, Plastics) {
    const auto smooth = material(R"(<bsdf type="plastic"/>)");
    EXPECT_EQ(smooth.kind, IR_MATERIAL_PLASTIC);
    EXPECT_EQ(smooth.flags, 0u);
    EXPECT_FLOAT_EQ(smooth.eta, static_cast<float>(1.49 / 1.000277));  // polypropylene in air
    expect_near({smooth.r, smooth.g, smooth.b}, {0.5, 0.5, 0.5}, 0);
    EXPECT_FLOAT_EQ(smooth.specular_weight, static_cast<float>(1.0 / 1.5));
    EXPECT_EQ(smooth.coat, 1u);
    EXPECT_GT(smooth.internal_reflectance, 0.5f);
    EXPECT_EQ(smooth.back, IR_NO_MATERIAL);
    EXPECT_TRUE(scene_.texels.empty());  // no table
    const auto own = material(R"(<bsdf type="plastic"><rgb name="diffuse_reflectance" value=".1, .2, .3"/>
        <rgb name="specular_reflectance" value=".6"/><boolean name="nonlinear" value="true"/>
        <float name="int_ior" value="1.9"/></bsdf>)");
    EXPECT_EQ(own.flags, IR_MATERIAL_NONLINEAR);
    expect_near({own.r, own.g, own.b}, {0.1, 0.2, 0.3}, 1e-7);
    EXPECT_FLOAT_EQ(own.specular_weight, 0.75f);  // .6 / (.6 + .2)
    EXPECT_FLOAT_EQ(own.eta, static_cast<float>(1.9 / 1.000277));
    const auto black = material(R"(<bsdf type="plastic"><float name="diffuse_reflectance" value="0"/>
        <float name="specular_reflectance" value="0"/></bsdf>)");
    EXPECT_EQ(black.specular_weight, 0.5f);
    const auto rough = material(R"(<bsdf type="roughplastic"><boolean name="nonlinear" value="true"/></bsdf>)");
    EXPECT_EQ(rough.kind, IR_MATERIAL_ROUGH_PLASTIC);
    EXPECT_EQ(rough.flags, IR_MATERIAL_BECKMANN | IR_MATERIAL_NONLINEAR);
    EXPECT_FLOAT_EQ(rough.alpha_u, 0.1f);
    EXPECT_EQ(rough.eta, smooth.eta);
    EXPECT_EQ(rough.coat_table, 0u);
    EXPECT_EQ(scene_.texels.size(), IR_COAT_TABLE);
    const auto textured = material(R"(<bsdf type="roughplastic">
        <texture name="diffuse_reflectance" type="checkerboard"/></bsdf>)");
    EXPECT_EQ(textured.texture, 0);
    EXPECT_EQ(textured.coat_table, 6u);  // behind the two colours
    EXPECT_FLOAT_EQ(textured.specular_weight, static_cast<float>(1.0 / 1.3));
}

// The records of the irradiance cache are kept apart by coats: alike ones are one.
TEST_F(Bsdf, CoatsThatAreAlikeAreOne) {
    const auto coats = [&](const std::vector<std::string>& bsdfs) {
        std::string body = sensor + lamp;
        for (const auto& b : bsdfs) body += "<shape type=\"rectangle\">" + b + "</shape>";
        scene_ = load(body);
        std::vector<std::uint32_t> numbers;
        for (std::size_t i = 0; i < bsdfs.size(); ++i)
            numbers.push_back(scene_.materials[scene_.triangles.at(2 + 2 * i).material].coat);
        return numbers;
    };
    const auto plastic = [](const std::string& type, const std::string& inside) {
        return "<bsdf type=\"" + type + "\">" + inside + "</bsdf>";
    };
    const std::string red = R"(<rgb name="diffuse_reflectance" value=".8, .1, .1"/>)",
                      blue = R"(<rgb name="diffuse_reflectance" value=".1, .1, .8"/>)";
    EXPECT_EQ(coats({plastic("plastic", red), plastic("plastic", blue),
                     plastic("plastic", R"(<boolean name="nonlinear" value="true"/>)"),
                     plastic("plastic", R"(<string name="int_ior" value="acrylic glass"/>)"),  // 1.49 too
                     plastic("plastic", R"(<float name="int_ior" value="1.5"/>)"), R"(<bsdf type="diffuse"/>)"}),
              (std::vector<std::uint32_t>{1, 1, 1, 1, 2, 0}));
    const std::string wide = R"(<float name="alpha" value=".2"/>)";
    EXPECT_EQ(
        coats({plastic("roughplastic", red), plastic("roughplastic", blue), plastic("plastic", red),
               plastic("roughplastic", wide), plastic("roughplastic", R"(<string name="distribution" value="ggx"/>)"),
               plastic("roughplastic", wide + blue)}),
        (std::vector<std::uint32_t>{1, 1, 2, 3, 4, 3}));
    EXPECT_EQ(scene_.texels.size(), 3 * IR_COAT_TABLE);  // the smooth one has no table
    std::vector<std::uint32_t> tables;
    for (const std::size_t t : {2u, 4u, 8u, 10u})
        tables.push_back(scene_.materials[scene_.triangles.at(t).material].coat_table);
    EXPECT_EQ(tables, (std::vector<std::uint32_t>{0, 0, IR_COAT_TABLE, 2 * IR_COAT_TABLE}));
}

TEST_F(Bsdf, Twosided) {
    const auto one = material(R"(<bsdf type="twosided"><bsdf type="plastic"/></bsdf>)");
    EXPECT_EQ(one.kind, IR_MATERIAL_PLASTIC);
    EXPECT_EQ(one.back, index_);
    const auto two = material(R"(<bsdf type="twosided"><bsdf type="roughconductor"/><bsdf type="diffuse">
        <float name="reflectance" value=".3"/></bsdf></bsdf>)");
    EXPECT_EQ(two.kind, IR_MATERIAL_ROUGH_CONDUCTOR);
    ASSERT_NE(two.back, IR_NO_MATERIAL);
    ASSERT_NE(two.back, index_);
    const auto& back = scene_.materials.at(static_cast<std::size_t>(two.back));
    EXPECT_EQ(back.kind, IR_MATERIAL_DIFFUSE);
    EXPECT_FLOAT_EQ(back.r, 0.3f);
}

TEST_F(Bsdf, MaskAndNull) {
    const auto half = material(R"(<bsdf type="mask"><bsdf type="diffuse"/></bsdf>)");
    EXPECT_EQ(half.opacity, 0.5f);  // Mitsuba's default
    EXPECT_EQ(half.kind, IR_MATERIAL_DIFFUSE);
    EXPECT_EQ(half.back, IR_NO_MATERIAL);
    EXPECT_EQ(scene_.features & IR_FEATURE_MASKS, IR_FEATURE_MASKS);
    const auto mask = [&](const std::string& opacity, const std::string& nested) {
        return material("<bsdf type=\"mask\">" + opacity + nested + "</bsdf>");
    };
    const std::string quarter = R"(<float name="opacity" value=".25"/>)", diffuse = R"(<bsdf type="diffuse"/>)";
    EXPECT_EQ(mask(quarter, diffuse).opacity, 0.25f);
    EXPECT_FLOAT_EQ(mask(R"(<rgb name="opacity" value="1, 0.5, 0"/>)", diffuse).opacity, 0.5f);
    const auto textured = mask(R"(<texture type="checkerboard" name="opacity"/>)", diffuse);
    EXPECT_EQ(textured.opacity_texture, 0);
    EXPECT_EQ(textured.texture, IR_NO_TEXTURE);
    EXPECT_EQ(scene_.features & (IR_FEATURE_MASKS | IR_FEATURE_TEXTURES), IR_FEATURE_MASKS | IR_FEATURE_TEXTURES);
    const auto both = mask(quarter, "<bsdf type=\"twosided\"><bsdf type=\"plastic\"/></bsdf>");
    EXPECT_EQ(both.kind, IR_MATERIAL_PLASTIC);
    EXPECT_EQ(both.opacity, 0.25f);
    EXPECT_EQ(both.back, index_);
    EXPECT_EQ(mask(quarter, "<bsdf type=\"mask\">" + diffuse + "</bsdf>").opacity, 0.125f);  // the product
    const auto null = material(R"(<bsdf type="null"/>)");
    EXPECT_EQ(null.opacity, 0.0f);
    EXPECT_EQ(null.back, index_);
    EXPECT_EQ(mask(quarter, R"(<bsdf type="null"/>)").opacity, 0.0f);
    EXPECT_EQ(mask(R"(<float name="opacity" value="1"/>)", diffuse).opacity, 1.0f);
    EXPECT_EQ(scene_.features & IR_FEATURE_MASKS, 0u);
}

TEST_F(Bsdf, BumpAndNormalMaps) {
    const std::string heights = R"(<texture type="bitmap"><string name="filename" value="h.exr"/></texture>)";
    write_picture<float>("h.exr", 1, 1, 3, OIIO::TypeDesc::FLOAT, {-2.0f, 3.0f, 0.5f});
    const auto bump = material("<bsdf type=\"bumpmap\">" + heights + "<bsdf type=\"diffuse\"/></bsdf>");
    EXPECT_EQ(bump.kind, IR_MATERIAL_DIFFUSE);
    EXPECT_EQ(bump.map, 0);
    EXPECT_EQ(bump.map_scale, 1.0f);
    EXPECT_EQ(bump.flags & IR_MATERIAL_NORMAL_MAP, 0u);
    EXPECT_EQ(scene_.features & IR_FEATURE_BUMPS, IR_FEATURE_BUMPS);
    EXPECT_EQ(std::bit_cast<float>(scene_.texels.at(0)), -2.0f);  // heights are no reflectances
    EXPECT_TRUE(warnings_.empty());
    const std::string scaled = "<bsdf type=\"bumpmap\"><float name=\"scale\" value=\"-4\"/>" + heights;
    const auto both =
        material(scaled + R"(<bsdf type="twosided"><bsdf type="roughplastic"/><bsdf type="diffuse"/></bsdf></bsdf>)");
    EXPECT_EQ(both.kind, IR_MATERIAL_ROUGH_PLASTIC);
    EXPECT_EQ(both.map_scale, -4.0f);
    EXPECT_EQ(scene_.materials.at(static_cast<std::size_t>(both.back)).kind, IR_MATERIAL_DIFFUSE);
    const auto inside = material("<bsdf type=\"twosided\">" + scaled + "<bsdf type=\"conductor\"/></bsdf></bsdf>");
    EXPECT_EQ(inside.map, 0);
    EXPECT_EQ(inside.back, index_);
    const auto normals =
        material("<bsdf type=\"normalmap\">" +
                 std::string(R"(<texture type="bitmap" name="normalmap"><boolean name="raw" value="true"/>
        <string name="filename" value="h.exr"/></texture><bsdf type="dielectric"/></bsdf>)"));
    EXPECT_EQ(normals.kind, IR_MATERIAL_DIELECTRIC);
    EXPECT_EQ(normals.flags, IR_MATERIAL_NORMAL_MAP);
    EXPECT_EQ(normals.map, 0);
    const auto all = material("<bsdf type=\"mask\"><float name=\"opacity\" value=\".75\"/>" + scaled +
                              R"(<bsdf type="twosided"><bsdf type="plastic"/></bsdf></bsdf></bsdf>)");
    EXPECT_EQ(all.opacity, 0.75f);
    EXPECT_EQ(all.map, 0);
    EXPECT_EQ(all.back, index_);
    EXPECT_EQ(all.coat, 1u);
}

TEST_F(Bsdf, Checkerboards) {
    const auto board = [&](const std::string& inside) {
        material("<bsdf type=\"diffuse\"><texture type=\"checkerboard\" name=\"reflectance\">" + inside +
                 "</texture></bsdf>");
        std::vector<float> values;
        for (const std::uint32_t word : scene_.texels) values.push_back(std::bit_cast<float>(word));
        return values;
    };
    EXPECT_EQ(board(""), (std::vector<float>{0.4f, 0.4f, 0.4f, 0.2f, 0.2f, 0.2f}));  // Mitsuba's defaults
    EXPECT_EQ(board(R"(<rgb name="color0" value="1, 0.5, 0"/><rgb name="color1" value="0.1"/>
        <transform name="to_uv"><scale x="4" y="8"/></transform>)"),
              (std::vector<float>{1.0f, 0.5f, 0.0f, 0.1f, 0.1f, 0.1f}));
    const auto& t = scene_.textures.at(0);
    EXPECT_EQ(t.format, IR_TEXTURE_CHECKERBOARD);
    EXPECT_EQ(t.width, 1u);
    EXPECT_EQ(t.height, 1u);
    expect_near({t.m00, t.m01, t.m02}, {4, 0, 0}, 0);
    expect_near({t.m10, t.m11, t.m12}, {0, 8, 0}, 0);
}

}  // namespace
}  // namespace irradia::test
