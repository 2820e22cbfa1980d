// Spots, textured area lights and cylinders on the device: against Mitsuba (tests/data/vectors/emitters.json), closed
// forms, and sums in double over the light.
#include <functional>
#include <nlohmann/json.hpp>

#include "light_kernels.h"

namespace irradia::test {
namespace {

// ---- spots ---------------------------------------------------------------------------------------------------------

class SpotLight : public LightTest {};

// The weight of Mitsuba's sample is intensity times falloff over squared distance; 4e-6 of the angle (float32, both)
// are up to 2e-5 of the falloff near the edge of a cone.
TEST_F(SpotLight, IsMitsubas) {
    std::ifstream file(IRRADIA_SOURCE_DIR "/tests/data/vectors/emitters.json");
    const nlohmann::json oracle = nlohmann::json::parse(file);
    int lit = 0, dark = 0;
    for (const auto& spot : oracle.at("spots")) {
        std::string parameters =
            R"(<float name="cutoff_angle" value=")" + std::to_string(spot.at("cutoff_angle").get<double>()) + "\"/>";
        if (!spot.at("beam_width").is_null())
            parameters +=
                R"(<float name="beam_width" value=")" + std::to_string(spot.at("beam_width").get<double>()) + "\"/>";
        LightKernels kernels(load(R"(<emitter type="spot"><rgb name="intensity" value="3, 2, 1"/>)" + parameters +
                                  R"(<transform name="to_world"><lookat origin="1, 2, 3" target="0.5, -1, 0.25"
                                     up="0, 1, 0"/></transform></emitter>)"));
        for (const auto& c : spot.at("cases")) {
            const Sample s = kernels.samples(c.at("point"), {0, 0, 1}, {{0.5f, 0.5f}}).at(0);
            const Vec want = c.at("irradiance");
            EXPECT_EQ(s.density, 0);
            ++(s.valid ? lit : dark);
            for (std::size_t i = 0; i < 3; ++i)
                EXPECT_NEAR(s.valid ? s.radiance[i] : 0, want[i], 1e-4 * want[i] + 1e-6)
                    << "cutoff " << spot.at("cutoff_angle") << ", " << c.at("degrees") << " degrees";
        }
    }
    EXPECT_GT(lit, 15);
    EXPECT_GT(dark, 6);
}

// intensity / distance^2 on the axis and up to beam_width; between the cones linear in the angle; nothing beyond.
TEST_F(SpotLight, IsItsClosedForm) {
    LightKernels kernels(load(R"(<emitter type="spot"><rgb name="intensity" value="8"/><float name="cutoff_angle"
        value="30"/><float name="beam_width" value="10"/></emitter>)"));  // at the origin, along +z
    for (const double degrees : {0.0, 5.0, 9.99, 10.01, 15.0, 20.0, 29.0, 29.999, 30.001, 45.0, 90.0, 179.0}) {
        const double angle = degrees * kPi / 180, distance = 2.5;
        const Vec p{distance * std::sin(angle) * 0.6, distance * std::sin(angle) * -0.8, distance * std::cos(angle)};
        const Sample s = kernels.samples(p, {0, 0, -1}, {{0.1f, 0.9f}}).at(0);
        const double falloff = degrees <= 10 ? 1 : std::max((30 - degrees) / 20, 0.0);
        EXPECT_EQ(s.valid, falloff > 0) << degrees;
        EXPECT_NEAR(s.valid ? s.radiance[1] : 0, 8 / (distance * distance) * falloff, 3e-6) << degrees;
        if (s.valid) {
            EXPECT_NEAR(s.distance, distance, 1e-6);
        }
    }
}

// ---- area lights: any surface x(a, b), a and b in [0, 1], that emits radiance(a, b) along its normal --------------

struct Emitter {
    std::function<Vec(double, double)> point, normal;
    std::function<double(double, double)> radiance;
    double area;  // of which a and b take equal parts
};

/// Irradiance at p by the midpoint rule.
double integrated_irradiance(const Emitter& e, const Vec& p, const Vec& n) {
    constexpr int kSteps = 600;
    double sum = 0;
    for (int i = 0; i < kSteps; ++i)
        for (int k = 0; k < kSteps; ++k) {
            const double a = (i + 0.5) / kSteps, b = (k + 0.5) / kSteps;
            const Vec d = e.point(a, b) - p;
            const double square = dot(d, d), out = -dot(d, e.normal(a, b)), in = dot(d, n);
            if (out > 0 && in > 0) sum += e.radiance(a, b) * out * in / (square * square);
        }
    return sum * e.area / (kSteps * kSteps);
}

void expect_irradiance(const Scene& scene, const Emitter& e, const Vec& p, const Vec& n, double noise = 0.005) {
    LightKernels kernels(scene);
    const Vec centre{scene.centre[0], scene.centre[1], scene.centre[2]};
    const Estimate found = sampled_irradiance(kernels, p - centre, n, 1u << 17);
    const double want = integrated_irradiance(e, p, n);
    EXPECT_GT(want, 0);
    EXPECT_LE(found.error(), noise * want);
    EXPECT_NEAR(found.mean(), want, 5 * found.error() + 1e-3 * want) << "at " << p[0] << " " << p[1] << " " << p[2];
}

class TexturedLight : public LightTest {
protected:
    static constexpr int kWidth = 4, kHeight = 3;
    void SetUp() override {
        LightTest::SetUp();
        std::mt19937 random(17);
        std::uniform_real_distribution<float> uniform(0.0f, 5.0f);
        for (int i = 0; i < 3 * kWidth * kHeight; ++i) rgb_.push_back(uniform(random));
        picture("glow.exr", kWidth, kHeight, rgb_);
    }
    static std::string emitter() {
        return R"(<emitter type="area"><texture type="bitmap" name="radiance"><string name="filename" value="glow.exr"/>
            </texture></emitter>)";
    }
    [[nodiscard]] double texture(double u, double v) const { return bilinear(rgb_, kWidth, kHeight, u, v); }
    /// Mean over the light, by the midpoint rule. The loader takes it at 16 x 16 points at least: to 0.3 %.
    static double mean(const Emitter& e) {
        double sum = 0;
        for (int i = 0; i < 500; ++i)
            for (int k = 0; k < 500; ++k) sum += e.radiance((i + 0.5) / 500, (k + 0.5) / 500);
        return sum / 250000;
    }
    std::vector<float> rgb_;
};

// Near (sampled in solid angle) and far (by area). Mitsuba's rectangle: (u, v) = (0, 0) at (-1, -1), (1, 1) at (1, 1).
TEST_F(TexturedLight, Rectangle) {
    const Scene scene = load(R"(<shape type="rectangle"><transform name="to_world"><scale x="1.5" y="0.5"/>
        <rotate x="1" angle="180"/><translate z="2"/></transform>)" +
                             emitter() + "</shape>");
    ASSERT_EQ(scene.lights.size(), 1u);
    EXPECT_EQ(scene.lights[0].kind, IR_LIGHT_QUAD);
    const Emitter e{[](double a, double b) {
                        return Vec{1.5 * (2 * a - 1), -0.5 * (2 * b - 1), 2};
                    },
                    [](double, double) {
                        return Vec{0, 0, -1};
                    },
                    [&](double a, double b) { return texture(a, b); }, 3};
    EXPECT_NEAR(scene.lights[0].g, mean(e), 3e-3 * mean(e));
    for (const Vec p : {Vec{0.3, 0.1, 1.2}, Vec{1.4, -0.4, 1.5}, Vec{-0.5, 0.7, 0.1}, Vec{3, 4, -9}})
        expect_irradiance(scene, e, p, {0, 0, 1});
}

