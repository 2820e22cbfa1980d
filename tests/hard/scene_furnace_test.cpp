// Closed furnaces: every wall emits L_e and reflects rho, so that after D path edges the radiance is
// L_e (1 + rho + ... + rho^(D-1)) in every direction at every point, wherever the camera stands.
#include "scene_fixture.h"

namespace irradia::test {
namespace {

double series(double rho, int edges) {
    double sum = 0, term = 1;
    for (int i = 0; i < edges; ++i, term *= rho) sum += term;
    return sum;
}

// The cube [-1, 1]^3, seen from `origin`.
Scene furnace(double rho, int size, const std::string& origin = "0.3, 0.2, 0.8",
              const std::string& target = "-0.2, -0.1, -0.5", double fov = 90, const std::string& clip = "") {
    return load_text(scene_text(
        camera(size, size, origin, target, fov, clip) +
        R"(<shape type="cube"><boolean name="flip_normals" value="true"/><bsdf type="diffuse"><rgb name="reflectance" value=")" +
        text(rho) + R"("/></bsdf><emitter type="area"><rgb name="radiance" value="1"/></emitter></shape>)"));
}

class Albedo : public ::testing::TestWithParam<Method> {};

// Noise of path: pixels are independent, their spread gives the error of the mean. Caching: the pixels of one picture
// share records, so the error is that of the means of pictures of several seeds.
Mean of_seeds(const Scene& scene, RenderSettings settings, int seeds, std::size_t* bad) {
    Mean all;
    double square = 0;
    for (int i = 0; i < seeds; ++i) {
        settings.seed = static_cast<std::uint64_t>(i + 1);
        const Image image = picture(scene, settings).image;
        *bad += unsound(image);
        const double m = channel_mean(image, 1).mean;
        all.mean += m / seeds;
        square += m * m / seeds;
    }
    all.error = std::sqrt(std::max(square - all.mean * all.mean, 0.0) / (seeds - 1));
    return all;
}

RenderSettings furnace_settings(Method method) {
    RenderSettings settings;
    settings.method = method;
    settings.spp = method == Method::path ? 128 : 4;
    settings.hemisphere_m = 4;
    settings.hemisphere_n = 16;
    settings.grid_paths = 1 << 11;
    return settings;
}

// 1 with a limit of depth, so that the sum is finite.
TEST_P(Albedo, SeriesDoesNotBlowUp) {
    constexpr int seeds = 8;  // Student's t of 7 degrees of freedom: |t| > 5 once in 600
    std::size_t bad = 0;
    double worst = 0;
    for (const auto& [rho, depth] : {std::pair{0.0, 16}, {0.99, 16}, {0.99, 48}, {1.0, 2}, {1.0, 16}, {1.0, 32}}) {
        const Scene scene = furnace(rho, GetParam() == Method::path ? 8 : 4);
        RenderSettings settings = furnace_settings(GetParam());
        settings.max_depth = depth;
        const Mean m = of_seeds(scene, settings, seeds, &bad);
        const double expected = series(rho, depth);
        // 1e-5: float32 sums of some hundred terms.
        const double z = std::abs(m.mean - expected) / std::hypot(m.error, 1e-5 * expected);
        EXPECT_LE(m.error, 0.02 * expected) << "nothing is tested: rho " << rho << " depth " << depth;
        EXPECT_LE(z, 5) << "rho " << rho << " depth " << depth << ": " << m.mean << " +- " << m.error << ", expected "
                        << expected;
        worst = std::max(worst, z);
    }
    EXPECT_EQ(bad, 0u);
    hard_case("closed furnace, albedo 0, .99, 1, 2 to 48 edges, " + name_of(GetParam()),
              "closed form: (1 - rho^D) / (1 - rho), D for rho = 1", "|error| of the mean in standard errors", worst, 5,
              "1 / (1 - rho) = 1/0 for albedo 1");
}

// Without a limit of depth: 100 L_e.
TEST_P(Albedo, UnlimitedAtPoint99) {
    constexpr int seeds = 8;  // Student's t of 7 degrees of freedom: |t| > 5 once in 600
    std::size_t bad = 0;
    const Mean m =
        of_seeds(furnace(0.99, GetParam() == Method::path ? 8 : 4), furnace_settings(GetParam()), seeds, &bad);
    EXPECT_EQ(bad, 0u);
    const double z = std::abs(m.mean - 100) / m.error;
    EXPECT_LE(m.error, 2) << "nothing is tested";
    EXPECT_LE(z, 5) << m.mean << " +- " << m.error;
    hard_case("closed furnace, albedo .99, no limit of depth, " + name_of(GetParam()),
              "closed form: 1 / (1 - rho) = 100",
              "|error| of the mean in standard errors (" + figure(m.mean) + " +- " + figure(m.error) + ")", z, 5,
              "roulette with survival of at most .95: unbounded variance from albedo .975 on");
}

INSTANTIATE_TEST_SUITE_P(Methods, Albedo, ::testing::Values(Method::path, Method::irradiance, Method::radiance),
                         [](const auto& parameter) { return name_of(parameter.param); });

// Cameras on a wall, on an edge, in a corner, to the last bit: rays start on surfaces that they must not find, and
// records lie in corners. Every pixel is 1 / (1 - rho).
TEST(Camera, OnSurfacesAndInCorners) {
    const double rho = 0.5, expected = 2;
    const std::string clip = R"(<float name="near_clip" value="1e-6"/><float name="far_clip" value="100"/>)";
    std::size_t bad = 0;
    double worst = 0, lowest = 1e30;
    for (const Method method : {Method::path, Method::irradiance})
        for (const auto& [origin, target, fov] : {std::tuple{"1, 0.1, 0.2", "-1, 0.2, 0.1", 90.0},
                                                  {"1, 1, 0.2", "0, 0.01, 0.1", 45.0},
                                                  {"1, 1, 1", "0, 0.01, 0.02", 45.0},
                                                  {"-1, -1, 0.999999", "0, 0, 0.02", 45.0}}) {
            const Scene scene = furnace(rho, 12, origin, target, fov, clip);
            RenderSettings settings;
            settings.method = method;
            settings.spp = 64;
            const Image image = picture(scene, settings).image;
            bad += unsound(image);
            const Mean m = channel_mean(image, 1);
            lowest = std::min(lowest, m.lowest);
            // Pixels in a row share what a record has of noise: its mean over a picture is good to .3 %
            // (closed_form_test).
            const double z =
                std::abs(m.mean - expected) / std::hypot(m.error, method == Method::path ? 0 : 0.001 * expected);
            worst = std::max(worst, z);
            EXPECT_LE(z, 5) << name_of(method) << " from " << origin << ": " << m.mean << " +- " << m.error;
            EXPECT_GT(m.lowest, 0.5 * expected) << name_of(method) << " from " << origin;
        }
    EXPECT_EQ(bad, 0u);
    hard_case("camera on a wall, an edge, in a corner of a furnace (lowest pixel " + figure(lowest / expected) +
                  " of the closed form)",
              "closed form: 1 / (1 - rho)", "|error| of the mean in standard errors", worst, 5);
}

}  // namespace
}  // namespace irradia::test
