// Every condition of check_scene(): a scene that breaks it, and the line that says so.
#include <gtest/gtest.h>

#include <cmath>
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

struct Case {
    const char* expected;  ///< part of the message
    std::function<void(Scene&)> damage;
};

constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
constexpr float kInfinite = std::numeric_limits<float>::infinity();

void expect_refused(const std::vector<Case>& cases) {
    for (const Case& c : cases) {
        Scene s = small_scene();
        c.damage(s);
        const std::string message = error_of([&] { check_scene("file", s); });
        EXPECT_TRUE(one_line(message) && message.starts_with("file: ") && has(message, c.expected))
            << "expected: " << c.expected << "\n     got: " << message;
    }
}

TEST(CheckScene, AcceptsAValidScene) {
    EXPECT_EQ(error_of([] { check_scene("file", small_scene()); }), "");
}

TEST(CheckScene, Geometry) {
    expect_refused({
        {"vertex 2: a number is not finite", [](Scene& s) { s.vertices[2].py = kNan; }},
        {"vertex 0: a number is not finite", [](Scene& s) { s.vertices[0].v = kInfinite; }},
        {"triangle 0: vertex 4 is not below 4", [](Scene& s) { s.triangles[0].v0 = 4; }},
        {"triangle 0: vertex 4294967295", [](Scene& s) { s.triangles[0].v1 = 0xffffffffu; }},
        {"triangle 1: vertex", [](Scene& s) { s.triangles[1].v2 = 5; }},
        {"triangle 1: material 2 is not below 2", [](Scene& s) { s.triangles[1].material = 2; }},
        {"triangle 1: light 4 is neither -1 nor below 4", [](Scene& s) { s.triangles[1].light = 4; }},
        {"triangle 1: light -2", [](Scene& s) { s.triangles[1].light = -2; }},
        {"triangle 1: unknown flags", [](Scene& s) { s.triangles[1].flags = 4; }},
        {"triangle 1: a number", [](Scene& s) { s.triangles[1].nz = kNan; }},
        {"analytic primitive 0: unknown kind", [](Scene& s) { s.analytics[0].kind = 3; }},
        {"analytic primitive 0: material", [](Scene& s) { s.analytics[0].material = 2; }},
        {"analytic primitive 0: light", [](Scene& s) { s.analytics[0].light = 9; }},
        {"analytic primitive 0: radius", [](Scene& s) { s.analytics[0].radius = 0.0f; }},
        {"analytic primitive 0: a number", [](Scene& s) { s.analytics[0].vx = kNan; }},
    });
}

TEST(CheckScene, Appearance) {
    expect_refused({
        {"material 0: texture 3", [](Scene& s) { s.materials[0].texture = 3; }},
        {"material 0: unknown kind", [](Scene& s) { s.materials[0].kind = IR_MATERIAL_KINDS; }},
        {"material 1: unknown flags", [](Scene& s) { s.materials[1].flags = 16; }},
        {"material 1: reflectance", [](Scene& s) { s.materials[1].g = 1.01f; }},
        {"material 1: reflectance", [](Scene& s) { s.materials[1].b = kNan; }},
        {"material 1: index of refraction", [](Scene& s) { s.materials[1].eta = 0.0f; }},
        {"material 1: a conductor's index", [](Scene& s) { s.materials[1].k_g = -1.0f; }},
        {"material 1: roughness", [](Scene& s) { s.materials[1].alpha_v = 1e-20f; }},
        {"material 1: a number", [](Scene& s) { s.materials[1].alpha_u = kNan; }},
        {"material 1: opacity", [](Scene& s) { s.materials[1].opacity = 1.5f; }},
        {"material 1: the coat's internal", [](Scene& s) { s.materials[1].internal_reflectance = 1.0f; }},
        {"material 1: the coat's weight", [](Scene& s) { s.materials[1].specular_weight = kNan; }},
        {"material 1: the coat's table",
         [](Scene& s) {
             s.materials[1].kind = IR_MATERIAL_ROUGH_PLASTIC;
             s.materials[1].coat_table = static_cast<std::uint32_t>(s.texels.size()) - IR_COAT_TABLE + 1;
             s.features |= IR_FEATURE_BSDFS;
         }},
        {"material 1: a transmittance",
         [](Scene& s) {
             s.materials[1].kind = IR_MATERIAL_ROUGH_PLASTIC;
             s.materials[1].coat_table = static_cast<std::uint32_t>(s.texels.size());
             s.texels.resize(s.texels.size() + IR_COAT_TABLE);
             s.texels.back() = 0x7fc00000u;
             s.features |= IR_FEATURE_BSDFS;
         }},
        {"material 1: vertex colours",
         [](Scene& s) {
             s.textures[1].format = IR_TEXTURE_VERTEX_COLOUR;
             s.materials[1].map = 1;
             s.features |= IR_FEATURE_BUMPS;
         }},
        {"material 1: vertex colours",
         [](Scene& s) {
             s.textures[1].format = IR_TEXTURE_VERTEX_COLOUR;
             s.materials[1].opacity_texture = 1;
             s.features |= IR_FEATURE_MASKS;
         }},
        {"texture 0: unknown format", [](Scene& s) { s.textures[0].format = 5; }},
        {"texture 0: unknown wrap", [](Scene& s) { s.textures[0].wrap = 3; }},
        {"texture 0: unknown filter", [](Scene& s) { s.textures[0].filter = 2; }},
        {"texture 1: a number", [](Scene& s) { s.textures[1].m12 = kInfinite; }},
        {"texture 1: size", [](Scene& s) { s.textures[1].width = 0; }},
        {"texture 1: size", [](Scene& s) { s.textures[1].height = 0x80000000u; }},
        {"texture 1: texels are outside", [](Scene& s) { s.textures[1].width = s.textures[1].height = 1u << 20; }},
        {"texture 2: texels are outside", [](Scene& s) { s.textures[2].offset = 11; }},
        {"texture 2: texels are outside", [](Scene& s) { s.textures[2].offset = 0xffffffffu; }},
        {"texture 2: texels are outside", [](Scene& s) { s.texels.pop_back(); }},
        {"texture 2: a texel", [](Scene& s) { s.texels.back() = 0x7fc00000u; }},
        {"texture 2: a texel", [](Scene& s) { s.texels.back() = 0x40000000u; }},
    });
}

