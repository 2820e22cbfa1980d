// Pictures whose every pixel is known: furnaces, the integrating sphere, form factors, polygons. Sources: tests/data/
// vectors (furnace.json, polygon_irradiance.json) and the formulas beside each test.
#include <nlohmann/json.hpp>
#include <sstream>

#include "render_fixture.h"

namespace irradia::test {
namespace {

nlohmann::json vectors(const std::string& name) {
    std::ifstream file(test_data("vectors/" + name));
    return nlohmann::json::parse(file);
}

std::string text(double x) {
    std::ostringstream s;
    s.precision(9);
    s << x;
    return s.str();
}

class Furnace : public ::testing::TestWithParam<Method> {};

// L = L_e / (1 - rho) in every direction at every point (furnace.json).
TEST_P(Furnace, EveryPixelIsTheSeries) {
    const nlohmann::json file = vectors("furnace.json");
    for (const auto& c : file.at("furnace")) {
        const double rho = c.at("rho"), expected = c.at("L_total");
        if (rho >= 0.95) continue;  // hundreds of bounces: the hard cases' own test
        RenderSettings settings;
        settings.method = GetParam();
        settings.spp = GetParam() == Method::gather ? 2 : 32;
        const RenderResult r = run(load(project_scene("furnace.xml"), {{"rho", text(rho)}, {"size", "24"}}), settings);
        const Mean m = channel_mean(r.image, 1);
        EXPECT_GT(m.lowest, 0);
        // Cached irradiance is correlated between pixels: its noise is that of few records, 2 % / sqrt(40) at most.
        const double correlated = GetParam() == Method::irradiance ? 0.003 * expected : 0.0;
        EXPECT_NEAR(m.mean, expected, 4 * m.error + correlated + 1e-5 * expected) << "rho " << rho;
    }
}
INSTANTIATE_TEST_SUITE_P(Methods, Furnace, ::testing::Values(Method::irradiance, Method::gather, Method::path));

// A point light in the middle of a sphere: radiance rho I / (pi r² (1 - rho)) everywhere; the direct part rho I / (pi
// r²) without noise at all.
TEST(IntegratingSphere, IsUniform) {
    const double rho = 0.8, intensity = 4, radius = 2, pi = 3.14159265358979;
    const double direct = rho * intensity / (pi * radius * radius), all = direct / (1 - rho);
    for (const Method method : {Method::irradiance, Method::path}) {
        RenderSettings settings;
        settings.method = method;
        settings.spp = 32;
        settings.aovs = {"direct"};
        const RenderResult r = run(load(project_scene("integrating-sphere.xml"), {{"size", "32"}}), settings);
        const Mean m = channel_mean(r.image, 0), d = channel_mean(r.image, 0, 1);
        EXPECT_NEAR(m.mean, all, 4 * m.error + (method == Method::irradiance ? 0.003 * all : 0.0))
            << "method " << static_cast<int>(method);
        EXPECT_NEAR(d.lowest, direct, 1e-4 * direct);
        EXPECT_NEAR(d.highest, direct, 1e-4 * direct);
        // Its harmonic mean distance is the radius (furnace.json: sphere_distances): no record may be far off in E.
        if (method == Method::irradiance) {
            EXPECT_GT(m.lowest, 0.93 * all);
            EXPECT_LT(m.highest, 1.07 * all);
        }
    }
}

// Camera over a unit square that fills the film exactly: pixels are equal areas of it, so the picture's mean is
// rho L F, F the form factor from the square to the emitter (furnace.json: form_factors).
double form_factor(const std::string& emitter, Method method) {
    const Scene scene =
        load_text(R"(<scene version="3.0.0"><sensor type="perspective"><float name="fov" value="53.13010235415598"/>
        <transform name="to_world"><lookat origin="0, 0, 1" target="0, 0, 0" up="0, 1, 0"/></transform>
        <film type="hdrfilm"><integer name="width" value="32"/><integer name="height" value="32"/><rfilter type="box"/></film></sensor>
        <shape type="rectangle"><transform name="to_world"><scale value="0.5"/></transform>
        <bsdf type="diffuse"><rgb name="reflectance" value="1"/></bsdf></shape>)" +
                  emitter + "</scene>");
    RenderSettings settings;
    settings.method = method;
    settings.spp = 256;
    settings.max_depth = 2;
    const RenderResult r = run(scene, settings);
    return channel_mean(r.image, 0).mean;
}

TEST(FormFactor, ParallelUnitSquares) {
    // The emitter is 1 above, over the camera's own plane: camera rays never meet it.
    const double f = form_factor(
        R"(<shape type="rectangle"><transform name="to_world"><scale value="0.5"/><rotate x="1" angle="180"/>
        <translate z="1"/></transform><emitter type="area"><rgb name="radiance" value="1"/></emitter></shape>)",
        Method::irradiance);
    // 262 144 stratified samples: the error of the mean is below 2e-4; the form factor has nine digits.
    EXPECT_NEAR(f, 0.19982489569838746, 2e-4);
}

