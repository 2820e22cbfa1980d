// Rendering small scenes in tests.
#pragma once
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <map>
#include <string>
#include <vector>

#include "irradia/Accel.h"
#include "irradia/Renderer.h"
#include "irradia/SceneLoader.h"

namespace irradia::test {

inline Scene load(const std::string& path, std::map<std::string, std::string> defines = {}, int width = 0,
                  int height = 0) {
    LoadOptions options;
    options.defines = std::move(defines);
    options.width = width;
    options.height = height;
    Scene scene = load_scene(path, options);
    build_accel(scene);
    return scene;
}

inline std::string project_scene(const std::string& name) {
    return std::string(IRRADIA_SOURCE_DIR) + "/scenes/" + name;
}
inline std::string test_data(const std::string& name) {
    return std::string(IRRADIA_SOURCE_DIR) + "/tests/data/" + name;
}

/// A scene written as XML text.
inline Scene load_text(const std::string& xml) {
    static int number = 0;
    const std::filesystem::path path =
        std::filesystem::temp_directory_path() /
        ("irradia-render-test-" + std::to_string(::getpid()) + "-" + std::to_string(number++) + ".xml");
    std::ofstream(path) << xml;
    Scene scene = load(path.string());
    std::filesystem::remove(path);
    return scene;
}

/// Mean and standard error of a picture's channel, pixels taken as independent.
struct Mean {
    double mean = 0, error = 0, lowest = 0, highest = 0;
};
inline Mean channel_mean(const Image& image, int channel, std::size_t layer = 0) {
    const Layer& l = image.layers.at(layer);
    Mean m;
    double sum = 0, square = 0;
    const std::size_t n = l.data.size() / static_cast<std::size_t>(l.channels);
    m.lowest = 1e300;
    m.highest = -1e300;
    for (std::size_t i = 0; i < n; ++i) {
        const double x =
            static_cast<double>(l.data[i * static_cast<std::size_t>(l.channels) + static_cast<std::size_t>(channel)]);
        sum += x;
        square += x * x;
        m.lowest = std::min(m.lowest, x);
        m.highest = std::max(m.highest, x);
    }
    m.mean = sum / static_cast<double>(n);
    m.error = std::sqrt(std::max(square / static_cast<double>(n) - m.mean * m.mean, 0.0) / static_cast<double>(n));
    return m;
}

inline RenderResult run(const Scene& scene, RenderSettings settings, DeviceOptions options = {}) {
    Device device(options);
    return render(scene, device, settings);
}

}  // namespace irradia::test
