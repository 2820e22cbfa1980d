// Kernels compiled by processes that render starts (src/device/compilers.h): the same ones, nothing else, and nothing
// of them is left behind.
#include <signal.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <functional>
#include <set>
#include <thread>

#include "command.h"
#include "irradia/Device.h"

namespace irradia {
namespace {

using Arguments = std::vector<std::string>;
namespace fs = std::filesystem;

class CompileCommand : public test::CommandTest {
protected:
    void SetUp() override {
        CommandTest::SetUp();
        if (std::thread::hardware_concurrency() < 2) GTEST_SKIP() << "one processor: no other process is started";
        for (const char* name : {"IRRADIA_KERNEL_CACHE", "POCL_CACHE_DIR", "IRRADIA_SHIPPED_KERNELS"}) {
            const char* value = std::getenv(name);
            before_.emplace_back(name, value != nullptr ? std::optional<std::string>(value) : std::nullopt);
        }
        ::setenv("IRRADIA_SHIPPED_KERNELS", "", 1);
    }
    void TearDown() override {
        for (const auto& [name, value] : before_)
            value ? ::setenv(name.c_str(), value->c_str(), 1) : ::unsetenv(name.c_str());
        CommandTest::TearDown();
    }

    void empty_kernels(const std::string& name) {
        kernels_ = in_folder(name + ".kernels");
        ::setenv("IRRADIA_KERNEL_CACHE", kernels_.c_str(), 1);
    }
    /// For processes alone: PoCL keeps to the folder that it has found at first.
    void empty_caches(const std::string& name) {
        empty_kernels(name);
        driver_ = in_folder(name + ".driver");
        fs::create_directory(driver_);
        ::setenv("POCL_CACHE_DIR", driver_.c_str(), 1);
    }
    [[nodiscard]] static std::set<std::string> names_in(const std::string& folder) {
        std::set<std::string> names;
        if (fs::exists(folder))
            for (const auto& entry : fs::directory_iterator(folder)) names.insert(entry.path().filename());
        return names;
    }
    /// Sources and the like that PoCL keeps while it compiles. (An empty file is left by every process that opens it.)
    [[nodiscard]] std::vector<std::string> driver_litter() const {
        std::vector<std::string> found;
        std::error_code gone;
        for (const std::string& name : names_in(driver_))
            if (name.find("temp") != std::string::npos && fs::file_size(driver_ + "/" + name, gone) > 0 && !gone)
                found.push_back(name);
        return found;
    }

    [[nodiscard]] static Arguments small(const Arguments& more) {
        Arguments all{std::string(IRRADIA_SOURCE_DIR) + "/scenes/" + more.front(),
                      "--width",
                      "16",
                      "--spp",
                      "1",
                      "--hemisphere",
                      "4x16",
                      "--grid-paths",
                      "1024"};
        all.insert(all.end(), more.begin() + 1, more.end());
        return all;
    }
    /// No program took OpenCL's header (device/compile_program.h) of those that the render itself compiled.
    static void expect_own_builtins(const std::string& statistics) {
        const std::string text = test::file_text(statistics);
        EXPECT_NE(text.find("\"build\""), std::string::npos) << statistics;
        EXPECT_EQ(text.find("build with header"), std::string::npos) << statistics;
    }
    /// What `threads` = 1 compiles itself, in turn, 2 has compiled: the same kernels for the same picture.
    void expect_same(const std::string& scene, const std::string& method) {
        std::set<std::string> kernels[2];
        for (const int threads : {1, 2}) {
            const std::string n = std::to_string(threads);
            empty_caches(method + n);
            const test::Outcome outcome =
                call(RENDER, small({scene, "--method", method, "--threads", n, "-o", n + ".pfm", "--stats", n}));
            EXPECT_EQ(outcome.status, 0) << outcome.err;
            expect_own_builtins(in_folder(n));
            kernels[threads - 1] = names_in(kernels_);
        }
        EXPECT_GE(kernels[0].size(), 5u);
        EXPECT_EQ(kernels[0], kernels[1]) << scene << ", " << method;
        EXPECT_EQ(test::file_text(in_folder("1.pfm")), test::file_text(in_folder("2.pfm"))) << scene;
    }

    /// Starts render in a group of its own.
    [[nodiscard]] static pid_t start(const Arguments& arguments) {
        const pid_t child = ::fork();
        if (child != 0) return child;
        ::setpgid(0, 0);
        Arguments words = arguments;
        words.insert(words.begin(), RENDER);
        std::vector<char*> argv;
        for (std::string& word : words) argv.push_back(word.data());
        argv.push_back(nullptr);
        if (std::freopen("/dev/null", "w", stderr) == nullptr) ::_exit(126);
        ::execv(RENDER, argv.data());
        ::_exit(127);
    }
    static bool within(double seconds, const std::function<bool()>& true_then) {
        const auto end = std::chrono::steady_clock::now() + std::chrono::duration<double>(seconds);
        while (!true_then()) {
            if (std::chrono::steady_clock::now() > end) return false;
            std::this_thread::sleep_for(std::chrono::milliseconds(5));
        }
        return true;
    }
    /// Processes that compile for `parent`.
    [[nodiscard]] static std::vector<pid_t> compilers_of(pid_t parent) {
        std::vector<pid_t> found;
        for (const auto& entry : fs::directory_iterator("/proc")) {
            const std::string name = entry.path().filename();
            if (name.find_first_not_of("0123456789") != std::string::npos) continue;
            const std::string status = test::file_text(entry.path() / "status");
            if (status.find("PPid:\t" + std::to_string(parent) + "\n") != std::string::npos &&
                test::file_text(entry.path() / "cmdline").find(kCompileForParent) != std::string::npos)
                found.push_back(std::stoi(name));
        }
        return found;
    }
    [[nodiscard]] static bool runs(pid_t process) {
        const std::string status = test::file_text("/proc/" + std::to_string(process) + "/status");
        return !status.empty() && status.find("State:\tZ") == std::string::npos;
    }

