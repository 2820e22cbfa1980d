// Files that one load leaves to the next: what is read again and what not, and that nobody can tell from the scene.
#include <zlib.h>

#include <chrono>
#include <cstring>
#include <thread>

#include "OpenImageIO/imageio.h"
#include "scene_test.h"

namespace irradia::test {
namespace {

template <class T>
bool same_bytes(const std::vector<T>& a, const std::vector<T>& b) {
    return a.size() == b.size() && (a.empty() || std::memcmp(a.data(), b.data(), a.size() * sizeof(T)) == 0);
}

void expect_same(const Scene& a, const Scene& b) {
    EXPECT_TRUE(same_bytes(a.vertices, b.vertices));
    EXPECT_TRUE(same_bytes(a.triangles, b.triangles));
    EXPECT_TRUE(same_bytes(a.analytics, b.analytics));
    EXPECT_TRUE(same_bytes(a.materials, b.materials));
    EXPECT_TRUE(same_bytes(a.textures, b.textures));
    EXPECT_TRUE(same_bytes(a.texels, b.texels));
    EXPECT_TRUE(same_bytes(a.lights, b.lights));
    EXPECT_EQ(std::memcmp(&a.info, &b.info, sizeof a.info), 0);
    EXPECT_EQ(a.centre, b.centre);
    EXPECT_EQ(a.features, b.features);
    EXPECT_EQ(a.sample_count, b.sample_count);
}

const std::string quad_obj = R"(v 0 0 0 1 0 0
v 1 0 0 0 1 0
v 1 1 0 0 0 1
v 0 1 0 1 1 1
vt 0 0
vt 1 0
vt 1 1
vt 0 1
vn 0 0 1
f 1/1/1 2/2/1 3/3/1 4/4/1
)";

class Parts : public SceneTest {
protected:
    void SetUp() override {
        SceneTest::SetUp();
        write("quad.obj", quad_obj);
        write("tetrahedron.ply", tetrahedron);
        picture("wood.png", 3, OIIO::TypeDesc::UINT8, 0.25f);
        settle();
    }
    /// Files younger than a tenth of a second are read again, whatever their times say.
    static void settle() { std::this_thread::sleep_for(std::chrono::milliseconds(160)); }

    void picture(const std::string& name, int channels, OIIO::TypeDesc type, float value) {
        const auto out = OIIO::ImageOutput::create(path(name));
        ASSERT_TRUE(out) << OIIO::geterror();
        ASSERT_TRUE(out->open(path(name), OIIO::ImageSpec(4, 3, channels, type)));
        std::vector<float> data(static_cast<std::size_t>(12 * channels));
        for (std::size_t i = 0; i < data.size(); ++i) data[i] = value * static_cast<float>(i % 5) / 4.0f;
        ASSERT_TRUE(out->write_image(OIIO::TypeDesc::FLOAT, data.data()));
        ASSERT_TRUE(out->close());
    }
    static std::string mesh(const std::string& type, const std::string& file, double x, const std::string& more = "") {
        return "<shape type=\"" + type + "\"><string name=\"filename\" value=\"" + file +
               "\"/><transform name=\"to_world\"><rotate y=\"1\" angle=\"20\"/><translate x=\"" + std::to_string(x) +
               "\"/></transform>" + more + "</shape>\n";
    }
    const std::string wood =
        R"(<bsdf type="diffuse"><texture name="reflectance" type="bitmap"><string name="filename" value="wood.png"/></texture></bsdf>)";
    std::string frame(double x) {
        return sensor + lamp + mesh("obj", "quad.obj", x, wood) + mesh("ply", "tetrahedron.ply", 2);
    }

    /// Loads with parts and without, compares all, returns how many files were read with them.
    std::size_t read_by(const std::string& body, LoadOptions options = {}) {
        const Scene expected = load(body, options);
        const std::vector<std::string> warnings = warnings_;
        options.parts = &parts_;
        const std::size_t before = parts_.files_read();
        const Scene found = load(body, options);
        expect_same(expected, found);
        EXPECT_EQ(warnings, warnings_);
        return parts_.files_read() - before;
    }

