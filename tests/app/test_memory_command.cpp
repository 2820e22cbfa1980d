// --memory-limit: what is refused, at which point, and how far the process has gone until then.
#include <sys/resource.h>

#include <bit>
#include <cmath>

#include "command.h"
#include "core/memory.h"

namespace irradia {
namespace {

const std::string kCornell = std::string(IRRADIA_SOURCE_DIR) + "/scenes/cornell-box.xml";
constexpr std::uint64_t kMiB = 1 << 20;
// What a process may have taken beyond its limit when it refuses: libraries, and what is not worth a check of its own.
constexpr std::uint64_t kAllowance = 16 * kMiB;

class MemoryCommand : public test::CommandTest {
protected:
    struct Result {
        int status = -1;
        std::uint64_t peak = 0;
        std::string err;
    };
    /// Runs `render` in the folder; `address_space`: RLIMIT_AS, bytes, 0: none.
    Result render(const std::vector<std::string>& arguments, std::uint64_t address_space = 0) const {
        const std::string err = folder_.string() + ".err";
        const pid_t child = ::fork();
        if (child == 0) {
            if (!std::freopen(err.c_str(), "w", stderr) || ::chdir(folder_.c_str()) != 0) ::_exit(126);
            if (address_space > 0) {
                const rlimit limit{address_space, address_space};
                ::setrlimit(RLIMIT_AS, &limit);
            }
            std::vector<char*> argv{const_cast<char*>(RENDER)};
            for (const std::string& argument : arguments) argv.push_back(const_cast<char*>(argument.c_str()));
            argv.push_back(nullptr);
            ::execv(RENDER, argv.data());
            ::_exit(127);
        }
        int status = 0;
        rusage usage{};
        EXPECT_EQ(::wait4(child, &status, 0, &usage), child);
        Result result{WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status),
                      static_cast<std::uint64_t>(usage.ru_maxrss) * 1024, test::file_text(err)};
        std::filesystem::remove(err);
        return result;
    }

    /// A height field of 2 cells^2 triangles under a lamp.
    void write_field(std::uint32_t cells) const {
        static_assert(std::endian::native == std::endian::little);
        const std::uint32_t rows = cells + 1;
        std::ofstream ply(in_folder("field.ply"), std::ios::binary);
        ply << "ply\nformat binary_little_endian 1.0\nelement vertex " << rows * rows
            << "\nproperty float x\nproperty float y\nproperty float z\nelement face " << 2 * cells * cells
            << "\nproperty list uchar int vertex_indices\nend_header\n";
        const auto put = [&](const auto& value) { ply.write(reinterpret_cast<const char*>(&value), sizeof value); };
        for (std::uint32_t j = 0; j < rows; ++j)
            for (std::uint32_t i = 0; i < rows; ++i) {
                const float x = 2.0f * static_cast<float>(i) / static_cast<float>(cells) - 1,
                            z = 2.0f * static_cast<float>(j) / static_cast<float>(cells) - 1;
                put(x), put(0.1f * std::sin(20 * x) * std::cos(17 * z)), put(z);
            }
        const auto triangle = [&](std::uint32_t a, std::uint32_t b, std::uint32_t c) {
            put(std::uint8_t{3}), put(a), put(b), put(c);
        };
        for (std::uint32_t j = 0; j < cells; ++j)
            for (std::uint32_t i = 0; i < cells; ++i) {
                const std::uint32_t a = j * rows + i;
                triangle(a, a + rows, a + 1);
                triangle(a + 1, a + rows, a + rows + 1);
            }
        std::ofstream(in_folder("field.xml"))
            << R"(<scene version="3.0.0"><sensor type="perspective"><transform name="to_world"><lookat origin="0,2,3" )"
            << R"(target="0,0,0" up="0,1,0"/></transform><film type="hdrfilm"><integer name="width" value="32"/>)"
            << R"(<integer name="height" value="32"/></film></sensor><shape type="ply"><string name="filename" )"
            << R"(value="field.ply"/></shape><emitter type="constant"/></scene>)";
    }

    void expect_refusal(const std::vector<std::string>& arguments, std::uint64_t limit, const std::string& what) const {
        std::vector<std::string> all = arguments;
        all.insert(all.end(), {"-o", "out.pfm", "--stats", "s.json", "--save-records", "r", "--quiet", "--memory-limit",
                               std::to_string(limit)});
        const std::size_t before = files();
        const Result result = render(all);
        SCOPED_TRACE("limit " + std::to_string(limit / kMiB) + " MiB, peak " + std::to_string(result.peak / kMiB) +
                     " MiB: " + result.err);
        EXPECT_EQ(result.status, 1);
        EXPECT_EQ(result.err.rfind("render: no memory for " + what, 0), 0u);
        EXPECT_EQ(result.err.find('\n'), result.err.size() - 1);
        EXPECT_NE(result.err.find(memory_text(limit) + " allowed (--memory-limit): "), std::string::npos);
        EXPECT_EQ(files(), before);
        EXPECT_LE(result.peak, limit + kAllowance);
    }

