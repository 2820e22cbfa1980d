// Records carried from one render to the next: what the second one costs and shows; and read by another program.
#include <gtest/gtest.h>

#include <unistd.h>

#include <cmath>
#include <random>

#include "../render/room.h"
#include "irradia/Error.h"
#include "irradia/Points.h"
#include "irradia/RecordFile.h"

namespace irradia::test {
namespace {

constexpr const char* kCopper =
    R"(<bsdf type="twosided"><bsdf type="roughconductor"><string name="material" value="Cu"/>
    <float name="alpha" value=".3"/></bsdf></bsdf>)";
constexpr const char* kBall =
    R"(<shape type="sphere"><float name="radius" value=".3"/><point name="center" x=".3" y="-.7"
    z=".2"/><bsdf type="diffuse"><rgb name="reflectance" value=".5"/></bsdf></shape>)";

/// The room seen from an angle about its middle.
Scene room_from(const std::string& floor, double angle, int size = 64) {
    std::string text = room(floor, kBall);
    const std::string origin = "0,0.2,2.9";
    text.replace(text.find(origin), origin.size(),
                 std::to_string(2.9 * std::sin(angle)) + ",0.2," + std::to_string(2.9 * std::cos(angle)));
    for (std::size_t at = 0; (at = text.find("value=\"64\"", at)) != std::string::npos; ++at)
        text.replace(at, 10, "value=\"" + std::to_string(size) + "\"");
    return load_text(text);
}

/// Of two pictures' indirect light, over the mean.
struct Difference {
    double largest = 0, rms = 0;
};
Difference difference(const RenderResult& a, const RenderResult& b) {
    const auto &x = a.image.layers[1].data, &y = b.image.layers[1].data;
    double square = 0, mean = 0, largest = 0;
    for (std::size_t i = 0; i < x.size(); ++i) {
        const double d = std::abs(static_cast<double>(x[i]) - static_cast<double>(y[i]));
        largest = std::max(largest, d);
        square += d * d;
        mean += static_cast<double>(x[i]);
    }
    const auto n = static_cast<double>(x.size());
    return {largest / (mean / n), std::sqrt(square / n) / (mean / n)};
}

/// A file in the system's temporary folder, gone at the end.
struct RecordPath {
    std::string path =
        (std::filesystem::temp_directory_path() / ("irradia-carry-" + std::to_string(::getpid()))).string();
    ~RecordPath() { std::filesystem::remove(path); }
    [[nodiscard]] RecordSet through(const RecordSet& set) const {
        write_records(path, set);
        return read_records(path);
    }
};

struct Kind {
    const char* name;
    Method method;
    GlossyRule glossy;
};

class Carried : public ::testing::TestWithParam<Kind> {
protected:
    [[nodiscard]] RenderSettings settings() const {
        RenderSettings s;
        s.method = GetParam().method;
        s.glossy = GetParam().glossy;
        s.spp = 32;
        s.aovs = {"indirect"};
        s.hemisphere_m = 8;
        s.hemisphere_n = 24;
        return s;
    }
    [[nodiscard]] Scene scene(double angle = 0, int size = 64) const {
        return room_from(GetParam().method == Method::radiance ? kCopper : grey_floor, angle, size);
    }
    RecordPath file_;
};

// The same picture again: no new record. Every sample finds the records that it found in the end of the first render;
// pixels that were done before the last records were made have them now too. Of diffuse surfaces that is rounding (the
// octree is built in another order); glossy ones miss records more often while they are shaded. What the records alone
// say, a third render, is the same to the bit.
TEST_P(Carried, SamePictureCostsNothing) {
    const Scene scene = this->scene();
    Device device({});
    RecordSet set;
    const RenderResult first = render(scene, device, settings(), {}, &set);
    EXPECT_EQ(first.statistics.records, set.irradiance.size());
    EXPECT_EQ(first.statistics.radiance_records, set.radiance.size());
    ASSERT_GT(set.irradiance.size(), 50u);
    EXPECT_EQ(set.radiance.size() > 0, GetParam().method == Method::radiance);
    EXPECT_EQ(set.views.size(), 1u);

    RecordSet loaded = file_.through(set);
    const RenderResult second = render(scene, device, settings(), {}, &loaded);
    EXPECT_EQ(loaded.irradiance.size(), set.irradiance.size());
    EXPECT_EQ(loaded.radiance.size(), set.radiance.size());
    EXPECT_EQ(loaded.views.size(), 1u);
    const Difference d = difference(first, second);
    std::printf("%s: %zu and %zu records; second picture differs by %.2g of the mean, at most by %.2g\n",
                GetParam().name, set.irradiance.size(), set.radiance.size(), d.rms, d.largest);
    RenderSettings s = settings();
    s.seed = 1;
    EXPECT_LT(d.rms, difference(first, render(scene, device, s)).rms / 4) << "of what another seed changes";

    RecordSet again = file_.through(loaded);
    const RenderResult third = render(scene, device, settings(), {}, &again);
    EXPECT_EQ(third.image.layers[0].data, second.image.layers[0].data);
}