// ---- rectangles without a texture: receivers in tiles --------------------------------------------------------------

class RectangleLight : public LightTest {
protected:
    [[nodiscard]] Scene lamp() const {  // 3 x 1 at z = 2, facing down
        return load(R"(<shape type="rectangle"><transform name="to_world"><scale x="1.5" y="0.5"/>
            <rotate x="1" angle="180"/><translate z="2"/></transform><emitter type="area">
            <rgb name="radiance" value="3, 2, 1"/></emitter></shape>)");
    }
    /// Of world positions.
    static std::vector<std::array<Sample, 2>> samples(const Scene& scene,
                                                      std::vector<LightKernels::TileQuestion> questions) {
        for (auto& q : questions) q.p = q.p - Vec{scene.centre[0], scene.centre[1], scene.centre[2]};
        return LightKernels(scene).tile_samples(questions);
    }
};

// CPU devices sample it for eight receivers at once (light_cpu.h). Both ways round differently: by 1e-5 of the
// direction as Device32 has it, more as the receiver nears the lamp's plane; the density of an area sample goes with
// the cosine there.
TEST_F(RectangleLight, ReceiversTogetherGetTheSamplesOfEachAlone) {
    const Scene scene = lamp();
    ASSERT_EQ(scene.lights.size(), 1u);
    ASSERT_EQ(scene.lights[0].kind, IR_LIGHT_QUAD);
    std::mt19937 random(23);
    std::uniform_real_distribution<double> unit(0, 1);
    std::vector<LightKernels::TileQuestion> questions;
    for (int i = 0; i < 4003; ++i) {  // near, far, under the lamp at all heights, behind it; the last tile is not full
        const double size = i % 4 == 0 ? 30 : 3,
                     height = i % 4 == 1 ? std::pow(10, -5 * unit(random)) : size * unit(random);
        questions.push_back(
            {{size * (unit(random) - 0.5), size * (unit(random) - 0.5), i % 4 == 2 ? 2 + height : 2 - height},
             {0, 0, 1},
             {static_cast<float>(unit(random)), static_cast<float>(unit(random))}});
    }
    const std::vector<std::array<Sample, 2>> found = samples(scene, questions);
    int lit = 0, dark = 0;
    for (std::size_t i = 0; i < found.size(); ++i) {
        const auto& [together, alone] = found[i];
        const Vec& p = questions[i].p;
        SCOPED_TRACE(::testing::Message() << "receiver " << i << " at " << p[0] << " " << p[1] << " " << p[2]);
        ASSERT_EQ(together.valid, alone.valid);
        ++(alone.valid ? lit : dark);
        if (!alone.valid) continue;
        double size = 0;  // the largest distance in the picture
        for (const double x : {-1.5, 1.5})
            for (const double y : {-0.5, 0.5}) size = std::max(size, length(Vec{x, y, 2} - p));
        const double steep = std::max(1.0, 0.1 * size / (2 - p[2]));
        EXPECT_LE(length(together.direction - alone.direction), 4e-5 * steep);
        EXPECT_NEAR(together.distance, alone.distance, 4e-5 * steep * alone.distance);
        EXPECT_NEAR(together.density, alone.density, 1e-4 * steep * alone.density);
        EXPECT_NEAR(together.cosine, alone.cosine, 4e-5 * steep);
        for (std::size_t k = 0; k < 3; ++k)
            EXPECT_NEAR(together.radiance[k] * together.density, 3.0 - static_cast<double>(k), 1e-5);
    }
    EXPECT_GT(lit, 2900);
    EXPECT_GT(dark, 900);
}

