// --threads: one thread is one thread, and changes no result.
#include <gtest/gtest.h>
#include <sys/resource.h>

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

TEST(Threads, NegativeIsRefused) {
    try {
        Device d({"", -1, ""});
        FAIL();
    } catch (const irradia::Error& e) {
        EXPECT_NE(std::string(e.what()).find("-1"), std::string::npos);
    }
}

}  // namespace
