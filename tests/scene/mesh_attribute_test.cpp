// Vertex colours and .serialized files. The bytes of these files were also given to Mitsuba 3.9.1, which reads the same
// positions, normals, texture coordinates and (PLY, in floating point) colours from them.
#include <zlib.h>

#include <bit>
#include <cstring>

#include "scene/build.h"
#include "scene_test.h"

namespace irradia::test {
namespace {

template <class T>
void put(std::string& out, T value) {
    out.append(reinterpret_cast<const char*>(&value), sizeof(T));
}

const float kVertices[4][3] = {{0, 0, 0}, {2, 0, 0}, {0, 1, 0}, {0, 0, 1.5f}};
const std::uint32_t kFaces[4][3] = {{0, 2, 1}, {0, 1, 3}, {0, 3, 2}, {1, 2, 3}};
const float kNormals[4][3] = {{0, 0, 1}, {0, 1, 0}, {1, 0, 0}, {0, 0, -1}};
const float kUvs[4][2] = {{0, 0}, {1, 0}, {0, 1}, {.5f, .25f}};
const float kColours[4][3] = {{.1f, .2f, .3f}, {.4f, .5f, .6f}, {.7f, .8f, .9f}, {1, 0, .5f}};

template <class Scalar>
std::string body(int version, std::uint32_t flags, const std::string& name) {
    std::string out;
    put(out, flags);
    if (version == 4) out += name + '\0';
    put(out, std::uint64_t{4});
    put(out, std::uint64_t{4});
    const auto add = [&](const auto& rows) {
        for (const auto& row : rows)
            for (const float x : row) put(out, static_cast<Scalar>(x));
    };
    add(kVertices);
    if (flags & 1u) add(kNormals);
    if (flags & 2u) add(kUvs);
    if (flags & 8u) add(kColours);
    for (const auto& f : kFaces)
        for (const std::uint32_t i : f) put(out, i);
    return out;
}

std::string file(int version, const std::vector<std::string>& bodies) {
    std::string out;
    std::vector<std::uint64_t> begins;
    for (const std::string& b : bodies) {
        begins.push_back(out.size());
        put(out, std::uint16_t{0x041c});
        put(out, static_cast<std::uint16_t>(version));
        std::string packed(compressBound(b.size()), '\0');
        uLongf size = packed.size();
        compress(reinterpret_cast<Bytef*>(packed.data()), &size, reinterpret_cast<const Bytef*>(b.data()), b.size());
        out.append(packed, 0, size);
    }
    for (const std::uint64_t begin : begins) {
        if (version == 4)
            put(out, begin);
        else
            put(out, static_cast<std::uint32_t>(begin));
    }
    put(out, static_cast<std::uint32_t>(bodies.size()));
    return out;
}

class MeshAttributes : public SceneTest {
protected:
    Scene serialized(int index, const std::string& more = "") {
        return load(sensor + lamp +
                    "<shape type=\"serialized\"><string name=\"filename\" value=\"m.serialized\"/>"
                    "<integer name=\"shape_index\" value=\"" +
                    std::to_string(index) + "\"/>" + more + "</shape>");
    }
    static constexpr std::uint32_t first = 4;  // vertex of the mesh: the lamp has four
};

TEST_F(MeshAttributes, SerializedHasMeshesByIndex) {
    for (const int version : {3, 4}) {
        write("m.serialized", file(version, {body<float>(version, 0x1000u | 1u | 2u | 8u, "one"),
                                             body<double>(version, 0x2000u, "two")}));
        const Scene one = serialized(0);
        ASSERT_EQ(one.vertices.size(), first + 4);
        ASSERT_EQ(one.triangles.size(), 6u);
        for (std::uint32_t i = 0; i < 4; ++i) {
            expect_near(position(one, first + i), {kVertices[i][0], kVertices[i][1], kVertices[i][2]}, 1e-6);
            expect_near(vertex_normal(one, first + i), {kNormals[i][0], kNormals[i][1], kNormals[i][2]}, 0.0);
            EXPECT_EQ(one.vertices[first + i].u, kUvs[i][0]);
            EXPECT_EQ(one.vertices[first + i].v, kUvs[i][1]);  // as they stand, as in Mitsuba
        }
        EXPECT_EQ(one.triangles[2].v1, first + 2);
        // Mitsuba's computed normal of vertex 0 of the second mesh: (-1, -1, -1) / sqrt(3); of vertex 1 as below.
        const Scene two = serialized(1);
        expect_near(position(two, first + 3), {0, 0, 1.5}, 1e-6);
        expect_near(vertex_normal(two, first), {-0.5773502588, -0.5773502588, -0.5773502588}, 1e-6);
        expect_near(vertex_normal(two, first + 1), {0.9625532031, -0.1599377394, -0.2188863307}, 1e-6);
        EXPECT_EQ(two.triangles[2].flags & IR_TRIANGLE_HAS_UV, 0u);
        EXPECT_EQ(serialized(1, "<boolean name=\"face_normals\" value=\"true\"/>").triangles[2].flags,
                  IR_TRIANGLE_FLAT);
    }
}

TEST_F(MeshAttributes, BadSerializedFilesAreNamed) {
    const std::string mesh = body<float>(4, 0x1000u, "one"), good = file(4, {mesh});
    const auto refused = [&](const std::string& bytes, int index = 0) {
        write("m.serialized", bytes);
        return error_of([&] { serialized(index); });
    };
    expect_message(refused(good, 1), {"scene.xml:2:", "m.serialized", "holds 1 meshes", "shape_index is 1"});
    expect_message(refused(good, -1), {"shape_index is -1"});
    expect_message(refused("ply\nformat"), {"not a serialized mesh"});
    expect_message(refused(std::string("\x1c\x04\x02\x00zz", 6)), {"version 2", "3 or 4"});
    expect_message(refused(good.substr(0, 40)), {"truncated"});
    expect_message(refused(file(4, {mesh.substr(0, mesh.size() - 5)})), {"truncated"});
    std::string many = mesh;
    many[8 + 5] = 1;  // of the count of vertices: 2^40 more
    expect_message(refused(file(4, {many})), {"announces", "more than it can hold"});
    std::string damaged = good;
    damaged[10] = '\xff';
    expect_message(refused(damaged), {"damaged"});
}

const std::string kColouredPly = R"(ply
format ascii 1.0
element vertex 3
property float x
property float y
property float z
property TYPE R
property TYPE G
property TYPE B
element face 1
property list uchar int vertex_indices
end_header
0 0 0 COLOURS
1 0 0 0 0 0
0 1 0 1 1 1
3 0 1 2
)";
std::string coloured(const std::string& type, const std::vector<std::string>& names, const std::string& colours) {
    std::string text = kColouredPly;
    const auto replace = [&](const std::string& from, const std::string& to) {
        for (std::size_t at = 0; (at = text.find(from, at)) != std::string::npos; at += to.size())
            text.replace(at, from.size(), to);
    };
    replace("COLOURS", colours);
    replace("TYPE", type);
    replace(" R\n", " " + names[0] + "\n");
    replace(" G\n", " " + names[1] + "\n");
    replace(" B\n", " " + names[2] + "\n");
    return text;
}

TEST_F(MeshAttributes, PlyAndObjKeepVertexColoursIfAskedTo) {
    for (const auto& names : {std::vector<std::string>{"r", "g", "b"}, {"red", "green", "blue"}}) {
        const loader::Mesh mesh = loader::read_ply(write("a.ply", coloured("float", names, ".1 .2 .3")), true);
        ASSERT_EQ(mesh.colours.size(), 3u);
        EXPECT_EQ(mesh.colours[0], glm::vec3(.1f, .2f, .3f));
        EXPECT_EQ(mesh.colours[2], glm::vec3(1.0f));
    }
    // Whole numbers are fractions of their largest here (Mitsuba takes them as they stand and warns).
    const loader::Mesh bytes =
        loader::read_ply(write("b.ply", coloured("uchar", {"red", "green", "blue"}, "255 51 0")), true);
    EXPECT_EQ(bytes.colours[0], glm::vec3(1.0f, 0.2f, 0.0f));
    EXPECT_TRUE(loader::read_ply(path("a.ply"), false).colours.empty());

    write("c.obj", "v 0 0 0 .1 .2 .3\nv 1 0 0 1 1 1\nv 0 1 0\nf 3 2 1\n");
    const loader::Mesh obj = loader::read_obj(path("c.obj"), true);
    ASSERT_EQ(obj.colours.size(), 3u);
    EXPECT_EQ(obj.colours[2], glm::vec3(.1f, .2f, .3f));  // the third corner is the first vertex of the file
    EXPECT_TRUE(loader::read_obj(path("c.obj"), false).colours.empty());
}

TEST_F(MeshAttributes, ColoursBecomeTexelsAVertexEach) {
    const loader::Node node;
    std::vector<loader::Shape> shapes(2);
    for (loader::Shape& s : shapes) s.node = &node;
    shapes[0].mesh.positions.resize(2);  // without colours, of a material that does not ask
    shapes[1].mesh.positions.resize(1);
    shapes[1].mesh.colours = {{.25f, .5f, 3.0f}};
    shapes[1].material = 1;
    std::vector<shared::Material> materials(2, blank_material());
    materials[1].texture = 1;
    loader::TextureTable table;
    loader::TextureSpec bitmap, held, free;
    bitmap.path = "a.png";
    held.vertex_colours = free.vertex_colours = free.unbounded = true;
    table.add(bitmap);
    EXPECT_FALSE(table.vertex_colours());
    table.add(held);
    table.add(free);
    EXPECT_TRUE(table.vertex_colours());
    Scene scene;
    scene.textures.resize(3);
    scene.textures[1].format = scene.textures[2].format = IR_TEXTURE_VERTEX_COLOUR;
    scene.texels.assign(5, 0u);  // of other textures
    loader::add_vertex_colours(shapes, materials, table, scene);
    EXPECT_EQ(scene.textures[1].offset, 5u);
    ASSERT_EQ(scene.textures[2].offset, 14u);
    ASSERT_EQ(scene.texels.size(), 23u);
    const auto texel = [&](std::size_t i) { return std::bit_cast<float>(scene.texels[i]); };
    EXPECT_EQ(texel(5 + 3 * 2), .25f);  // vertex 2 of the scene
    EXPECT_EQ(texel(5 + 3 * 2 + 2), 1.0f);
    EXPECT_EQ(texel(14 + 3 * 2 + 2), 3.0f);

    shapes[0].material = 1;
    loader::Node named;
    named.tag = "shape";
    const std::string name = "s.xml";
    named.file = &name;
    shapes[0].node = &named;
    expect_message(error_of([&] { loader::add_vertex_colours(shapes, materials, table, scene); }),
                   {"s.xml:", "<shape>", "no vertex colours"});
}

}  // namespace
}  // namespace irradia::test
