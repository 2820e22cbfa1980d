// The executables load OpenEXR and OpenImageIO when a picture needs them, and only then.
#include <fmt/format.h>

#include "command.h"

namespace irradia {
namespace {

class PictureModules : public test::CommandTest {
protected:
    void SetUp() override {
        CommandTest::SetUp();
        const Image picture = test::picture(8, 8, [](int x, int, int) { return 1.0 + x; });
        write_image(in_folder("x.pfm"), picture);
        write_image(in_folder("x.exr"), picture);
        std::filesystem::create_directory(in_folder("modules"));
        write_scene("");
    }
    void write_scene(const std::string& material) const {
        std::ofstream(in_folder("s.xml")) << "<scene version=\"3.0.0\"><sensor type=\"perspective\"/>\n"
                                             "<emitter type=\"constant\"/>\n<shape type=\"rectangle\">\n"
                                          << material << "</shape></scene>\n";
    }
    /// With modules looked for in the folder "modules", which is empty.
    test::Outcome without(const std::string& executable, std::vector<std::string> arguments) const {
        arguments.insert(arguments.begin(), {"IRRADIA_MODULE_DIR=modules", executable});
        return call("env", arguments);
    }
    test::Outcome render(const std::string& output) const {
        return without(RENDER, {"s.xml", "-o", output, "--quiet", "--method", "path", "--spp", "1", "--width", "8",
                                "--height", "8"});
    }
};

TEST_F(PictureModules, ExecutablesLinkNone) {
    // The dynamic linker loads what is named in the file.
    for (const auto& [library, module] : {std::pair{"libOpenImageIO.so", OIIO_MODULE}, {"libOpenEXR", EXR_MODULE}}) {
        EXPECT_EQ(test::file_text(RENDER).find(library), std::string::npos);
        EXPECT_EQ(test::file_text(COMPARE).find(library), std::string::npos);
        EXPECT_NE(test::file_text(module).find(library), std::string::npos);
    }
    EXPECT_EQ(test::file_text(EXR_MODULE).find("libOpenImageIO.so"), std::string::npos);
}

TEST_F(PictureModules, ExrIsWrittenWithoutOpenImageIO) {
    std::filesystem::copy(EXR_MODULE, in_folder("modules/libirradia_exr.so"));
    const test::Outcome rendered = render("a.exr");
    EXPECT_EQ(rendered.status, 0) << rendered.err;
    expect_one_line(render("a.png"), 1, "render", "modules/libirradia_oiio.so: cannot be loaded");
    EXPECT_EQ(read_image(in_folder("a.exr")).width, 8);
}

TEST_F(PictureModules, PfmNeedsNone) {
    const test::Outcome rendered = render("a.pfm");
    EXPECT_EQ(rendered.status, 0) << rendered.err;
    const test::Outcome compared = without(COMPARE, {"a.pfm", "x.pfm"});
    EXPECT_EQ(compared.status, 0) << compared.err;
}

TEST_F(PictureModules, MissingIsOneLine) {
    const std::string what = "modules/libirradia_oiio.so: cannot be loaded";
    for (const std::string output : {"a.exr", "a.EXR", "a.PNG"}) {
        expect_one_line(render(output), 1, "render",
                        output == "a.PNG" ? what : "modules/libirradia_exr.so: cannot be loaded, which writes .exr");
        EXPECT_FALSE(std::filesystem::exists(in_folder(output)));
    }
    expect_one_line(without(COMPARE, {"x.exr", "x.pfm"}), 1, "compare", what);
    expect_one_line(without(COMPARE, {"x.pfm", "x.pfm", "--heatmap", "h.png"}), 1, "compare", what);

    write_scene(
        R"(<bsdf type="diffuse"><texture type="bitmap" name="reflectance"><string name="filename" value="x.exr"/>
                   </texture></bsdf>)");
    expect_one_line(render("a.pfm"), 1, "render", "s.xml:4: " + what);
}

TEST_F(PictureModules, AnotherIsOneLine) {
    for (const auto& [module, output] : {std::pair{"exr", "a.exr"}, {"oiio", "a.png"}}) {
        const std::string file = fmt::format("modules/libirradia_{}.so", module);
        std::ofstream(in_folder(file)) << "no library";
        expect_one_line(render(output), 1, "render", file + ": cannot be loaded");
        std::filesystem::remove(in_folder(file));
        std::filesystem::create_symlink("/proc/self/exe", in_folder(file));
        expect_one_line(render(output), 1, "render", file + ": cannot be loaded");
    }
}

}  // namespace
}  // namespace irradia
