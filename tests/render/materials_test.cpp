// Materials in pictures: white surroundings that no lossless material can change, and the caches on surfaces that are
// not plainly diffuse against path tracing of the same scene.
#include <cmath>

#include "room.h"
#include "scene/build.h"

#include "cl/portable.h"
namespace irradia::host {
#include "cl/fresnel.h"
}
#undef R

namespace irradia::test {
namespace {

// ---- white surroundings
// ----------------------------------------------------------------------------------------------

struct Lossless {
    const char* name;
    const char* bsdf;
    bool exact;  // at every sample; else paths inside the sphere end by roulette now and then, and the mean is
};
void PrintTo(const Lossless& l, std::ostream* out) { *out << l.name; }

class WhiteFurnace : public ::testing::TestWithParam<Lossless> {};

// A sphere in surroundings of radiance 1: what it neither absorbs nor emits, it cannot be told from them. Mirrors and
// glass are exact at every sample.
TEST_P(WhiteFurnace, CannotBeSeen) {
    const Scene scene = load_text(R"(<scene version="3.0.0">)" + sensor(16, "0,0,4", "0,0,0", 35) +
                                  R"(<emitter type="constant"><rgb name="radiance" value="1"/></emitter>
        <shape type="sphere">)" + GetParam().bsdf +
                                  "</shape></scene>");
    for (const Method method : {Method::path, Method::irradiance}) {
        RenderSettings s;
        s.method = method;
        s.spp = 64;
        const Image image = run(scene, s).image;
        for (int channel = 0; channel < 3; ++channel) {
            const Mean m = channel_mean(image, channel);
            if (GetParam().exact) {
                EXPECT_GT(m.lowest, 1.0 - 1e-5);
                EXPECT_LT(m.highest, 1.0 + 1e-5);
            } else {
                EXPECT_NEAR(m.mean, 1.0, 5 * m.error + 1e-5);
                EXPECT_LT(m.error, 1e-3);
            }
        }
    }
}

INSTANTIATE_TEST_SUITE_P(
    Materials, WhiteFurnace,
    ::testing::Values(
        Lossless{"mirror",
                 R"(<bsdf type="twosided"><bsdf type="conductor"><string name="material" value="none"/></bsdf></bsdf>)",
                 true},
        Lossless{"thin", R"(<bsdf type="thindielectric"/>)", false},
        Lossless{"nothing", R"(<bsdf type="null"/>)", true},
        Lossless{"masked", R"(<bsdf type="mask"><float name="opacity" value="0.5"/><bsdf type="twosided">
            <bsdf type="conductor"><string name="material" value="none"/></bsdf></bsdf></bsdf>)",
                 false}),
    [](const auto& tested) { return std::string(tested.param.name); });

// By how much smooth plastic's base is too bright at albedo 1: its share of light that the coat throws back inside,
// r, is a fit (Egan and Hilgeman's, as in Mitsuba), and light comes out as 1 / (1 - r). Against the integral: .12 %.
double excess_of_smooth_plastic() {
    constexpr double eta = 1.49 / 1.000277;  // polypropylene in air, Mitsuba's defaults
    constexpr int steps = 20000;
    host::real r = 0, unused = 0;
    for (int i = 0; i < steps; ++i) {
        const double c = (i + .5) / steps;
        r += 2 * c * host::fresnel_dielectric(c, 1 / eta, &unused) / steps;
    }
    return (1 - r) / (1 - loader::smooth_internal_reflectance(eta)) - 1;
}

// Light that refraction traps inside comes out after many bounces: unbiased roulette keeps the mean, sample by sample
// it varies. So does a rough surface's, which loses some to facets that shade each other.
TEST(WhiteFurnaceOnAverage, GlassShowsNothingAndRoughSurfacesDarkenOnly) {
    const auto mean_of = [](const std::string& bsdf) {
        const Scene scene = load_text(R"(<scene version="3.0.0">)" + sensor(16, "0,0,4", "0,0,0", 20) +
                                      R"(<emitter type="constant"><rgb name="radiance" value="1"/></emitter>
            <shape type="sphere">)" + bsdf +
                                      "</shape></scene>");
        RenderSettings s;
        s.method = Method::path;
        s.spp = 1024;
        return channel_mean(run(scene, s).image, 1);
    };
    const Mean glass = mean_of(R"(<bsdf type="dielectric"/>)");
    EXPECT_NEAR(glass.mean, 1.0, 5 * glass.error + 1e-4);
    const std::string rough = R"(<float name="alpha" value="0.3"/><string name="distribution" value="ggx"/>)";
    const std::vector<std::pair<std::string, double>> surfaces = {
        {R"(<bsdf type="roughdielectric">)" + rough + "</bsdf>", 0},
        {R"(<bsdf type="roughconductor"><string name="material" value="none"/>)" + rough + "</bsdf>", 0},
        {R"(<bsdf type="roughplastic"><rgb name="diffuse_reflectance" value="1"/>)" + rough + "</bsdf>", 0},
        {R"(<bsdf type="plastic"><rgb name="diffuse_reflectance" value="1"/></bsdf>)", excess_of_smooth_plastic()}};
    for (const auto& [bsdf, excess] : surfaces) {
        const Mean m = mean_of(bsdf);
        EXPECT_LE(m.mean, 1.0 + excess + 5 * m.error + 1e-4) << bsdf;
        EXPECT_GT(m.mean, 0.6) << bsdf;
    }
}

// ---- the caches against path tracing -------------------------------------------------------------------------------

struct Hard {
    const char* name;
    std::string floor, things;
    double bias, rmse;  // bounds, about 1.5 times what was measured when the test was written
};

