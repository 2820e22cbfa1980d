// From the scene file to the device's numbers: cylinders and thin lenses against Mitsuba 3.9.1 (tests/data/vectors/
// cylinder.json and thin_lens.json say what it was asked). Both sides compute in float32, Mitsuba by other formulas.
#include <memory>
#include <nlohmann/json.hpp>

#include "irradia/Device.h"
#include "scene_test.h"

namespace irradia::test {
namespace {

using nlohmann::json;

class DeviceShapes : public SceneTest {
protected:
    static void SetUpTestSuite() { device_ = std::make_unique<Device>(DeviceOptions{}); }
    static void TearDownTestSuite() { device_.reset(); }

    static json vectors(const std::string& name) {
        std::ifstream file(std::string(IRRADIA_SOURCE_DIR) + "/tests/data/vectors/" + name + ".json");
        json cases = json::parse(file).at("cases");
        EXPECT_FALSE(cases.empty());
        return cases;
    }
    static Vec vec(const json& j) { return {j.at(0), j.at(1), j.at(2)}; }

    template <class T>
    static std::vector<double> run(const std::string& kernel, const T& about, const std::vector<float>& in,
                                   std::size_t stride, std::size_t outputs) {
        const std::size_t count = in.size() / stride;
        std::vector<float> out(count * outputs);
        const Buffer first = device_->upload(std::vector<T>{about}), from = device_->upload(in);
        Buffer to = device_->upload(out);
        Kernel k = device_->kernel("shapes_test.cl", kernel, {});
        k.arg(first).arg(from).arg(static_cast<std::uint32_t>(count)).arg(to).run((count + 63) / 64, 64);
        device_->read(to, out.data(), out.size() * sizeof(float));
        return {out.begin(), out.end()};
    }
    static inline std::unique_ptr<Device> device_;
};

Vec at(const std::vector<double>& v, std::size_t i) { return {v[i], v[i + 1], v[i + 2]}; }

TEST_F(DeviceShapes, CylindersAreMitsubas) {
    for (const json& c : vectors("cylinder")) {
        SCOPED_TRACE(c.at("name").get<std::string>());
        const Scene s = load(sensor + "<shape type=\"cylinder\">" + c.at("shape").get<std::string>() +
                             "<emitter type=\"area\"/></shape>");
        ASSERT_EQ(s.analytics.size(), 1u);
        EXPECT_NEAR(s.lights.at(0).area, c.at("area").get<double>(), 1e-5);
        const auto& i = s.info;
        const Vec lo = vec(c.at("min")), hi = vec(c.at("max")), centre{s.centre[0], s.centre[1], s.centre[2]};
        expect_near(Vec{i.min_x + centre[0], i.min_y + centre[1], i.min_z + centre[2]}, lo, 2e-6);
        expect_near(Vec{i.max_x + centre[0], i.max_y + centre[1], i.max_z + centre[2]}, hi, 2e-6);

        std::vector<float> rays;
        for (const json& hit : c.at("hits")) {
            for (const double x : vec(hit.at("origin")) - centre) rays.push_back(static_cast<float>(x));
            for (const double x : vec(hit.at("direction"))) rays.push_back(static_cast<float>(x));
        }
        const std::vector<double> found = run("test_cylinder", s.analytics[0], rays, 6, 9);
        for (std::size_t k = 0; k < c.at("hits").size(); ++k) {
            const json& hit = c.at("hits")[k];
            // Rounding of origin and direction over the distance, magnified by the slant (a cosine of .2): 1e-5.
            EXPECT_NEAR(found[9 * k], hit.at("t").get<double>(), 1e-5) << k;
            expect_near(at(found, 9 * k + 1), vec(hit.at("p")) - centre, 1e-5);
            expect_near(at(found, 9 * k + 4), vec(hit.at("n")), 3e-5);  // of radius .4 and more
            EXPECT_NEAR(found[9 * k + 7], hit.at("uv")[0].get<double>(), 5e-6) << k;
            EXPECT_NEAR(found[9 * k + 8], hit.at("uv")[1].get<double>(), 1e-5) << k;
        }
    }
}

TEST_F(DeviceShapes, LensRaysAreMitsubas) {
    for (const json& c : vectors("thin_lens")) {
        SCOPED_TRACE(c.at("name").get<std::string>());
        const Scene s = load("<sensor type=\"thinlens\">" + c.at("sensor").get<std::string>() +
                             "</sensor><shape type=\"rectangle\"><transform name=\"to_world\"><translate z=\"-20\"/>"
                             "</transform><emitter type=\"area\"/></shape>");
        EXPECT_TRUE(s.features & IR_FEATURE_THIN_LENS);
        const Vec centre{s.centre[0], s.centre[1], s.centre[2]};
        std::vector<float> samples;
        for (const json& ray : c.at("rays")) {
            samples.push_back(static_cast<float>(ray.at("film")[0].get<double>() * s.info.width));
            samples.push_back(static_cast<float>(ray.at("film")[1].get<double>() * s.info.height));
            for (const double x : ray.at("lens")) samples.push_back(static_cast<float>(x));
        }
        const std::vector<double> found = run("test_lens_ray", s.info, samples, 4, 8);
        for (std::size_t k = 0; k < c.at("rays").size(); ++k) {
            const json& ray = c.at("rays")[k];
            const Vec o = at(found, 8 * k), d = at(found, 8 * k + 3);
            expect_near(d, vec(ray.at("direction")), 3e-6);
            Vec start = o;
            for (std::size_t i = 0; i < 3; ++i) start[i] += centre[i] + found[8 * k + 6] * d[i];
            expect_near(start, vec(ray.at("start")), 5e-6);  // coordinates of 20 after centring: some 2e-6
            EXPECT_NEAR(found[8 * k + 7] - found[8 * k + 6], ray.at("length").get<double>(), 1e-4);
        }
    }
}

// Through the middle of the lens runs the pinhole's ray, whatever the plane in focus.
TEST_F(DeviceShapes, TheLensesCentreIsThePinhole) {
    const Scene s = load(
        "<sensor type=\"thinlens\"><float name=\"aperture_radius\" value=\".25\"/>"
        "<float name=\"focus_distance\" value=\"7\"/><film type=\"hdrfilm\">"
        "<integer name=\"width\" value=\"16\"/><integer name=\"height\" value=\"9\"/></film>"
        "<transform name=\"to_world\"><lookat origin=\"1,2,3\" target=\"0,.5,-1\" up=\"0,1,0\"/>"
        "</transform></sensor><emitter type=\"constant\"/><shape type=\"sphere\"/>");
    std::vector<float> out(16 * 9 * 8);
    const Buffer info = device_->upload(std::vector<shared::SceneInfo>{s.info});
    Buffer to = device_->upload(out);
    device_->kernel("shapes_test.cl", "test_lens_centre", {}).arg(info).arg(std::uint32_t{16 * 9}).arg(to).run(3, 64);
    device_->read(to, out.data(), out.size() * sizeof(float));
    for (std::size_t i = 0; i < out.size(); ++i)
        ASSERT_NEAR(out[i], 0.0, i % 8 == 7 ? 5e-3 : 1e-6) << i;  // t_max is 1e4: some ulp of 1e-3
}

}  // namespace
}  // namespace irradia::test
