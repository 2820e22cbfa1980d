// Where a camera path has the camera: against closed forms, and against the loader's camera of the same view.
#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <limits>
#include <numbers>

#include "irradia/CameraPath.h"
#include "tests/scene/scene_test.h"

namespace irradia::test {
namespace {

using Point = std::array<double, 3>;

/// Looks along -z from the origin, 40 degrees wide, 160 x 90 pixels; the scene's centre is its own.
Scene some_scene() {
    Scene scene;
    auto& c = scene.info.camera;
    const auto tx = static_cast<float>(std::tan(20.0 * std::numbers::pi / 180.0));
    c.forwardz = -1;
    c.dxx = 2 * tx;
    c.dyy = -2 * tx * 90 / 160;
    c.cornerx = -0.5f * c.dxx, c.cornery = -0.5f * c.dyy, c.cornerz = -1;
    c.near_clip = 0.5f, c.far_clip = 700;
    scene.info.width = 160, scene.info.height = 90;
    scene.info.fov_axis = IR_FOV_AXIS_X;
    return scene;
}

CameraKeyframe key(double frame, const Point& origin, const Point& target = {0, 0, -100}) {
    CameraKeyframe k;
    k.frame = frame;
    k.origin = origin;
    k.target = target;
    return k;
}

CameraPath path_of(std::vector<CameraKeyframe> keys, bool smooth = true) {
    CameraPath path;
    path.source = "path.json";
    path.smooth = smooth;
    path.keyframes = std::move(keys);
    return path;
}

Point origin_at(const CameraPath& path, double frame) {
    const shared::Camera c = camera_at(path, some_scene(), frame);
    return {c.ox, c.oy, c.oz};
}

void expect_at(const CameraPath& path, double frame, const Point& expected, double tolerance = 0.0) {
    const Point found = origin_at(path, frame);
    for (std::size_t k = 0; k < 3; ++k) {
        const double ulp = std::abs(expected[k]) * 0x1p-23;  // single precision
        EXPECT_NEAR(found[k], expected[k], ulp + tolerance) << "frame " << frame << ", component " << k;
    }
}

TEST(CameraPath, LinearHalfway) {
    const CameraPath path = path_of({key(1, {0, 0, 0}), key(5, {4, -2, 8}), key(6, {0, 0, 1})}, false);
    expect_at(path, 3, {2, -1, 4});
    expect_at(path, 2, {1, -0.5, 2});
    expect_at(path, 5.5, {2, -1, 4.5});
}

TEST(CameraPath, StandsStillBeforeAndAfter) {
    for (const bool smooth : {false, true}) {
        const CameraPath path = path_of({key(10, {1, 2, 3}), key(20, {4, 5, 6})}, smooth);
        expect_at(path, -1e6, {1, 2, 3});
        expect_at(path, 9, {1, 2, 3});
        expect_at(path, 21, {4, 5, 6});
        expect_at(path_of({key(10, {1, 2, 3})}, smooth), 17, {1, 2, 3});
    }
}

TEST(CameraPath, PassesThroughItsKeyframes) {
    const std::vector<CameraKeyframe> keys{key(1, {0.1, 0.2, 0.3}), key(2.5, {-7, 1, 2}), key(30, {0, 9, 1e3}),
                                           key(31, {5, 5, 5}), key(100, {0.1, 0.2, 0.3})};
    for (const auto& k : keys) {
        const shared::Camera c = camera_at(path_of(keys), some_scene(), k.frame);
        EXPECT_EQ(c.ox, static_cast<float>(k.origin[0]));
        EXPECT_EQ(c.oy, static_cast<float>(k.origin[1]));
        EXPECT_EQ(c.oz, static_cast<float>(k.origin[2]));
    }
}

TEST(CameraPath, KeepsAStraightUniformMotion) {
    // Unevenly spaced frames of p = (1, -2, 3) + frame (0.25, 0.5, -0.125)
    const auto place = [](double f) { return Point{1 + 0.25 * f, -2 + 0.5 * f, 3 - 0.125 * f}; };
    std::vector<CameraKeyframe> keys;
    for (const double f : {0.0, 1.0, 7.0, 9.0, 40.0, 41.0}) keys.push_back(key(f, place(f)));
    for (double f = 0; f <= 41; f += 0.37) expect_at(path_of(keys), f, place(f), 1e-7);
}

TEST(CameraPath, IsAParabolaWhereItsKeyframesAre) {
    // Three-point velocities are exact for parabolas, at the ends too, and so is Hermite's cubic.
    const auto place = [](double f) { return Point{f, 0.01 * f * f, 0}; };
    std::vector<CameraKeyframe> keys;
    for (const double f : {0.0, 4.0, 7.0, 15.0}) keys.push_back(key(f, place(f)));
    for (double f = 0; f <= 15; f += 0.31) expect_at(path_of(keys), f, place(f), 1e-6);
}

TEST(CameraPath, VelocityIsContinuous) {
    const std::vector<CameraKeyframe> keys{key(0, {0, 0, 0}), key(4, {3, 1, 0}), key(6, {5, 4, -2}),
                                           key(20, {6, 9, -1}), key(24, {10, 10, 0})};
    const CameraPath path = path_of(keys);
    constexpr double h = 1.0 / 64;  // differences of floats of up to 10: rounding 1e-6 / h = 6e-5
    for (const double f : {4.0, 6.0, 20.0}) {
        const Point before = origin_at(path, f - h), at = origin_at(path, f), after = origin_at(path, f + h);
        for (std::size_t k = 0; k < 3; ++k)  // accelerations are below 1 a squared frame
            EXPECT_NEAR((at[k] - before[k]) / h, (after[k] - at[k]) / h, 1.0 * h) << "frame " << f;
    }
    // Straight lines do have a kink there.
    const CameraPath straight = path_of(keys, false);
    EXPECT_GT(std::abs(origin_at(straight, 6 + h)[1] + origin_at(straight, 6 - h)[1] - 8) / h, 0.5);
}

TEST(CameraPath, NeverOvershoots) {
    const CameraPath path = path_of({key(0, {0, 0, 0}), key(10, {1, 0, 0}), key(11, {9, 0, 0}), key(30, {10, 0, 0}),
                                     key(31, {10, 0, 0}), key(40, {2, 0, 0}), key(41, {3, 0, 0})});
    double last = 0;
    for (double f = 0; f <= 30; f += 0.125) {
        const double x = origin_at(path, f)[0];
        EXPECT_GE(x, last) << f;
        last = x;
    }
    for (double f = 30; f <= 31; f += 0.125) expect_at(path, f, {10, 0, 0});  // two alike: rests
    for (double f = 31; f <= 40; f += 0.125) {
        const double x = origin_at(path, f)[0];
        EXPECT_LE(x, last) << f;
        EXPECT_GE(x, 2) << f;
        last = x;
    }
}

TEST(CameraPath, DirectionUpAndFieldOfViewMoveToo) {
    CameraPath path = path_of({key(0, {0, 0, 0}, {0, 0, -2}), key(2, {0, 0, 0}, {2, 0, 0})}, false);
    path.keyframes[0].fov = 30;
    path.keyframes[1].fov = 60;
    path.keyframes[1].up = Point{0, 0, -3};
    const shared::Camera c = camera_at(path, some_scene(), 1);
    const double r = std::sqrt(0.5);  // target (1, 0, -1)
    EXPECT_NEAR(c.forwardx, r, 1e-7);
    EXPECT_NEAR(c.forwardy, 0, 1e-7);
    EXPECT_NEAR(c.forwardz, -r, 1e-7);
    // up, (0, 1, -1) / 2, less its part along the view is (-1, 2, -1) / 4
    const double t = std::tan(22.5 * std::numbers::pi / 180), down = 2 * t * 90 / 160 / std::sqrt(6.0);
    EXPECT_NEAR(c.dyx, down, 1e-7);
    EXPECT_NEAR(c.dyy, -2 * down, 1e-7);
    EXPECT_NEAR(c.dyz, down, 1e-7);
    EXPECT_NEAR(c.pixel_size, 2 * t / 160, 1e-7);
    EXPECT_EQ(c.near_clip, 0.5f);
    EXPECT_EQ(c.far_clip, 700.0f);
}

TEST(CameraPath, FocusIsTheScenesUnlessItIsGiven) {
    Scene scene = some_scene();
    CameraPath path = path_of({key(0, {0, 0, 0}), key(2, {1, 0, 0})}, false);
    path.keyframes[1].focus_distance = 8;
    EXPECT_EQ(camera_at(path, scene, 1).focus_distance, 0.0f);  // a pinhole
    scene.info.camera.aperture_radius = 0.25f;
    scene.info.camera.focus_distance = 4;
    EXPECT_EQ(camera_at(path, scene, 0).focus_distance, 4.0f);
    EXPECT_EQ(camera_at(path, scene, 1).focus_distance, 6.0f);
    EXPECT_EQ(camera_at(path, scene, 2).aperture_radius, 0.25f);
}

// ---- against the loader ---------------------------------------------------------------------------------------------

class CameraPathScene : public SceneTest {
protected:
    /// Far off the world's origin, so that centring matters.
    static std::string scene(const std::string& inside, const std::string& look) {
        return "<sensor type=\"thinlens\"><float name=\"aperture_radius\" value=\".1\"/><float name=\"focus_distance\" "
               "value=\"7.7\"/>" +
               inside + "<transform name=\"to_world\">" + look +
               "</transform><film type=\"hdrfilm\"><integer name=\"width\" value=\"161\"/><integer name=\"height\" "
               "value=\"90\"/></film></sensor>"
               "<shape type=\"sphere\"><point name=\"center\" x=\"103.3\" y=\"-41.7\" z=\"7.1\"/>"
               "<emitter type=\"area\"/></shape>";
    }
    static CameraPath copy(const std::optional<double>& fov, const std::optional<Point>& up) {
        CameraKeyframe k = key(1, {99.13, -38.31, 3.77}, {103, -41.3, 7.9});
        k.fov = fov;
        k.up = up;
        return path_of({k});
    }
    static std::string look(const std::string& up) {
        return "<lookat origin=\"99.13,-38.31,3.77\" target=\"103,-41.3,7.9\" up=\"" + up + "\"/>";
    }
};

TEST_F(CameraPathScene, IsTheLoadersCamera) {
    for (const char* const axis : {"x", "y", "diagonal", "smaller", "larger"}) {
        const Scene s = load(
            scene("<float name=\"fov\" value=\"47.3\"/><string name=\"fov_axis\" value=\"" + std::string(axis) + "\"/>",
                  look("0.1,1,0.3")));
        ASSERT_NE(s.centre[0], 0.0);
        const shared::Camera c = camera_at(copy(47.3, Point{0.1, 1, 0.3}), s, 1);
        EXPECT_EQ(std::memcmp(&c, &s.info.camera, sizeof c), 0) << axis;
        CameraPath named = copy(47.3, Point{0.1, 1, 0.3});
        named.fov_axis = axis;
        Scene packed = s;
        packed.info.fov_axis = IR_FOV_AXIS_UNKNOWN;  // as before packed scenes said it
        const shared::Camera d = camera_at(named, packed, 1);
        EXPECT_EQ(std::memcmp(&d, &s.info.camera, sizeof d), 0) << axis;
        EXPECT_NE(error_of([&] { camera_at(copy(47.3, {}), packed, 1); }).find("fov_axis"), std::string::npos);
    }
}

void expect_close(const shared::Camera& a, const shared::Camera& b) {
    const auto* x = reinterpret_cast<const float*>(&a);
    const auto* y = reinterpret_cast<const float*>(&b);
    for (std::size_t i = 0; i < sizeof a / sizeof(float); ++i)
        EXPECT_NEAR(x[i], y[i], 2e-7 * std::max(1.0f, std::abs(y[i]))) << "float " << i;
}

TEST_F(CameraPathScene, LeavesToTheSceneWhatItDoesNotSay) {
    // Field of view, upright axis, principal point: recovered from single precision.
    for (const std::string up : {"0,1,0", "0,0,1", "0,-1,0"}) {
        const Scene s = load(scene("<float name=\"fov\" value=\"47.3\"/>", look(up)));
        expect_close(camera_at(copy({}, {}), s, 1), s.info.camera);
    }
    const Scene shifted = load(scene(
        R"(<float name="fov" value="40"/><float name="principal_point_offset_x" value=".1"/><float name="principal_point_offset_y" value="-.2"/>)",
        look("0,1,0")));
    expect_close(camera_at(copy({}, {}), shifted, 1), shifted.info.camera);
    expect_close(camera_at(copy(40, {}), shifted, 1), shifted.info.camera);
    const Scene focal = load(scene(R"(<string name="focal_length" value="35mm"/>)", look("0,1,0")));
    expect_close(camera_at(copy({}, {}), focal, 1), focal.info.camera);
}

TEST_F(CameraPathScene, AMirroredPictureStaysMirrored) {
    const Scene s = load(scene("<float name=\"fov\" value=\"40\"/>", "<scale x=\"-1\"/>" + look("0,1,0")));
    const shared::Camera c = camera_at(copy(40, Point{0, 1, 0}), s, 1);
    EXPECT_EQ(std::memcmp(&c, &s.info.camera, sizeof c), 0);
}

TEST_F(CameraPathScene, AnotherFilmSizeIsFollowed) {
    LoadOptions options;
    options.width = 90;
    options.height = 160;
    const Scene s =
        load(scene("<float name=\"fov\" value=\"40\"/><string name=\"fov_axis\" value=\"smaller\"/>", look("0,1,0")),
             options);
    const shared::Camera c = camera_at(copy(40, Point{0, 1, 0}), s, 1);
    EXPECT_EQ(std::memcmp(&c, &s.info.camera, sizeof c), 0);
}

// ---- no view --------------------------------------------------------------------------------------------------------

std::string error_at(const CameraPath& path, double frame) {
    try {
        camera_at(path, some_scene(), frame);
    } catch (const Error& error) {
        return error.what();
    }
    return "";
}

TEST(CameraPath, NoViewIsSaidWithItsFrame) {
    // The camera flies through its target at frame 3.
    const CameraPath through = path_of({key(1, {0, 0, 2}, {0, 0, 0}), key(5, {0, 0, -2}, {0, 0, 0})}, false);
    EXPECT_EQ(error_at(through, 2), "");
    EXPECT_EQ(error_at(through, 3), "path.json: frame 3: origin and target meet at (0, 0, 0), expected them apart");
    // The view passes the zenith at frame 3.
    const CameraPath zenith = path_of({key(1, {0, 0, 0}, {0, 1, -1}), key(5, {0, 0, 0}, {0, 1, 1})}, false);
    EXPECT_EQ(error_at(zenith, 2.5), "");
    EXPECT_EQ(error_at(zenith, 3),
              "path.json: frame 3: up is (0, 1, 0), zero or parallel to the view along (0, 1, 0), expected another "
              "direction: give keyframes an 'up'");
    // Up turns over by way of nothing.
    CameraPath over = path_of({key(1, {0, 0, 0}), key(5, {0, 0, 0})});
    over.keyframes[1].up = Point{0, -1, 0};
    EXPECT_EQ(error_at(over, 2), "");
    EXPECT_EQ(error_at(over, 3),
              "path.json: frame 3: up is (0, 0, 0), zero or parallel to the view along (0, 0, -1), expected another "
              "direction: give keyframes an 'up'");
    EXPECT_NE(error_at(over, std::numeric_limits<double>::quiet_NaN()), "");
    // Without a file, and wrong in a way that no file can be.
    CameraPath bad = path_of({key(1, {0, 0, std::numeric_limits<double>::infinity()})});
    bad.source.clear();
    EXPECT_EQ(error_at(bad, 1),
              "camera path: keyframes[0].origin: found (0, 0, inf), expected three numbers of at most 1e18");
    CameraPath narrow = path_of({key(1, {0, 0, 0})});
    narrow.keyframes[0].fov = 1e-50;
    EXPECT_EQ(error_at(narrow, 1),
              "path.json: frame 1: the camera's place or field of view is beyond single precision");
}

}  // namespace
}  // namespace irradia::test
