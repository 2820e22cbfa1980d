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
    std::vector<Environment> environment(const std::vector<Vec>& directions, const Vec& n) {
        std::vector<float> in;
        for (const Vec& d : directions) {
            add(in, d);
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