TEST_F(RectangleLight, ReceiversTogetherMeanTheIntegral) {
    const Scene scene = lamp();
    const Emitter e{[](double a, double b) {
                        return Vec{1.5 * (2 * a - 1), -0.5 * (2 * b - 1), 2};
                    },
                    [](double, double) {
                        return Vec{0, 0, -1};
                    },
                    [](double, double) { return 2.0; }, 3};
    for (const Vec p : {Vec{0.3, 0.1, 1.2}, Vec{1.4, -0.4, 1.5}, Vec{-0.5, 0.7, 0.1}, Vec{3, 4, -9}}) {
        std::vector<LightKernels::TileQuestion> questions;
        for (const auto& uv : random_pairs(1u << 16, 6)) questions.push_back({p, {0, 0, 1}, uv});
        Estimate found;
        for (const auto& [s, alone] : samples(scene, questions))
            found.add(s.valid ? s.radiance[1] * std::max(s.direction[2], 0.0) : 0.0);
        const double want = integrated_irradiance(e, p, {0, 0, 1});
        EXPECT_NEAR(found.mean(), want, 5 * found.error() + 1e-3 * want) << "at " << p[0] << " " << p[1] << " " << p[2];
    }
}

// A sheared rectangle: two triangles, each with its half of the texture.
TEST_F(TexturedLight, Triangles) {
    const Scene scene = load(R"(<shape type="rectangle"><transform name="to_world">
        <matrix value="1 0.5 0 0  0 -1 0 0  0 0 -1 2  0 0 0 1"/></transform>)" +
                             emitter() + "</shape>");
    ASSERT_EQ(scene.lights.size(), 2u);
    const Emitter e{[](double a, double b) {
                        return Vec{2 * a - 1 + 0.5 * (2 * b - 1), 1 - 2 * b, 2};
                    },
                    [](double, double) {
                        return Vec{0, 0, -1};
                    },
                    [&](double a, double b) { return texture(a, b); }, 4};
    EXPECT_NEAR(0.5 * (scene.lights[0].g + scene.lights[1].g), mean(e), 3e-3 * mean(e));
    EXPECT_GT(std::abs(scene.lights[0].g - scene.lights[1].g), 0.05 * mean(e));  // each its own
    for (const Vec p : {Vec{0.3, 0.1, 1.2}, Vec{3, 4, -9}}) expect_irradiance(scene, e, p, {0, 0, 1});
}

