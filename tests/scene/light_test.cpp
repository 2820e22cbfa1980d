#include <numbers>

#include "scene_test.h"

namespace irradia::test {
namespace {

constexpr double pi = std::numbers::pi;

class Light : public SceneTest {};

TEST_F(Light, RectangleIsOneQuadSharedByBothTriangles) {
    const Scene s =
        load(sensor +
             R"(<shape type="rectangle"><transform name="to_world"><scale x="2" y="3"/><translate z="1"/></transform>
        <emitter type="area"><rgb name="radiance" value="1, 2, 3"/></emitter></shape>)");
    ASSERT_EQ(s.lights.size(), 1u);
    const auto& l = s.lights[0];
    EXPECT_EQ(l.kind, IR_LIGHT_QUAD);
    EXPECT_FLOAT_EQ(l.area, 24.0f);
    EXPECT_FLOAT_EQ(l.px, -2.0f);
    EXPECT_FLOAT_EQ(l.py, -3.0f);
    expect_near({l.e1x, l.e1y, l.e1z}, {4, 0, 0}, 0.0);
    expect_near({l.e2x, l.e2y, l.e2z}, {0, 6, 0}, 0.0);
    expect_near({l.nx, l.ny, l.nz}, {0, 0, 1}, 0.0);
    expect_near({l.r, l.g, l.b}, {1, 2, 3}, 0.0);
    EXPECT_EQ(l.probability, 1.0f);
    EXPECT_EQ(l.cdf, 1.0f);
    EXPECT_EQ(s.triangles[0].light, 0);
    EXPECT_EQ(s.triangles[1].light, 0);
}

// Halves of a rectangle that follow each other are one light, as the rectangle shape's are.
TEST_F(Light, CubeIsSixQuads) {
    for (const char* flip : {"false", "true"}) {
        const Scene s = load(sensor + R"(<shape type="cube"><boolean name="flip_normals" value=")" + flip +
                             R"("/><emitter type="area"/></shape>)");
        const float side = std::string(flip) == "true" ? -1.0f : 1.0f;
        ASSERT_EQ(s.lights.size(), 6u);
        for (std::size_t i = 0; i < 6; ++i) {
            const auto& l = s.lights[i];
            EXPECT_EQ(l.kind, IR_LIGHT_QUAD);
            EXPECT_FLOAT_EQ(l.area, 4.0f);
            EXPECT_EQ(s.triangles[2 * i].light, static_cast<int>(i));
            EXPECT_EQ(s.triangles[2 * i + 1].light, static_cast<int>(i));
            EXPECT_FLOAT_EQ(side, l.nx * (l.px + (l.e1x + l.e2x) / 2) + l.ny * (l.py + (l.e1y + l.e2y) / 2) +
                                      l.nz * (l.pz + (l.e1z + l.e2z) / 2));
            EXPECT_FLOAT_EQ(l.probability, 1.0f / 6.0f);
        }
    }
}

// Neither a sheared rectangle nor the faces of a tetrahedron have a right-angled partner.
TEST_F(Light, OtherTrianglesStayTriangles) {
    const Scene s = load(sensor + R"(<shape type="rectangle"><transform name="to_world">
        <matrix value="1 0.5 0 0  0 1 0 0  0 0 1 0  0 0 0 1"/></transform><emitter type="area"/></shape>)");
    ASSERT_EQ(s.lights.size(), 2u);
    for (std::size_t i = 0; i < 2; ++i) {
        EXPECT_EQ(s.lights[i].kind, IR_LIGHT_TRIANGLE);
        EXPECT_FLOAT_EQ(s.lights[i].area, 2.0f);
        EXPECT_EQ(s.triangles[i].light, static_cast<int>(i));
    }
}

TEST_F(Light, SelectedInProportionToPower) {
    // Power by Rec. 709 luminance: area L A pi, point 4 pi I, directional E pi r^2, constant 4 pi^2 r^2 L; r = half the
    // diagonal of the bounding box, which here is that of the unit rectangle: sqrt(8) / 2.
    const Scene s = load(sensor + R"(
        <shape type="rectangle"><emitter type="area"><rgb name="radiance" value="2"/></emitter></shape>
        <emitter type="point"><point name="position" x="0" y="0" z="0.5"/><rgb name="intensity" value="0, 3, 0"/></emitter>
        <emitter type="directional"><vector name="direction" x="0" y="0" z="-2"/><rgb name="irradiance" value="5"/></emitter>
        <emitter type="constant"><rgb name="radiance" value="0.5"/></emitter>)");
    ASSERT_EQ(s.lights.size(), 4u);
    const double r2 = 2.0;
    const double power[] = {2.0 * 4.0 * pi, 0.7152 * 3.0 * 4.0 * pi, 5.0 * pi * r2, 0.5 * 4.0 * pi * pi * r2};
    const double sum = power[0] + power[1] + power[2] + power[3];
    double running = 0.0;
    for (std::size_t i = 0; i < 4; ++i) {
        running += power[i] / sum;
        EXPECT_NEAR(s.lights[i].probability, power[i] / sum, 1e-7);
        EXPECT_NEAR(s.lights[i].cdf, running, 1e-7);
    }
    EXPECT_EQ(s.lights[3].cdf, 1.0f);
    EXPECT_EQ(s.lights[1].kind, IR_LIGHT_POINT);
    EXPECT_FLOAT_EQ(s.lights[1].pz, 0.5f);
    expect_near({s.lights[2].nx, s.lights[2].ny, s.lights[2].nz}, {0, 0, -1}, 0.0);
    EXPECT_EQ(s.info.environment_light, 3);
    EXPECT_EQ(s.features, IR_FEATURE_ENVIRONMENT | IR_FEATURE_DELTA_LIGHTS);
    EXPECT_EQ(s.info.light_count, 4u);
}

TEST_F(Light, DirectionalByTransformAndPointByTransform) {
    const Scene s = load(sensor + lamp + R"(
        <emitter type="directional"><transform name="to_world"><rotate x="1" angle="90"/></transform></emitter>
        <emitter type="point"><transform name="to_world"><translate x="1" y="2" z="3"/></transform></emitter>)");
    expect_near({s.lights[1].nx, s.lights[1].ny, s.lights[1].nz}, {0, -1, 0}, 1e-7);  // +z turned about x
    expect_near({s.lights[2].px, s.lights[2].py, s.lights[2].pz}, {1, 2, 3}, 1e-7);
}

TEST_F(Light, FlatSpectrumIsEqualEnergyWhite) {
    // Mitsuba 3.9.1: area emitter with <spectrum value="3"/> evaluates to (3.61438, 2.84487, 2.72675), <float
    // value="3"/> to 3
    const auto radiance = [&](const std::string& value) {
        const Scene s =
            load(sensor + "<shape type=\"rectangle\"><emitter type=\"area\">" + value + "</emitter></shape>");
        return Vec{s.lights[0].r, s.lights[0].g, s.lights[0].b};
    };
    expect_near(radiance(R"(<spectrum name="radiance" value="3"/>)"), {3.61438, 2.84487, 2.72675}, 5e-4);
    expect_near(radiance(R"(<float name="radiance" value="3"/>)"), {3, 3, 3}, 0.0);
    expect_near(radiance(R"(<rgb name="radiance" value="3"/>)"), {3, 3, 3}, 0.0);
}

TEST_F(Light, SphereAndDisk) {
    const Scene s = load(sensor + R"(
        <shape type="sphere"><float name="radius" value="2"/><boolean name="flip_normals" value="true"/><emitter type="area"/></shape>
        <shape type="disk"><emitter type="area"/></shape>)");
    EXPECT_EQ(s.lights[0].kind, IR_LIGHT_SPHERE);
    EXPECT_FLOAT_EQ(s.lights[0].radius, 2.0f);
    EXPECT_FLOAT_EQ(s.lights[0].nx, -1.0f);  // emits inward
    EXPECT_EQ(s.analytics[0].light, 0);
    EXPECT_EQ(s.lights[1].kind, IR_LIGHT_DISK);
    EXPECT_FLOAT_EQ(s.lights[1].area, static_cast<float>(pi));
    expect_near({s.lights[1].e2x, s.lights[1].e2y, s.lights[1].e2z}, {0, 1, 0}, 0.0);
    EXPECT_EQ(s.analytics[1].light, 1);
    EXPECT_EQ(s.features, IR_FEATURE_ANALYTIC);
}

TEST_F(Light, BlackEmittersAreNoLights) {
    const Scene s = load(
        sensor + lamp +
        R"(<shape type="rectangle" id="dark"><emitter type="area"><rgb name="radiance" value="0"/></emitter></shape>)");
    EXPECT_EQ(s.lights.size(), 1u);
    EXPECT_EQ(s.triangles[2].light, IR_NO_LIGHT);
    ASSERT_EQ(warnings_.size(), 1u);
    expect_message(warnings_[0], {"dark", "black"});
}

}  // namespace
}  // namespace irradia::test
