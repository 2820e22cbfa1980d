// Environment pictures on the device: radiance against Mitsuba's (tests/data/vectors/emitters.json), samples against
// their density, both against sums in double.
#include <nlohmann/json.hpp>

#include "light_kernels.h"

namespace irradia::test {
namespace {

nlohmann::json oracle() {
    std::ifstream file(IRRADIA_SOURCE_DIR "/tests/data/vectors/emitters.json");
    return nlohmann::json::parse(file);
}

const Vec kUp{0, 0, 1};
constexpr int kWidth = 16, kHeight = 9;

class EnvironmentLight : public LightTest {
protected:
    void SetUp() override {
        LightTest::SetUp();
        std::mt19937 random(3);
        std::uniform_real_distribution<float> uniform(0.02f, 1.0f);
        for (int i = 0; i < kWidth * kHeight; ++i) {
            const float grey = uniform(random);
            rgb_.insert(rgb_.end(), {0.5f * grey, grey, 0.8f * grey});
        }
        for (std::size_t i = 0; i < 3; ++i) rgb_[3 * (3 * kWidth + 15) + i] = 40;  // a sun, next to the seam
        picture("sky.exr", kWidth, kHeight, rgb_);
    }
    static std::string emitter(const std::string& more = "") {
        return R"(<emitter type="envmap"><string name="filename" value="sky.exr"/>)" + more + "</emitter>";
    }
    /// Radiance (green) in double; columns at half integers, rows from pole to pole.
    [[nodiscard]] double radiance(const Vec& d) const {
        double u = std::atan2(d[0], -d[2]) / (2 * kPi);
        const double v = std::acos(std::clamp(d[1], -1.0, 1.0)) / kPi;
        const double x = u * kWidth - 0.5, x0 = std::floor(x), y = v * (kHeight - 1);
        const int row = std::min(static_cast<int>(y), kHeight - 2);
        const auto at = [&](double column, int k) {
            const int i = (static_cast<int>(column) + 2 * kWidth) % kWidth;
            return static_cast<double>(rgb_[static_cast<std::size_t>(3 * (k * kWidth + i) + 1)]);
        };
        return (at(x0, row) * (x0 + 1 - x) + at(x0 + 1, row) * (x - x0)) * (row + 1 - y) +
               (at(x0, row + 1) * (x0 + 1 - x) + at(x0 + 1, row + 1) * (x - x0)) * (y - row);
    }
    std::vector<float> rgb_;
};

// Mitsuba computes in float32 too: u and v are known to some 1e-7, times 7 columns, times the largest step between
// texels, 300. Next to the poles its acos(y) makes an error of 6e-8 / sin(polar angle), times 4 rows, times 300.
TEST_F(EnvironmentLight, RadianceIsMitsubas) {
    const nlohmann::json e = oracle().at("environment");
    picture("oracle.exr", e.at("width"), e.at("height"), e.at("texels"));
    const Scene scene = load(R"(<emitter type="envmap"><string name="filename" value="oracle.exr"/>
        <float name="scale" value="2.5"/><transform name="to_world"><rotate x="0.2857142857" y="0.4285714286" z="0.8571428571" angle="40"/></transform>
        </emitter>)");
    const shared::Light& light = scene.lights.at(0);
    LightKernels kernels(scene);
    std::vector<Vec> directions;
    for (const auto& c : e.at("cases")) directions.push_back(c.at("direction"));
    const std::vector<Environment> found = kernels.environment(directions, kUp);
    ASSERT_GT(found.size(), 300u);
    double worst = 0;
    for (std::size_t i = 0; i < found.size(); ++i) {
        const double y = dot(directions[i], {light.e2x, light.e2y, light.e2z});
        const double sine = std::sqrt(std::max(1 - y * y, 1e-7));
        for (std::size_t c = 0; c < 3; ++c) {
            const double want = e.at("cases")[i].at("radiance")[c], difference = found[i].radiance[c] - want;
            EXPECT_NEAR(difference, 0, 5e-4 + 1e-5 * want + (sine < 0.01 ? 6e-8 / sine * 4 / kPi * 300 : 0))
                << "case " << i << ", channel " << c;
            if (sine > 0.01) worst = std::max(worst, std::abs(difference));
        }
    }
    RecordProperty("worst_difference", std::to_string(worst));
}

TEST_F(EnvironmentLight, SamplesHaveTheirDensity) {
    for (const std::string more : {"", R"(<transform name="to_world"><rotate x="1" y="-1" z="0.5" angle="70"/>
                                       <scale x="-1"/></transform>)"})
        expect_samples_of_density(load(emitter(more)), kWidth, kHeight, {0.3, 0.2, 0.1}, kUp, false);
}

// CPU devices search the picture for a tile of samples in step. Pictures of any size, with black rows and columns;
// random numbers at both ends of their range, and a last tile that is not full. The same but for rounding.
TEST_F(EnvironmentLight, SamplesInATileAreThoseOfEachAlone) {
    for (const auto& [width, height] : {std::pair{16, 9}, {7, 5}, {2, 2}, {33, 130}}) {
        std::mt19937 random(5);
        std::uniform_real_distribution<float> uniform(0.02f, 1.0f);
        std::vector<float> rgb;
        for (int i = 0; i < width * height; ++i) {
            const bool black = width > 2 && (i / width % 4 == 1 || i % width % 3 == 1);
            for (int c = 0; c < 3; ++c) rgb.push_back(black ? 0.0f : uniform(random));
        }
        picture("tiles.exr", width, height, rgb);
        const Scene scene = load(R"(<emitter type="envmap"><string name="filename" value="tiles.exr"/></emitter>)");
        std::vector<LightKernels::TileQuestion> questions;
        for (const std::array<float, 2>& uv : random_pairs(4003, 12)) questions.push_back({{0.1, 0.2, 0.3}, kUp, uv});
        for (const float u : {0.0f, 0.5f, 0.99999994f})
            for (const float v : {0.0f, 0.5f, 0.99999994f}) questions.push_back({{0, 0, 0}, kUp, {u, v}});
        SCOPED_TRACE(::testing::Message() << width << " x " << height);
        expect_tiles_as_alone(scene, questions);
    }
}

// The flux of the sun's four cells is most of the sky's: samples have to find it as often as it shines. Irradiance
// against the midpoint rule on 1600 x 800 directions.
TEST_F(EnvironmentLight, IrradianceIsTheIntegral) {
    const Scene scene = load(emitter(R"(<float name="scale" value="3"/>)"));
    LightKernels kernels(scene);
    for (const Vec n : {Vec{0, 0, 1}, Vec{0.6, 0, -0.8}, Vec{0, -1, 0}, Vec{-0.36, 0.48, 0.8}}) {
        constexpr int kAcross = 1600, kDown = 800;
        double expected = 0, mean = 0;
        for (int row = 0; row < kDown; ++row)
            for (int column = 0; column < kAcross; ++column) {
                const Vec d = picture_direction((column + 0.5) / kAcross, (row + 0.5) / kDown);
                const double angle =
                    2 * kPi / kAcross * (std::cos(kPi * row / kDown) - std::cos(kPi * (row + 1) / kDown));
                expected += 3 * radiance(d) * std::max(dot(d, n), 0.0) * angle;
                mean += 3 * radiance(d) * angle / (4 * kPi);
            }
        const Estimate e = sampled_irradiance(kernels, {0, 0, 0}, n, 1u << 18);
        EXPECT_LE(e.error(), 0.005 * expected + 0.01);
        EXPECT_NEAR(e.mean(), expected, 5 * e.error() + 1e-4 * expected);
        EXPECT_NEAR(double{scene.lights[0].g}, mean, 1e-4 * mean);
    }
}

// Black but for one texel: nothing else is sampled, and nothing of it is missed. Its flux is known: bilinear tents.
TEST_F(EnvironmentLight, OneBrightTexel) {
    for (const int row : {0, 4, kHeight - 1}) {
        std::fill(rgb_.begin(), rgb_.end(), 0.0f);
        const std::size_t at = static_cast<std::size_t>(3 * (row * kWidth + 7));
        rgb_[at] = rgb_[at + 1] = rgb_[at + 2] = 1000;
        picture("sky.exr", kWidth, kHeight, rgb_);
        LightKernels kernels(load(emitter()));
        Estimate flux;
        for (const Sample& s : kernels.samples({0, 0, 0}, kUp, random_pairs(1u << 10, 2))) {
            ASSERT_TRUE(s.valid);
            EXPECT_GT(s.environment_density, 0);
            flux.add(s.radiance[1]);
        }
        // 2 pi / width times the integral of a tent of half width h around theta: 2 sin(theta) (1 - cos h) / h; at a
        // pole half of it is there: 1 - sin(h) / h.
        const double h = kPi / (kHeight - 1), theta = h * row;
        const double tent = row == 4 ? 2 * std::sin(theta) * (1 - std::cos(h)) / h : 1 - std::sin(h) / h;
        const double expected = 1000 * 2 * kPi / kWidth * tent;
        EXPECT_NEAR(flux.mean(), expected, 5 * flux.error() + 1e-5 * expected) << "row " << row;
    }
}

// Among other lights densities hold the light's probability; so does the constant environment's.
TEST_F(EnvironmentLight, DensityHoldsTheChoice) {
    const std::string lamp = R"(<emitter type="point"><rgb name="intensity" value="2"/></emitter>)";
    LightKernels alone(load(emitter()));
    const Scene both = load(lamp + emitter());
    ASSERT_EQ(both.info.environment_light, 1);
    const double probability = both.lights[1].probability;
    EXPECT_GT(probability, 0.05);
    EXPECT_LT(probability, 0.95);
    LightKernels with(both);
    const std::vector<Vec> directions{{0, 0, 1}, {0.6, 0, 0.8}, {0.48, -0.6, 0.64}, {0, -0.8, -0.6}};
    const auto a = alone.environment(directions, kUp), b = with.environment(directions, kUp);
    for (std::size_t i = 0; i < directions.size(); ++i) {
        EXPECT_NEAR(b[i].density, probability * a[i].density, 1e-6 * a[i].density);
        EXPECT_EQ(a[i].radiance, b[i].radiance);
    }
    const Scene constant =
        load(lamp + R"(<emitter type="constant"><rgb name="radiance" value="0.1, 0.2, 0.3"/></emitter>)");
    const auto c = LightKernels(constant).environment(directions, kUp);
    for (std::size_t i = 0; i < directions.size(); ++i) {
        EXPECT_NEAR(c[i].density, constant.lights[1].probability * std::max(directions[i][2], 0.0) / kPi, 1e-7);
        EXPECT_FLOAT_EQ(static_cast<float>(c[i].radiance[1]), 0.2f);
    }
    const auto none = LightKernels(load(lamp)).environment(directions, kUp);
    for (const Environment& e : none) {
        EXPECT_EQ(e.density, 0);
        EXPECT_EQ(e.radiance, (Vec{0, 0, 0}));
    }
    // The mixture of samples is that of their densities: irradiance of both lights by one estimate.
    const Estimate sky = sampled_irradiance(alone, {0, 0, -1}, {0, 0, 1}, 1u << 17);
    const Estimate all = sampled_irradiance(with, {0, 0, -1}, {0, 0, 1}, 1u << 17);
    EXPECT_NEAR(all.mean(), sky.mean() + 2, 5 * (all.error() + sky.error()));
}

}  // namespace
}  // namespace irradia::test