    SceneParts parts_;
};

TEST_F(Parts, NothingIsReadTwice) {
    EXPECT_EQ(read_by(frame(0)), 3u);
    EXPECT_EQ(read_by(frame(0)), 0u);
    EXPECT_EQ(read_by(frame(0.5)), 0u);  // another transform
    EXPECT_EQ(parts_.files_kept(), 3u);
    // Other scene files, and other ways to name the same files.
    EXPECT_EQ(
        read_by(sensor + lamp + mesh("obj", path("quad.obj"), 1, "<boolean name=\"face_normals\" value=\"true\"/>") +
                mesh("ply", "./tetrahedron.ply", -1)),
        0u);
}

TEST_F(Parts, OneReadForAllShapesOfAFile) {
    const std::string body = sensor + lamp + mesh("ply", "tetrahedron.ply", 2) + mesh("ply", "tetrahedron.ply", -2) +
                             mesh("ply", "./tetrahedron.ply", 4);
    EXPECT_EQ(read_by(body), 1u);
    EXPECT_EQ(read_by(body), 0u);
}

TEST_F(Parts, ATouchedMeshIsReadAgainAndNothingElse) {
    EXPECT_EQ(read_by(frame(0)), 3u);
    std::string moved = quad_obj;
    moved.replace(moved.find("v 1 1 0"), 7, "v 2 2 1");  // as many bytes
    write("quad.obj", moved);
    settle();
    EXPECT_EQ(read_by(frame(0)), 1u);
    EXPECT_EQ(read_by(frame(0)), 0u);
    // The same length, and times set back to what they were: the inode has changed.
    const auto time = std::filesystem::last_write_time(path("quad.obj"));
    write("quad.obj", quad_obj);
    std::filesystem::last_write_time(path("quad.obj"), time);
    settle();
    EXPECT_EQ(read_by(frame(0)), 1u);
    // Another file by the same name, as old as the former.
    write("other.obj", moved);
    std::filesystem::last_write_time(path("other.obj"), time);
    std::filesystem::rename(path("other.obj"), path("quad.obj"));
    settle();
    EXPECT_EQ(read_by(frame(0)), 1u);
}

TEST_F(Parts, WhatWasJustWrittenIsNotTrusted) {
    // Two writes within a step of the file system's clock leave the same times.
    write("quad.obj", quad_obj);
    EXPECT_EQ(read_by(frame(0)), 3u);
    EXPECT_EQ(parts_.files_kept(), 2u);
    settle();
    EXPECT_EQ(read_by(frame(0)), 1u);
    EXPECT_EQ(read_by(frame(0)), 0u);
}

TEST_F(Parts, AChangedTextureIsReadAgainAndNothingElse) {
    EXPECT_EQ(read_by(frame(0)), 3u);
    picture("wood.png", 3, OIIO::TypeDesc::UINT8, 0.75f);
    settle();
    EXPECT_EQ(read_by(frame(0)), 1u);
    std::string raw = frame(0);
    raw.replace(raw.find("</texture>"), 0, "<boolean name=\"raw\" value=\"true\"/>");
    EXPECT_EQ(read_by(raw), 1u);  // the same file, read in another way
    EXPECT_EQ(read_by(raw), 0u);
}

TEST_F(Parts, EnvironmentsAndTheirWarnings) {
    picture("sky.exr", 3, OIIO::TypeDesc::FLOAT, -2.0f);
    {
        const auto out = OIIO::ImageOutput::create(path("sky.exr"));
        ASSERT_TRUE(out && out->open(path("sky.exr"), OIIO::ImageSpec(8, 4, 3, OIIO::TypeDesc::FLOAT)));
        std::vector<float> data(96);
        for (std::size_t i = 0; i < data.size(); ++i) data[i] = i % 7 == 0 ? -1.0f : static_cast<float>(i);
        ASSERT_TRUE(out->write_image(OIIO::TypeDesc::FLOAT, data.data()) && out->close());
    }
    settle();
    const auto sky = [&](const std::string& scale, const std::string& angle) {
        return sensor + mesh("ply", "tetrahedron.ply", 2) +
               "<emitter type=\"envmap\"><string name=\"filename\" value=\"sky.exr\"/><float name=\"scale\" value=\"" +
               scale + "\"/><transform name=\"to_world\"><rotate y=\"1\" angle=\"" + angle +
               "\"/></transform></emitter>";
    };
    EXPECT_EQ(read_by(sky("1", "0")), 2u);
    EXPECT_EQ(warnings_.size(), 1u);
    EXPECT_EQ(read_by(sky("1", "30")), 0u);  // turned
    EXPECT_EQ(warnings_.size(), 1u);         // warned of as if it had been read
    EXPECT_EQ(read_by(sky("2", "30")), 1u);
    EXPECT_EQ(parts_.files_kept(), 2u);
}

TEST_F(Parts, VertexColoursAreReadWhenASceneAsksForThem) {
    const std::string coloured = sensor + lamp +
                                 mesh("obj", "quad.obj", 1,
                                      R"(<bsdf type="diffuse"><texture name="reflectance" type="mesh_attribute">
                                         <string name="name" value="vertex_color"/></texture></bsdf>)");
    EXPECT_EQ(read_by(sensor + lamp + mesh("obj", "quad.obj", 1)), 1u);
    EXPECT_EQ(read_by(coloured), 1u);
    EXPECT_EQ(read_by(coloured), 0u);
}

TEST_F(Parts, EveryMeshOfASerializedFile) {
    const auto stream = [](float x) {  // version 4: flags, name, counts, positions, corners, compressed
        std::string raw;
        const auto put = [&](auto v) { raw.append(reinterpret_cast<const char*>(&v), sizeof v); };
        put(std::uint32_t{0x1000});
        raw += '\0';
        put(std::uint64_t{3});
        put(std::uint64_t{1});
        for (const float v : {x, 0.0f, 0.0f, 1.0f, 0.0f, 0.0f, 0.0f, 1.0f, 0.0f}) put(v);
        for (const std::uint32_t i : {0u, 1u, 2u}) put(i);
        uLongf size = compressBound(raw.size());
        std::string packed(size, '\0');
        EXPECT_EQ(compress(reinterpret_cast<Bytef*>(packed.data()), &size, reinterpret_cast<const Bytef*>(raw.data()),
                           raw.size()),
                  Z_OK);
        packed.resize(size);
        return std::string("\x1c\x04\x04\x00", 4) + packed;
    };
    const std::string first = stream(0.0f), second = stream(-1.0f);
    std::string file = first + second;
    for (const std::uint64_t offset : {std::uint64_t{0}, std::uint64_t{first.size()}})
        file.append(reinterpret_cast<const char*>(&offset), sizeof offset);
    file.append("\x02\x00\x00\x00", 4);
    write("two.serialized", file);
    settle();
    const auto shape = [&](int index) {
        return mesh("serialized", "two.serialized", 1,
                    "<integer name=\"shape_index\" value=\"" + std::to_string(index) + "\"/>");
    };
    EXPECT_EQ(read_by(sensor + lamp + shape(0)), 1u);
    EXPECT_EQ(read_by(sensor + lamp + shape(0) + shape(1)), 1u);
    EXPECT_EQ(read_by(sensor + lamp + shape(1) + shape(0)), 0u);
}

TEST_F(Parts, CoatsOfRoughPlastics) {
    const auto coated = [&](const std::string& alpha) {
        return sensor + lamp +
               mesh("ply", "tetrahedron.ply", 2,
                    R"(<bsdf type="roughplastic"><float name="alpha" value=")" + alpha + "\"/></bsdf>");
    };
    EXPECT_EQ(read_by(coated("0.2")), 1u);
    EXPECT_EQ(read_by(coated("0.2")), 0u);
    EXPECT_EQ(read_by(coated("0.3")), 0u);
}

