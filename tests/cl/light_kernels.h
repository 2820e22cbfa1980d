// Runs the kernels of cl/light_test.cl over a scene's lights on the default device.
#pragma once
#include <OpenImageIO/imageio.h>
#include <unistd.h>

#include <array>
#include <filesystem>
#include <fstream>
#include <random>

#include "device.h"
#include "irradia/Scene.h"
#include "irradia/SceneLoader.h"

namespace irradia::test {

using Vec = std::array<double, 3>;
inline Vec operator+(const Vec& a, const Vec& b) { return {a[0] + b[0], a[1] + b[1], a[2] + b[2]}; }
inline Vec operator-(const Vec& a, const Vec& b) { return {a[0] - b[0], a[1] - b[1], a[2] - b[2]}; }
inline Vec operator*(const Vec& a, double s) { return {a[0] * s, a[1] * s, a[2] * s}; }
inline double dot(const Vec& a, const Vec& b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }
inline double length(const Vec& a) { return std::sqrt(dot(a, a)); }

struct Sample {
    Vec direction;
    double distance;
    Vec radiance;  // over the density
    double density, cosine;
    bool valid;
    double light_density, environment_density;
};
struct Environment {
    Vec radiance;
    double density;
};
struct AreaLight {
    double density;
    Vec radiance;
};

/// The arrays of a scene that lights need, on the device.
class LightKernels {
public:
    explicit LightKernels(const Scene& scene) : features_(scene.features), buffers_(upload(scene)) {}

    /// A sample a pair of numbers in [0, 1).
    std::vector<Sample> samples(const Vec& p, const Vec& n, const std::vector<std::array<float, 2>>& uv) {
        std::vector<float> in;
        for (const auto& [u, v] : uv) {
            add(in, p);
            add(in, n);
            in.insert(in.end(), {u, v});
        }
        const std::vector<float> out = run("test_light_samples", in, uv.size(), 12);
        std::vector<Sample> all;
        for (std::size_t i = 0; i < uv.size(); ++i) {
            const float* a = out.data() + 12 * i;
            all.push_back({{a[0], a[1], a[2]}, a[3], {a[4], a[5], a[6]}, a[7], a[8], a[9] != 0, a[10], a[11]});
        }
        return all;
    }
    struct TileQuestion {
        Vec p, n;
        std::array<float, 2> uv;
    };
    /// Of each receiver a sample made together with others, and one made alone.
    std::vector<std::array<Sample, 2>> tile_samples(const std::vector<TileQuestion>& questions) {
        std::vector<float> in;
        for (const TileQuestion& q : questions) {
            add(in, q.p);
            add(in, q.n);
            in.insert(in.end(), q.uv.begin(), q.uv.end());
        }
        const std::vector<float> out = run("test_light_tile", in, questions.size(), 20, "light_tile_test.cl");
        std::vector<std::array<Sample, 2>> all(questions.size());
        for (std::size_t i = 0; i < 2 * questions.size(); ++i) {
            const float* a = out.data() + 10 * i;
            all[i / 2][i % 2] = {{a[0], a[1], a[2]}, a[3], {a[4], a[5], a[6]}, a[7], a[8], a[9] != 0, 0, 0};
        }
        return all;
    }
    std::vector<Environment> environment(const std::vector<Vec>& directions, const Vec& n, const Vec& p = {}) {
        std::vector<float> in;
        for (const Vec& d : directions) {
            add(in, d);
            add(in, p);
            add(in, n);
        }
        const std::vector<float> out = run("test_environment", in, directions.size(), 4);
        std::vector<Environment> all;
        for (std::size_t i = 0; i < out.size(); i += 4) all.push_back({{out[i], out[i + 1], out[i + 2]}, out[i + 3]});
        return all;
    }
    struct AreaQuestion {
        Vec p;
        double cosine, distance, u, v;
    };
    std::vector<AreaLight> area_light(const std::vector<AreaQuestion>& questions) {
        std::vector<float> in;
        for (const AreaQuestion& q : questions) {
            add(in, q.p);
            for (const double x : {q.cosine, q.distance, q.u, q.v}) in.push_back(static_cast<float>(x));
        }
        const std::vector<float> out = run("test_area_light", in, questions.size(), 4);
        std::vector<AreaLight> all;
        for (std::size_t i = 0; i < out.size(); i += 4) all.push_back({out[i], {out[i + 1], out[i + 2], out[i + 3]}});
        return all;
    }

private:
    std::uint32_t features_;
    std::vector<Buffer> buffers_;

