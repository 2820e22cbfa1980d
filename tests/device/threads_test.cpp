// --threads: one thread is one thread, and changes no result.
#include <gtest/gtest.h>
#include <sys/resource.h>

#include <algorithm>
#include <chrono>
#include <cstdint>
#include <string>
#include <vector>

#include "irradia/Device.h"
#include "irradia/Error.h"

namespace {

using irradia::Buffer;
using irradia::Device;
using irradia::Kernel;

double processor_seconds() {
    rusage r{};
    getrusage(RUSAGE_SELF, &r);
    const auto seconds = [](const timeval& t) {
        return static_cast<double>(t.tv_sec) + 1e-6 * static_cast<double>(t.tv_usec);
    };
    return seconds(r.ru_utime) + seconds(r.ru_stime);
}

struct Measured {
    double busy;  // processor seconds a second of wall time
    std::vector<std::uint32_t> result;
};

Measured spin(const std::string& select, int threads) {
    Device device({select, threads, ""});
    constexpr std::size_t groups = 512, size = 64;
    Buffer out = device.allocate(groups * size * 4);
    Kernel k = device.kernel(std::string(IRRADIA_SOURCE_DIR) + "/tests/device/test_kernels.cl", "spin", {});
    k.arg(out).arg(std::uint32_t{1}).run(groups, size);  // compiles
    device.finish();
    const double cpu = processor_seconds();
    const auto start = std::chrono::steady_clock::now();
    k.arg(out).arg(std::uint32_t{10000}).run(groups, size);
    device.finish();
    const double wall = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
    Measured run{(processor_seconds() - cpu) / wall, std::vector<std::uint32_t>(groups * size)};
    device.read(out, run.result.data(), out.bytes());
    return run;
}

TEST(Threads, OneThreadIsOne) {
    std::string cpu;
    unsigned units = 0;
    for (const auto& d : irradia::list_devices())
        if (d.is_cpu && cpu.empty()) cpu = std::to_string(d.index), units = d.compute_units;
    if (cpu.empty() || units < 2) GTEST_SKIP() << "needs a CPU device of two units or more";
    const Measured all = spin(cpu, 0), one = spin(cpu, 1), more = spin(cpu, 1000000), again = spin(cpu, 0);
    // Two busy threads of a loaded machine may get less than two processors, but one thread never more than one.
    EXPECT_LT(one.busy, 1.1);
    EXPECT_GT(std::max(all.busy, again.busy), 0.0);
    EXPECT_EQ(one.result, all.result);
    EXPECT_EQ(more.result, all.result);
    RecordProperty("busy_all", std::to_string(all.busy));
    RecordProperty("busy_one", std::to_string(one.busy));
    std::printf("processors busy: all threads %.2f, one thread %.2f\n", all.busy, one.busy);
}

// Launches of all widths, wider ones after narrower ones: of what PoCL 3.1 keeps for each width, parts of one launch on
// several threads lost count, and the process ended.
TEST(Threads, EveryGroupRunsOnce) {
    for (const int threads : {1, 2, 0}) {
        Device device({"", threads, ""});
        Kernel visit = device.kernel(std::string(IRRADIA_SOURCE_DIR) + "/tests/device/test_kernels.cl", "visit", {});
        for (const std::size_t size : {std::size_t{16}, std::size_t{64}}) {
            for (const std::size_t groups : {1, 3, 100, 7, 1000, 50, 4000, 2, 4001, 8000}) {
                const std::size_t items = groups * size;
                Buffer visits = device.allocate(items * 4), places = device.allocate(items * 4);
                device.fill(visits, 0, items * 4);
                for (int i = 0; i < 3; ++i) visit.arg(visits).arg(places).arg(std::uint32_t{200}).run(groups, size);
                std::vector<std::uint32_t> count(items), place(items);
                device.read(visits, count.data(), items * 4);
                device.read(places, place.data(), items * 4);
                std::size_t wrong = 0;
                for (std::size_t i = 0; i < items; ++i) wrong += count[i] != 3 || place[i] != i;
                EXPECT_EQ(wrong, 0u) << threads << " threads, " << groups << " groups of " << size;
            }
        }
    }
}

TEST(Threads, LargeBuffersAreFilledToTheLastWord) {
    Device device({"", 0, ""});
    for (const std::size_t words : {std::size_t{262144}, std::size_t{262145}, std::size_t{3000001}}) {
        Buffer buffer = device.allocate((words + 1) * 4);
        device.fill(buffer, 7, (words + 1) * 4);
        device.fill(buffer, 0xfedcba98u, words * 4);
        std::vector<std::uint32_t> read(words + 1);
        device.read(buffer, read.data(), read.size() * 4);
        EXPECT_EQ(read.back(), 7u);
        read.pop_back();
        EXPECT_EQ(std::count(read.begin(), read.end(), 0xfedcba98u), static_cast<std::ptrdiff_t>(words));
    }
}

// Threads share out what is larger than 256 kB: to the last byte, and no further, at any offset.
TEST(Threads, LargeBuffersAreWrittenReadAndCopiedToTheLastByte) {
    Device device({"", 0, ""});
    for (const std::size_t bytes : {std::size_t{262144}, std::size_t{262145}, std::size_t{9000001}}) {
        std::vector<unsigned char> data(bytes);
        for (std::size_t i = 0; i < bytes; ++i) data[i] = static_cast<unsigned char>(i * 2654435761u >> 13);
        Buffer a = device.allocate(bytes + 8), b = device.allocate(bytes + 8);
        for (Buffer* buffer : {&a, &b}) device.fill(*buffer, 0xeeeeeeeeu, (bytes + 8) / 4 * 4);
        device.write(a, data.data(), bytes, 3);
        std::vector<unsigned char> read(bytes + 2, 0x55);
        device.read(a, read.data() + 1, bytes, 3);
        EXPECT_TRUE(std::equal(data.begin(), data.end(), read.begin() + 1));
        EXPECT_EQ(read.front(), 0x55);
        EXPECT_EQ(read.back(), 0x55);
        device.copy(a, b, bytes);
        device.finish();
        std::vector<unsigned char> copied(bytes + 3);
        device.read(b, copied.data(), copied.size());
        EXPECT_EQ(std::vector<unsigned char>(copied.begin(), copied.begin() + 3), std::vector<unsigned char>(3, 0xee));
        EXPECT_TRUE(std::equal(copied.begin() + 3, copied.end() - 3, data.begin()));
        EXPECT_EQ(std::vector<unsigned char>(copied.end() - 3, copied.end()), std::vector<unsigned char>(3, 0xee));
    }
}

TEST(Threads, NegativeIsRefused) {
    try {
        Device d({"", -1, ""});
        FAIL();
    } catch (const irradia::Error& e) {
        EXPECT_NE(std::string(e.what()).find("-1"), std::string::npos);
    }
}

}  // namespace
