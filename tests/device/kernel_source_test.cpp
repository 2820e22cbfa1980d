// #include lines of device code.
#include "device/kernel_source.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <string>

#include "irradia/Device.h"
#include "irradia/Error.h"

namespace {

namespace fs = std::filesystem;
using irradia::device::expand_source;
using irradia::device::find_source;

std::size_t count(const std::string& text, const std::string& part) {
    std::size_t n = 0;
    for (std::size_t at = text.find(part); at != text.npos; at = text.find(part, at + 1)) ++n;
    return n;
}

/// A folder of device code that IRRADIA_CL_DIR names while this object lives.
class SourceFolder {
public:
    SourceFolder() : path_(fs::temp_directory_path() / ("irradia-cl-" + std::to_string(::getpid()))) {
        fs::create_directories(path_);
        ::setenv("IRRADIA_CL_DIR", path_.c_str(), 1);
    }
    ~SourceFolder() {
        ::unsetenv("IRRADIA_CL_DIR");
        fs::remove_all(path_);
    }
    void file(const std::string& name, const std::string& text) const { std::ofstream(path_ / name) << text; }

private:
    fs::path path_;
};

TEST(KernelSource, EmbeddedFilesAreTheFilesOfTheTree) {
    for (const std::string name : {"portable.h", "echo_sizes.cl", "irradia/shared/scene_types.h"}) {
        std::string text;
        ASSERT_TRUE(find_source(name, text)) << name;
        const std::string folder = name.starts_with("irradia/") ? "/include/" : "/cl/";
        std::ifstream in(IRRADIA_SOURCE_DIR + folder + name);
        const std::string expected{std::istreambuf_iterator<char>(in), {}};
        EXPECT_EQ(text, expected) << name;
    }
}

TEST(KernelSource, EachHeaderOnceWithLines) {
    SourceFolder folder;
    folder.file("a.cl", "#include \"b.h\"\n#include \"c.h\"\nint a;\n");
    folder.file("b.h", "#ifndef B\n#define B\n  #  include \"c.h\"\nint b;\n#endif\n");
    folder.file("c.h", "#ifndef C\n#define C\nint c;\n#endif");
    EXPECT_EQ(expand_source("a.cl"),
              "#line 1 \"a.cl\"\n"
              "#line 1 \"b.h\"\n#ifndef B\n#define B\n"
              "#line 1 \"c.h\"\n#ifndef C\n#define C\nint c;\n#endif\n"
              "#line 4 \"b.h\"\nint b;\n#endif\n"
              "#line 2 \"a.cl\"\n"
              "#line 3 \"a.cl\"\nint a;\n");
}

TEST(KernelSource, HeaderSeenUnderAConditionComesAgain) {
    SourceFolder folder;
    folder.file("a.cl",
                "#ifdef X\n#include \"b.h\"\n#else\n#include \"b.h\"\n#endif\n#include \"b.h\"\n#include \"b.h\"\n");
    folder.file("b.h", "#ifndef B\n#define B\nint b;\n#endif\n");
    EXPECT_EQ(count(expand_source("a.cl"), "int b;"), 3u);  // both branches, and once after them
}

TEST(KernelSource, RingsEnd) {
    SourceFolder folder;
    folder.file("a.h", "#include \"b.h\"\nint a;\n");
    folder.file("b.h", "#include \"a.h\"\nint b;\n");
    EXPECT_EQ(count(expand_source("a.h"), "int a;"), 1u);
}

TEST(KernelSource, MissingHeaderCountsOnlyWhereReached) {
    SourceFolder folder;
    folder.file("a.cl", "#ifdef NEVER\n#include \"gone.h\"\n#endif\n__kernel void k(__global int* a) { a[0] = 1; }\n");
    folder.file("b.cl", "\n#include \"gone.h\"\n__kernel void k(__global int* a) { a[0] = 1; }\n");
    irradia::Device device({});
    EXPECT_NO_THROW(device.kernel("a.cl", "k", {}));
    try {
        device.kernel("b.cl", "k", {});
        FAIL() << "compiled";
    } catch (const irradia::Error& e) {
        EXPECT_NE(std::string(e.what()).find("\"gone.h\" is no file of the device code"), std::string::npos)
            << e.what();
        EXPECT_NE(std::string(e.what()).find("b.cl:2"), std::string::npos) << e.what();
    }
}

TEST(KernelSource, FolderComesBeforeEmbeddedFiles) {
    SourceFolder folder;
    folder.file("portable.h", "// another\n");
    std::string text;
    ASSERT_TRUE(find_source("portable.h", text));
    EXPECT_EQ(text, "// another\n");
    ASSERT_TRUE(find_source("echo_sizes.cl", text));  // the rest is embedded
    EXPECT_NE(text.find("echo_sizes"), std::string::npos);
}

TEST(KernelSource, EmbeddedSumsAreOfEmbeddedFilesAlone) {
    using irradia::device::embedded_sums;
    const irradia::Checksums* const shade = embedded_sums("shade_pixels.cl");
    ASSERT_NE(shade, nullptr);
    ASSERT_NE(embedded_sums("echo_sizes.cl"), nullptr);
    EXPECT_NE(*shade, *embedded_sums("echo_sizes.cl"));
    EXPECT_EQ(embedded_sums("nothing.cl"), nullptr);
    EXPECT_EQ(embedded_sums(IRRADIA_SOURCE_DIR "/cl/shade_pixels.cl"), nullptr);
    const SourceFolder folder;  // a file of it may be part of any other
    EXPECT_EQ(embedded_sums("shade_pixels.cl"), nullptr);
}

// See cl/portable.h: a function of its own that takes local memory may lose what it writes.
TEST(KernelSource, FunctionsThatTakeLocalMemoryAreInlined) {
    std::size_t functions = 0;
    for (const irradia::device::EmbeddedFile* f = irradia::device::embedded_files(); f->name != nullptr; ++f) {
        const std::string text(reinterpret_cast<const char*>(f->text), f->bytes);
        for (std::size_t at = text.find("FN "); at != std::string::npos; at = text.find("FN ", at + 1)) {
            const std::size_t line = text.rfind('\n', at) + 1;
            const std::string head = text.substr(line, text.find('{', at) - line);
            if (head.starts_with('#') ||
                (head.find("IR_LOCAL ") == std::string::npos && head.find("IR_CELL_SPACE ") == std::string::npos))
                continue;
            EXPECT_TRUE(head.starts_with("IR_INLINE_FN ")) << f->name << ": " << head;
            ++functions;
        }
    }
    EXPECT_GE(functions, 6u);  // those of sample_hemispheres.cl and make_record.h
}

}  // namespace