TEST(CheckScene, Lights) {
    expect_refused({
        {"light 1: unknown kind", [](Scene& s) { s.lights[1].kind = 10; }},
        {"light 1: a number", [](Scene& s) { s.lights[1].px = kNan; }},
        {"light 1: negative radiance", [](Scene& s) { s.lights[1].r = -1.0f; }},
        {"light 0: negative area", [](Scene& s) { s.lights[0].area = -1.0f; }},
        {"light 1: the cdf descends", [](Scene& s) { s.lights[1].cdf = 0.25f; }},
        {"light 3: the last cdf", [](Scene& s) { s.lights[3].cdf = 0.99f; }},
        {"light 2: probability", [](Scene& s) { s.lights[2].probability = 1.5f; }},
        {"light 2: a number", [](Scene& s) { s.lights[2].cdf = kNan; }},
    });
}

TEST(CheckScene, Settings) {
    expect_refused({
        {"camera 0: a number", [](Scene& s) { s.info.camera.dyz = kNan; }},
        {"size is out of range", [](Scene& s) { s.info.width = 0; }},
        {"size is out of range", [](Scene& s) { s.info.width = s.info.height = 1u << 16; }},
        {"reconstruction filter", [](Scene& s) { s.info.rfilter = 3; }},
        {"radius is out of range", [](Scene& s) { s.info.rfilter_radius = 1e30f; }},
        {"radius is out of range", [](Scene& s) { s.info.rfilter_radius = 0.0f; }},
        {"width is not positive", [](Scene& s) { s.info.rfilter_stddev = 0.0f; }},
        {"not four standard deviations", [](Scene& s) { s.info.rfilter_radius = 1.5f; }},
        {"counts do not match", [](Scene& s) { s.info.triangle_count = 3; }},
        {"counts do not match", [](Scene& s) { s.info.analytic_count = 0; }},
        {"counts do not match", [](Scene& s) { s.info.light_count = 5; }},
        {"environment light 4", [](Scene& s) { s.info.environment_light = 4; }},
        {"environment light is of another kind", [](Scene& s) { s.info.environment_light = 0; }},
        {"diagonal", [](Scene& s) { s.info.diagonal = -1.0f; }},
        {"bounds", [](Scene& s) { s.info.min_y = 2.0f; }},
        {"unknown features", [](Scene& s) { s.features |= 0x1000u; }},
        {"no samples", [](Scene& s) { s.sample_count = 0; }},
        {"a number", [](Scene& s) { s.centre[1] = std::nan(""); }},
        {"control character", [](Scene& s) { s.source = "a\nb"; }},
    });
    for (const std::uint32_t feature : {IR_FEATURE_TEXTURES, IR_FEATURE_ANALYTIC, IR_FEATURE_SMOOTH_NORMALS,
                                        IR_FEATURE_ENVIRONMENT, IR_FEATURE_DELTA_LIGHTS})
        expect_refused({{"a feature that it needs", [=](Scene& s) { s.features &= ~feature; }}});
}