TEST_F(Parts, MeansOfPicturesInPlaceOfTexturedLamps) {
    const std::string body =
        sensor + mesh("ply", "tetrahedron.ply", 2) +
        R"(<emitter type="point"><texture name="intensity" type="bitmap"><string name="filename" value="wood.png"/></texture></emitter>)";
    EXPECT_EQ(read_by(body, lenient()), 2u);
    EXPECT_EQ(read_by(body, lenient()), 0u);
}

TEST_F(Parts, WhatALoadDoesNotUseIsDropped) {
    EXPECT_EQ(read_by(frame(0)), 3u);
    const std::size_t all = parts_.bytes();
    EXPECT_GT(all, 0u);
    EXPECT_EQ(read_by(sensor + lamp + mesh("ply", "tetrahedron.ply", 2)), 0u);
    EXPECT_EQ(parts_.files_kept(), 1u);
    EXPECT_LT(parts_.bytes(), all);
    EXPECT_EQ(read_by(frame(0)), 2u);
    EXPECT_EQ(parts_.bytes(), all);
}

TEST_F(Parts, AVanishedFileIsAnErrorAndTheRestStays) {
    EXPECT_EQ(read_by(frame(0)), 3u);
    std::filesystem::rename(path("quad.obj"), path("away.obj"));
    LoadOptions options;
    options.parts = &parts_;
    const std::string without = error(frame(1));
    EXPECT_EQ(error(frame(1), options), without);
    expect_message(without, {"scene.xml:", "quad.obj", "does not exist"});
    std::filesystem::remove(path("wood.png"));
    const std::string picture_gone = sensor + lamp + mesh("ply", "tetrahedron.ply", 2, wood);
    EXPECT_EQ(error(picture_gone, options), error(picture_gone));
    expect_message(error(picture_gone, options), {"wood.png"});

    std::filesystem::rename(path("away.obj"), path("quad.obj"));
    picture("wood.png", 3, OIIO::TypeDesc::UINT8, 0.25f);
    settle();
    EXPECT_EQ(read_by(frame(1)), 2u);  // of the three all but the tetrahedron
    EXPECT_EQ(read_by(frame(1)), 0u);
}