// Another camera pays for what it shows anew, and its picture is as near to one with records of its own as such
// pictures are to each other.
TEST_P(Carried, AnotherCameraPaysForNewSurfacesAlone) {
    const Scene here = scene(), there = scene(0.2);
    Device device({});
    RecordSet set;
    render(here, device, settings(), {}, &set);
    const std::size_t known = set.irradiance.size() + set.radiance.size();
    RecordSet loaded = file_.through(set), own, other;
    const RenderResult carried = render(there, device, settings(), {}, &loaded);
    const RenderResult alone = render(there, device, settings(), {}, &own);
    RenderSettings s = settings();
    s.seed = 1;
    const RenderResult noise = render(there, device, s, {}, &other);
    const std::size_t made = loaded.irradiance.size() + loaded.radiance.size() - known,
                      needed = own.irradiance.size() + own.radiance.size();
    const double between = difference(carried, alone).rms, separate = difference(alone, noise).rms;
    std::printf(
        "%s: %zu new records, %zu without those of the other camera; pictures differ by %.4f, with other seeds by "
        "%.4f\n",
        GetParam().name, made, needed, between, separate);
    EXPECT_LT(made, needed / 2);
    EXPECT_LT(between, 1.2 * separate);
    EXPECT_EQ(loaded.views.size(), 2u);
}

INSTANTIATE_TEST_SUITE_P(Kinds, Carried,
                         ::testing::Values(Kind{"irradiance", Method::irradiance, GlossyRule::automatic},
                                           Kind{"samples", Method::radiance, GlossyRule::samples},
                                           Kind{"harmonics", Method::radiance, GlossyRule::harmonics}),
                         [](const auto& kind) { return std::string(kind.param.name); });

TEST(CarriedRecords, OfOtherLayoutAreRefused) {
    const Scene scene = room_from(kCopper, 0, 24);
    Device device({});
    RenderSettings s;
    s.method = Method::radiance;
    s.spp = 1;
    s.hemisphere_m = 4;
    s.hemisphere_n = 16;
    RecordSet set;
    render(scene, device, s, {}, &set);
    ASSERT_GT(set.radiance.size(), 0u);
    EXPECT_EQ(set.radiance.stride, 64u);
    s.hemisphere_n = 24;
    try {
        render(scene, device, s, {}, &set);
        FAIL() << "used";
    } catch (const Error& e) {
        EXPECT_NE(std::string(e.what()).find("64 samples and harmonics of order 0, expected 96"), std::string::npos)
            << e.what();
    }
    // A method that does not use them hands them on, with their own settings.
    s.method = Method::irradiance;
    s.glossy_accuracy = 0.7f;
    const std::size_t count = set.radiance.size();
    const RecordOrigin origin = set.origin;
    render(scene, device, s, {}, &set);
    EXPECT_EQ(set.radiance.size(), count);
    EXPECT_EQ(set.origin.settings.back(), origin.settings.back());
}

// ---- another program -----------------------------------------------------------------------------------------------