// Without texture coordinates of its own a mesh has its barycentrics.
TEST_F(TexturedLight, MeshWithoutCoordinates) {
    std::ofstream(folder_ / "a.obj") << "v -1 -1 2\nv -1 1 2\nv 1 -1 2\nf 1 2 3\n";
    const Scene scene = load(R"(<shape type="obj"><string name="filename" value="a.obj"/>)" + emitter() + "</shape>");
    const Emitter e{[](double a, double b) {
                        const double r = std::sqrt(a), u = r * (1 - b), v = r * b;
                        return Vec{-1 + 2 * v, -1 + 2 * u, 2};
                    },
                    [](double, double) {
                        return Vec{0, 0, -1};
                    },
                    [&](double a, double b) { return texture(std::sqrt(a) * (1 - b), std::sqrt(a) * b); }, 2};
    ASSERT_EQ(scene.lights.size(), 1u);
    EXPECT_NEAR(scene.lights[0].g, mean(e), 3e-3 * mean(e));
    for (const Vec p : {Vec{-0.3, -0.1, 1.2}, Vec{3, 4, -9}}) expect_irradiance(scene, e, p, {0, 0, 1});
}

// Mitsuba's sphere: u azimuth over 2 pi, v polar angle over pi; disk: u radius, v azimuth over 2 pi.
TEST_F(TexturedLight, SphereAndDisk) {
    const auto out = [](double a, double b) {
        const double z = 1 - 2 * b, r = std::sqrt(1 - z * z);
        return Vec{r * std::cos(2 * kPi * a), r * std::sin(2 * kPi * a), z};
    };
    const Emitter ball{[&](double a, double b) {
                           return Vec{0, 0, 2} + out(a, b) * 0.5;
                       },
                       out, [&](double a, double b) { return texture(a, std::acos(1 - 2 * b) / kPi); }, kPi};
    const Scene sphere = load(R"(<shape type="sphere"><point name="center" x="0" y="0" z="2"/><float name="radius"
        value="0.5"/>)" + emitter() +
                              "</shape>");
    EXPECT_NEAR(sphere.lights.at(0).g, mean(ball), 3e-3 * mean(ball));
    for (const Vec p : {Vec{0.2, -0.3, 1.1}, Vec{2, 1, 0}}) expect_irradiance(sphere, ball, p, {0, 0, 1});

    const Emitter plate{[](double a, double b) {
                            return Vec{std::sqrt(a) * std::cos(2 * kPi * b), -std::sqrt(a) * std::sin(2 * kPi * b), 2};
                        },
                        [](double, double) {
                            return Vec{0, 0, -1};
                        },
                        [&](double a, double b) { return texture(std::sqrt(a), b); }, kPi};
    const Scene disk = load(R"(<shape type="disk"><transform name="to_world"><rotate x="1" angle="180"/>
        <translate z="2"/></transform>)" +
                            emitter() + "</shape>");
    EXPECT_NEAR(disk.lights.at(0).g, mean(plate), 3e-3 * mean(plate));
    for (const Vec p : {Vec{0.2, -0.3, 0.8}, Vec{2, 1, 0}}) expect_irradiance(disk, plate, p, {0, 0, 1}, 0.01);
}

