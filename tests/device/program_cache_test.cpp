// Compiled programs kept between runs: found again, never wrong.
#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>
#include <vector>

#include "irradia/Device.h"

namespace {

namespace fs = std::filesystem;
using irradia::Buffer;
using irradia::Device;

/// A folder of kernels that $IRRADIA_KERNEL_CACHE names, and one of sources that $IRRADIA_CL_DIR names.
class ProgramCache : public ::testing::Test {
protected:
    void SetUp() override {
        const char* old = std::getenv("IRRADIA_KERNEL_CACHE");
        had_ = old != nullptr;
        if (had_) before_ = old;
        fs::create_directories(sources());
        ::setenv("IRRADIA_KERNEL_CACHE", cache().c_str(), 1);
        ::setenv("IRRADIA_CL_DIR", sources().c_str(), 1);
        source("7");
    }
    void TearDown() override {
        ::unsetenv("IRRADIA_CL_DIR");
        if (had_)
            ::setenv("IRRADIA_KERNEL_CACHE", before_.c_str(), 1);
        else
            ::unsetenv("IRRADIA_KERNEL_CACHE");
        fs::remove_all(root_);
    }

    [[nodiscard]] fs::path cache() const { return root_ / "kernels"; }
    [[nodiscard]] fs::path sources() const { return root_ / "cl"; }
    void source(const std::string& value) const {
        std::ofstream(sources() / "constant.cl")
            << "__kernel void constant_kernel(__global uint* out) { out[get_global_id(0)] = IR_FACTOR * " << value
            << "u; }\n";
    }

    /// What the kernel writes, by a device of its own.
    static std::uint32_t run(const std::string& factor = "1") {
        Device device({});
        return run(device, factor);
    }
    static std::uint32_t run(Device& device, const std::string& factor) {
        Buffer out = device.allocate(16 * sizeof(std::uint32_t));
        device.kernel("constant.cl", "constant_kernel", {{"IR_FACTOR", factor + "u"}}).arg(out).run(1, 16);
        std::uint32_t value = 0;
        device.read(out, &value, sizeof value);
        return value;
    }

