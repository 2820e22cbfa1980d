// Conventions of the built-in shapes. Numbers marked "Mitsuba" are what Mitsuba 3.9.1 (scalar_rgb) gives for the same
// shape.
#include <mutex>
#include <numbers>
#include <set>
#include <thread>

#include "scene_test.h"

namespace irradia::test {
namespace {

class Shape : public SceneTest {
protected:
    Scene shape(const std::string& type, const std::string& inside) {
        return load(sensor + "<shape type=\"" + type + "\">" + inside + "<emitter type=\"area\"/></shape>");
    }
};
std::string to_world(const std::string& operations) {
    return "<transform name=\"to_world\">" + operations + "</transform>";
}

TEST_F(Shape, RectangleFacesPlusZWithUnitUv) {
    const Scene s = shape("rectangle", "");
    ASSERT_EQ(s.triangles.size(), 2u);
    for (const auto& t : s.triangles) {
        expect_near(normal(t), {0, 0, 1}, 0.0);
        expect_near(winding(s, t), {0, 0, 1}, 1e-7);
        EXPECT_EQ(t.flags, IR_TRIANGLE_FLAT | IR_TRIANGLE_HAS_UV);
        for (const auto v : {t.v0, t.v1, t.v2}) {  // uv = (p + 1) / 2, Mitsuba: (.3, .2) -> (.65, .6)
            EXPECT_FLOAT_EQ(s.vertices[v].u, static_cast<float>(0.5 * (position(s, v)[0] + 1.0)));
            EXPECT_FLOAT_EQ(s.vertices[v].v, static_cast<float>(0.5 * (position(s, v)[1] + 1.0)));
        }
    }
}

TEST_F(Shape, RectangleNormalFollowsMitsubasFrame) {
    // Mitsuba's shading frame: to_world mirrored in x keeps +z, mirrored in z turns it, flip_normals turns it.
    expect_near(normal(shape("rectangle", to_world("<scale x=\"-1\"/>")).triangles[0]), {0, 0, 1}, 1e-7);
    expect_near(normal(shape("rectangle", to_world("<scale z=\"-1\"/>")).triangles[0]), {0, 0, -1}, 1e-7);
    expect_near(normal(shape("rectangle", "<boolean name=\"flip_normals\" value=\"true\"/>").triangles[0]), {0, 0, -1},
                1e-7);
    // Mitsuba, with (1,2,3) / sqrt(14) as the axis: normal (0.788048, -0.0715812, 0.611438), area 11.99067497
    const Scene s = shape(
        "rectangle",
        to_world(R"(<rotate x="1" y="2" z="3" angle="40"/><scale x="1" y="2" z="3"/><translate x="1" y="2" z="3"/>)"));
    expect_near(normal(s.triangles[0]), {0.788048, -0.0715812, 0.611438}, 2e-6);
    ASSERT_EQ(s.lights.size(), 2u);  // scaling after the rotation has sheared it: two triangles
    EXPECT_NEAR(s.lights[0].area + s.lights[1].area, 11.99067497, 1e-5);
    ASSERT_EQ(warnings_.size(), 1u);
    expect_message(warnings_[0], {"<rotate>", "not of unit length"});
}

TEST_F(Shape, CubeHasOutwardFacesAndMitsubasUv) {
    const Scene s = shape("cube", "");
    ASSERT_EQ(s.triangles.size(), 12u);
    double area = 0.0;
    for (const auto& t : s.triangles) {
        const Vec n = normal(t), p = position(s, t.v0);
        EXPECT_NEAR(dot(n, p), 1.0, 1e-7);  // outward: each face lies in the plane n . p = 1
        expect_near(winding(s, t), n, 1e-7);
        EXPECT_EQ(t.flags, IR_TRIANGLE_FLAT | IR_TRIANGLE_HAS_UV);
        area += 0.5 * length(cross(position(s, t.v1) - p, position(s, t.v2) - p));
        for (const auto v : {t.v0, t.v1, t.v2}) {
            const Vec q = position(s, v);
            // Mitsuba on the top face: (.3, .2, 1) has uv (.6, .65), i.e. u = (y + 1) / 2, v = (x + 1) / 2
            if (n[2] > 0.5) {
                EXPECT_FLOAT_EQ(s.vertices[v].u, static_cast<float>(0.5 * (q[1] + 1.0)));
                EXPECT_FLOAT_EQ(s.vertices[v].v, static_cast<float>(0.5 * (q[0] + 1.0)));
            }
        }
    }
    EXPECT_NEAR(area, 24.0, 1e-6);
}

TEST_F(Shape, MirroredCubeStillFacesOutward) {
    // Mitsuba: shading normal (0, 0, 1) on top of a cube mirrored in x, (0, 0, -1) with flip_normals
    for (const auto& t : shape("cube", to_world("<scale x=\"-1\"/>")).triangles)
        EXPECT_EQ(t.flags & IR_TRIANGLE_FLAT, IR_TRIANGLE_FLAT);
    const Scene s = shape("cube", to_world("<scale x=\"-1\"/>"));
    for (const auto& t : s.triangles) EXPECT_NEAR(dot(normal(t), position(s, t.v0)), 1.0, 1e-7);
    const Scene f = shape("cube", "<boolean name=\"flip_normals\" value=\"true\"/>" + to_world("<scale x=\"-1\"/>"));
    for (const auto& t : f.triangles) EXPECT_NEAR(dot(normal(t), position(f, t.v0)), -1.0, 1e-7);
}

TEST_F(Shape, TransformsComposeFirstToLast) {
    // rotate 90 degrees about z takes x to y, then translate, then scale: (1,-1,0) -> (1,1,0) -> (2,1,0) -> (4,2,0)
    const Scene s = shape("rectangle", to_world(R"(<rotate z="1" angle="90"/><translate x="1"/><scale value="2"/>)"));
    expect_near(position(s, s.triangles[0].v1), {4, 2, 0}, 1e-6);
    // a matrix is applied like any other operation; 9 numbers are its linear part
    const Scene m = shape("rectangle", to_world(R"(<translate x="1"/><matrix value="0 -1 0  1 0 0  0 0 1"/>)"));
    expect_near(position(m, m.triangles[0].v1), {1, 2, 0}, 1e-6);  // (1,-1,0) -> (2,-1,0) -> (1,2,0)
    const Scene n = shape("rectangle", to_world(R"(<matrix value="1 0 0 5, 0 1 0 6, 0 0 1 7, 0 0 0 1"/>)"));
    expect_near(position(n, n.triangles[0].v1), {6, 5, 7}, 1e-6);
}

TEST_F(Shape, SphereTakesCentreRadiusAndUniformScale) {
    // Mitsuba: bounding box (-3, -5, -6) to (9, 7, 6)
    const Scene s = shape("sphere", R"(<point name="center" x="1" y="0" z="0"/><float name="radius" value="2"/>)" +
                                        to_world(R"(<scale value="3"/><translate y="1"/>)"));
    ASSERT_EQ(s.analytics.size(), 1u);
    const auto& a = s.analytics[0];
    EXPECT_EQ(a.kind, IR_ANALYTIC_SPHERE);
    EXPECT_FLOAT_EQ(a.radius, 6.0f);
    EXPECT_FLOAT_EQ(a.sign, 1.0f);
    expect_near({a.px + s.centre[0], a.py + s.centre[1], a.pz + s.centre[2]}, {3, 1, 0}, 1e-6);
    EXPECT_NEAR(s.info.min_x + s.centre[0], -3.0, 1e-6);
    EXPECT_NEAR(s.info.max_y + s.centre[1], 7.0, 1e-6);
    EXPECT_NEAR(s.lights[0].area, 4.0 * std::numbers::pi * 36.0, 1e-4);
}

TEST_F(Shape, SphereFrameRotatesAndFlips) {
    const Scene s = shape("sphere", to_world("<rotate y=\"1\" angle=\"90\"/>"));  // x -> -z, z -> x
    expect_near({s.analytics[0].ux, s.analytics[0].uy, s.analytics[0].uz}, {0, 0, -1}, 1e-6);
    expect_near({s.analytics[0].vx, s.analytics[0].vy, s.analytics[0].vz}, {1, 0, 0}, 1e-6);
    EXPECT_FLOAT_EQ(shape("sphere", "<boolean name=\"flip_normals\" value=\"true\"/>").analytics[0].sign, -1.0f);
    // Mitsuba: a mirrored to_world turns a sphere's normals inward, flip_normals turns them back
    EXPECT_FLOAT_EQ(shape("sphere", to_world("<scale x=\"-1\"/>")).analytics[0].sign, -1.0f);
    EXPECT_FLOAT_EQ(shape("sphere", "<boolean name=\"flip_normals\" value=\"true\"/>" + to_world("<scale x=\"-1\"/>"))
                        .analytics[0]
                        .sign,
                    1.0f);
}

TEST_F(Shape, DiskKeepsItsEllipse) {
    const Scene s = shape("disk", to_world(R"(<scale x="2" y="3"/><translate z="5"/>)"));
    const auto& a = s.analytics[0];
    EXPECT_EQ(a.kind, IR_ANALYTIC_DISK);
    // half axes (2,0,0) and (0,3,0), stored divided by their squared lengths
    expect_near({a.ux, a.uy, a.uz}, {0.5, 0, 0}, 1e-7);
    expect_near({a.vx, a.vy, a.vz}, {0, 1.0 / 3.0, 0}, 1e-7);
    expect_near({a.nx, a.ny, a.nz}, {0, 0, 1}, 0.0);
    EXPECT_NEAR(s.lights[0].area, 6.0 * std::numbers::pi, 1e-5);
    EXPECT_FLOAT_EQ(s.info.max_y, 3.0f);
    EXPECT_FLOAT_EQ(s.info.max_x, 2.0f);
    EXPECT_FLOAT_EQ(s.info.max_z, 0.0f);
    expect_near({shape("disk", to_world("<scale z=\"-1\"/>")).analytics[0].nx, 0,
                 shape("disk", to_world("<scale z=\"-1\"/>")).analytics[0].nz},
                {0, 0, -1}, 1e-7);  // Mitsuba: the same
}

// Numbers of whole cylinders against Mitsuba's: device_shapes_test.cpp.
TEST_F(Shape, CylinderTakesEndsRadiusAndScaleAlongItsAxis) {
    const Scene s = shape("cylinder", R"(<point name="p0" x="1" y="0" z="0"/><point name="p1" x="1" y="0" z="2"/>
        <float name="radius" value=".5"/>)" +
                                          to_world(R"(<scale x="2" y="2" z="3"/><translate y="1"/>)"));
    ASSERT_EQ(s.analytics.size(), 1u);
    const auto& a = s.analytics[0];
    EXPECT_EQ(a.kind, IR_ANALYTIC_CYLINDER);
    EXPECT_FLOAT_EQ(a.radius, 1.0f);
    EXPECT_FLOAT_EQ(a.length, 6.0f);
    expect_near({a.nx, a.ny, a.nz}, {0, 0, 1}, 1e-7);
    expect_near({a.px + s.centre[0], a.py + s.centre[1], a.pz + s.centre[2]}, {2, 1, 0}, 1e-6);
    ASSERT_EQ(s.lights.size(), 1u);
    EXPECT_EQ(s.lights[0].kind, IR_LIGHT_CYLINDER);
    expect_near({s.lights[0].e1x, s.lights[0].e1y, s.lights[0].e1z}, {0, 0, 6}, 1e-6);
    EXPECT_FLOAT_EQ(s.lights[0].radius, 1.0f);
    EXPECT_NEAR(s.lights[0].area, 12 * std::numbers::pi, 1e-5);
}

TEST_F(Shape, CylindersThatAreNoneAreRefused) {
    const auto refused = [&](const std::string& inside) { return error_of([&] { shape("cylinder", inside); }); };
    expect_message(refused("<float name=\"radius\" value=\"0\"/>"), {"radius is 0", "positive"});
    expect_message(refused("<point name=\"p1\" value=\"0, 0, 0\"/>"), {"p0 and p1 are the same point"});
    expect_message(refused(to_world("<scale x=\"2\"/>")), {"elliptical"});
    expect_message(refused(to_world("<matrix value=\"1 0 .5  0 1 0  0 0 1\"/>")), {"shears"});
    EXPECT_NO_THROW(shape("cylinder", to_world("<scale z=\"2\"/>")));
}

TEST_F(Shape, TiltedDiskBoundsAreTight) {
    // A unit disk tilted by 45 degrees about x reaches 1 in x and sqrt(1/2) in y and z.
    const Scene s = shape("disk", to_world("<rotate x=\"1\" angle=\"45\"/>"));
    EXPECT_NEAR(s.info.max_x, 1.0, 1e-6);
    EXPECT_NEAR(s.info.max_y, std::sqrt(0.5), 1e-6);
    EXPECT_NEAR(s.info.max_z, std::sqrt(0.5), 1e-6);
}

TEST_F(Shape, CentreIsSubtractedInDouble) {
    // Two unit squares a millimetre apart, 1e7 units from the origin: float32 there has a spacing of 1 unit.
    const Scene s = load(sensor + R"(
        <shape type="rectangle"><transform name="to_world"><translate x="10000000" y="0.001"/></transform><emitter type="area"/></shape>
        <shape type="rectangle"><transform name="to_world"><translate x="10000000"/></transform></shape>)");
    EXPECT_NEAR(s.centre[0], 1e7, 1e-6);
    EXPECT_NEAR(s.centre[1], 0.0005, 1e-12);
    EXPECT_NEAR(s.vertices[0].py - s.vertices[4].py, 0.001, 1e-7);
    EXPECT_FLOAT_EQ(s.vertices[0].px, -1.0f);
    EXPECT_NEAR(s.info.diagonal, std::sqrt(4.0 + 2.001 * 2.001), 1e-6);
}

TEST_F(Shape, InstancesAreFlattened) {
    const Scene s = load(sensor + lamp + R"(
        <shape type="shapegroup" id="group"><shape type="rectangle"><transform name="to_world"><translate z="1"/></transform></shape></shape>
        <shape type="instance"><ref id="group"/><transform name="to_world"><scale value="2"/></transform></shape>
        <shape type="instance"><ref id="group"/><transform name="to_world"><translate x="5"/></transform></shape>)");
    ASSERT_EQ(s.triangles.size(), 6u);  // the lamp and two instances; the group itself is not drawn
    expect_near(position(s, s.triangles[2].v0), {-2, -2, 2}, 1e-6);
    expect_near(position(s, s.triangles[4].v0), {4, -1, 1}, 1e-6);
}

// Shapes are loaded in parallel, but not by more threads than asked for.
TEST_F(Shape, OneThreadLoadsAllIfAskedTo) {
    std::string shapes = sensor + "<shape type=\"cube\"><emitter type=\"area\"/></shape>";
    for (int i = 0; i < 64; ++i) shapes += "<shape type=\"cube\"/>\n";
    LoadOptions options;
    options.threads = 1;
    std::mutex mutex;
    std::set<std::thread::id> threads;
    std::size_t told = 0;
    options.progress = [&](const std::string& stage, double) {
        const std::lock_guard lock(mutex);
        threads.insert(std::this_thread::get_id());
        told += stage == "meshes";
    };
    EXPECT_EQ(load(shapes, options).triangles.size(), 65u * 12u);
    EXPECT_GE(told, 65u);
    EXPECT_EQ(threads, std::set{std::this_thread::get_id()});
}

}  // namespace
}  // namespace irradia::test
