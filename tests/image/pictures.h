// Pictures the image tests are made of, and a folder of their own to write to.
#pragma once
#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <functional>
#include <random>
#include <string>

#include "irradia/Image.h"

namespace irradia::test {

/// Picture whose channel c at (x, y) is value(x, y, c).
inline Image picture(int width, int height, const std::function<double(int, int, int)>& value) {
    Image image{width, height, {{"", 3, {}}}, {}};
    for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x)
            for (int c = 0; c < 3; ++c) image.layers[0].data.push_back(static_cast<float>(value(x, y, c)));
    return image;
}

/// Adds independent normal noise of the given standard deviation to the beauty layer.
inline Image noisy(Image image, double deviation, unsigned seed) {
    std::mt19937 generator(seed);
    std::normal_distribution<double> noise(0, deviation);
    for (float& value : image.layers[0].data) value = static_cast<float>(value + noise(generator));
    return image;
}

/// A test in an empty folder, removed afterwards.
class InFolder : public testing::Test {
protected:
    void SetUp() override {
        const auto* info = testing::UnitTest::GetInstance()->current_test_info();
        folder_ = std::filesystem::temp_directory_path() /
                  (std::string("irradia ") + info->name() + " " + std::to_string(::getpid()));
        std::filesystem::create_directories(folder_);
    }
    void TearDown() override { std::filesystem::remove_all(folder_); }
    [[nodiscard]] std::string in_folder(const std::string& name) const { return (folder_ / name).string(); }
    [[nodiscard]] std::size_t files() const {
        std::size_t n = 0;
        for ([[maybe_unused]] const auto& entry : std::filesystem::directory_iterator(folder_)) ++n;
        return n;
    }
    std::filesystem::path folder_;
};

}  // namespace irradia::test