TEST_F(TexturedLight, RadianceAtCoordinates) {
    LightKernels textured(load(R"(<shape type="rectangle">)" + emitter() + "</shape>"));
    LightKernels plain(load(R"(<shape type="rectangle"><emitter type="area"><rgb name="radiance" value="3, 2, 1"/>
        </emitter></shape>)"));
    std::vector<LightKernels::AreaQuestion> questions;
    for (const double u : {0.0, 0.1, 0.5, 0.83, 1.3}) questions.push_back({{0, 0, 5}, 1, 5, u, 1 - 0.7 * u});
    const auto found = textured.area_light(questions), same = plain.area_light(questions);
    for (std::size_t i = 0; i < questions.size(); ++i) {
        EXPECT_NEAR(found[i].radiance[1], texture(questions[i].u, questions[i].v), 1e-5);
        EXPECT_EQ(same[i].radiance, (Vec{3, 2, 1}));
    }
}

// ---- cylinders -----------------------------------------------------------------------------------------------------

constexpr double kRadius = 0.4, kLength = 1.5;
const Vec kBase{0.2, -0.3, 0.5}, kAxis{0.6, 0.8, 0}, kAcross{0.8, -0.6, 0};  // unit vectors; the third one: z
const double kCylinderArea = 2 * kPi * kRadius * kLength;

Emitter cylinder(double side, std::function<double(double, double)> radiance) {
    const auto out = [](double a) {
        return kAcross * std::cos(2 * kPi * a) + Vec{0, 0, -1} * std::sin(2 * kPi * a);  // x, y, axis: right-handed
    };
    return {[=](double a, double b) { return kBase + kAxis * (kLength * b) + out(a) * kRadius; },
            [=](double a, double) { return out(a) * side; }, std::move(radiance), kCylinderArea};
}

/// That cylinder as the one light of a scene, whose centre is the origin.
Scene cylinder_scene(Scene scene, double side) {
    shared::Light& l = scene.lights.at(0);
    const auto set = [](float& x, float& y, float& z, const Vec& v) {
        x = static_cast<float>(v[0]), y = static_cast<float>(v[1]), z = static_cast<float>(v[2]);
    };
    l.kind = IR_LIGHT_CYLINDER;
    set(l.px, l.py, l.pz, kBase);
    set(l.e1x, l.e1y, l.e1z, kAxis * kLength);
    set(l.e2x, l.e2y, l.e2z, {0, 0, 0});
    set(l.nx, l.ny, l.nz, {side, 0, 0});
    l.radius = static_cast<float>(kRadius);
    l.area = static_cast<float>(kCylinderArea);
    shared::Analytic a{};
    a.kind = IR_ANALYTIC_CYLINDER;
    set(a.px, a.py, a.pz, kBase);
    set(a.nx, a.ny, a.nz, kAxis);
    set(a.ux, a.uy, a.uz, kAcross);
    set(a.vx, a.vy, a.vz, {0, 0, -1});
    a.radius = l.radius;
    a.length = static_cast<float>(kLength);
    a.sign = static_cast<float>(side);
    scene.analytics = {a};
    l.primitive = static_cast<std::uint32_t>(scene.triangles.size());
    scene.features |= IR_FEATURE_ANALYTIC;
    return scene;
}

class CylinderLight : public TexturedLight {
protected:
    [[nodiscard]] Scene plain(double side) const {
        return cylinder_scene(load(R"(<shape type="rectangle"><emitter type="area"><rgb name="radiance" value="2"/>
            </emitter></shape>)"),
                              side);
    }
};

const Vec kOutside{0.9, 0.2, 1.6}, kInside{0.6, 0.25, 0.6};

TEST_F(CylinderLight, IrradianceIsTheIntegral) {
    const auto two = [](double, double) { return 2.0; };
    for (const Vec n : {Vec{0, 0, -1}, Vec{-0.6, 0, -0.8}})
        expect_irradiance(plain(1), cylinder(1, two), kOutside, n, 0.01);
    for (const Vec n : {Vec{0, 0, -1}, Vec{0.6, 0, 0.8}})
        expect_irradiance(plain(-1), cylinder(-1, two), kInside, n, 0.02);
}

// Mitsuba's cylinder: u azimuth over 2 pi, v height.
TEST_F(CylinderLight, Textured) {
    const Scene scene = cylinder_scene(load(R"(<shape type="rectangle">)" + emitter() + "</shape>"), 1);
    const Emitter e = cylinder(1, [this](double a, double b) { return texture(a, b); });
    for (const Vec n : {Vec{0, 0, -1}, Vec{-0.6, 0, -0.8}}) expect_irradiance(scene, e, kOutside, n, 0.01);
}

// Every sample carries the radiance of the point that it lies on; few of them, for oclgrind too.
TEST_F(CylinderLight, SamplesShowTheTexture) {
    const auto check = [&](const Scene& scene, const Vec& p, const std::function<Vec(const Vec&)>& uv) {
        int valid = 0;
        for (const Sample& s : LightKernels(scene).samples(p, {0, 0, 1}, random_pairs(64, 9))) {
            if (!s.valid) continue;
            ++valid;
            const Vec at = uv(p + s.direction * s.distance);
            EXPECT_NEAR(s.radiance[1] * s.density, texture(at[0], at[1]), 2e-4);
        }
        EXPECT_GT(valid, 15);
    };
    const std::string textured = emitter() + "</shape>";
    check(cylinder_scene(load(R"(<shape type="rectangle">)" + textured), 1), kOutside, [](const Vec& point) {
        const Vec d = point - kBase;
        return Vec{std::atan2(-d[2], dot(d, kAcross)) / (2 * kPi), dot(d, kAxis) / kLength, 0};
    });
    const Scene square = load(R"(<shape type="rectangle">)" + textured);
    for (const double height : {0.5, 50.0})  // in solid angle, by area
        check(square, {0.25, -0.125, height}, [](const Vec& p) { return Vec{(p[0] + 1) / 2, (p[1] + 1) / 2, 0}; });
    check(load(R"(<shape type="sphere"><float name="radius" value="0.5"/>)" + textured), {0.5, 0.75, 2},
          [](const Vec& p) {
              return Vec{std::atan2(p[1], p[0]) / (2 * kPi), std::acos(p[2] / 0.5) / kPi, 0};
          });
    check(load(R"(<shape type="disk">)" + textured), {0.5, 0.75, 2}, [](const Vec& p) {
        return Vec{std::sqrt(p[0] * p[0] + p[1] * p[1]), std::atan2(p[1], p[0]) / (2 * kPi), 0};
    });
}

// Parts of the surface, 24 of the azimuth by 12 of the length: a part is chosen as often as light_density() says,
// summed over its solid angle. Chi-square of as many as are seen; from inside, where all of it is, the sum is 1.
TEST_F(CylinderLight, SamplesHaveTheirDensity) {
    for (const double side : {1.0, -1.0}) {
        LightKernels kernels(plain(side));
        const Vec p = side > 0 ? kOutside : kInside;
        const Emitter e = cylinder(side, {});
        constexpr int kAround = 24, kAlong = 12, kFine = 20;
        std::vector<LightKernels::AreaQuestion> questions;
        std::vector<double> angles;
        for (int i = 0; i < kAround * kFine; ++i)
            for (int k = 0; k < kAlong * kFine; ++k) {
                const double a = (i + 0.5) / (kAround * kFine), b = (k + 0.5) / (kAlong * kFine);
                const Vec d = e.point(a, b) - p;
                const double distance = length(d), cosine = -dot(d, e.normal(a, b)) / distance;
                questions.push_back({p, std::max(cosine, 1e-9), distance, 0, 0});
                angles.push_back(std::max(cosine, 0.0) / (distance * distance) * kCylinderArea /
                                 (kAround * kAlong * kFine * kFine));
            }
        const std::vector<AreaLight> densities = kernels.area_light(questions);
        std::vector<double> expected(kAround * kAlong), counts(expected.size());
        for (std::size_t i = 0; i < angles.size(); ++i)
            expected[i / (kAlong * kFine) / kFine * kAlong + i % (kAlong * kFine) / kFine] +=
                densities[i].density * angles[i];
        double sum = 0;
        for (const double x : expected) sum += x;
        if (side < 0) {
            EXPECT_NEAR(sum, 1, 1e-5);
        }

        constexpr std::size_t kSamples = 1u << 18;
        double valid = 0;
        for (const Sample& s : kernels.samples(p, {0, 0, -1}, random_pairs(kSamples, 23))) {
            if (!s.valid) continue;
            ++valid;
            EXPECT_NEAR(s.density, s.light_density, 1e-4 * s.density);
            const Vec d = p + s.direction * s.distance - kBase;
            const double height = dot(d, kAxis);
            EXPECT_NEAR(length(d - kAxis * height), kRadius, 1e-5);
            double a = std::atan2(-d[2], dot(d, kAcross)) / (2 * kPi);
            a -= std::floor(a);
            const int around = std::min(static_cast<int>(a * kAround), kAround - 1);
            const int along = std::clamp(static_cast<int>(height / kLength * kAlong), 0, kAlong - 1);
            ++counts[static_cast<std::size_t>(around * kAlong + along)];
        }
        EXPECT_NEAR(valid / kSamples, sum, 0.005);
        double chi_square = 0, parts = 0;
        for (std::size_t i = 0; i < counts.size(); ++i) {
            const double want = expected[i] * kSamples;
            if (want < 20) {  // at the edge of what is seen
                EXPECT_LE(counts[i], 60);
                continue;
            }
            chi_square += (counts[i] - want) * (counts[i] - want) / want;
            ++parts;
        }
        RecordProperty("chi_square", std::to_string(chi_square) + " of " + std::to_string(parts));
        EXPECT_GT(parts, 60);
        EXPECT_LT(chi_square, parts + 5 * std::sqrt(2 * parts));
    }
}

}  // namespace
}  // namespace irradia::test
