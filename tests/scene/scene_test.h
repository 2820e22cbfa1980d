// A folder of its own for every test, and scenes written into it.
#pragma once
#include <gtest/gtest.h>
#include <unistd.h>

#include <array>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

#include "irradia/Error.h"
#include "irradia/SceneLoader.h"

namespace irradia::test {

using Vec = std::array<double, 3>;

inline Vec operator-(const Vec& a, const Vec& b) { return {a[0] - b[0], a[1] - b[1], a[2] - b[2]}; }
inline double dot(const Vec& a, const Vec& b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }
inline Vec cross(const Vec& a, const Vec& b) {
    return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}
inline double length(const Vec& a) { return std::sqrt(dot(a, a)); }
inline Vec unit(const Vec& a) {
    const double l = length(a);
    return {a[0] / l, a[1] / l, a[2] / l};
}
inline void expect_near(const Vec& found, const Vec& expected, double tolerance) {
    for (std::size_t i = 0; i < 3; ++i) EXPECT_NEAR(found[i], expected[i], tolerance) << "component " << i;
}

class SceneTest : public ::testing::Test {
protected:
    void SetUp() override {
        const auto* info = ::testing::UnitTest::GetInstance()->current_test_info();
        std::string name = std::string(info->test_suite_name()) + "." + info->name();
        for (char& c : name)
            if (c == '/') c = '_';
        folder_ = std::filesystem::temp_directory_path() / ("irradia-" + std::to_string(::getpid()) + "-" + name);
        std::filesystem::create_directories(folder_);
    }
    void TearDown() override { std::filesystem::remove_all(folder_); }

    std::string write(const std::string& name, const std::string& text) {
        const auto path = folder_ / name;
        std::filesystem::create_directories(path.parent_path());
        std::ofstream(path, std::ios::binary) << text;
        return path.string();
    }
    [[nodiscard]] std::string path(const std::string& name) const { return (folder_ / name).string(); }

    /// Loads <scene> with `body` inside; warnings go to warnings_.
    Scene load(const std::string& body, const LoadOptions& options = {}) {
        return load_file(write("scene.xml", "<scene version=\"3.0.0\">\n" + body + "\n</scene>\n"), options);
    }
    Scene load_file(const std::string& file, LoadOptions options = {}) {
        warnings_.clear();
        options.warn = [this](const std::string& line) { warnings_.push_back(line); };
        return load_scene(file, options);
    }
    /// The message of the Error that loading `body` throws; its line 1 is <scene>, so `body` starts on line 2.
    std::string error(const std::string& body, const LoadOptions& options = {}) {
        return error_of([&] { load(body, options); });
    }
    template <class F>
    static std::string error_of(const F& f) {
        try {
            f();
        } catch (const Error& e) {
            return e.what();
        }
        ADD_FAILURE() << "nothing was thrown";
        return "";
    }
    static LoadOptions lenient() {
        LoadOptions options;
        options.lenient = true;
        return options;
    }

    std::filesystem::path folder_;
    std::vector<std::string> warnings_;
};

/// `text` has every one of `parts`, and is one line.
inline void expect_message(const std::string& text, const std::vector<std::string>& parts) {
    for (const auto& part : parts)
        EXPECT_NE(text.find(part), std::string::npos) << "'" << part << "' is not in: " << text;
    EXPECT_EQ(text.find('\n'), std::string::npos) << text;
}

/// Outside the shapes that the tests place around the origin; looks at them.
inline const std::string sensor =
    R"(<sensor type="perspective"><float name="fov" value="40"/><transform name="to_world"><translate z="-9"/></transform></sensor>)";
inline const std::string lamp = R"(<shape type="rectangle" id="lamp"><emitter type="area"/></shape>)";
inline const std::string tetrahedron = R"(ply
format ascii 1.0
element vertex 4
property float x
property float y
property float z
element face 4
property list uchar int vertex_indices
end_header
0 0 0
2 0 0
0 1 0
0 0 1.5
3 0 2 1
3 0 1 3
3 0 3 2
3 1 2 3
)";

/// World position of a vertex.
inline Vec position(const Scene& s, std::uint32_t vertex) {
    const auto& v = s.vertices.at(vertex);
    return {static_cast<double>(v.px) + s.centre[0], static_cast<double>(v.py) + s.centre[1],
            static_cast<double>(v.pz) + s.centre[2]};
}
inline Vec vertex_normal(const Scene& s, std::uint32_t vertex) {
    const auto& v = s.vertices.at(vertex);
    return {static_cast<double>(v.nx), static_cast<double>(v.ny), static_cast<double>(v.nz)};
}
inline Vec normal(const shared::Triangle& t) {
    return {static_cast<double>(t.nx), static_cast<double>(t.ny), static_cast<double>(t.nz)};
}
/// Unit vector along (v1 - v0) x (v2 - v0).
inline Vec winding(const Scene& s, const shared::Triangle& t) {
    return unit(cross(position(s, t.v1) - position(s, t.v0), position(s, t.v2) - position(s, t.v0)));
}

}  // namespace irradia::test