    /// Peak of a run that ends with an error right before its scene is read, having opened the device.
    std::uint64_t bare() const { return render({"none.xml", "-o", "a.pfm"}).peak; }
};

TEST_F(MemoryCommand, RefusesMeshesTrianglesHierarchyAndBuffers) {
    write_field(500);  // half a million triangles, 9.5 MB
    const std::uint64_t base = bare();
    expect_refusal({"field.xml"}, base + 8 * kMiB, "the scene's meshes");  // 2.4 times its file
    expect_refusal({"field.xml"}, base + 42 * kMiB, "the scene's triangles");
    expect_refusal({"field.xml"}, base + 90 * kMiB, "the scene's hierarchy");
    // 100 MB of the grid's table beside what was enough for the hierarchy.
    expect_refusal({"field.xml", "--grid-paths", "4194304"}, base + 130 * kMiB, "a buffer of device");
    const Result enough =
        render({"field.xml", "-o", "out.pfm", "--quiet", "--quality", "draft", "--memory-limit", "90%"});
    EXPECT_EQ(enough.status, 0) << enough.err;
    EXPECT_TRUE(std::filesystem::exists(in_folder("out.pfm")));
}

TEST_F(MemoryCommand, RefusesFilmsBuffersPackedScenesAndRecords) {
    ASSERT_EQ(render({kCornell, "-o", "a.pfm", "--quality", "draft", "--width", "96", "--save-records", "kept"}).status,
              0);
    std::filesystem::resize_file(in_folder("kept"), 100 * kMiB);  // never read
    const std::uint64_t base = bare();
    const std::vector<std::string> large{kCornell, "--width", "2048", "--height", "2048", "--quality", "draft"};
    expect_refusal(large, base + 100 * kMiB, "a picture of 2048 x 2048 pixels");
    expect_refusal({kCornell, "--width", "64"}, base + 9 * kMiB, "a buffer of device");
    expect_refusal({kCornell, "--load-records", "kept"}, base + 9 * kMiB, "the records of kept");

    write_field(300);
    ASSERT_EQ(render({"field.xml", "--pack", "packed"}).status, 0);
    expect_refusal({"packed"}, base + 9 * kMiB, "the packed scene");
    const Result tiny = render({kCornell, "-o", "out.pfm", "--quiet", "--memory-limit", std::to_string(base / 2)});
    EXPECT_EQ(tiny.status, 1);  // less than the program itself
    EXPECT_EQ(tiny.err.rfind("render: no memory for loading (parsing): ", 0), 0u) << tiny.err;
}

// Records grow while the picture is made: what has begun ends with the same line.
TEST_F(MemoryCommand, RefusesWhatGrowsDuringTheRender) {
    const std::string knot = std::string(IRRADIA_SOURCE_DIR) + "/scenes/glossy-knot.xml";
    const std::vector<std::string> growing{knot, "--method", "radiance", "--quality",         "draft", "--spp",
                                           "1",  "--width",  "192",      "--glossy-accuracy", "0.05"};
    std::vector<std::string> unlimited = growing;
    unlimited.insert(unlimited.end(), {"-o", "b.pfm", "--quiet"});
    const Result whole = render(unlimited);  // and compiles the kernels, which takes memory of its own
    ASSERT_EQ(whole.status, 0) << whole.err;
    const std::uint64_t peak = render(unlimited).peak;
    std::filesystem::remove(in_folder("b.pfm"));
    const std::uint64_t base = bare();
    ASSERT_GT(peak, base + 40 * kMiB);
    expect_refusal(growing, base + (peak - base) * 3 / 4, "");  // a buffer, or whatever comes next
}

TEST_F(MemoryCommand, FailedAllocationsAreOneLineWithoutALimitToo) {
    write_field(500);
    // The device's own libraries take .4 GB of address space, a film of 16384 x 16384 18 GB.
    const Result film = render({kCornell, "-o", "out.pfm", "--quiet", "--method", "path", "--spp", "1", "--width",
                                "16384", "--height", "16384"},
                               std::uint64_t{4} << 30);
    EXPECT_EQ(film.status, 1) << film.err;
    EXPECT_EQ(film.err.rfind("render: out of memory for a picture of 16384 x 16384 pixels", 0), 0u) << film.err;
    EXPECT_EQ(film.err.find('\n'), film.err.size() - 1) << film.err;
    EXPECT_EQ(files(), 2u);
}

TEST_F(MemoryCommand, WrongSizesAreWrongCommandLines) {
    for (const char* size : {"lots", "-1G", "0", "4X"})
        expect_one_line(call(RENDER, {kCornell, "-o", "a.pfm", "--memory-limit", size}), 2, "render",
                        "'" + std::string(size) + "' is not a size");
}

}  // namespace
}  // namespace irradia
