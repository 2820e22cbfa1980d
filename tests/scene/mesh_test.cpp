// PLY and OBJ. Vertex normals marked "Mitsuba" are mesh.vertex_normals() of Mitsuba 3.9.1 for the same file.
#include <algorithm>
#include <bit>
#include <cstring>

#include "scene_test.h"

namespace irradia::test {
namespace {

class Mesh : public SceneTest {
protected:
    Scene mesh(const std::string& type, const std::string& file, const std::string& extra = "") {
        return load(sensor + lamp + "<shape type=\"" + type + "\"><string name=\"filename\" value=\"" + file + "\"/>" +
                    extra + "</shape>");
    }
    /// The first vertex of the mesh (the lamp has 4).
    static constexpr std::uint32_t first = 4;
};
const std::string flat = R"(<boolean name="face_normals" value="true"/>)";
const std::string mirror = R"(<transform name="to_world"><scale x="-1" y="2" z="1"/></transform>)";
const std::string flip = R"(<boolean name="flip_normals" value="true"/>)";

template <class T>
void append(std::string& out, T value, bool big) {
    char bytes[sizeof(T)];
    std::memcpy(bytes, &value, sizeof(T));
    if (big == (std::endian::native == std::endian::little)) std::reverse(bytes, bytes + sizeof(T));
    out.append(bytes, sizeof(T));
}

/// The tetrahedron of scene_test.h in binary, with properties in between that have to be skipped.
std::string binary_tetrahedron(bool big) {
    std::string out =
        std::string("ply\nformat binary_") + (big ? "big" : "little") +
        "_endian 1.0\ncomment made by a test\nelement vertex 4\nproperty double x\nproperty uchar red\nproperty float "
        "y\n"
        "property float z\nelement note 1\nproperty list uchar short numbers\nelement face 4\nproperty uchar flag\n"
        "property list uchar uint vertex_index\nproperty float weight\nend_header\n";
    const double p[4][3] = {{0, 0, 0}, {2, 0, 0}, {0, 1, 0}, {0, 0, 1.5}};
    for (const auto& v : p) {
        append(out, v[0], big);
        append(out, std::uint8_t{200}, big);
        append(out, static_cast<float>(v[1]), big);
        append(out, static_cast<float>(v[2]), big);
    }
    append(out, std::uint8_t{2}, big);
    append(out, std::int16_t{-5}, big);
    append(out, std::int16_t{300}, big);
    const std::uint32_t f[4][3] = {{0, 2, 1}, {0, 1, 3}, {0, 3, 2}, {1, 2, 3}};
    for (const auto& t : f) {
        append(out, std::uint8_t{1}, big);
        append(out, std::uint8_t{3}, big);
        for (const auto i : t) append(out, i, big);
        append(out, 0.5f, big);
    }
    return out;
}

TEST_F(Mesh, AsciiAndBinaryPlyAgree) {
    write("a.ply", tetrahedron);
    write("l.ply", binary_tetrahedron(false));
    write("b.ply", binary_tetrahedron(true));
    const Scene a = mesh("ply", "a.ply");
    ASSERT_EQ(a.triangles.size(), 6u);
    expect_near(position(a, first + 3), {0, 0, 1.5}, 1e-6);
    for (const char* file : {"l.ply", "b.ply"}) {
        const Scene s = mesh("ply", file);
        ASSERT_EQ(s.vertices.size(), a.vertices.size());
        EXPECT_EQ(std::memcmp(s.vertices.data(), a.vertices.data(), a.vertices.size() * sizeof(shared::Vertex)), 0)
            << file;
        ASSERT_EQ(s.triangles.size(), a.triangles.size());
        EXPECT_EQ(std::memcmp(s.triangles.data(), a.triangles.data(), a.triangles.size() * sizeof(shared::Triangle)), 0)
            << file;
    }
}

TEST_F(Mesh, MissingNormalsAreComputedAsMitsubaDoes) {
    write("a.ply", tetrahedron);
    const Scene s = mesh("ply", "a.ply");
    expect_near(vertex_normal(s, first + 0), {-0.57735002, -0.57735002, -0.57735002}, 1e-5);
    expect_near(vertex_normal(s, first + 1), {0.96254998, -0.15994000, -0.21889000}, 1e-5);
    expect_near(vertex_normal(s, first + 2), {-0.39636001, 0.84494001, -0.35914001}, 1e-5);
    expect_near(vertex_normal(s, first + 3), {-0.31920999, -0.21025001, 0.92407000}, 1e-5);
    EXPECT_EQ(s.features, IR_FEATURE_SMOOTH_NORMALS);
    EXPECT_EQ(s.triangles[2].flags, 0u);
    // scaled and mirrored: computed in world space, on the side to which the corners turn
    const Scene m = mesh("ply", "a.ply", mirror);
    expect_near(vertex_normal(m, first + 1), {0.93563998, 0.27138001, 0.22566000}, 1e-5);
    expect_near(normal(m.triangles[5]), {0.51450002, -0.51450002, -0.68599999}, 1e-5);
    const Scene f = mesh("ply", "a.ply", flip);
    expect_near(vertex_normal(f, first + 1), {-0.96254998, 0.15994000, 0.21889000}, 1e-5);
    expect_near(normal(f.triangles[5]), {-0.3840999, -0.76819998, -0.51209998}, 1e-4);
}

TEST_F(Mesh, FaceNormalsAreFlat) {
    write("a.ply", tetrahedron);
    const Scene s = mesh("ply", "a.ply", flat);
    for (std::size_t i = 2; i < 6; ++i) {
        EXPECT_EQ(s.triangles[i].flags, IR_TRIANGLE_FLAT);
        expect_near(normal(s.triangles[i]), winding(s, s.triangles[i]), 1e-6);
    }
    EXPECT_EQ(s.features, 0u);
    expect_near(normal(mesh("ply", "a.ply", flat + flip).triangles[5]), {-0.3840999, -0.76819998, -0.51209998}, 1e-4);
    expect_near(normal(mesh("ply", "a.ply", flat + mirror).triangles[5]), {0.51450002, -0.51450002, -0.68599999}, 1e-5);
}

const std::string obj = R"(# the same tetrahedron, texture coordinates on three faces only
v 0 0 0
v 2 0 0
v 0 1 0
v 0 0 1.5
vt 0.1 0.2
vt 0.9 0.2
vt 0.1 0.7
f 1/1 3/3 2/2
f 1/1 2/2 4/3
f 1/1 4/3 3/2
f 2 3 4
)";

TEST_F(Mesh, ObjVerticesSplitAsInMitsuba) {
    write("a.obj", obj);
    const Scene s = mesh("obj", "a.obj");
    ASSERT_EQ(s.vertices.size(), 4u + 8u);  // Mitsuba: 8 vertices
    const Vec expected[8] = {{-0.57735, -0.57735, -0.57735},
                             {0, 0, -1},
                             {0, -0.81134, -0.58458},
                             {-0.53552, -0.84452, 0},
                             {-1, 0, 0},
                             {0.38411, 0.76822, 0.51215},
                             {0.38411, 0.76822, 0.51215},
                             {0.38411, 0.76822, 0.51215}};
    const double uv[5][2] = {
        {0.1, 0.8}, {0.1, 0.3}, {0.9, 0.8}, {0.1, 0.3}, {0.9, 0.8}};  // v turned over: flip_tex_coords
    for (std::uint32_t i = 0; i < 8; ++i) expect_near(vertex_normal(s, first + i), expected[i], 1e-5);
    for (std::uint32_t i = 0; i < 5; ++i) {
        EXPECT_NEAR(s.vertices[first + i].u, uv[i][0], 1e-6);
        EXPECT_NEAR(s.vertices[first + i].v, uv[i][1], 1e-6);
    }
    EXPECT_EQ(s.triangles[5].flags & IR_TRIANGLE_FLAT, IR_TRIANGLE_FLAT);  // its three normals are the face's
    EXPECT_EQ(s.triangles[2].flags & IR_TRIANGLE_FLAT, 0u);
    const Scene kept = mesh("obj", "a.obj", R"(<boolean name="flip_tex_coords" value="false"/>)");
    EXPECT_NEAR(kept.vertices[first].v, 0.2, 1e-6);
}

TEST_F(Mesh, PlyTextureCoordinatesStand) {
    write("uv.ply", R"(ply
format ascii 1.0
element vertex 3
property float x
property float y
property float z
property float nx
property float ny
property float nz
property float s
property float t
element face 1
property list uchar int vertex_indices
end_header
0 0 0  0 0 2  0 0.25
1 0 0  0 0 2  1 0.25
0 1 0  0 0 2  0 0.75
3 0 1 2
)");
    const Scene s = mesh("ply", "uv.ply");
    EXPECT_FLOAT_EQ(s.vertices[first].v, 0.25f);
    EXPECT_EQ(s.triangles[2].flags, IR_TRIANGLE_FLAT | IR_TRIANGLE_HAS_UV);
    expect_near(vertex_normal(s, first), {0, 0, 1}, 0.0);
    EXPECT_FLOAT_EQ(mesh("ply", "uv.ply", R"(<boolean name="flip_tex_coords" value="true"/>)").vertices[first].v,
                    0.75f);
}

TEST_F(Mesh, FrontFollowsTheVertexNormals) {
    // Corners run clockwise seen from +z, the normals say +z: Mitsuba's frames and emitters follow the normals.
    write("a.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nvn 0 0 1\nf 1//1 3//1 2//1\n");
    const Scene s = mesh("obj", "a.obj");
    expect_near(normal(s.triangles[2]), {0, 0, 1}, 1e-7);
    expect_near(winding(s, s.triangles[2]), {0, 0, -1}, 1e-7);
    EXPECT_EQ(s.triangles[2].flags, IR_TRIANGLE_FLAT);
    expect_near(normal(mesh("obj", "a.obj", flat).triangles[2]), {0, 0, -1}, 1e-7);  // without them the corners decide
}

TEST_F(Mesh, PolygonsAreFansAndNegativeIndicesCount) {
    write("a.obj", "v 0 0 0\nv 2 0 0\nv 3 1 0\nv 1 2 0\nv -1 1 0\nf -5 -4 -3 -2 -1\n");
    const Scene s = mesh("obj", "a.obj");
    ASSERT_EQ(s.triangles.size(), 5u);
    double area = 0.0;
    for (std::size_t i = 2; i < 5; ++i) {
        const auto& t = s.triangles[i];
        EXPECT_EQ(t.v0, first);
        area += 0.5 * length(cross(position(s, t.v1) - position(s, t.v0), position(s, t.v2) - position(s, t.v0)));
    }
    EXPECT_NEAR(area, 5.0, 1e-6);  // shoelace formula
}

TEST_F(Mesh, BackToBackFacesAreFlat) {
    // Two coincident triangles that share their vertices and face opposite ways: the vertex normals cancel.
    write("a.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\nf 1 3 2\n");
    const Scene s = mesh("obj", "a.obj");
    ASSERT_EQ(s.triangles.size(), 4u);
    EXPECT_EQ(s.triangles[2].flags, IR_TRIANGLE_FLAT);
    EXPECT_EQ(s.triangles[3].flags, IR_TRIANGLE_FLAT);
    expect_near(normal(s.triangles[2]), {0, 0, 1}, 0.0);
    expect_near(normal(s.triangles[3]), {0, 0, -1}, 0.0);
}

TEST_F(Mesh, DegenerateTrianglesAreDroppedAndCounted) {
    write("a.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 2 0 0\nf 1 2 3\nf 1 2 4\nf 1 1 3\n");
    const Scene s = mesh("obj", "a.obj");
    EXPECT_EQ(s.triangles.size(), 3u);
    ASSERT_EQ(warnings_.size(), 1u);
    expect_message(warnings_[0], {"scene.xml:2:", "a.obj", "2 degenerate triangles dropped"});
    for (const auto& v : s.vertices) EXPECT_TRUE(std::isfinite(v.nx) && std::isfinite(v.ny) && std::isfinite(v.nz));
}

TEST_F(Mesh, EmittingMeshIsALightATriangle) {
    write("a.ply", tetrahedron);
    const Scene s =
        load(sensor + R"(<shape type="ply"><string name="filename" value="a.ply"/><emitter type="area"/></shape>)");
    ASSERT_EQ(s.lights.size(), 4u);
    // areas: 1 (2 x 1 / 2), 1.5, 0.75, and the slanted face: |(-2,1,0) x (-2,0,1.5)| / 2
    const double slanted = 0.5 * length(cross({-2, 1, 0}, {-2, 0, 1.5}));
    const double area[] = {1.0, 1.5, 0.75, slanted}, sum = 3.25 + slanted;
    for (std::size_t i = 0; i < 4; ++i) {
        EXPECT_NEAR(s.lights[i].area, area[i], 1e-6);
        EXPECT_NEAR(s.lights[i].probability, area[i] / sum, 1e-6);
        expect_near({s.lights[i].nx, s.lights[i].ny, s.lights[i].nz}, normal(s.triangles[i]), 0.0);
    }
}

TEST_F(Mesh, ManyMeshesLoadTheSameEveryTime) {
    std::string body = sensor + lamp;
    for (int i = 0; i < 40; ++i) {
        std::string text = tetrahedron;
        text.replace(text.find("2 0 0"), 1, std::to_string(2 + i));
        write("m" + std::to_string(i) + ".ply", text);
        body += "<shape type=\"ply\"><string name=\"filename\" value=\"m" + std::to_string(i) + ".ply\"/></shape>";
    }
    const Scene a = load(body), b = load(body);
    ASSERT_EQ(a.vertices.size(), 4u + 160u);
    EXPECT_EQ(std::memcmp(a.vertices.data(), b.vertices.data(), a.vertices.size() * sizeof(shared::Vertex)), 0);
    for (std::uint32_t i = 0; i < 40; ++i)
        EXPECT_NEAR(position(a, first + 4 * i + 1)[0], 2.0 + i, 1e-5);  // in file order
}

// ---- bad files --------------------------------------------------------------------------------------------------
class BadMesh : public Mesh {
protected:
    std::string message(const std::string& name, const std::string& text) {
        write(name, text);
        return error_of([&] { mesh(name.substr(name.find('.') + 1), name); });
    }
    static std::string changed(std::string from, std::string to) {
        std::string text = tetrahedron;
        text.replace(text.find(from), from.size(), to);
        return text;
    }
};

TEST_F(BadMesh, MissingOrEmpty) {
    expect_message(error_of([&] { mesh("ply", "absent.ply"); }), {"scene.xml:2:", "absent.ply", "does not exist"});
    expect_message(message("empty.ply", ""), {"scene.xml:2:", "empty.ply", "is empty"});
    expect_message(message("empty.obj", ""), {"empty.obj", "is empty"});
    expect_message(message("comment.obj", "# nothing\n"), {"comment.obj", "no vertices"});
    expect_message(message("points.obj", "v 0 0 0\nv 1 0 0\n"), {"points.obj", "no faces"});
    expect_message(message("n.ply", "hello\nthere\n"), {"n.ply", "not a PLY file"});
    expect_message(error_of([&] { load(sensor + lamp + "<shape type=\"ply\"/>"); }),
                   {"needs <string name=\"filename\">"});
}

TEST_F(BadMesh, NotFinite) {
    expect_message(message("nan.ply", changed("0 1 0", "0 nan 0")), {"nan.ply", "vertex 2", "not finite"});
    expect_message(message("inf.ply", changed("0 0 1.5", "0 0 inf")), {"inf.ply", "vertex 3", "not finite"});
    expect_message(message("huge.ply", changed("0 0 1.5", "0 0 1e999")), {"huge.ply", "vertex 3", "not finite"});
    expect_message(message("nan.obj", "v 0 0 0\nv 1 0 nan\nv 0 1 0\nf 1 2 3\n"),
                   {"nan.obj", "line 2", "not a finite number"});
    std::string text = binary_tetrahedron(false);
    const float infinity = INFINITY;
    std::memcpy(text.data() + text.find("end_header\n") + 11 + 9, &infinity, 4);  // y of vertex 0
    expect_message(message("binary.ply", text), {"binary.ply", "vertex 0", "not finite"});
}

TEST_F(BadMesh, IndexOutOfRange) {
    expect_message(message("i.ply", changed("3 1 2 3", "3 1 2 4")), {"i.ply", "triangle 3", "vertex 4", "there are 4"});
    expect_message(message("n.ply", changed("3 1 2 3", "3 1 -2 3")), {"n.ply", "face 3", "-2", "out of range"});
    expect_message(message("i.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 7\n"), {"i.obj", "vertex 7", "3 v"});
    expect_message(message("t.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nf 1/1 2/2 3/1\n"),
                   {"t.obj", "texture coordinate 2", "1 vt"});
}

TEST_F(BadMesh, Truncated) {
    const std::string text = binary_tetrahedron(false);
    expect_message(message("t.ply", text.substr(0, text.size() - 10)), {"t.ply", "truncated", "face 3"});
    expect_message(message("h.ply", text.substr(0, 60)), {"h.ply", "header"});
    expect_message(message("a.ply", tetrahedron.substr(0, tetrahedron.size() - 9)), {"a.ply", "truncated"});
    expect_message(message("c.ply", changed("element vertex 4", "element vertex 4000000000")),
                   {"c.ply", "truncated", "4000000000"});
}

TEST_F(BadMesh, MalformedPly) {
    expect_message(message("w.ply", changed("0 1 0", "0 one 0")), {"w.ply", "vertex 2", "'one'", "not a number"});
    expect_message(message("f.ply", changed("3 1 2 3", "2 1 2 3")), {"f.ply", "face 3", "2 corners"});
    expect_message(message("x.ply", changed("property float x", "property float a")), {"x.ply", "without x, y, z"});
    expect_message(message("y.ply", changed("property float x", "property flaot x")), {"y.ply", "line 4", "flaot"});
    expect_message(message("z.ply", changed("ascii", "binary_middle_endian")), {"z.ply", "binary_middle_endian"});
}

// Nothing to be seen: Mitsuba renders such scenes too, and public ones have some.
TEST_F(BadMesh, OnlyDegenerateTrianglesAreLeftOutWithAWarning) {
    write("d.obj", "v 0 0 0\nv 1 0 0\nv 2 0 0\nf 1 2 3\n");
    const Scene s = load(sensor + lamp + R"(<shape type="obj"><string name="filename" value="d.obj"/></shape>)");
    EXPECT_EQ(s.triangles.size(), 2u);
    ASSERT_EQ(warnings_.size(), 1u);
    expect_message(warnings_[0], {"d.obj", "degenerate", "left out"});
}

}  // namespace
}  // namespace irradia::test