    std::string kernels_, driver_;

private:
    std::vector<std::pair<std::string, std::optional<std::string>>> before_;
};

TEST_F(CompileCommand, CompilesWhatIrradianceWants) { expect_same("cornell-box.xml", "irradiance"); }
TEST_F(CompileCommand, CompilesWhatRadianceWants) { expect_same("glossy-box.xml", "radiance"); }

// Every program of every method, with all features: a built-in that cl/builtins_cpu.h lacks would cost each first run.
TEST_F(CompileCommand, DeclaresAllBuiltinsThatItUses) {
    const std::vector<Arguments> runs{
        {"cornell-box.xml", "--method", "path", "--report-error"},
        {"cornell-box.xml", "--method", "gather"},
        {"cornell-box.xml", "--gradients", "ward", "--no-specialise"},
        {"glossy-box.xml", "--method", "radiance", "--glossy", "harmonics", "--no-specialise"}};
    for (std::size_t i = 0; i < runs.size(); ++i) {
        empty_caches("b" + std::to_string(i));
        Arguments all = small(runs[i]);
        const std::string statistics = std::to_string(i) + ".json";
        for (const std::string more : {"--threads", "1", "-o", "b.pfm", "--stats", statistics.c_str()})
            all.push_back(more);
        const test::Outcome outcome = call(RENDER, all);
        EXPECT_EQ(outcome.status, 0) << outcome.err;
        expect_own_builtins(in_folder(statistics));
    }
}

// Without a kernel being asked for, so that it is the others who have compiled; what then asks finds it.
TEST_F(CompileCommand, OtherProcessesCompile) {
    empty_kernels("k");
    DeviceOptions options;
    options.compiler = RENDER;
    Device device(options);
    const KernelSource sums{"echo_sizes.cl", {}};
    device.expect({sums, {"echo_sizes.cl", {{"IR_OTHER", "1"}}}, sums});
    EXPECT_TRUE(within(60, [&] { return names_in(kernels_).size() == 2; }));
    device.kernel(sums.file, "echo_sizes", sums.defines);
    EXPECT_EQ(names_in(kernels_).size(), 2u);
}

TEST_F(CompileCommand, CompilesItselfWhereOthersCannot) {
    for (const std::string executable : {"/bin/false", "/nowhere", RENDER}) {
        empty_kernels("k" + std::to_string(executable.size()));
        DeviceOptions options;
        options.compiler = executable;
        if (executable == RENDER) options.memory_limit = std::uint64_t{64} << 30;  // which does not count them
        Device device(options);
        const std::vector<KernelSource> both{{"echo_sizes.cl", {}}, {"echo_sizes.cl", {{"IR_OTHER", "1"}}}};
        device.expect(both);
        device.kernel(both[0].file, "echo_sizes", both[0].defines);
        EXPECT_EQ(device.stage_times().at("build").launches, 1u);
        EXPECT_TRUE(names_in(kernels_).empty()) << executable;  // this process stores at its end
    }
}

TEST_F(CompileCommand, GoWithTheirParent) {
    empty_caches("g");
    const pid_t parent = start(small({"cornell-box.xml", "--threads", "2", "-o", in_folder("x.pfm")}));
    std::vector<pid_t> compilers;
    const bool met = within(60, [&] { return (compilers = compilers_of(parent)).size() == 2 || !runs(parent); });
    ::kill(parent, SIGKILL);
    int status = 0;
    ::waitpid(parent, &status, 0);
    ASSERT_TRUE(met && compilers.size() == 2);
    for (const pid_t process : compilers) EXPECT_TRUE(within(10, [&] { return !runs(process); }));
}

// A signal to the whole group, as a terminal sends it: they finish what they are at.
TEST_F(CompileCommand, LeaveNothingWhenStopped) {
    for (const int signal : {SIGINT, SIGTERM}) {
        empty_caches("s" + std::to_string(signal));
        const pid_t parent = start(small({"cornell-box.xml", "--threads", "2", "-o", in_folder("x.pfm")}));
        std::vector<pid_t> compilers;
        const bool met = within(60, [&] {
            compilers = compilers_of(parent);
            return (compilers.size() == 2 && !driver_litter().empty()) || !runs(parent);
        });
        ::kill(-parent, signal);
        int status = 0;
        ::waitpid(parent, &status, 0);
        ASSERT_TRUE(met && compilers.size() == 2);
        EXPECT_TRUE(WIFEXITED(status) && WEXITSTATUS(status) == 128 + signal) << status;
        for (const pid_t process : compilers) EXPECT_FALSE(runs(process));
        EXPECT_EQ(driver_litter(), std::vector<std::string>{});
        for (const std::string& name : names_in(kernels_)) EXPECT_TRUE(name.ends_with(".program")) << name;
        EXPECT_FALSE(fs::exists(in_folder("x.pfm")));
    }
}

TEST_F(CompileCommand, IsNotForUsers) {
    expect_one_line(call(RENDER, {kCompileForParent}), 2, "render", "expected to be started by render itself");
}

}  // namespace
}  // namespace irradia