// The squares share an edge. Next to it samples of the light's area have no bounded variance (their mean over 262 144
// is 1.6 % low). In solid angle it is at most E (W - E) / pi^2 (near_light_test.cpp): 8e-4 of error without strata, and
// as with the parallel squares a quarter of that with them. The path tracer's numbers are not stratified.
TEST(FormFactor, PerpendicularUnitSquares) {
    for (const Method method : {Method::irradiance, Method::path}) {
        const double f = form_factor(
            R"(<shape type="rectangle"><transform name="to_world"><scale value="0.5"/><rotate y="1" angle="-90"/>
        <translate x="0.5" z="0.5"/></transform><emitter type="area"><rgb name="radiance" value="1"/></emitter></shape>)",
            method);
        EXPECT_NEAR(f, 0.20004377607540316, method == Method::path ? 6e-4 : 2e-4);
    }
}

// Irradiance of polygons at a point (polygon_irradiance.json): a camera of tiny field of view looks at the point; its
// pixels see rho E / pi.
TEST(PolygonIrradiance, DirectLightIsLambertsFormula) {
    const nlohmann::json oracle = vectors("polygon_irradiance.json");
    int tested = 0;
    for (const auto& c : oracle.at("cases")) {
        const auto v = c.at("vertices");
        const auto p = c.at("p"), n = c.at("n");
        if (v.size() != 3 && v.size() != 4) continue;
        if (std::abs(n[2].get<double>() - 1.0) > 1e-12) continue;  // receivers in the plane z = p_z
        std::string ply =
            "ply\nformat ascii 1.0\nelement vertex " + std::to_string(v.size()) +
            "\nproperty float x\nproperty float y\nproperty float z\nelement face 1\nproperty list uchar int "
            "vertex_indices\nend_header\n";
        for (const auto& q : v) ply += text(q[0]) + " " + text(q[1]) + " " + text(q[2]) + "\n";
        const double px = p[0], py = p[1], pz = p[2];
        // Facing the receiver: the polygon's normal by Newell's formula, its order reversed if it looks away.
        double nx = 0, ny = 0, nz = 0;
        for (std::size_t i = 0; i < v.size(); ++i) {
            const auto &a = v[i], &b = v[(i + 1) % v.size()];
            nx += (a[1].get<double>() - b[1].get<double>()) * (a[2].get<double>() + b[2].get<double>());
            ny += (a[2].get<double>() - b[2].get<double>()) * (a[0].get<double>() + b[0].get<double>());
            nz += (a[0].get<double>() - b[0].get<double>()) * (a[1].get<double>() + b[1].get<double>());
        }
        const double side =
            nx * (px - v[0][0].get<double>()) + ny * (py - v[0][1].get<double>()) + nz * (pz - v[0][2].get<double>());
        for (std::size_t i = 0; i < v.size(); ++i)
            ply += (i == 0 ? std::to_string(v.size()) + " " : " ") + std::to_string(side > 0 ? i : v.size() - 1 - i);
        ply += "\n";
        const auto file =
            std::filesystem::temp_directory_path() / ("irradia-polygon-" + std::to_string(::getpid()) + ".ply");
        std::ofstream(file) << ply;
        const Scene scene =
            load_text(R"(<scene version="3.0.0"><sensor type="perspective"><float name="fov" value="0.001"/>
            <transform name="to_world"><lookat origin=")" +
                      text(px) + ", " + text(py) + ", " + text(pz + 0.05) + R"(" target=")" + text(px) + ", " +
                      text(py) + ", " + text(pz) + R"(" up="0, 1, 0"/></transform>
            <film type="hdrfilm"><integer name="width" value="16"/><integer name="height" value="16"/><rfilter type="box"/></film></sensor>
            <shape type="rectangle"><transform name="to_world"><scale value="0.01"/><translate x=")" +
                      text(px) + "\" y=\"" + text(py) + "\" z=\"" + text(pz) + R"("/></transform>
            <bsdf type="diffuse"><rgb name="reflectance" value="1"/></bsdf></shape>
            <shape type="ply"><string name="filename" value=")" +
                      file.string() + R"("/><boolean name="face_normals" value="true"/>
            <emitter type="area"><rgb name="radiance" value="1"/></emitter></shape></scene>)");
        std::filesystem::remove(file);
        RenderSettings settings;
        settings.spp = 256;
        settings.max_depth = 2;
        const Mean m = channel_mean(run(scene, settings).image, 0);
        const double expected = c.at("E").get<double>() / c.at("radiance").get<double>() / 3.14159265358979;
        EXPECT_NEAR(m.mean, expected, 4 * m.error + 1e-5 * expected) << "case " << tested;
        ++tested;
    }
    EXPECT_GE(tested, 3);
}

}  // namespace
}  // namespace irradia::test
