// Damaged meshes and pictures give a scene or an Error of one line; no crash, nothing that a sanitizer reports, no long
// time, no allocation out of proportion. Variants come from a fixed seed, so that a failure comes again; a crash leaves
// the folder with the file that was read last.
#include <OpenImageIO/imageio.h>
#include <gtest/gtest.h>
#include <tbb/global_control.h>
#include <unistd.h>

#include <chrono>
#include <filesystem>
#include <fstream>

#include "damaged_files.h"
#include "irradia/Error.h"
#include "irradia/SceneLoader.h"

// Libraries keep things until the process ends, so leaks are not looked for. A single allocation of more than 400 MB is
// a failure: no file of this test is larger than some kilobytes.
extern "C" const char* __asan_default_options() {
    return "detect_leaks=0:max_allocation_size_mb=400:quarantine_size_mb=32";
}

namespace irradia::test {
namespace {

constexpr int kVariants = 400, kPictureVariants = 250;  // pictures: OpenImageIO allocates 64 MiB for each
constexpr double kSeconds = 5;  // of one file of some kilobytes; usually it is a thousandth of that

class LoaderFuzz : public ::testing::Test {
protected:
    LoaderFuzz() : folder_(std::filesystem::temp_directory_path() / ("irradia-fuzz-" + std::to_string(::getpid()))) {
        std::filesystem::create_directories(folder_);
        OIIO::attribute("threads", 1);
        OIIO::attribute("exr_threads", -1);
    }
    ~LoaderFuzz() override { std::filesystem::remove_all(folder_); }

    void write(const std::string& name, const std::string& bytes) const {
        std::ofstream(folder_ / name, std::ios::binary) << bytes;
    }

    /// What came of it: "" a scene, otherwise the Error's message.
    std::string load(const Sample& sample, const std::string& bytes) const {
        write(sample.name, bytes);
        std::string element = sample.element;
        element.replace(element.find("$FILE"), 5, sample.name);
        write("scene.xml", "<scene version=\"3.0.0\"><sensor type=\"perspective\"/><emitter type=\"constant\"/>" +
                               element + "</scene>");
        const auto began = std::chrono::steady_clock::now();
        std::string message;
        try {
            const Scene scene = load_scene((folder_ / "scene.xml").string());
            EXPECT_FALSE(scene.triangles.empty());
        } catch (const Error& error) {
            message = error.what();
            EXPECT_FALSE(message.empty());
            EXPECT_EQ(message.find('\n'), std::string::npos) << message;
            for (const char c : message) EXPECT_TRUE(static_cast<unsigned char>(c) >= 32 && c != 127) << message;
        } catch (const std::exception& error) {
            ADD_FAILURE() << "another exception: " << error.what();
        }
        const std::chrono::duration<double> time = std::chrono::steady_clock::now() - began;
        EXPECT_LT(time.count(), kSeconds);
        return message;
    }

    std::filesystem::path folder_;
    // Files this small are read by one thread anyway; to start and end others, which the sanitizer watches, would take
    // most of the time.
    tbb::global_control one_thread_{tbb::global_control::max_allowed_parallelism, 1};
};

TEST_F(LoaderFuzz, DamagedFiles) {
    for (const Sample& sample : samples(folder_.string())) {
        ASSERT_EQ(load(sample, sample.bytes), "") << sample.name;  // whole, it is read
        const int variants = sample.element.find("texture") == std::string::npos ? kVariants : kPictureVariants;
        int refused = 0;
        for (int i = 0; i < variants; ++i) {
            std::mt19937 random(static_cast<std::uint32_t>(i));
            std::string bytes = sample.bytes;
            if (sample.inside && i % 2)
                bytes = sample.inside([&](std::string& inside) { damage(inside, random); });
            else
                damage(bytes, random);
            SCOPED_TRACE(sample.name + ", variant " + std::to_string(i));
            refused += !load(sample, bytes).empty();
            if (HasFailure()) return;
        }
        // If nearly all were refused, or hardly any, the damage would be no test.
        EXPECT_GT(refused, variants / 20) << sample.name;
        EXPECT_LT(refused, variants) << sample.name;
        RecordProperty(sample.name, refused);
    }
}

// Cut off at many lengths, small ones all.
TEST_F(LoaderFuzz, TruncatedFiles) {
    for (const Sample& sample : samples(folder_.string()))
        for (std::size_t size = 0; size < sample.bytes.size(); size += 1 + sample.bytes.size() / 150) {
            SCOPED_TRACE(sample.name + ", " + std::to_string(size) + " bytes of " +
                         std::to_string(sample.bytes.size()));
            load(sample, sample.bytes.substr(0, size));
            if (HasFailure()) return;
        }
}

}  // namespace
}  // namespace irradia::test
