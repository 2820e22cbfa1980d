// `render` on everything that can be wrong with its input: status 1, one line that names it, and no file left behind.
// What each message says in detail is tested beside the code that says it, in tests/scene, core and device.
#include "command.h"

namespace irradia {
namespace {

const std::string kSensor = R"(<sensor type="perspective"><transform name="to_world"><translate z="-9"/></transform>
<film type="hdrfilm"><integer name="width" value="16"/><integer name="height" value="16"/></film></sensor>)";
const std::string kSky = R"(<emitter type="constant"/>)";
const std::string kCube = R"(<shape type="cube"/>)";

std::string mesh(const std::string& type, const std::string& file) {
    return "<shape type=\"" + type + "\"><string name=\"filename\" value=\"" + file + "\"/></shape>";
}
std::string textured(const std::string& file) {
    return R"(<shape type="cube"><bsdf type="diffuse"><texture type="bitmap" name="reflectance">)"
           "<string name=\"filename\" value=\"" +
           file + "\"/></texture></bsdf></shape>";
}

class BadInputCommand : public test::CommandTest {
protected:
    void write(const std::string& name, const std::string& text) const {
        std::ofstream(in_folder(name), std::ios::binary) << text;
    }
    void write_scene(const std::string& body) const {
        write("s.xml", "<scene version=\"3.0.0\">\n" + body + "\n</scene>\n");
    }
    static std::vector<std::string> small(const std::string& scene) {
        return {scene, "-o", "a.exr", "--quiet", "--method", "path", "--spp", "1"};
    }
    /// `environment` variables "NAME=value" first, then the command line.
    test::Outcome render(std::vector<std::string> arguments, std::vector<std::string> environment = {}) const {
        environment.push_back(RENDER);
        environment.insert(environment.end(), arguments.begin(), arguments.end());
        return call("env", environment);
    }
    /// After a limit of the shell is set ("ulimit -v 1000").
    test::Outcome render_limited(const std::string& limit, std::vector<std::string> arguments) const {
        arguments.insert(arguments.begin(), {"-c", limit + "; exec \"$0\" \"$@\"", RENDER});
        return call("sh", arguments);
    }
    /// Neither a picture nor a packed scene may be left.
    void expect_refused(const std::string& file, const std::string& what) const {
        const std::size_t before = files();
        std::vector<std::string> arguments = small(file);
        arguments.insert(arguments.end(), {"--pack", "p.bin"});
        expect_one_line(render(arguments), 1, "render", what);
        EXPECT_EQ(files(), before);
    }
};

TEST_F(BadInputCommand, SceneFiles) {
    expect_refused("none.xml", "'none.xml' does not exist");
    expect_refused(".", "'.' cannot be read");
    write("s.xml", "");
    expect_refused("s.xml", "s.xml:1: malformed XML: no XML element in it; a scene file or a packed scene");
    write("s.xml", "<scene version=\"3.0.0\">\n<shape type=\"cube\">\n</scene>\n");
    expect_refused("s.xml", "s.xml:3: malformed XML");
    write("s.xml", std::string("\0\1\2\3 no text", 12));
    expect_refused("s.xml", "s.xml:1: ");
}

TEST_F(BadInputCommand, Scenes) {
    write("empty.ply", "");
    write("no-faces.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\n");
    write("nan.obj", "v 0 0 0\nv 1 nan 0\nv 0 1 0\nf 1 2 3\n");
    write("inf.obj", "v 0 0 0\nv 1 inf 0\nv 0 1 0\nf 1 2 3\n");
    write("noise.png", "this is no picture");
    const std::string good = kSensor + kSky + kCube + "\n";  // two lines, so what follows is on line 4
    const auto with = [&](const std::string& what) { return good + what; };
    const std::string lamp = R"(<shape type="rectangle"><transform name="to_world"><scale x="0"/></transform>)"
                             R"(<emitter type="area"/></shape>)";
    std::string inside = kSensor, no_width = kSensor, negative_height = kSensor;
    inside.replace(inside.find("-9"), 2, "0");
    no_width.replace(no_width.find("16"), 2, "0");
    negative_height.replace(negative_height.rfind("16"), 2, "-16");
    const std::pair<std::string, std::string> bad[] = {
        {with(R"(<shape type="cube"><ref id="wal"/></shape><bsdf type="diffuse" id="wall"/>)"),
         "s.xml:4: unknown id 'wal'; did you mean 'wall'?"},
        {with(mesh("ply", "none.ply")), "s.xml:4: file 'none.ply' does not exist"},
        {with(mesh("ply", "empty.ply")), "s.xml:4: mesh 'empty.ply' is empty"},
        {with(mesh("obj", "no-faces.obj")), "s.xml:4: mesh 'no-faces.obj'"},
        {with(mesh("obj", "nan.obj")), "s.xml:4: mesh 'nan.obj' line 2: 'v 1 nan 0'"},
        {with(mesh("obj", "inf.obj")), "s.xml:4: mesh 'inf.obj' line 2: 'v 1 inf 0'"},
        {with(lamp), "s.xml:4: <shape type=\"rectangle\">: to_world is singular, the shape has no area"},
        {kSensor + kCube, "s.xml: nothing emits light"},
        {with(textured("none.png")), "s.xml:4: file 'none.png' does not exist"},
        {with(textured("noise.png")), "s.xml:4: texture 'noise.png' cannot be read"},
        {inside + kSky + kCube, "s.xml:2: sensor: the camera at (0, 0, 0) is inside <shape type=\"cube\">"},
        {no_width + kSky + kCube, "s.xml:3: film: width is 0"},
        {negative_height + kSky + kCube, "s.xml:3: film: height is -16"},
        {with(R"(<emitter type="point"><rgb name="intensity" value="1e39"/></emitter>)"),
         "s.xml:4: <rgb name=\"intensity\">: '1e39' is too large for single precision"},
        // Each number fits, their product does not.
        {with(
             R"(<emitter type="point"><transform name="to_world"><translate x="1e30"/><scale value="1e30"/></transform>)"
             R"(</emitter>)"),
         "s.xml: light 1: a number is not finite"},
    };
    for (const auto& [scene, what] : bad) {
        SCOPED_TRACE(what);
        write_scene(scene);
        expect_refused("s.xml", what);
    }
    write_scene(good);  // and it is good
    EXPECT_EQ(render(small("s.xml")).status, 0);
}

TEST_F(BadInputCommand, PictureSizes) {
    write_scene(kSensor + kSky + kCube);
    const auto sized = [](const std::string& width, const std::string& height) {
        return std::vector<std::string>{"s.xml", "-o", "a.exr", "--width", width, "--height", height};
    };
    expect_one_line(render(sized("0", "16")), 2, "render", "--width");
    expect_one_line(render(sized("16", "-1")), 2, "render", "--height");
    expect_one_line(render(sized("65537", "16")), 2, "render", "--width");
    expect_one_line(render(sized("65536", "65536")), 1, "render", "65536 x 65536 are 4294967296 pixels");
    expect_one_line(render({"s.xml", "-o", "a.exr", "--width", "65536"}), 1, "render", "65536 x 65536 pixels");
    EXPECT_EQ(files(), 1u);
}

TEST_F(BadInputCommand, PackedScenes) {
    write_scene(kSensor + kSky + kCube);
    ASSERT_EQ(render({"s.xml", "--pack", "good.bin", "--quiet"}).status, 0);
    const std::string good = test::file_text(in_folder("good.bin"));
    write("p", good.substr(0, 10));
    expect_refused("p", "p: truncated: 10 bytes");
    write("p", good.substr(0, good.size() - 1));
    expect_refused("p", "p: truncated or extended");
    write("p", good + "x");
    expect_refused("p", "p: truncated or extended");
    for (const std::size_t at : {std::size_t{40}, good.size() / 2, good.size() - 1}) {
        std::string altered = good;
        altered[at] = static_cast<char>(altered[at] ^ 4);
        write("p", altered);
        expect_refused("p", "p: damaged packed scene: checksum");
    }
}

TEST_F(BadInputCommand, FilesThatCannotBeWritten) {
    write_scene(kSensor + kSky + kCube);
    expect_one_line(render({"s.xml", "-o", "none/a.exr"}), 1, "render", "none/a.exr: cannot be written: there is no");
    // A disk that is full, or a quota: the picture has 12 MB, a file may have 8 (blocks of 1024 bytes, or of 512).
    std::vector<std::string> large = small("s.xml");
    large.insert(large.end(), {"--width", "1024", "--height", "1024", "--max-depth", "1"});
    large[2] = "a.pfm";
    ASSERT_EQ(render(large).status, 0);  // compiles the kernels, so that their files come first
    std::filesystem::resize_file(in_folder("a.pfm"), 5);
    expect_one_line(render_limited("trap '' XFSZ; ulimit -f 8192", large), 1, "render",
                    "a.pfm: cannot be written: File too large");
    EXPECT_EQ(std::filesystem::file_size(in_folder("a.pfm")), 5u);  // what was there is there still
    expect_one_line(render_limited("trap '' XFSZ; ulimit -f 1", {"s.xml", "--pack", "p.bin", "--quiet"}), 1, "render",
                    "p.bin: cannot be written: File too large");
    EXPECT_EQ(files(), 2u);
}

TEST_F(BadInputCommand, NoDevice) {
    write_scene(kSensor + kSky + kCube);
    const std::vector<std::string> none = {"OCL_ICD_VENDORS=/nonexistent/"};
    expect_one_line(render(small("s.xml"), none), 1, "render", "no OpenCL platform found (on Debian");
    expect_one_line(render({"--list-devices"}, none), 1, "render", "no OpenCL platform found (on Debian");
    EXPECT_EQ(files(), 1u);
}

TEST_F(BadInputCommand, DeviceOutOfMemory) {
    if (render({"--list-devices"}).out.find("Portable Computing Language") == std::string::npos)
        GTEST_SKIP() << "PoCL alone can be told how much memory it has";
    // A texture of 8300 x 8300 texels takes 276 MB; a device of 1 GB gives buffers of a quarter of that.
    write("t.pgm", "P5 8300 8300 255\n");
    std::filesystem::resize_file(in_folder("t.pgm"), 17 + 8300 * 8300);
    write_scene(kSensor + kSky + textured("t.pgm"));
    std::vector<std::string> arguments = small("s.xml");
    arguments.insert(arguments.end(), {"--device", "portable"});
    expect_one_line(render(arguments, {"POCL_MEMORY_LIMIT=1"}), 1, "render",
                    "no memory for a buffer of 275560000 bytes");
    EXPECT_EQ(files(), 2u);
}

TEST_F(BadInputCommand, HostOutOfMemory) {
#ifdef __SANITIZE_ADDRESS__
    GTEST_SKIP() << "the sanitizer itself takes more than the limit";
#endif
    write_scene(kSensor + kSky + kCube);
    std::vector<std::string> arguments = small("s.xml");
    arguments.insert(arguments.end(), {"--width", "30000", "--height", "30000", "--aov", "all"});
    expect_one_line(render_limited("ulimit -v 8000000", arguments), 1, "render",
                    "out of memory for a picture of 30000 x 30000 pixels");
    EXPECT_EQ(files(), 1u);
}

// A hemisphere of a megabyte lies on the stack where there is room, in memory where the system allows little of it.
TEST_F(BadInputCommand, LittleStack) {
#ifdef __SANITIZE_ADDRESS__
    GTEST_SKIP() << "the sanitizer's own frames are larger";
#endif
    write_scene(kSensor + kSky + kCube);
    const test::Outcome outcome =
        render_limited("ulimit -s 1024", {"s.xml", "-o", "a.pfm", "--quiet", "--spp", "1", "--width", "8", "--height",
                                          "8", "--hemisphere", "100x288", "--min-spacing", "30"});
    EXPECT_EQ(outcome.status, 0) << outcome.err;
}

}  // namespace
}  // namespace irradia