    [[nodiscard]] std::vector<fs::path> files() const {
        std::vector<fs::path> list;
        if (fs::exists(cache()))
            for (const auto& entry : fs::directory_iterator(cache())) list.push_back(entry.path());
        std::sort(list.begin(), list.end());
        return list;
    }
    static std::string bytes(const fs::path& path) {
        std::ifstream in(path, std::ios::binary);
        return {std::istreambuf_iterator<char>(in), {}};
    }
    static void write(const fs::path& path, const std::string& text) {
        std::ofstream(path, std::ios::binary).write(text.data(), static_cast<std::streamsize>(text.size()));
    }

private:
    fs::path root_ = fs::temp_directory_path() / ("irradia-programs-" + std::to_string(::getpid()));
    std::string before_;
    bool had_ = false;
};

TEST_F(ProgramCache, KeepsWhatWasCompiledAndUsesIt) {
    EXPECT_EQ(run(), 7u);
    ASSERT_EQ(files().size(), 1u);
    const fs::path file = files()[0];
    const auto written = fs::last_write_time(file);
    EXPECT_EQ(run(), 7u);  // a program that came from the cache is not stored again
    ASSERT_EQ(files().size(), 1u);
    EXPECT_EQ(fs::last_write_time(file), written);
}

// Those that are kept are there once they are expected, though their files are gone; one that is damaged is compiled.
TEST_F(ProgramCache, LoadsWhatIsExpectedAtOnce) {
    Device device({});
    if (device.host_threads() < 2) GTEST_SKIP() << "one thread loads them when they are asked for";
    std::vector<irradia::KernelSource> expected;
    for (const std::string factor : {"1", "2", "3", "2"}) {
        EXPECT_EQ(run(factor), 7 * static_cast<std::uint32_t>(std::stoul(factor)));
        expected.push_back({"constant.cl", {{"IR_FACTOR", factor + "u"}}});
    }
    ASSERT_EQ(files().size(), 3u);
    write(files()[0], "damaged");
    device.expect(expected);
    for (const fs::path& file : files()) fs::remove(file);
    source("5");  // which only what is not there yet is compiled of
    int loaded = 0, compiled = 0;
    for (const std::uint32_t factor : {1u, 2u, 3u}) {
        const std::uint32_t value = run(device, std::to_string(factor));
        loaded += value == 7 * factor ? 1 : 0;
        compiled += value == 5 * factor ? 1 : 0;
    }
    EXPECT_EQ(loaded, 2);
    EXPECT_EQ(compiled, 1);
}

// A text that declares its built-ins but uses others, and one that does not: PoCL's compiler reads OpenCL's header
// then.
TEST_F(ProgramCache, WhatDeclaresTooFewBuiltinsIsCompiledWithTheHeader) {
    const std::string declares =
        "#ifdef IR_OWN_BUILTINS\nfloat __attribute__((overloadable, const)) sqrt(float);\n#endif\n";
    const auto kernel = [](const std::string& f) {
        return "__kernel void k(__global float* a) { a[0] = " + f + "(a[0]); }\n";
    };
    const auto built = [&](const std::string& text, float expected) {
        write(sources() / "k.cl", text);
        Device device({});
        float value = 4.0f;
        Buffer a = device.upload(&value, sizeof value);
        device.kernel("k.cl", "k", {}).arg(a).run(1, 1);
        device.read(a, &value, sizeof value);
        EXPECT_NEAR(value, expected, 1e-6f);
        if (device.description().platform != "Portable Computing Language") return false;
        return device.stage_times().count("build with header") != 0;
    };
    EXPECT_FALSE(built(kernel("sqrt"), 2.0f));
    EXPECT_FALSE(built(declares + kernel("sqrt"), 2.0f));
    const bool pocl = Device({}).description().platform == "Portable Computing Language";
    EXPECT_EQ(built(declares + kernel("log2"), 2.0f), pocl);
    EXPECT_EQ(files().size(), 3u);
    EXPECT_EQ(built(declares + kernel("log2"), 2.0f), false);  // kept
}

TEST_F(ProgramCache, TellsSourcesAndOptionsApart) {
    EXPECT_EQ(run(), 7u);
    EXPECT_EQ(run("3"), 21u);
    source("5");
    EXPECT_EQ(run(), 5u);
    EXPECT_EQ(run("3"), 15u);
    EXPECT_EQ(files().size(), 4u);
    source("7");
    EXPECT_EQ(run(), 7u);
    EXPECT_EQ(files().size(), 4u);
}

TEST_F(ProgramCache, DamagedFilesAreCompiledAnew) {
    EXPECT_EQ(run(), 7u);
    ASSERT_EQ(files().size(), 1u);
    const fs::path file = files()[0];
    const std::string whole = bytes(file);
    ASSERT_GT(whole.size(), 100u);
    std::vector<std::string> damaged{"", whole.substr(0, 10), whole.substr(0, whole.size() / 2),
                                     std::string(whole.size(), 'x')};
    for (const std::size_t at : {std::size_t{0}, std::size_t{9}, std::size_t{17}, std::size_t{25}, whole.size() / 2,
                                 whole.size() - 1}) {  // each field of the header, and the binary
        damaged.push_back(whole);
        damaged.back()[at] = static_cast<char>(damaged.back()[at] ^ 4);
    }
    for (const std::string& text : damaged) {
        write(file, text);
        EXPECT_EQ(run(), 7u);
        EXPECT_EQ(bytes(file).size(), whole.size());  // and stored again
    }
    write(file, "");
    source("5");
    EXPECT_EQ(run(), 5u);
    fs::rename(files()[0] == file ? files()[1] : files()[0], file);  // another program's under this one's name
    source("7");
    EXPECT_EQ(run(), 7u);
}

// What came with the installation is used where the user's own folder has nothing, and is left as it is.
TEST_F(ProgramCache, ShippedProgramsAreUsed) {
    EXPECT_EQ(run(), 7u);
    const fs::path shipped = sources() / "shipped", file = shipped / files().at(0).filename();
    fs::rename(cache(), shipped);
    const std::string whole = bytes(file);
    EXPECT_EQ(run(), 7u);  // by default there are none beside this executable's folder
    ASSERT_EQ(files().size(), 1u);
    fs::remove_all(cache());
    ::setenv("IRRADIA_SHIPPED_KERNELS", shipped.c_str(), 1);
    EXPECT_EQ(run(), 7u);
    EXPECT_TRUE(files().empty());
    EXPECT_EQ(run("3"), 21u);  // another one
    EXPECT_EQ(files().size(), 1u);
    write(file, whole.substr(0, whole.size() / 2));
    EXPECT_EQ(run(), 7u);
    EXPECT_EQ(files().size(), 2u);
    ::setenv("IRRADIA_SHIPPED_KERNELS", "", 1);
    EXPECT_EQ(run(), 7u);
    ::unsetenv("IRRADIA_SHIPPED_KERNELS");
    EXPECT_EQ(bytes(file).size(), whole.size() / 2);
}

TEST_F(ProgramCache, NothingIsKeptWhereNothingCanBe) {
    ::setenv("IRRADIA_KERNEL_CACHE", "", 1);
    EXPECT_EQ(run(), 7u);
    EXPECT_TRUE(files().empty());
    ::setenv("IRRADIA_KERNEL_CACHE", "/proc/nowhere", 1);
    EXPECT_EQ(run(), 7u);
}

}  // namespace