TEST(CheckScene, Bvh8) {
    expect_refused({
        {"no acceleration structure", [](Scene& s) { s.accel.bvh8_nodes.clear(); }},
        {"BVH8 node 0: child 2 is not below 2", [](Scene& s) { s.accel.bvh8_nodes[0].child[0] = 2; }},
        {"BVH8 node 0: a child that has another parent", [](Scene& s) { s.accel.bvh8_nodes[0].child[0] = 0; }},
        {"BVH8 node 1: a child that has another parent", [](Scene& s) { s.accel.bvh8_nodes[1].child[0] = 0; }},
        {"BVH8 node 0: a child that has another parent", [](Scene& s) { s.accel.bvh8_nodes[0].child[1] = 1; }},
        {"BVH8 node 1: more than eight", [](Scene& s) { s.accel.bvh8_nodes[1].count = 9; }},
        {"BVH8 node 1: a child beyond the count", [](Scene& s) { s.accel.bvh8_nodes[1].count = 0; }},
        {"BVH8 node 1: a child is missing",
         [](Scene& s) {
             s.accel.bvh8_nodes[1].count = 2;
             s.accel.bvh8_nodes[1].lo_x[1] = s.accel.bvh8_nodes[1].hi_x[1] = 0;
         }},
        {"BVH8 node 1: an empty child has a box", [](Scene& s) { s.accel.bvh8_nodes[1].lo_y[7] = 0.0f; }},
        {"BVH8 node 1: an empty child has a box", [](Scene& s) { s.accel.bvh8_nodes[1].hi_z[7] = kNan; }},
        {"BVH8 node 0: a number", [](Scene& s) { s.accel.bvh8_nodes[0].hi_z[1] = kNan; }},
        {"BVH8 node 1: a leaf's count", [](Scene& s) { s.accel.bvh8_nodes[1].child[0] = IR_LEAF | 9u << 24; }},
        {"BVH8 node 1: a leaf beyond the triangles",
         [](Scene& s) { s.accel.bvh8_nodes[1].child[0] = IR_LEAF | 1u << 24 | 1u; }},
        {"BVH8 node 0: a leaf beyond the analytic",
         [](Scene& s) { s.accel.bvh8_nodes[0].child[1] = IR_LEAF | IR_LEAF_ANALYTIC | 2u << 24; }},
        {"BVH8 node 0: a leaf beyond the analytic",
         [](Scene& s) { s.accel.bvh8_nodes[0].child[1] = IR_LEAF | IR_LEAF_ANALYTIC | 1u << 24 | 1u; }},
        {"triangle block 0: triangle 2 is not below 2", [](Scene& s) { s.accel.bvh8_triangles[0].primitive[1] = 2; }},
        {"triangle block 0: a number", [](Scene& s) { s.accel.bvh8_triangles[0].v2z[7] = kNan; }},
        {"triangle block 0: an unused slot", [](Scene& s) { s.accel.bvh8_triangles[0].v1x[7] = 1.0f; }},
    });
}

TEST(CheckScene, Bvh2) {
    expect_refused({
        {"no acceleration structure", [](Scene& s) { s.accel.bvh2_nodes.clear(); }},
        {"BVH2 node 0: child 7", [](Scene& s) { s.accel.bvh2_nodes[0].child0 = 7; }},
        {"BVH2 node 1: a child that has another parent", [](Scene& s) { s.accel.bvh2_nodes[1].child1 = 1; }},
        {"BVH2 node 1: a number", [](Scene& s) { s.accel.bvh2_nodes[1].lo1y = kInfinite; }},
        {"BVH2 node 1: a leaf beyond the triangles",
         [](Scene& s) { s.accel.bvh2_nodes[1].child1 = IR_LEAF | 2u << 24 | 1u; }},
        {"BVH2 node 1: a leaf beyond the triangles", [](Scene& s) { s.accel.bvh2_nodes[1].child1 = IR_LEAF; }},
        {"BVH2 node 0: a leaf beyond the analytic",
         [](Scene& s) { s.accel.bvh2_nodes[0].child1 = IR_LEAF | IR_LEAF_ANALYTIC | 2u << 24; }},
        {"packed triangle 1: triangle 2", [](Scene& s) { s.accel.bvh2_triangles[1].primitive = 2; }},
        {"packed triangle 1: a number", [](Scene& s) { s.accel.bvh2_triangles[1].v1y = kNan; }},
    });
}

// Chains as deep as the traversals' stacks allow, and one deeper.
TEST(CheckScene, Depth) {
    for (const bool deeper : {false, true}) {
        Scene s = small_scene();
        auto& nodes = s.accel.bvh8_nodes;
        auto last = nodes[1];
        nodes.resize(1);
        const std::uint32_t depth8 = IR_BVH8_MAX_DEPTH + (deeper ? 1 : 0);
        for (std::uint32_t i = 1; i < depth8; ++i) {
            nodes.push_back(last);
            nodes[i - 1].child[0] = i;
        }
        EXPECT_EQ(has(error_of([&] { check_scene("file", s); }), "BVH8 node 24: deeper than 24 nodes"), deeper);
        Scene t = small_scene();
        const auto end = t.accel.bvh2_nodes[1];
        t.accel.bvh2_nodes.resize(1);
        const std::uint32_t depth2 = IR_BVH2_MAX_DEPTH + (deeper ? 1 : 0);
        for (std::uint32_t i = 1; i < depth2; ++i) {
            t.accel.bvh2_nodes.push_back(end);
            t.accel.bvh2_nodes[i - 1].child0 = i;
        }
        const std::string message = error_of([&] { check_scene("file", t); });
        EXPECT_EQ(has(message, "BVH2 node 64: deeper than 64 nodes"), deeper) << message;
        EXPECT_EQ(message.empty(), !deeper) << message;
    }
}

}  // namespace
