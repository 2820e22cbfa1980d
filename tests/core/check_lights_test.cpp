// Conditions of check_scene() on environment pictures, spots, cylinders and textured area lights.
#include <gtest/gtest.h>

#include <bit>
#include <functional>
#include <limits>
#include <string>
#include <vector>

#include "irradia/PackedScene.h"
#include "small_scene.h"

namespace {

using irradia::check_scene;
using irradia::Scene;
using namespace irradia::test;

std::uint32_t bits(float x) { return std::bit_cast<std::uint32_t>(x); }

/// The small scene whose environment is a picture of 2 x 3 texels, radiance up to 7; table: see cl/environment.h.
Scene scene_with_picture() {
    Scene s = small_scene();
    irradia::shared::Light& l = s.lights[3];
    l.kind = IR_LIGHT_ENVMAP;
    l.e1x = l.e2y = l.nz = 1.0f;
    l.texture = 3;
    irradia::shared::Texture t{};
    t.offset = static_cast<std::uint32_t>(s.texels.size());
    t.width = 2;
    t.height = 3;
    t.format = IR_TEXTURE_RGB32F;
    t.m00 = t.m11 = 1.0f;
    s.textures.push_back(t);
    for (int i = 0; i < 18; ++i) s.texels.push_back(bits(static_cast<float>(i % 8)));
    l.table = static_cast<std::uint32_t>(s.texels.size());
    for (const float x : {0.25f, 1.0f, /**/ 0.0f, 1.0f, 0.0f, /**/ 0.3f, 0.3f, /**/ 0.5f, 1.0f, 0.125f, 1.0f})
        s.texels.push_back(bits(x));
    s.features |= IR_FEATURE_ENVMAP;
    return s;
}

/// A textured disk, a cylinder and a spot.
Scene scene_with_others() {
    Scene s = small_scene();
    s.lights[0].texture = 1;
    s.lights[0].primitive = 2;
    s.lights[0].kind = IR_LIGHT_DISK;
    s.lights[1].kind = IR_LIGHT_SPOT;
    s.lights[1].e2x = 0.4f;
    s.lights[1].e2y = 0.3f;
    s.lights[2].kind = IR_LIGHT_CYLINDER;
    s.features |= IR_FEATURE_TEXTURED_LIGHTS;
    return s;
}

struct Case {
    const char* expected;  ///< part of the message
    std::function<void(Scene&)> damage;
};

void expect_refused(const Scene& whole, const std::vector<Case>& cases) {
    for (const Case& c : cases) {
        Scene s = whole;
        c.damage(s);
        const std::string message = error_of([&] { check_scene("file", s); });
        EXPECT_TRUE(one_line(message) && message.starts_with("file: ") && has(message, c.expected))
            << "expected: " << c.expected << "\n     got: " << message;
    }
}

TEST(CheckLights, AcceptsValidScenes) {
    EXPECT_EQ(error_of([] { check_scene("file", scene_with_picture()); }), "");
    EXPECT_EQ(error_of([] { check_scene("file", scene_with_others()); }), "");
}

TEST(CheckLights, EnvironmentPicture) {
    const Scene whole = scene_with_picture();
    const std::size_t table = whole.lights[3].table;
    const auto put = [table](std::size_t i, float x) { return [=](Scene& s) { s.texels[table + i] = bits(x); }; };
    expect_refused(
        whole,
        {
            {"a feature that it needs", [](Scene& s) { s.features &= ~IR_FEATURE_ENVMAP; }},
            {"light 3: an environment without its picture", [](Scene& s) { s.lights[3].texture = -1; }},
            {"light 3: texture 4", [](Scene& s) { s.lights[3].texture = 4; }},
            {"another format", [](Scene& s) { s.lights[3].texture = 0; }},
            {"less than 2 rows", [](Scene& s) { s.lights[3].texture = 2; }},
            {"tables are outside", [](Scene& s) { s.texels.pop_back(); }},
            {"tables are outside", [](Scene& s) { s.lights[3].table = 0xffffffffu; }},
            {"light 3: what is seen of an environment", [](Scene& s) { s.lights[3].view = 9; }},
            {"texture 3: a texel is not finite", [](Scene& s) { s.texels[s.textures[3].offset + 5] = 0x7fc00000u; }},
            {"texture 3: a texel is outside [0, 1]", [](Scene& s) { s.materials[1].texture = 3; }},
            {"descends", put(0, 1.5f)},
            {"descends", put(0, -0.5f)},
            {"does not end at 1", put(1, 0.9f)},
            {"height is outside", put(3, 1.5f)},
            {"density of a row", put(5, 0.0f)},
            {"descends", put(9, std::numeric_limits<float>::quiet_NaN())},
            {"does not end at 1", put(8, 0.5f)},
            {"does not end at 1", put(10, 1.25f)},
            {"unit length", [](Scene& s) { s.lights[3].e2y = 1.1f; }},
        });
}

TEST(CheckLights, OtherKinds) {
    expect_refused(scene_with_others(),
                   {
                       {"a feature that it needs", [](Scene& s) { s.features &= ~IR_FEATURE_TEXTURED_LIGHTS; }},
                       {"light 0: primitive 3 is not below 3", [](Scene& s) { s.lights[0].primitive = 3; }},
                       {"light 0: texture 3", [](Scene& s) { s.lights[0].texture = 3; }},
                       {"light 1: a texture on a light without area", [](Scene& s) { s.lights[1].texture = 0; }},
                       {"light 1: a spot's inner cone", [](Scene& s) { s.lights[1].e2y = 0.5f; }},
                       {"light 2: a cylinder without area", [](Scene& s) { s.lights[2].radius = 0.0f; }},
                       {"light 2: a cylinder without area", [](Scene& s) { s.lights[2].area = 0.0f; }},
                   });
}

}  // namespace
