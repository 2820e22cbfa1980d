// BSDFs under bump and normal maps against Mitsuba 3 (tests/data/vectors/bsdf_maps.json, by
// tests/data/make_bsdf_maps.py): the loader's reading of them, the perturbed frame, what the bump lets through.
#include <OpenImageIO/imageio.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>

#include "device.h"
#include "irradia/Scene.h"
#include "irradia/SceneLoader.h"

namespace irradia::test {
namespace {

class BsdfMaps : public ::testing::Test {
protected:
    void SetUp() override {
        folder_ = std::filesystem::temp_directory_path() / ("irradia-maps-" + std::to_string(::getpid()));
        std::filesystem::create_directories(folder_);
        for (const auto& [name, picture] : oracle_.at("pictures").items()) {
            const std::string path = (folder_ / name).string();
            const std::vector<float> rgb = picture.at("rgb");
            auto out = OIIO::ImageOutput::create(path);
            ASSERT_TRUE(out && out->open(path, OIIO::ImageSpec(picture.at("width"), picture.at("height"), 3,
                                                               OIIO::TypeDesc::FLOAT)));
            ASSERT_TRUE(out->write_image(OIIO::TypeDesc::FLOAT, rgb.data()));
            out->close();
        }
        std::ofstream(folder_ / "leaning.obj") << oracle_.at("obj").get<std::string>();
    }
    void TearDown() override { std::filesystem::remove_all(folder_); }

    /// Diffuse, glossy, density; seven floats for each place, view and direction, in this order; `questions` of them.
    [[nodiscard]] std::vector<float> values(const std::string& bsdf, std::size_t questions = 1000000) const {
        const std::string path = (folder_ / "scene.xml").string();
        std::ofstream(path) << R"(<scene version="3.0.0"><sensor type="perspective"/><shape type="obj">
            <string name="filename" value="leaning.obj"/>)"
                            << bsdf << R"(</shape><emitter type="constant"/></scene>)";
        const Scene s = load_scene(path, {});
        std::vector<float> in;
        for (const json& place : oracle_.at("places"))
            for (const json& view : oracle_.at("views"))
                for (const json& w : oracle_.at("directions"))
                    for (const json& part : {view, w, place})
                        for (const json& x : part) in.push_back(x.get<float>());
        const std::size_t count = std::min(in.size() / 8, questions);
        std::vector<float> out(7 * count);
        Device& d = device();
        const std::uint32_t features =
            IR_FEATURE_TEXTURES | IR_FEATURE_SMOOTH_NORMALS | IR_FEATURE_BUMPS | IR_FEATURE_BSDFS;
        Kernel kernel = d.kernel("bsdf_test.cl", "test_bsdf_at", {{"IR_FEATURES", std::to_string(features) + "u"}});
        std::vector<Buffer> buffers;
        const auto put = [&]<class T>(const std::vector<T>& v) {
            buffers.push_back(v.empty() ? d.upload(std::vector<std::uint32_t>{0}) : d.upload(v));
        };
        const std::vector<std::uint32_t> nothing;  // no rays are traced, no lights sampled
        put(nothing), put(nothing), put(s.analytics), put(s.triangles), put(s.vertices);
        put(s.materials), put(s.textures), put(s.texels), put(nothing), put(std::vector<shared::SceneInfo>{s.info});
        put(in), put(out);
        for (const Buffer& b : buffers) kernel.arg(b);
        kernel.arg(static_cast<std::uint32_t>(count)).run((count + 63) / 64, 64);
        d.read(buffers.back(), out.data(), out.size() * sizeof(float));
        return out;
    }

    const json oracle_ = load_vectors("bsdf_maps");
    std::filesystem::path folder_;
};

// Within 2e-4, as all BSDFs are; rough coats' two quadratures agree within 1e-3, and their share of the densities, that
// goes by the little which a coat does not let pass, within 8e-3.
TEST_F(BsdfMaps, AreMitsubas) {
    std::size_t bright = 0;
    for (const json& bsdf : oracle_.at("bsdfs")) {
        const std::string xml = bsdf.at("xml");
        const bool coat = xml.find("roughplastic") != std::string::npos;
        const std::vector<float> found = values(xml);
        const std::vector<double> wanted = bsdf.at("values"), densities = bsdf.at("densities");
        ASSERT_EQ(found.size(), 7 * wanted.size());
        const double most = *std::max_element(wanted.begin(), wanted.end());
        const double densest = *std::max_element(densities.begin(), densities.end());
        const std::size_t ways = oracle_.at("directions").size(), views = oracle_.at("views").size();
        for (std::size_t i = 0; i < wanted.size(); ++i) {
            const json& view = oracle_.at("views").at(i / ways % views);
            const std::string what = xml + " place " + std::to_string(i / ways / views) + " view " + view.dump() +
                                     " direction " + std::to_string(i % ways);
            const auto value = static_cast<double>(found[7 * i + 1] + found[7 * i + 4]);
            EXPECT_NEAR(value, wanted[i], (coat ? 1e-3 : 2e-4) * wanted[i] + 1e-6 * most) << what;
            if (wanted[i] == 0) continue;  // where nothing is reflected, how likely it is does not matter
            ++bright;
            EXPECT_NEAR(static_cast<double>(found[7 * i + 6]), densities[i],
                        (coat ? 8e-3 : 2e-4) * densities[i] + 1e-6 * densest)
                << what;
        }
    }
    EXPECT_GT(bright, 2000u);
}

// Heights that do not count leave the surface as it is: the same frame, and nothing in the shade.
TEST_F(BsdfMaps, OfNoHeightDoNothing) {
    const std::string plain = R"(<bsdf type="diffuse"><float name="reflectance" value="0.6"/></bsdf>)";
    const std::string flat = R"(<bsdf type="bumpmap"><float name="scale" value="0"/><texture type="bitmap" name="map">
        <string name="filename" value="heights.exr"/><boolean name="raw" value="true"/></texture>)" +
                             plain + "</bsdf>";
    const std::vector<float> with = values(flat, 36), without = values(plain, 36);
    float brightest = 0;
    for (std::size_t i = 0; i < with.size(); ++i) {
        EXPECT_NEAR(with[i], without[i], 1e-6);
        brightest = std::max(brightest, with[i]);
    }
    EXPECT_GT(brightest, 0.1f);
}

}  // namespace
}  // namespace irradia::test
