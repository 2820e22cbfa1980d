// Camera paths as files: what is read, and what is said of wrong ones.
#include <gtest/gtest.h>

#include <random>

#include "irradia/CameraPath.h"
#include "tests/scene/scene_test.h"

namespace irradia::test {
namespace {

const std::string good = R"({
  "interpolation": "linear",
  "fov_axis": "smaller",
  "keyframes": [
    {"frame": 1, "origin": [0, 1, 4.5], "target": [0, 1, 0]},
    {"frame": 2.5, "origin": [1, 1, 4], "target": [0, 1, 0], "up": [0, 0, 1], "fov": 45, "focus_distance": 3}
  ]
})";

class CameraPathFile : public SceneTest {
protected:
    CameraPath read(const std::string& text) { return read_camera_path(write("path.json", text)); }
    /// What is said of a file, less its path.
    std::string said(const std::string& text) {
        const std::string file = write("path.json", text);
        const std::string message = error_of([&] { read_camera_path(file); });
        EXPECT_EQ(message.rfind(file, 0), 0u) << message;
        EXPECT_EQ(message.find('\n'), std::string::npos) << message;
        return message.substr(std::min(message.size(), file.size()));
    }
    /// Of keyframes: a good one and then this.
    std::string said_of(const std::string& keyframe) {
        return said(R"({"keyframes": [{"frame": 1, "origin": [0, 1, 4], "target": [0, 1, 0]},)" + keyframe + "]}");
    }
};

TEST_F(CameraPathFile, AllThatItSays) {
    const CameraPath path = read(good);
    EXPECT_EQ(path.source, this->path("path.json"));
    EXPECT_FALSE(path.smooth);
    EXPECT_EQ(path.fov_axis, "smaller");
    ASSERT_EQ(path.keyframes.size(), 2u);
    const auto& [a, b] = std::tie(path.keyframes[0], path.keyframes[1]);
    EXPECT_EQ(a.frame, 1);
    EXPECT_EQ(a.origin, (std::array<double, 3>{0, 1, 4.5}));
    EXPECT_EQ(a.target, (std::array<double, 3>{0, 1, 0}));
    EXPECT_FALSE(a.up || a.fov || a.focus_distance);
    EXPECT_EQ(b.frame, 2.5);
    EXPECT_EQ(b.up, (std::array<double, 3>{0, 0, 1}));
    EXPECT_EQ(b.fov, 45);
    EXPECT_EQ(b.focus_distance, 3);
    EXPECT_TRUE(read(R"({"keyframes": [{"frame": 1, "origin": [0, 1, 4], "target": [0, 1, 0]}]})").smooth);
}

TEST_F(CameraPathFile, NoJson) {
    expect_message(said(""), {":1: found no JSON: "});
    expect_message(said("{\"keyframes\":\n[\n{\"frame\": }]}"), {":3: found no JSON: "});
    expect_message(said("{\"keyframes\":\n[1e999]}"), {":2: found 1e999, expected a number of at most 1e18"});
    expect_message(said("{\"keyframes\": [NaN]}"), {":1: found no JSON: "});
    expect_message(said(std::string("{\"a\xff\x01\": 1}")), {":1: found no JSON: "});
    expect_message(said(good + "x"), {":8: found no JSON: "});
    expect_message(said(std::string(100000, '[')), {":1: found no JSON: "});
    EXPECT_EQ(said(R"({"interpolation": "linear", "interpolation": "smooth"})"),
              ": found \"interpolation\" twice in one object, expected it once");
}

TEST_F(CameraPathFile, NoFile) {
    expect_message(error_of([&] { read_camera_path(path("none.json")); }), {"none.json: "});
    expect_message(error_of([&] { read_camera_path(folder_.string()); }), {folder_.string() + ": "});
}

TEST_F(CameraPathFile, TheWholeOfIt) {
    EXPECT_EQ(said("[1, 2]"), ": found [1,2], expected an object {\"keyframes\": [...]}");
    EXPECT_EQ(said(R"({"keyframe": []})"), ": found 'keyframe', expected interpolation, fov_axis or keyframes");
    EXPECT_EQ(said("{}"), ": keyframes: found nothing, expected a list of them");
    EXPECT_EQ(said(R"({"keyframes": {"frame": 1}})"), ": keyframes: found {\"frame\":1}, expected a list of them");
    EXPECT_EQ(said(R"({"keyframes": []})"), ": keyframes: found none, expected at least one");
    EXPECT_EQ(said(R"({"keyframes": [], "interpolation": "cubic"})"),
              ": interpolation: found \"cubic\", expected \"smooth\" or \"linear\"");
    EXPECT_EQ(said(R"({"keyframes": [], "interpolation": null})"),
              ": interpolation: found null, expected \"smooth\" or \"linear\"");
    EXPECT_EQ(said(R"({"keyframes": [], "fov_axis": "z"})"),
              ": fov_axis: found 'z', expected x, y, diagonal, smaller or larger");
    EXPECT_EQ(said(R"({"keyframes": [], "fov_axis": 1})"),
              ": fov_axis: found 1, expected x, y, diagonal, smaller or larger");
}