TEST_F(Parts, ADamagedFileIsAnErrorEveryTime) {
    EXPECT_EQ(read_by(frame(0)), 3u);
    write("quad.obj", "v 0 0 zero\n");
    settle();
    LoadOptions options;
    options.parts = &parts_;
    const std::string without = error(frame(0));
    EXPECT_EQ(error(frame(0), options), without);
    EXPECT_EQ(error(frame(0), options), without);
    write("quad.obj", quad_obj);
    settle();
    EXPECT_EQ(read_by(frame(0)), 1u);
}

TEST_F(Parts, FailedLoadsDoNotPileUp) {
    EXPECT_EQ(read_by(frame(0)), 3u);
    LoadOptions options;
    options.parts = &parts_;
    for (int i = 0; i < 5; ++i) {
        const std::string file = "sky" + std::to_string(i) + ".png";
        picture(file, 3, OIIO::TypeDesc::UINT8, 0.5f);
        settle();
        // The picture is read, then the load fails: nothing emits light.
        error(sensor + mesh("ply", "tetrahedron.ply", 2,
                            "<bsdf type=\"diffuse\"><texture name=\"reflectance\" type=\"bitmap\"><string "
                            "name=\"filename\" value=\"" +
                                file + "\"/></texture></bsdf>"),
              options);
        EXPECT_EQ(parts_.files_kept(), 3u);  // tetrahedron, this picture, and wood.png of the last good load
    }
}

}  // namespace
}  // namespace irradia::test