    static void add(std::vector<float>& to, const Vec& v) {
        for (const double x : v) to.push_back(static_cast<float>(x));
    }
    static std::vector<Buffer> upload(const Scene& s) {
        Device& d = device();
        std::vector<Buffer> b;
        const auto put = [&]<class T>(const std::vector<T>& v) {
            if (v.empty())
                b.push_back(d.upload(std::vector<std::uint32_t>{0}));
            else
                b.push_back(d.upload(v));
        };
        const std::vector<std::uint32_t> nothing;  // no rays are traced
        put(nothing), put(nothing), put(s.analytics), put(s.triangles), put(s.vertices);
        put(s.materials), put(s.textures), put(s.texels), put(s.lights), put(std::vector<shared::SceneInfo>{s.info});
        return b;
    }
    std::vector<float> run(const char* name, const std::vector<float>& in, std::size_t count, std::size_t outputs,
                           const char* file = "light_test.cl") {
        Device& d = device();
        std::vector<float> out(count * outputs);
        const Buffer from = d.upload(in);
        Buffer to = d.upload(out);
        Kernel kernel = d.kernel(file, name, {{"IR_FEATURES", std::to_string(features_) + "u"}});
        for (const Buffer& b : buffers_) kernel.arg(b);
        kernel.arg(from).arg(to).arg(static_cast<std::uint32_t>(count)).run((count + 63) / 64, 64);
        d.read(to, out.data(), out.size() * sizeof(float));
        return out;
    }
};

/// A folder of the test's own, pictures and scenes in it.
class LightTest : public ::testing::Test {
protected:
    void SetUp() override {
        folder_ = std::filesystem::temp_directory_path() / ("irradia-light-" + std::to_string(::getpid()));
        std::filesystem::create_directories(folder_);
    }
    void TearDown() override { std::filesystem::remove_all(folder_); }

    void picture(const std::string& name, int width, int height, const std::vector<float>& rgb) const {
        const std::string path = (folder_ / name).string();
        auto out = OIIO::ImageOutput::create(path);
        ASSERT_TRUE(out && out->open(path, OIIO::ImageSpec(width, height, 3, OIIO::TypeDesc::FLOAT)));
        ASSERT_TRUE(out->write_image(OIIO::TypeDesc::FLOAT, rgb.data()));
        out->close();
    }
    /// Loads a scene whose centre is the origin: a rectangle of edge 2 in the plane z = 0, and `body`.
    [[nodiscard]] Scene load(const std::string& body) const {
        const std::string path = (folder_ / "scene.xml").string();
        std::ofstream(path) << R"(<scene version="3.0.0"><sensor type="perspective"><float name="fov" value="40"/>
            <transform name="to_world"><lookat origin="0, 1, 9" target="0, 0, 0" up="0, 1, 0"/></transform></sensor>
            <shape type="rectangle"/>)"
                            << body << "</scene>";
        return load_scene(path, {});
    }

    std::filesystem::path folder_;
};

inline std::vector<std::array<float, 2>> random_pairs(std::size_t count, unsigned seed) {
    std::mt19937 random(seed);
    std::vector<std::array<float, 2>> uv(count);
    for (auto& pair : uv)
        for (float& x : pair) x = static_cast<float>(random() >> 8) * 0x1p-24f;
    return uv;
}

/// Mean and standard error of numbers taken as independent.
struct Estimate {
    double sum = 0, square = 0, count = 0;
    void add(double x) { sum += x, square += x * x, ++count; }
    [[nodiscard]] double mean() const { return sum / count; }
    [[nodiscard]] double error() const { return std::sqrt(std::max(square / count - mean() * mean(), 0.0) / count); }
};

/// Unit direction at u, v of an environment picture, in the map's axes.
inline Vec picture_direction(double u, double v) {
    const double theta = kPi * v, phi = 2 * kPi * u;
    return {std::sin(theta) * std::sin(phi), std::cos(theta), -std::sin(theta) * std::cos(phi)};
}