TEST_F(CameraPathFile, EveryField) {
    EXPECT_EQ(said_of("7"), ": keyframes[1]: found 7, expected an object {\"frame\": ...}");
    EXPECT_EQ(said_of(R"({"frame": 2, "orgin": [0, 1, 4], "target": [0, 1, 0]})"),
              ": keyframes[1]: found 'orgin', expected frame, origin, target, up, fov or focus_distance");
    const std::string place = R"("origin": [0, 1, 4], "target": [0, 1, 0])";
    EXPECT_EQ(said_of("{" + place + "}"), ": keyframes[1].frame: found nothing, expected the number of a frame");
    EXPECT_EQ(said_of("{\"frame\": \"2\"," + place + "}"),
              ": keyframes[1].frame: found \"2\", expected the number of a frame");
    EXPECT_EQ(said_of("{\"frame\": 1e19," + place + "}"),
              ": keyframes[1].frame: found 1e+19, expected a number of at most 1e18");
    EXPECT_EQ(said_of("{\"frame\": 1," + place + "}"),
              ": keyframes[1].frame: found 1 after 1, expected a larger number: frames increase");
    EXPECT_EQ(said_of("{\"frame\": 0.5," + place + "}"),
              ": keyframes[1].frame: found 0.5 after 1, expected a larger number: frames increase");
    EXPECT_EQ(said_of(R"({"frame": 2, "target": [0, 1, 0]})"),
              ": keyframes[1].origin: found nothing, expected three numbers");
    EXPECT_EQ(said_of(R"({"frame": 2, "origin": [0, 1], "target": [0, 1, 0]})"),
              ": keyframes[1].origin: found [0,1], expected three numbers");
    EXPECT_EQ(said_of(R"({"frame": 2, "origin": [0, 1, 1e19], "target": [0, 1, 0]})"),
              ": keyframes[1].origin: found (0, 1, 1e+19), expected three numbers of at most 1e18");
    EXPECT_EQ(said_of(R"({"frame": 2, "origin": [0, 1, 4], "target": [0, "1", 0]})"),
              ": keyframes[1].target: found [0,\"1\",0], expected three numbers");
    EXPECT_EQ(said_of(R"({"frame": 2, "origin": [0, 1, 4], "target": [0, 1, 4]})"),
              ": keyframes[1].target: found (0, 1, 4), the origin, expected another point");
    EXPECT_EQ(said_of("{\"frame\": 2, \"up\": 1, " + place + "}"),
              ": keyframes[1].up: found 1, expected three numbers");
    EXPECT_EQ(said_of("{\"frame\": 2, \"up\": [0, 0, 0], " + place + "}"),
              ": keyframes[1].up: found (0, 0, 0), expected a direction");
    EXPECT_EQ(said_of("{\"frame\": 2, \"up\": [0, 0, 3], " + place + "}"),
              ": keyframes[1].up: found (0, 0, 3), parallel to the view, expected another direction");
    EXPECT_EQ(said_of("{\"frame\": 2, \"fov\": [4], " + place + "}"),
              ": keyframes[1].fov: found [4], expected degrees");
    for (const char* const fov : {"0", "180", "-40", "1e+20"})
        EXPECT_EQ(said_of("{\"frame\": 2, \"fov\": " + std::string(fov) + ", " + place + "}"),
                  ": keyframes[1].fov: found " + std::string(fov) + ", expected degrees above 0 and below 180");
    EXPECT_EQ(said_of("{\"frame\": 2, \"focus_distance\": \"far\", " + place + "}"),
              ": keyframes[1].focus_distance: found \"far\", expected a positive number");
    EXPECT_EQ(said_of("{\"frame\": 2, \"focus_distance\": 0, " + place + "}"),
              ": keyframes[1].focus_distance: found 0, expected a positive number of at most 1e18");
}

TEST_F(CameraPathFile, DamagedBytesAreReadOrRefused) {
    std::mt19937 random(7);
    std::size_t refused = 0;
    for (int i = 0; i < 2000; ++i) {
        std::string text = good;
        for (unsigned n = 1 + random() % 4; n > 0; --n) {
            const std::size_t at = random() % text.size();
            switch (random() % 4) {
                case 0:
                    text[at] = static_cast<char>(random() % 256);
                    break;
                case 1:
                    text.erase(at, 1 + random() % 5);
                    break;
                case 2:
                    text.insert(at, 1, "0123456789eE+-.[]{},:\"\\"[random() % 23]);
                    break;
                default:
                    text.insert(at, text.substr(random() % text.size(), 1 + random() % 20));
                    break;
            }
        }
        try {
            const CameraPath path = read(text);
            Scene scene;
            scene.info.width = scene.info.height = 10;
            scene.info.camera.forwardz = scene.info.camera.dxx = scene.info.camera.dyy = 1;
            scene.info.camera.cornerx = scene.info.camera.cornery = -0.5f;
            scene.info.camera.cornerz = 1;
            const shared::Camera c = camera_at(path, scene, 1.75);
            EXPECT_TRUE(std::isfinite(c.ox + c.cornerx + c.dxx + c.dyy + c.forwardz + c.pixel_size)) << text;
        } catch (const Error& error) {
            ++refused;
            EXPECT_EQ(std::string(error.what()).find('\n'), std::string::npos) << error.what();
        }
    }
    EXPECT_GT(refused, 1000u);  // and so some are not
    EXPECT_LT(refused, 2000u);
}

}  // namespace
}  // namespace irradia::test
