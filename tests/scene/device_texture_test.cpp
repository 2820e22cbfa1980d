// From a picture's file to the device's numbers: textures against Mitsuba 3.9.1 (tests/data/vectors/bitmaps.json says
// what it was asked).
#include <OpenImageIO/imageio.h>

#include <memory>
#include <nlohmann/json.hpp>

#include "irradia/Device.h"
#include "scene_test.h"

namespace irradia::test {
namespace {

using nlohmann::json;

class DeviceTextures : public SceneTest {
protected:
    static void SetUpTestSuite() { device_ = std::make_unique<Device>(DeviceOptions{}); }
    static void TearDownTestSuite() { device_.reset(); }

    static json vectors() {
        std::ifstream file(std::string(IRRADIA_SOURCE_DIR) + "/tests/data/vectors/bitmaps.json");
        return json::parse(file);
    }
    static std::string to_uv(const json& m) {
        if (m.is_null()) return "";
        std::string values;  // as 4 x 4, as which Mitsuba reads a <transform>: the translation is the fourth column
        for (const json& row : m) values += row[0].dump() + " " + row[1].dump() + " 0 " + row[2].dump() + " ";
        return "<transform name=\"to_uv\"><matrix value=\"" + values + "0 0 1 0 0 0 0 1\"/></transform>";
    }
    Scene with_texture(const std::string& name, const std::string& around, const std::string& texture) {
        return load(sensor + lamp + "<shape type=\"rectangle\"><bsdf type=\"" + around + "\"><texture name=\"" + name +
                    "\" " + texture + "</texture>" + (around == "diffuse" ? "" : "<bsdf type=\"diffuse\"/>") +
                    "</bsdf></shape>");
    }
    struct Answer {
        Vec colour;
        double number, du, dv;
    };
    static std::vector<Answer> ask(const Scene& s, const json& points) { return ask(*device_, s, points); }
    static std::vector<Answer> ask(Device& device, const Scene& s, const json& points) {
        std::vector<float> in;
        for (const json& p : points) in.insert(in.end(), {0.0f, p[0].get<float>(), p[1].get<float>()});
        std::vector<float> out(points.size() * 6);
        const Buffer nothing = device.upload(std::vector<std::uint32_t>{0});
        const Buffer textures = device.upload(s.textures), texels = device.upload(s.texels);
        const Buffer from = device.upload(in);
        Buffer to = device.upload(out);
        const auto features = std::to_string(IR_FEATURE_TEXTURES | IR_FEATURE_BUMPS) + "u";
        Kernel k = device.kernel("texture_test.cl", "test_textures", {{"IR_FEATURES", features}});
        for (int i = 0; i < 6; ++i) k.arg(nothing);  // no rays are traced, no materials looked at
        k.arg(textures).arg(texels).arg(nothing).arg(nothing).arg(from).arg(to);
        k.arg(static_cast<std::uint32_t>(points.size())).run((points.size() + 63) / 64, 64);
        device.read(to, out.data(), out.size() * sizeof(float));
        std::vector<Answer> answers;
        for (std::size_t i = 0; i < out.size(); i += 6)
            answers.push_back({{out[i], out[i + 1], out[i + 2]}, out[i + 3], out[i + 4], out[i + 5]});
        return answers;
    }
    static inline std::unique_ptr<Device> device_;
};

TEST_F(DeviceTextures, BitmapsAreMitsubas) {
    const json all = vectors();
    for (const auto& [name, p] : all.at("pictures").items()) {
        const std::vector<std::uint8_t> bytes = p.at("bytes");
        auto out = OIIO::ImageOutput::create(path(name + ".png"));
        ASSERT_TRUE(out->open(path(name + ".png"),
                              OIIO::ImageSpec(p.at("width"), p.at("height"), p.at("channels"), OIIO::TypeDesc::UINT8)));
        ASSERT_TRUE(out->write_image(OIIO::TypeDesc::UINT8, bytes.data()));
        out->close();
    }
    ASSERT_GT(all.at("cases").size(), 5u);
    for (const json& c : all.at("cases")) {
        const std::string picture = c.at("picture"), filter = c.at("filter_type"), wrap = c.at("wrap_mode");
        SCOPED_TRACE(picture + " " + filter + " " + wrap + " " + c.at("to_uv").dump());
        const std::string texture = "type=\"bitmap\"><string name=\"filename\" value=\"" + picture +
                                    ".png\"/><boolean name=\"raw\" value=\"" + c.at("raw").dump() +
                                    "\"/><string name=\"filter_type\" value=\"" + filter +
                                    "\"/><string name=\"wrap_mode\" value=\"" + wrap + "\"/>" + to_uv(c.at("to_uv"));
        const Scene s = with_texture("any", "bumpmap", texture);
        ASSERT_EQ(s.textures.size(), 1u);
        const json& points = c.at("points");
        const std::vector<Answer> found = ask(s, points);
        for (std::size_t i = 0; i < found.size(); ++i) {
            const json& p = points[i];
            // The same bytes and weights in float32; the position in texels, up to 15, is good to 1e-6.
            expect_near(found[i].colour, {p[2], p[3], p[4]}, 5e-6);
            // Mitsuba's luminance has two more digits in its weights: .212671, .715160, .072169.
            EXPECT_NEAR(found[i].number, p[5].get<double>(), 1e-4);
            const double slope = std::abs(p[6].get<double>()) + std::abs(p[7].get<double>());
            EXPECT_NEAR(found[i].du, p[6].get<double>(), 5e-4 + 1e-3 * slope);
            EXPECT_NEAR(found[i].dv, p[7].get<double>(), 5e-4 + 1e-3 * slope);
        }
    }
}

TEST_F(DeviceTextures, CheckerboardsAreMitsubas) {
    const json c = vectors().at("checkerboard");
    const auto colour = [&](const char* name) {
        const json& rgb = c.at(name);
        return "<rgb name=\"" + std::string(name) + "\" value=\"" + rgb[0].dump() + " " + rgb[1].dump() + " " +
               rgb[2].dump() + "\"/>";
    };
    const std::string texture = "type=\"checkerboard\">" + colour("color0") + colour("color1") + to_uv(c.at("to_uv"));
    const json& points = c.at("points");
    const std::vector<Answer> colours = ask(with_texture("reflectance", "diffuse", texture), points);
    const std::vector<Answer> numbers = ask(with_texture("opacity", "mask", texture), points);
    ASSERT_GT(points.size(), 20u);
    for (std::size_t i = 0; i < points.size(); ++i) {
        const json& p = points[i];
        expect_near(colours[i].colour, {p[2], p[3], p[4]}, 1e-6);
        EXPECT_NEAR(numbers[i].number, p[5].get<double>(), 1e-4);
        EXPECT_EQ(colours[i].du, 0.0);
        EXPECT_EQ(colours[i].dv, 0.0);
    }
}

// Every byte by IEC 61966-2-1: a table on CPU devices, computed on others (by two roundings and a logarithm).
TEST_F(DeviceTextures, BytesAreDecodedAsTheStandardSays) {
    std::vector<std::uint8_t> bytes;
    json points = json::array();
    for (int i = 0; i < 256; ++i) {
        bytes.insert(bytes.end(), {static_cast<std::uint8_t>(i), static_cast<std::uint8_t>(255 - i),
                                   static_cast<std::uint8_t>((i + 77) % 256)});
        points.push_back({(i + 0.5) / 256, 0.5});
    }
    auto out = OIIO::ImageOutput::create(path("bytes.png"));
    ASSERT_TRUE(out->open(path("bytes.png"), OIIO::ImageSpec(256, 1, 3, OIIO::TypeDesc::UINT8)));
    ASSERT_TRUE(out->write_image(OIIO::TypeDesc::UINT8, bytes.data()));
    out->close();
    const Scene s = with_texture("reflectance", "diffuse",
                                 "type=\"bitmap\"><string name=\"filename\" value=\"bytes.png\"/>"
                                 "<string name=\"filter_type\" value=\"nearest\"/>");
    const auto linear = [](std::uint8_t byte) {
        const double c = byte / 255.0;
        return c <= 0.04045 ? c / 12.92 : std::pow((c + 0.055) / 1.055, 2.4);
    };
    DeviceOptions as_gpu;
    as_gpu.traversal = "gpu";
    Device other(as_gpu);
    for (Device* device : {device_.get(), &other}) {
        const double rounding = device->cpu_traversal() ? 0x1p-24 : 2e-6;
        const std::vector<Answer> found = ask(*device, s, points);
        for (std::size_t i = 0; i < found.size(); ++i)
            for (std::size_t k = 0; k < 3; ++k) {
                const double expected = linear(bytes[3 * i + k]);
                EXPECT_NEAR(found[i].colour[k], expected, rounding * expected) << "byte " << int{bytes[3 * i + k]};
            }
    }
    EXPECT_NE(other.cpu_traversal(), device_->cpu_traversal());
}

}  // namespace
}  // namespace irradia::test
