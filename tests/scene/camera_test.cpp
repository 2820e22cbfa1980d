// Directions through film positions (0, 0) and (.25, .75) are those of Mitsuba 3.9.1's PerspectiveCamera::sample_ray
// (scalar_rgb, single precision; near_clip 1e-4), printed with seven digits.
#include "scene_test.h"

namespace irradia::test {
namespace {

Vec direction(const Scene& s, double x, double y) {
    const auto& c = s.info.camera;
    const auto along = [&](float corner, float dx, float dy) {
        return static_cast<double>(corner) + x * static_cast<double>(dx) + y * static_cast<double>(dy);
    };
    return unit({along(c.cornerx, c.dxx, c.dyx), along(c.cornery, c.dxy, c.dyy), along(c.cornerz, c.dxz, c.dyz)});
}

/// Out of the way of the cameras, which stand near the origin.
const std::string distant_lamp =
    R"(<shape type="rectangle"><transform name="to_world"><translate z="-50"/></transform><emitter type="area"/></shape>)";

const std::string look =
    R"(<transform name="to_world"><lookat origin="1,2,3" target="0,.5,-1" up="0,1,0"/></transform>)";

std::string camera(const std::string& inside, int width = 160, int height = 90) {
    return "<sensor type=\"perspective\">" + inside + "<film type=\"hdrfilm\"><integer name=\"width\" value=\"" +
           std::to_string(width) + "\"/><integer name=\"height\" value=\"" + std::to_string(height) +
           "\"/></film></sensor>" + distant_lamp;
}

struct Case {
    std::string name, inside;
    int width, height;
    Vec corner, inner;
};

void PrintTo(const Case& c, std::ostream* out) { *out << c.name; }

class CameraAxis : public SceneTest, public ::testing::WithParamInterface<Case> {};

TEST_P(CameraAxis, MatchesMitsuba) {
    const auto& c = GetParam();
    const Scene s = load(camera(c.inside, c.width, c.height));
    expect_near(direction(s, 0.0, 0.0), c.corner, 2e-6);
    expect_near(direction(s, 0.25, 0.75), c.inner, 2e-6);
}

std::string fov(const std::string& axis) {
    return "<float name=\"fov\" value=\"40\"/><string name=\"fov_axis\" value=\"" + axis + "\"/>" + look;
}

INSTANTIATE_TEST_SUITE_P(
    , CameraAxis,
    ::testing::Values(
        Case{"x", fov("x"), 160, 90, {-0.5518172, -0.1379405, -0.8224782}, {-0.387625, -0.4288317, -0.8159965}},
        Case{"y", fov("y"), 160, 90, {-0.7112577, 0.000125802, -0.7029314}, {-0.4937792, -0.480842, -0.7245502}},
        Case{"diagonal",
             fov("diagonal"),
             160,
             90,
             {-0.5172755, -0.1636883, -0.8400191},
             {-0.3683512, -0.4188465, -0.829991}},
        Case{"smaller",
             fov("smaller"),
             160,
             90,
             {-0.7112577, 0.000125802, -0.7029314},
             {-0.4937792, -0.480842, -0.7245502}},
        Case{"larger",
             fov("larger"),
             160,
             90,
             {-0.5518172, -0.1379405, -0.8224782},
             {-0.387625, -0.4288317, -0.8159965}},
        Case{"smaller_tall",
             fov("smaller"),
             90,
             160,
             {-0.5095946, 0.2137264, -0.8334473},
             {-0.3540414, -0.6055429, -0.7127219}},
        Case{"larger_tall",
             fov("larger"),
             90,
             160,
             {-0.4214492, 0.0001446349, -0.9068521},
             {-0.3055519, -0.5020731, -0.8090492}},
        Case{"focal_length",
             R"(<string name="focal_length" value="35mm"/>)" + look,
             160,
             90,
             {-0.6598142, -0.04858235, -0.7498567},
             {-0.4554208, -0.4626745, -0.7606078}},
        Case{"no_fov", look, 160, 90, {-0.5610857, -0.1308238, -0.8173543}, {-0.3929578, -0.4315673, -0.8119938}},
        Case{"principal_point",
             R"(<float name="fov" value="40"/><float name="principal_point_offset_x" value=".1"/>
                <float name="principal_point_offset_y" value=".2"/>)" +
                 look,
             160,
             90,
             {-0.496391, -0.2159181, -0.8408184},
             {-0.3115085, -0.5036166, -0.8058119}},
        Case{
            "mirrored",
            R"(<float name="fov" value="40"/><transform name="to_world"><scale x="-1"/><translate x="1"/></transform>)",
            160,
            90,
            {-0.3358611, 0.1889219, 0.9227708},
            {-0.1781433, -0.1002055, 0.9788891}},
        Case{
            "without_up",
            R"(<float name="fov" value="40"/><transform name="to_world"><lookat origin="0,0,0" target="1,2,3"/></transform>)",
            160,
            90,
            {0.4546825, 0.1956602, 0.8688964},
            {0.1795104, 0.3812886, 0.90686}}),
    [](const auto& test) { return test.param.name; });

class Camera : public SceneTest {};

TEST_F(Camera, OriginAndForwardInWorldUnits) {
    const Scene s = load(camera(fov("x")));
    const auto& c = s.info.camera;
    expect_near({c.ox + s.centre[0], c.oy + s.centre[1], c.oz + s.centre[2]}, {1, 2, 3}, 1e-6);
    expect_near({c.forwardx, c.forwardy, c.forwardz}, unit({-1, -1.5, -4}), 1e-7);
}

TEST_F(Camera, ScaledMatrixGivesTheSameRays) {
    // A scale about the eye moves no ray; Mitsuba refuses such matrices, exporters write them.
    const Scene a = load(camera(fov("x")));
    const Scene b = load(camera(
        R"(<float name="fov" value="40"/><transform name="to_world"><scale value="3"/><lookat origin="1,2,3" target="0,.5,-1" up="0,1,0"/></transform>)"));
    expect_near(direction(b, 0.1, 0.8), direction(a, 0.1, 0.8), 1e-6);
    EXPECT_FLOAT_EQ(a.info.camera.pixel_size, b.info.camera.pixel_size);
    expect_near({b.info.camera.forwardx, b.info.camera.forwardy, b.info.camera.forwardz},
                {a.info.camera.forwardx, a.info.camera.forwardy, a.info.camera.forwardz}, 1e-6);
}

TEST_F(Camera, PixelSizeIsTheEdgeAtUnitDepth) {
    // 2 tan(20 degrees) / 160; pixels are square
    const Scene s = load(camera(fov("x")));
    EXPECT_NEAR(s.info.camera.pixel_size, 2.0 * std::tan(20.0 * M_PI / 180.0) / 160.0, 1e-8);
}

TEST_F(Camera, FilmSizeOverrideChangesTheAspect) {
    LoadOptions options;
    options.width = 90;
    options.height = 160;
    const Scene s = load(camera(fov("smaller")), options);  // the film of "smaller_tall"
    EXPECT_EQ(s.info.width, 90u);
    EXPECT_EQ(s.info.height, 160u);
    expect_near(direction(s, 0.0, 0.0), {-0.5095946, 0.2137264, -0.8334473}, 2e-6);
}

TEST_F(Camera, FiltersAndTheirDefaults) {
    const auto info = [&](const std::string& filter) {
        return load("<sensor type=\"perspective\"><film type=\"hdrfilm\">" + filter + "</film></sensor>" + distant_lamp)
            .info;
    };
    EXPECT_EQ(info("<rfilter type=\"box\"/>").rfilter, IR_RFILTER_BOX);
    EXPECT_FLOAT_EQ(info("<rfilter type=\"box\"/>").rfilter_radius, 0.5f);
    EXPECT_EQ(info("<rfilter type=\"tent\"/>").rfilter, IR_RFILTER_TENT);
    EXPECT_FLOAT_EQ(info("<rfilter type=\"tent\"/>").rfilter_radius, 1.0f);
    EXPECT_FLOAT_EQ(info("<rfilter type=\"tent\"><float name=\"radius\" value=\"2\"/></rfilter>").rfilter_radius, 2.0f);
    const auto none = info("");  // Mitsuba prints GaussianFilter[stddev=0.50, radius=2.00] for a film without a filter
    EXPECT_EQ(none.rfilter, IR_RFILTER_GAUSSIAN);
    EXPECT_FLOAT_EQ(none.rfilter_stddev, 0.5f);
    EXPECT_FLOAT_EQ(none.rfilter_radius, 2.0f);
    const auto wide = info("<rfilter type=\"gaussian\"><float name=\"stddev\" value=\".75\"/></rfilter>");
    EXPECT_FLOAT_EQ(wide.rfilter_radius, 3.0f);
    EXPECT_EQ(none.width, 768u);  // HDRFilm's own default size
    EXPECT_EQ(none.height, 576u);
}

TEST_F(Camera, ClipPlanesAndSampleCount) {
    const Scene s =
        load(R"(<sensor type="perspective"><float name="near_clip" value=".1"/><float name="far_clip" value="5000"/>
        <sampler type="independent"><integer name="sample_count" value="17"/></sampler></sensor>)" +
             distant_lamp);
    EXPECT_FLOAT_EQ(s.info.camera.near_clip, 0.1f);
    EXPECT_FLOAT_EQ(s.info.camera.far_clip, 5000.0f);
    EXPECT_EQ(s.sample_count, 17u);
}

}  // namespace
}  // namespace irradia::test