struct V3 {
    double x, y, z;
};
double dot(const V3& a, const V3& b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
V3 minus(const V3& a, const V3& b) { return {a.x - b.x, a.y - b.y, a.z - b.z}; }
double size(const V3& a) { return std::sqrt(dot(a, a)); }

/// Indirect irradiance at p from all records of a file, as docs/record-format.md says how they are meant: no octree, in
/// double, nothing but the public header.
std::array<double, 3> interpolate(const RecordSet& set, const V3& p, const V3& n, double accuracy, double overlap) {
    double largest = 0, weights = 0;
    for (std::size_t k = 0; k < 3; ++k)
        largest = std::max({largest, std::abs(static_cast<double>(set.origin.lower[k])),
                            std::abs(static_cast<double>(set.origin.upper[k]))});
    std::array<double, 3> sum{};
    for (std::size_t i = 0; i < set.irradiance.size(); ++i) {
        const shared::RecordKey& k = set.irradiance.keys[i];
        const shared::RecordValue& v = set.irradiance.values[i];
        if (k.coat != 0) continue;
        const V3 pi{k.px, k.py, k.pz}, ni{k.nx, k.ny, k.nz}, t2{k.t2x, k.t2y, k.t2z}, d = minus(p, pi);
        const double along = dot(d, t2), across2 = std::max(dot(d, d) - along * along, 0.0);
        const double s1 = static_cast<double>(k.support1), s2 = static_cast<double>(k.support2);
        const double x = std::sqrt(across2 / (s1 * s1) + along * along / (s2 * s2)) +
                         size(minus(n, ni)) / std::sqrt(2.0) / (accuracy * overlap);
        if (x >= 1) continue;
        const double height = 0.5 * (dot(d, n) + dot(d, ni)), distance = size(d);
        if (height < -(0.05 * distance + std::ldexp(4.0, -23) * largest)) continue;
        if (dot(n, ni) > 0.95 && height > 0.3 * distance) continue;
        const double w = (1 - x) * (1 - x) * (1 + 2 * x);
        const V3 turn{ni.y * n.z - ni.z * n.y, ni.z * n.x - ni.x * n.z, ni.x * n.y - ni.y * n.x};
        weights += w;
        for (std::size_t c = 0; c < 3; ++c) {
            const auto vector = [&](const float* g) { return V3{g[3 * c], g[3 * c + 1], g[3 * c + 2]}; };
            const double e = static_cast<double>(v.e[c]);
            sum[c] += w * std::clamp(e + dot(turn, vector(v.rotation)) + dot(d, vector(v.translation)), 0.0, 2 * e);
        }
    }
    for (double& e : sum) e /= weights;
    return sum;
}

TEST(OtherReaders, InterpolateWhatTheRendererAnswers) {
    const Scene scene = room_from(grey_floor, 0);
    Device device({});
    RenderSettings s;
    s.spp = 16;
    RecordSet set;
    render(scene, device, s, {}, &set);
    // On the floor, a wall, the ball, and in the air, where no picture has put records.
    std::vector<IrradiancePoint> points;
    for (int i = 0; i < 40; ++i) {
        const double t = -0.9 + 1.8 * i / 39;
        points.push_back({{t, -1, 0.3 * t}, {0, 2, 0}});
        points.push_back({{-1, t, 0.1}, {1, 0, 0}});
        points.push_back({{0.2 * t, 0.1, t}, {0, 1, t}});
        const double a = 3 * t;
        points.push_back({{.3 + .3 * std::cos(a), -.7 + .3 * std::sin(a), .2}, {std::cos(a), std::sin(a), 0}});
    }
    const std::size_t before = set.irradiance.size();
    const std::vector<PointIrradiance> answers = irradiance_at(scene, device, s, points, {}, &set);
    EXPECT_GT(set.irradiance.size(), before);
    RecordPath file;
    const RecordSet read = file.through(set);
    double worst = 0;
    for (std::size_t i = 0; i < points.size(); ++i) {
        const IrradiancePoint& q = points[i];
        // Positions are float32: a record made at a point lies at it exactly.
        const double l = std::hypot(q.normal[0], q.normal[1], q.normal[2]);
        const auto rounded = [&](std::size_t k) {
            return static_cast<double>(static_cast<float>(q.position[k] - read.origin.centre[k]));
        };
        const std::array<double, 3> e = interpolate(read, {rounded(0), rounded(1), rounded(2)},
                                                    {q.normal[0] / l, q.normal[1] / l, q.normal[2] / l}, 0.2, 1.75);
        for (std::size_t c = 0; c < 3; ++c) {
            const double answer = static_cast<double>(answers[i].indirect[c]);
            EXPECT_GT(answer, 0) << "point " << i;
            worst = std::max(worst, std::abs(e[c] / answer - 1));
        }
    }
    std::printf("largest relative difference of %zu points: %.2g\n", points.size(), worst);
    EXPECT_LT(worst, 1e-3);
}

// Closed form: inside a sphere of radiance Le and albedo rho, irradiance is pi Le of direct light and pi Le rho / (1 -
// rho) of indirect light at every point of its wall, and in its middle whatever the normal.
TEST(Points, AnswerTheIntegratingSphere) {
    const Scene scene =
        load_text(R"(<scene version="3.0.0">)" + sensor(16, "0,0,.5", "0,0,0", 60) +
                  R"(<shape type="sphere"><float name="radius" value="1"/><boolean name="flip_normals" value="true"/>
        <point name="center" x="5" y="0" z="0"/><bsdf type="diffuse"><rgb name="reflectance" value=".5"/></bsdf>
        <emitter type="area"><rgb name="radiance" value="2"/></emitter></shape></scene>)");
    Device device({});
    RenderSettings s;
    s.spp = 1024;
    s.hemisphere_m = 16;
    s.hemisphere_n = 48;
    std::vector<IrradiancePoint> points;
    for (int i = 0; i < 20; ++i) {
        const double a = 0.3 * i, c = std::cos(a), d = std::sin(a);
        points.push_back({{5 - c, -d, 0}, {c, d, 0}});
        points.push_back({{5, 0, 0}, {c, 0, d}});
    }
    double direct = 0, indirect = 0;
    for (const PointIrradiance& e : irradiance_at(scene, device, s, points)) {
        EXPECT_NEAR(e.indirect[0] / (2 * 3.14159265), 1, 0.03);
        direct += static_cast<double>(e.direct[0]) / static_cast<double>(points.size());
        indirect += static_cast<double>(e.indirect[0]) / static_cast<double>(points.size());
    }
    EXPECT_NEAR(direct / (2 * 3.14159265), 1, 0.01);
    EXPECT_NEAR(indirect / (2 * 3.14159265), 1, 0.01);
    s.max_depth = 2;
    EXPECT_EQ(irradiance_at(scene, device, s, points)[3].indirect[1], 0.0f);
    EXPECT_TRUE(irradiance_at(scene, device, s, {}).empty());
    EXPECT_THROW(irradiance_at(scene, device, s, {{{5, 0, 0}, {0, 0, 0}}}), Error);
    s.method = Method::path;
    EXPECT_THROW(irradiance_at(scene, device, s, points), Error);
}

// Points at random places are looked up in another order than they were given in. Closed form: under a point light of
// intensity I at height 1, E = I / d^3 at distance d from it.
TEST(Points, AnswersLieInTheirOrder) {
    const Scene scene = load_text(R"(<scene version="3.0.0">)" + sensor(16, "0,-3,3", "0,0,0", 60) +
                                  R"(<shape type="rectangle"><transform name="to_world"><scale value="4"/></transform>
        <bsdf type="diffuse"/></shape>
        <emitter type="point"><point name="position" x="1" y="0" z="1"/><rgb name="intensity" value="3"/></emitter>
        </scene>)");
    Device device({});
    RenderSettings s;
    s.spp = 1;
    std::mt19937 random(4);
    std::uniform_real_distribution<double> u(-3, 3);
    std::vector<IrradiancePoint> points(1000);
    for (IrradiancePoint& p : points) p = {{u(random), u(random), 0}, {0, 0, 1}};
    const std::vector<PointIrradiance> answers = irradiance_at(scene, device, s, points);
    ASSERT_EQ(answers.size(), points.size());
    for (std::size_t i = 0; i < points.size(); ++i) {
        const double d = std::hypot(points[i].position[0] - 1, points[i].position[1], 1.0);
        EXPECT_NEAR(static_cast<double>(answers[i].direct[1]) / (3 / (d * d * d)), 1, 1e-5) << i;
    }
}

}  // namespace
}  // namespace irradia::test
