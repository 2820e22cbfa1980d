// Light samples of an environment picture by what is seen of it (cl/sky_view.h): their density, what they take where
// little or nothing is known. What paths have met is made up here.
#include "irradia/shared/sky_types.h"
#include "light_kernels.h"
#include "render/sky_view.h"

namespace irradia::test {
namespace {

constexpr int kWidth = 70, kHeight = 41;  // no multiples of the tiles'
const Vec kUp{0, 0, 1}, kPlace{0.3, 0.2, 0.1}, kBeside{0.36, 0.2, 0.1}, kElsewhere{-0.9, -0.9, 0.0};

class SkyView : public LightTest {
protected:
    void SetUp() override {
        LightTest::SetUp();
        std::mt19937 random(3);
        std::uniform_real_distribution<float> uniform(0.02f, 1.0f);
        std::vector<float> rgb;
        for (int i = 0; i < kWidth * kHeight; ++i) {
            const bool black = i / kWidth > 30 && i % kWidth < 20;  // tiles that bring nothing
            const float grey = black ? 0.0f : uniform(random);
            rgb.insert(rgb.end(), {0.5f * grey, grey, 0.8f * grey});
        }
        for (std::size_t i = 0; i < 3; ++i) rgb[3 * (12 * kWidth + 40) + i] = 20;  // a sun
        picture("sky.exr", kWidth, kHeight, rgb);
    }
    [[nodiscard]] Scene scene() const {
        return load(R"(<emitter type="envmap"><string name="filename" value="sky.exr"/></emitter>)");
    }
    /// `paths` paths that left from p, normal up, through tiles first, first + 7, first + 14, ..., more often through
    /// earlier ones.
    static void leave(std::vector<std::uint32_t>& events, const Scene& scene, const Vec& p, int paths,
                      std::uint32_t first) {
        const std::vector<float> point{
            static_cast<float>(p[0]), static_cast<float>(p[1]), static_cast<float>(p[2]), 0.0f, 0.0f, 1.0f};
        std::array<std::uint32_t, 2 * IR_GRID_LEVELS> keys{};
        const Buffer in = device().upload(point);
        Buffer out = device().allocate(sizeof keys);
        Kernel kernel = device().kernel("grid_test.cl", "test_grid_keys", {});
        kernel.arg(out).arg(sky_cells(scene)).arg(in).arg(std::uint32_t{1}).run(1, 16);
        device().read(out, keys.data(), sizeof keys);
        for (int i = 0; i < paths; ++i)
            events.insert(events.end(), {keys[0], first + 7 * static_cast<std::uint32_t>(i * i % 61 % 40), 1u});
    }
    static Scene taught(Scene scene, const std::vector<std::uint32_t>& events) {
        const std::vector<std::uint32_t> tables = sky_tables(scene, events, scene.texels.size());
        scene.lights[scene.info.environment_light].view = static_cast<std::uint32_t>(scene.texels.size());
        scene.texels.insert(scene.texels.end(), tables.begin(), tables.end());
        return scene;
    }
    /// The density of each of these directions where nothing is known, and at p.
    static double densities(const Scene& plain, const Scene& knowing, const Vec& p, const std::vector<Vec>& directions,
                            std::vector<double>& ratios) {
        const auto before = LightKernels(plain).environment(directions, kUp, p);
        const auto after = LightKernels(knowing).environment(directions, kUp, p);
        double least = 1e30;
        ratios.clear();
        for (std::size_t i = 0; i < directions.size(); ++i) {
            if (before[i].density == 0) {  // black
                EXPECT_EQ(after[i].density, 0);
                continue;
            }
            ratios.push_back(after[i].density / before[i].density);
            least = std::min(least, ratios.back());
        }
        return least;
    }
    static std::vector<Vec> all_directions() {
        std::vector<Vec> directions;
        for (const std::array<float, 2>& uv : random_pairs(4000, 8))
            directions.push_back(picture_direction(uv[0], std::acos(1 - 2 * double{uv[1]}) / kPi));
        return directions;
    }
};

TEST_F(SkyView, SamplesHaveTheirDensity) {
    const Scene plain = scene();
    std::vector<std::uint32_t> events;
    leave(events, plain, kPlace, 300, 100);
    const Scene knowing = taught(plain, events);
    expect_samples_of_density(knowing, kWidth, kHeight, kPlace, kUp, true);
}

// What is seen is sampled more often, everything else still by its share; where nothing is known, as ever.
TEST_F(SkyView, IsWhatIsSeenMostly) {
    const Scene plain = scene();
    std::vector<std::uint32_t> events;
    leave(events, plain, kPlace, 300, 100);
    const Scene knowing = taught(plain, events);
    std::vector<double> ratios;
    const std::vector<Vec> directions = all_directions();
    EXPECT_NEAR(densities(plain, knowing, kPlace, directions, ratios), IR_SKY_UNSEEN, 1e-5);
    EXPECT_GT(*std::max_element(ratios.begin(), ratios.end()), 5);
    EXPECT_EQ(densities(plain, knowing, kElsewhere, directions, ratios), 1);
    EXPECT_EQ(*std::max_element(ratios.begin(), ratios.end()), 1);
    const auto down = LightKernels(knowing).environment(directions, {0, 0, -1}, kPlace);
    const auto unknown = LightKernels(plain).environment(directions, {0, 0, -1}, kPlace);
    for (std::size_t i = 0; i < directions.size(); ++i) EXPECT_EQ(down[i].density, unknown[i].density);
}

// Cells that few paths have left from are answered for by coarser ones around them.
TEST_F(SkyView, CoarseCellsAnswerWhereFineOnesKnowTooLittle) {
    const Scene plain = scene();
    std::vector<std::uint32_t> events;
    leave(events, plain, kPlace, 300, 100);
    leave(events, plain, kBeside, 5, 200);
    const Scene knowing = taught(plain, events);
    std::vector<double> there, beside;
    const std::vector<Vec> directions = all_directions();
    densities(plain, knowing, kPlace, directions, there);
    EXPECT_NEAR(densities(plain, knowing, kBeside, directions, beside), IR_SKY_UNSEEN, 1e-5);
    EXPECT_NE(there, beside);
    expect_samples_of_density(knowing, kWidth, kHeight, kBeside, kUp, true);
}

TEST_F(SkyView, SamplesInATileAreThoseOfEachAlone) {
    const Scene plain = scene();
    std::vector<std::uint32_t> events;
    leave(events, plain, kPlace, 300, 100);
    std::vector<LightKernels::TileQuestion> questions;
    std::size_t i = 0;
    for (const std::array<float, 2>& uv : random_pairs(4003, 12))
        questions.push_back({++i % 3 == 0 ? kElsewhere : kPlace, kUp, uv});
    for (const float u : {0.0f, 0.1249999f, 0.125f, 0.5f})
        for (const float v : {0.0f, 0.5f}) questions.push_back({kPlace, kUp, {u, v}});
    expect_tiles_as_alone(taught(plain, events), questions);
}

// Under a sky of radiance 1 irradiance is pi, whatever is taken for seen.
TEST_F(SkyView, IrradianceStaysTheSame) {
    picture("sky.exr", kWidth, kHeight, std::vector<float>(3 * kWidth * kHeight, 1.0f));
    const Scene plain = scene();
    std::vector<std::uint32_t> events;
    leave(events, plain, kPlace, 300, 100);
    LightKernels kernels(taught(plain, events));
    const Estimate e = sampled_irradiance(kernels, kPlace, kUp, 1u << 18);
    EXPECT_LE(e.error(), 0.03);
    EXPECT_NEAR(e.mean(), kPi, 5 * e.error());
}

}  // namespace
}  // namespace irradia::test
