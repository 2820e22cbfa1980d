// Buffers, launches, local memory, atomics, times, and every way to get them wrong.
#include "irradia/Device.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <future>
#include <memory>
#include <numeric>
#include <string>
#include <utility>
#include <vector>

#include "irradia/Error.h"

namespace {

using irradia::Buffer;
using irradia::Device;
using irradia::Error;
using irradia::Kernel;

const std::string kKernels = std::string(IRRADIA_SOURCE_DIR) + "/tests/device/test_kernels.cl";

/// The message of the Error that `f` throws; "" if it throws none.
template <class F>
std::string error_of(F&& f) {
    try {
        f();
    } catch (const Error& e) {
        return e.what();
    }
    return "";
}

bool one_line(const std::string& s) { return !s.empty() && s.find('\n') == std::string::npos; }
bool has(const std::string& s, const std::string& part) { return s.find(part) != std::string::npos; }

class DeviceTest : public ::testing::Test {
protected:
    Device device{irradia::DeviceOptions{}};

    std::vector<std::uint32_t> words(const Buffer& b, std::size_t count, std::size_t offset = 0) {
        std::vector<std::uint32_t> v(count);
        device.read(b, v.data(), count * 4, offset * 4);
        return v;
    }
};

TEST_F(DeviceTest, WritesReadBack) {
    // One small (copied aside, queued) and one above the staging limit (waited for).
    for (const std::size_t count : {std::size_t{1000}, std::size_t{700000}}) {
        std::vector<std::uint32_t> data(count);
        std::iota(data.begin(), data.end(), 7u);
        Buffer b = device.upload(data);
        EXPECT_EQ(b.bytes(), count * 4);
        EXPECT_EQ(words(b, count), data);
        const std::uint32_t patch[] = {1, 2, 3};
        device.write(b, patch, sizeof patch, 40);
        EXPECT_EQ(words(b, 5, 9), (std::vector<std::uint32_t>{16, 1, 2, 3, 20}));
    }
}

// Kernels see the host's own array, wherever it begins; nothing of it is counted twice.
TEST_F(DeviceTest, SharedMemoryIsReadWhereItLies) {
    constexpr std::uint32_t groups = 64, size = 64;
    std::vector<std::uint32_t> data(groups * size + 3);
    for (const std::size_t from : {0u, 1u, 3u}) {
        std::iota(data.begin(), data.end(), 1u);
        Device fresh{irradia::DeviceOptions{}};
        const Buffer in = fresh.share(data.data() + from, groups * size * 4);
        EXPECT_EQ(in.bytes(), groups * size * 4);
        EXPECT_EQ(fresh.peak_memory(),
                  fresh.description().platform == "Portable Computing Language" ? 0u : groups * size * 4);
        Buffer out = fresh.allocate(groups * 4);
        Kernel k = fresh.kernel(kKernels, "sum_groups", {});
        k.arg(in).arg(out).local(size * 4).run(groups, size);
        std::vector<std::uint32_t> sums(groups);
        fresh.read(out, sums.data(), groups * 4);
        for (std::uint32_t g = 0; g < groups; ++g)
            EXPECT_EQ(sums[g], size * (g * size + from) + size * (size + 1) / 2) << "group " << g;
    }
    EXPECT_EQ(data.front(), 1u);
    EXPECT_GE(device.share(std::vector<float>{}).bytes(), 4u);
}

TEST_F(DeviceTest, QueuedWriteOutlivesItsSource) {
    Buffer b = device.allocate(4000);
    {
        std::vector<std::uint32_t> data(1000, 42u);
        device.write(b, data.data(), 4000);
        std::fill(data.begin(), data.end(), 1u);
    }
    EXPECT_EQ(words(b, 1000), std::vector<std::uint32_t>(1000, 42u));
}

TEST_F(DeviceTest, FillsAndCopies) {
    Buffer a = device.allocate(64), b = device.allocate(64);
    device.fill(a, 5u, 64);
    device.fill(b, 9u, 64);
    device.copy(a, b, 32);
    const auto v = words(b, 16);
    EXPECT_EQ(std::count(v.begin(), v.begin() + 8, 5u), 8);
    EXPECT_EQ(std::count(v.begin() + 8, v.end(), 9u), 8);
}

TEST_F(DeviceTest, EmptyBuffersExist) {
    Buffer b = device.upload(std::vector<float>{});
    EXPECT_GE(b.bytes(), 4u);
    EXPECT_NE(b.handle(), nullptr);
    device.read(b, nullptr, 0);
    EXPECT_EQ(Buffer().handle(), nullptr);
}

TEST_F(DeviceTest, BuffersMoveAndPeakMemoryCounts) {
    const auto before = device.peak_memory();
    Buffer a = device.allocate(1 << 20);
    const void* handle = a.handle();
    Buffer b = std::move(a);
    EXPECT_EQ(b.handle(), handle);
    b = device.allocate(1 << 10);  // the new one exists before the old one goes
    EXPECT_EQ(device.peak_memory(), before + (1 << 20) + (1 << 10));
    Buffer c = device.allocate(1 << 19);  // fits in what was freed
    EXPECT_EQ(device.peak_memory(), before + (1 << 20) + (1 << 10));
}

TEST_F(DeviceTest, SumsInLocalMemory) {
    constexpr std::uint32_t groups = 37, size = 64;
    std::vector<std::uint32_t> data(groups * size);
    std::iota(data.begin(), data.end(), 1u);
    Buffer in = device.upload(data), out = device.allocate(groups * 4);
    Kernel k = device.kernel(kKernels, "sum_groups", {});
    k.arg(in).arg(out).local(size * 4).run(groups, size);
    const auto sums = words(out, groups);
    for (std::uint32_t g = 0; g < groups; ++g)
        EXPECT_EQ(sums[g], size * (g * size) + size * (size + 1) / 2) << "group " << g;  // sum of an arithmetic series
}

TEST_F(DeviceTest, AtomicsCountEveryItem) {
    constexpr std::uint32_t groups = 200, size = 64, bins = 10;
    Buffer counts = device.allocate(bins * 4), extremes = device.allocate(8);
    device.fill(counts, 0, bins * 4);
    const std::uint32_t start[] = {0xffffffffu, 0u};
    device.write(extremes, start, 8);
    Kernel k = device.kernel(kKernels, "histogram", {{"BINS", "10u"}});
    k.arg(counts).arg(extremes).arg(std::uint32_t{5}).run(groups, size);
    EXPECT_EQ(words(counts, bins), std::vector<std::uint32_t>(bins, groups * size / bins));
    EXPECT_EQ(words(extremes, 2), (std::vector<std::uint32_t>{5, groups * size + 4}));
}

TEST_F(DeviceTest, DefinesMakeDifferentPrograms) {
    Buffer out = device.allocate(4);
    for (const char* value : {"3", "4", "3"}) {
        device.kernel(kKernels, "write_value", {{"VALUE", value}}).arg(out).run(1, 1);
        EXPECT_EQ(words(out, 1)[0], static_cast<std::uint32_t>(value[0] - '0'));
    }
    EXPECT_EQ(device.stage_times().at("build").launches, 2u);  // the third came from the cache
}

TEST_F(DeviceTest, TraversalSelectsTheDefine) {
    for (const std::string traversal : {"cpu", "gpu"}) {
        irradia::DeviceOptions options;
        options.traversal = traversal;
        Device d(options);
        EXPECT_EQ(d.cpu_traversal(), traversal == "cpu");
        EXPECT_EQ(d.tile(), traversal == "cpu" ? 16u : 1u);
        EXPECT_EQ(d.group_size(), traversal == "cpu" ? 64u : 256u);
        Buffer out = d.allocate(4);
        d.kernel(kKernels, "write_traversal", {}).arg(out).run(1, 1);
        std::uint32_t got = 9;
        d.read(out, &got, 4);
        EXPECT_EQ(got, traversal == "cpu" ? 1u : 0u);
    }
    irradia::DeviceOptions options;
    options.traversal = "tpu";
    const std::string message = error_of([&] { Device d(options); });
    EXPECT_TRUE(one_line(message) && has(message, "'tpu'")) << message;
}

TEST_F(DeviceTest, StageTimesComeFromTheDevice) {
    Buffer counts = device.allocate(40), extremes = device.allocate(8);
    device.fill(counts, 0, 40);
    device.fill(extremes, 0, 8);
    Kernel k = device.kernel(kKernels, "histogram", {{"BINS", "10u"}});
    for (int i = 0; i < 1000; ++i) k.arg(counts).arg(extremes).arg(std::uint32_t{0}).run(4, 64);  // several harvests
    device.finish();
    const auto times = device.stage_times();
    EXPECT_EQ(times.at("histogram").launches, 1000u);
    EXPECT_GT(times.at("histogram").seconds, 0.0);
    EXPECT_LT(times.at("histogram").seconds, 60.0);
    EXPECT_EQ(times.at("fill").launches, 2u);
    EXPECT_EQ(times.at("build").launches, 1u);
    EXPECT_EQ(times.count("read"), 0u);
}

TEST_F(DeviceTest, BuffersAndKernelsOutliveTheDevice) {
    auto own = std::make_unique<Device>(irradia::DeviceOptions{});
    Buffer b = own->allocate(64);
    Kernel k = own->kernel(kKernels, "write_value", {{"VALUE", "3"}});
    k.arg(b).run(1, 1);
    own.reset();
    EXPECT_EQ(b.bytes(), 64u);
}

TEST_F(DeviceTest, NoGroupsIsNoLaunch) {
    Buffer out = device.allocate(4);
    device.fill(out, 1, 4);
    device.kernel(kKernels, "write_value", {{"VALUE", "3"}}).arg(out).run(0, 64);
    EXPECT_EQ(words(out, 1)[0], 1u);
}

// ---- what can go wrong ------------------------------------------------------------------------------------------

TEST_F(DeviceTest, UnknownFileAndKernelListWhatThereIs) {
    const std::string no_file = error_of([&] { device.kernel("no_such.cl", "x", {}); });
    EXPECT_TRUE(one_line(no_file) && has(no_file, "no_such.cl") && has(no_file, "echo_sizes.cl")) << no_file;
    const std::string no_kernel = error_of([&] { device.kernel("echo_sizes.cl", "no_such", {}); });
    EXPECT_TRUE(one_line(no_kernel) && has(no_kernel, "no_such") && has(no_kernel, "there are: echo_sizes"))
        << no_kernel;
}

TEST_F(DeviceTest, CompilerLogNamesFileAndLine) {
    const std::string message = error_of([&] { device.kernel(kKernels, "broken", {{"BREAK", "1"}}); });
    EXPECT_TRUE(has(message, "test_kernels.cl:8:")) << message;  // the line of the mistake, after an #include
    EXPECT_TRUE(has(message, "no_such_variable")) << message;
    EXPECT_TRUE(has(message, "-D BREAK=1")) << message;
    EXPECT_TRUE(one_line(message.substr(0, message.find('\n'))));
}

TEST_F(DeviceTest, WrongNumberOfArguments) {
    Buffer out = device.allocate(4);
    Kernel k = device.kernel(kKernels, "write_value", {{"VALUE", "3"}});
    const std::string few = error_of([&] { k.run(1, 1); });
    EXPECT_TRUE(one_line(few) && has(few, "takes 1") && has(few, "0 were set")) << few;
    const std::string many = error_of([&] { k.arg(out).arg(out); });
    EXPECT_TRUE(one_line(many) && has(many, "write_value") && has(many, "CL_INVALID_ARG_INDEX")) << many;
    Kernel empty = device.kernel(kKernels, "write_value", {{"VALUE", "3"}});
    const std::string never = error_of([&] { empty.arg(Buffer()); });
    EXPECT_TRUE(one_line(never) && has(never, "never allocated")) << never;
}

TEST_F(DeviceTest, TooLargeAGroup) {
    Buffer out = device.allocate(4);
    Kernel k = device.kernel(kKernels, "write_value", {{"VALUE", "3"}});
    const std::string message = error_of([&] { k.arg(out).run(1, std::size_t{1} << 24); });
    EXPECT_TRUE(one_line(message) && has(message, "16777216")) << message;
}

TEST_F(DeviceTest, TooMuchMemoryNamesBytes) {
    const std::size_t bytes = std::size_t{1} << 50;
    const std::string message = error_of([&] { device.allocate(bytes); });
    EXPECT_TRUE(one_line(message) && has(message, "1125899906842624 bytes") && has(message, "--device")) << message;
    EXPECT_TRUE(has(message, "one buffer may have")) << message;
    EXPECT_EQ(device.peak_memory(), 0u);
}

TEST_F(DeviceTest, RangesAreChecked) {
    Buffer b = device.allocate(16), large = device.allocate(64);
    char data[64] = {};
    for (const std::string& message :
         {error_of([&] { device.write(b, data, 8, 12); }), error_of([&] { device.read(b, data, 17); }),
          error_of([&] { device.read(b, data, 4, ~std::size_t{0}); }), error_of([&] { device.copy(large, b, 20); }),
          error_of([&] { device.copy(b, large, 20); }), error_of([&] { device.fill(b, 0, 20); }),
          error_of([&] { device.fill(b, 0, 6); })})
        EXPECT_TRUE(one_line(message) && has(message, "device memory")) << message;
}

TEST(SelectDevice, ByIndexNameAndPlatform) {
    const auto list = irradia::list_devices();
    ASSERT_FALSE(list.empty());
    for (const auto& d : list) {
        EXPECT_FALSE(d.name.empty());
        EXPECT_FALSE(d.platform.empty());
        EXPECT_GT(d.compute_units, 0u);
        EXPECT_GT(d.global_memory, 0u);
        EXPECT_EQ(Device({std::to_string(d.index), 0, ""}).description().name, d.name);
    }
    std::string upper = list[0].name.substr(0, 5);
    std::transform(upper.begin(), upper.end(), upper.begin(),
                   [](unsigned char c) { return static_cast<char>(std::toupper(c)); });
    EXPECT_EQ(Device({upper, 0, ""}).description().index, 0);
    EXPECT_EQ(Device({list[0].platform, 0, ""}).description().index, 0);
}

TEST(SelectDevice, WrongNameListsDevices) {
    const auto list = irradia::list_devices();
    for (const std::string select : {"no such thing", "99", "123456789012345678901234567890"}) {
        const std::string message = error_of([&] { Device d({select, 0, ""}); });
        EXPECT_TRUE(one_line(message) && has(message, "'" + select + "'")) << message;
        for (const auto& d : list) EXPECT_TRUE(has(message, d.name)) << message;
    }
}

TEST(SelectDevice, OpensAhead) {
    std::future<std::unique_ptr<Device>> there = Device::open_ahead({}), not_there = Device::open_ahead({"99", 0, ""});
    const std::unique_ptr<Device> device = there.get();
    Buffer out = device->upload(std::vector<std::uint32_t>{3, 4, 5});
    std::uint32_t last = 0;
    device->read(out, &last, 4, 8);
    EXPECT_EQ(last, 5u);
    EXPECT_TRUE(has(error_of([&] { not_there.get(); }), "'99'"));
}

// In a process of its own, whose OpenCL loader finds no driver: the loader looks once a process.
TEST(NoDeviceDeathTest, NamesThePackageToInstall) {
    ::testing::GTEST_FLAG(death_test_style) = "threadsafe";
    ::setenv("OCL_ICD_VENDORS", "/nonexistent/", 1);
    EXPECT_EXIT(
        {
            const std::string message = error_of([] { Device d({}); });
            std::fprintf(stderr, "%s\n", message.c_str());
            std::exit(one_line(message) ? 3 : 4);
        },
        ::testing::ExitedWithCode(3), "no OpenCL platform found .*pocl-opencl-icd");
    ::unsetenv("OCL_ICD_VENDORS");
}

}  // namespace