/// Samples of an environment picture, the one light, at p, normal n, against their density. Bins: quarters of the
/// picture's cells, in which the density is constant; each expects more than five samples, or, with `rare`, those that
/// do not are one bin together. Pearson's chi-square of k bins has mean k - 1 and variance 2 (k - 1): a limit of 5
/// standard deviations.
inline void expect_samples_of_density(const Scene& scene, int width, int height, const Vec& p, const Vec& n,
                                      bool rare) {
    const shared::Light& light = scene.lights.at(0);
    const Vec axes[3] = {
        {light.e1x, light.e1y, light.e1z}, {light.e2x, light.e2y, light.e2z}, {light.nx, light.ny, light.nz}};
    LightKernels kernels(scene);
    const int across = 2 * width, down = 2 * (height - 1);
    std::vector<Vec> middles;
    std::vector<double> angles;
    for (int row = 0; row < down; ++row)
        for (int column = 0; column < across; ++column) {
            const Vec d = picture_direction((column + 0.5) / across + 0.5 / width, (row + 0.5) / down);
            middles.push_back(axes[0] * d[0] + axes[1] * d[1] + axes[2] * d[2]);
            angles.push_back(2 * kPi / across * (std::cos(kPi * row / down) - std::cos(kPi * (row + 1) / down)));
        }
    const std::vector<Environment> bins = kernels.environment(middles, n, p);
    double sum = 0;
    for (std::size_t i = 0; i < bins.size(); ++i) sum += bins[i].density * angles[i];
    EXPECT_NEAR(sum, 1, 2e-6);

    constexpr std::size_t kSamples = 1u << 19;
    std::vector<double> counts(bins.size());
    std::size_t off = 0;
    std::vector<Vec> directions;
    const std::vector<Sample> samples = kernels.samples(p, n, random_pairs(kSamples, 11));
    for (const Sample& s : samples) {
        ASSERT_TRUE(s.valid);
        ASSERT_NEAR(length(s.direction), 1, 1e-6);
        EXPECT_EQ(s.cosine, 1);
        const Vec d{dot(s.direction, axes[0]), dot(s.direction, axes[1]), dot(s.direction, axes[2])};
        double u = std::atan2(d[0], -d[2]) / (2 * kPi) - 0.5 / width;
        u -= std::floor(u);
        const double v = std::acos(std::clamp(d[1], -1.0, 1.0)) / kPi;
        ++counts[static_cast<std::size_t>(std::min(static_cast<int>(v * down), down - 1) * across +
                                          std::min(static_cast<int>(u * across), across - 1))];
        off += std::abs(s.environment_density - s.density) > 1e-5 * s.density ? 1 : 0;
        directions.push_back(s.direction);
    }
    EXPECT_LE(off, kSamples / 10000);  // directions that rounding moved across the border of a cell
    double chi_square = 0, degrees = -1, rare_count = 0, rare_expected = 0;
    const auto add_bin = [&](double count, double expected) {
        EXPECT_GT(expected, 5);
        chi_square += (count - expected) * (count - expected) / expected;
        ++degrees;
    };
    for (std::size_t i = 0; i < bins.size(); ++i) {
        const double expected = kSamples * bins[i].density * angles[i];
        if (rare && expected <= 5) {
            rare_count += counts[i];
            rare_expected += expected;
        } else {
            add_bin(counts[i], expected);
        }
    }
    if (rare) add_bin(rare_count, rare_expected);
    ::testing::Test::RecordProperty("chi_square", std::to_string(chi_square));
    EXPECT_LT(chi_square, degrees + 5 * std::sqrt(2 * degrees));
    EXPECT_GT(chi_square, degrees - 5 * std::sqrt(2 * degrees));

    // A sample's radiance is that of its direction.
    const std::vector<Environment> found = kernels.environment(directions, n, p);
    for (std::size_t i = 0; i < found.size(); i += 37)
        EXPECT_NEAR(samples[i].radiance[1] * samples[i].density, found[i].radiance[1], 2e-4);
}

/// Samples made together against those made alone: the same but for rounding.
inline void expect_tiles_as_alone(const Scene& scene, const std::vector<LightKernels::TileQuestion>& questions) {
    const std::vector<std::array<Sample, 2>> found = LightKernels(scene).tile_samples(questions);
    for (std::size_t i = 0; i < found.size(); ++i) {
        const auto& [together, alone] = found[i];
        SCOPED_TRACE(::testing::Message() << "sample " << i);
        ASSERT_TRUE(together.valid && alone.valid);
        EXPECT_LE(length(together.direction - alone.direction), 1e-6);
        EXPECT_EQ(together.distance, alone.distance);
        EXPECT_EQ(together.cosine, 1);
        EXPECT_NEAR(together.density, alone.density, 1e-6 * alone.density);
        for (std::size_t k = 0; k < 3; ++k)
            EXPECT_NEAR(together.radiance[k], alone.radiance[k], 1e-5 * (alone.radiance[k] + 1e-3));
    }
}

/// Irradiance of a surface by light samples.
inline Estimate sampled_irradiance(LightKernels& kernels, const Vec& p, const Vec& n, std::size_t count) {
    Estimate e;
    for (const Sample& s : kernels.samples(p, n, random_pairs(count, 5)))
        e.add(s.valid ? s.radiance[1] * std::max(dot(s.direction, n), 0.0) : 0.0);
    return e;
}

/// A bilinear picture that repeats, texel centres at half integers.
inline double bilinear(const std::vector<float>& rgb, int width, int height, double u, double v) {
    const double x = u * width - 0.5, y = v * height - 0.5, x0 = std::floor(x), y0 = std::floor(y);
    const auto at = [&](double i, double k) {
        const int column = (static_cast<int>(i) % width + width) % width;
        const int row = (static_cast<int>(k) % height + height) % height;
        return static_cast<double>(rgb[static_cast<std::size_t>(3 * (row * width + column) + 1)]);
    };
    return (at(x0, y0) * (x0 + 1 - x) + at(x0 + 1, y0) * (x - x0)) * (y0 + 1 - y) +
           (at(x0, y0 + 1) * (x0 + 1 - x) + at(x0 + 1, y0 + 1) * (x - x0)) * (y - y0);
}

}  // namespace irradia::test