void PrintTo(const Hard& h, std::ostream* out) { *out << h.name; }

class CachedSurfaces : public ::testing::TestWithParam<Hard> {};

TEST_P(CachedSurfaces, AgreeWithPathTracing) {
    const Comparison c = compare(load_text(room(GetParam().floor, GetParam().things)));
    RecordProperty("bias_percent", std::to_string(100 * c.bias));
    RecordProperty("rmse_percent", std::to_string(100 * c.rmse));
    std::printf("%-14s bias %+.2f %% +- %.2f %%, RMSE %.1f %%, %llu records\n", GetParam().name, 100 * c.bias,
                100 * c.noise, 100 * c.rmse, static_cast<unsigned long long>(c.records));
    EXPECT_NEAR(c.bias, 0.0, GetParam().bias + 3 * c.noise);
    EXPECT_LT(c.rmse, GetParam().rmse);
}

std::string sphere(const std::string& bsdf) {
    return R"(<shape type="sphere"><point name="center" value="0,-.6,0"/><float name="radius" value=".4"/>)" + bsdf +
           "</shape>";
}
std::string plastic(const std::string& kind, const std::string& rest) {
    return R"(<bsdf type="twosided"><bsdf type=")" + kind + R"("><rgb name="diffuse_reflectance" value=".5,.3,.2"/>
        <boolean name="nonlinear" value="true"/>)" +
           rest + "</bsdf></bsdf>";
}
// Waves of some degrees as a height map, in a file that lives as long as the tests.
std::string bumps() {
    const std::filesystem::path path =
        std::filesystem::temp_directory_path() / ("irradia-bumps-" + std::to_string(::getpid()) + ".ppm");
    std::ofstream file(path);
    file << "P3\n64 64\n255\n";
    for (int y = 0; y < 64; ++y)
        for (int x = 0; x < 64; ++x) {
            const int h = static_cast<int>(127.5 + 127.0 * std::sin(x * 0.39269908) * std::sin(y * 0.19634954));
            file << h << " " << h << " " << h << "\n";
        }
    return R"(<bsdf type="bumpmap"><float name="scale" value="0.05"/><texture name="map" type="bitmap">
        <string name="filename" value=")" +
           path.string() + R"("/><boolean name="raw" value="true"/></texture>)";
}
const std::string glossy = R"(<string name="distribution" value="ggx"/><float name="alpha" value="0.2"/>)";

INSTANTIATE_TEST_SUITE_P(
    Hard, CachedSurfaces,
    ::testing::Values(
        Hard{"corners", grey_floor, "", 0.006, 0.011}, Hard{"sphere", grey_floor, sphere(grey_floor), 0.006, 0.014},
        Hard{"plastic", plastic("plastic", ""), "", 0.006, 0.029},
        Hard{"rough_plastic", plastic("roughplastic", glossy), sphere(plastic("roughplastic", glossy)), 0.006, 0.021},
        Hard{"mirror", grey_floor,
             R"(<shape type="rectangle"><transform name="to_world"><scale value=".7"/><rotate y="1" angle="80"/>
                <translate x="-.9" y="-.2"/></transform><bsdf type="twosided"><bsdf type="conductor"/></bsdf></shape>)",
             0.01, 0.032},
        Hard{"metal", grey_floor,
             sphere(R"(<bsdf type="roughconductor"><string name="material" value="Cu"/>)" + glossy + "</bsdf>"), 0.006,
             0.021},
        Hard{"bumped", bumps() + grey_floor + "</bsdf>", "", 0.006, 0.01},
        Hard{"checkerboard",
             R"(<bsdf type="twosided"><bsdf type="diffuse"><texture name="reflectance" type="checkerboard">
                <transform name="to_uv"><scale value="4"/></transform></texture></bsdf></bsdf>)",
             "", 0.006, 0.012}),
    [](const auto& tested) { return std::string(tested.param.name); });

// What is seen in a flat mirror is spaced by its image's pixels: a mirror that doubles the room's visible part adds
// about as many records as that part would have, not one a pixel.
TEST(Mirror, DoesNotMultiplyRecords) {
    RenderSettings s;
    s.spp = 16;
    const std::string mirror = R"(<shape type="rectangle"><transform name="to_world"><scale x=".95" y=".95"/>
        <translate z="-.99"/></transform><bsdf type="twosided"><bsdf type="conductor"/></bsdf></shape>)";
    const std::uint64_t without = run(load_text(room(grey_floor, "")), s).statistics.records;
    const std::uint64_t with = run(load_text(room(grey_floor, mirror)), s).statistics.records;
    EXPECT_LT(with, without * 2);
}

// Kernels compiled for everything render what the specialised ones render: rounding may differ, nothing else.
TEST(Specialisation, DoesNotChangeThePicture) {
    for (const std::string& things : {std::string(), sphere(plastic("roughplastic", glossy))}) {
        const Scene scene = load_text(room(grey_floor, things));
        RenderSettings s;
        s.spp = 8;
        s.method = Method::path;
        const auto own = run(scene, s).image.layers[0].data;
        s.specialise = false;
        const auto all = run(scene, s).image.layers[0].data;
        double difference = 0, sum = 0;
        for (std::size_t i = 0; i < own.size(); ++i) {
            difference += static_cast<double>(all[i]) - static_cast<double>(own[i]);
            sum += static_cast<double>(own[i]);
        }
        EXPECT_NEAR(difference / sum, 0.0, 0.01);  // other random numbers: three standard errors
    }
}

}  // namespace
}  // namespace irradia::test
