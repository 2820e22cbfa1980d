// Renders that are interrupted, and gone on with by other objects: the same bytes as without.
#include "irradia/Checkpoint.h"

#include <cstring>
#include <filesystem>
#include <fstream>
#include <optional>
#include <utility>

#include "irradia/Error.h"
#include "irradia/RecordFile.h"
#include "room.h"

namespace irradia::test {
namespace {

namespace fs = std::filesystem;

struct Interrupted {};

class CheckpointFile {
public:
    CheckpointFile()
        : path_(fs::temp_directory_path() / ("irradia-checkpoint-" + std::to_string(::getpid()) + ".state")) {}
    ~CheckpointFile() { fs::remove(path_); }
    [[nodiscard]] std::string path() const { return path_.string(); }

private:
    fs::path path_;
};

const CheckpointIdentity identity = {{"scene", "a"}, {"spp", "16"}};

std::string glossy_floor() {
    return R"(<bsdf type="roughconductor"><string name="material" value="none"/><float name="alpha" value=".3"/></bsdf>)";
}

// All that is to be the same: layers, and figures but for times.
void expect_same(const RenderResult& a, const RenderResult& b) {
    ASSERT_EQ(a.image.layers.size(), b.image.layers.size());
    for (std::size_t l = 0; l < a.image.layers.size(); ++l) {
        EXPECT_EQ(a.image.layers[l].name, b.image.layers[l].name);
        EXPECT_EQ(a.image.layers[l].data, b.image.layers[l].data) << "layer '" << a.image.layers[l].name << "'";
    }
    ASSERT_EQ(a.error.has_value(), b.error.has_value());
    if (a.error) {  // probes of a finished picture are traced anew when they are stopped
        EXPECT_EQ(a.error->probes, b.error->probes);
        EXPECT_EQ(a.error->paths, b.error->paths);
        EXPECT_EQ(a.error->rel_rmse.value, b.error->rel_rmse.value);
        EXPECT_EQ(a.error->rel_rmse.high, b.error->rel_rmse.high);
    } else {
        EXPECT_EQ(a.statistics.rays, b.statistics.rays);
    }
    EXPECT_EQ(a.statistics.records, b.statistics.records);
    EXPECT_EQ(a.statistics.radiance_records, b.statistics.radiance_records);
    EXPECT_EQ(a.statistics.iterations, b.statistics.iterations);
    EXPECT_EQ(a.statistics.spp, b.statistics.spp);
    EXPECT_EQ(a.statistics.mean_spp, b.statistics.mean_spp);
}

struct Case {
    const char* name;
    Method method;
    int spp;
    float pixel_error;
    bool glossy;
    int launches;  // about: a test that never interrupts would pass
    bool sky = false;
};

class Checkpoints : public ::testing::TestWithParam<Case> {};

// Two views with one cache. Every so many rests the render is dropped, with its device, and gone on with from the file:
// many interruptions of one render, at different places.
TEST_P(Checkpoints, GoOnToTheSameBytes) {
    const Case& c = GetParam();
    const Scene scene =
        load_text(c.sky ? window_room(64) : room(c.glossy ? glossy_floor() : std::string(grey_floor), ""));
    RenderSettings s;
    s.method = c.method;
    s.spp = c.spp;
    s.pixel_error = c.pixel_error;
    s.accuracy = .5f;
    s.aovs = {"direct", "indirect", "albedo", "depth"};
    if (c.method != Method::gather) s.aovs.emplace_back("records");
    s.report_error = c.method == Method::irradiance;
    s.error_share = .05f;
    std::vector<shared::Camera> cameras(2, scene.info.camera);
    cameras[1].ox += .3f;
    std::vector<RenderResult> unbroken;
    RecordSet records, records_again;
    {
        Device device({});
        Renderer renderer(scene, device, s);
        for (const shared::Camera& camera : cameras) unbroken.push_back(renderer.render(camera));
        renderer.store(records);
    }
    const CheckpointFile file;
    std::vector<RenderResult> broken;
    int interruptions = 0, rests = 0;
    bool saved = false;
    while (broken.size() < cameras.size()) {
        DeviceOptions options;
        options.threads = 1 + interruptions % 2;
        Device device(options);
        Renderer renderer(scene, device, s);
        int until = 1 + interruptions * 3 % 5;
        renderer.on_rest([&](bool whole) {
            ASSERT_TRUE(whole);
            ++rests;
            if (until-- > 0) return;
            Checkpoint out = Checkpoint::write(file.path(), identity);
            renderer.save(out);
            out.finish();
            saved = true;
            throw Interrupted{};
        });
        try {
            if (saved) {
                Checkpoint in = Checkpoint::read(file.path(), identity);
                broken.push_back(renderer.resume(in));
            }
            while (broken.size() < cameras.size()) broken.push_back(renderer.render(cameras[broken.size()]));
            renderer.store(records_again);
        } catch (const Interrupted&) {
            ++interruptions;
        }
    }
    std::printf("%s: %d interruptions, %d rests\n", c.name, interruptions, rests);
    EXPECT_GE(interruptions, c.launches / 5);
    for (std::size_t i = 0; i < cameras.size(); ++i) {
        SCOPED_TRACE("view " + std::to_string(i));
        expect_same(unbroken[i], broken[i]);
    }
    ASSERT_EQ(records.irradiance.size(), records_again.irradiance.size());
    if (records.irradiance.size() > 0) {
        EXPECT_EQ(std::memcmp(records.irradiance.keys.data(), records_again.irradiance.keys.data(),
                              records.irradiance.size() * sizeof records.irradiance.keys[0]),
                  0);
    }
    EXPECT_EQ(records.radiance.samples, records_again.radiance.samples);
    EXPECT_EQ(records.views.size(), records_again.views.size());
}
INSTANTIATE_TEST_SUITE_P(Methods, Checkpoints,
                         ::testing::Values(Case{"irradiance", Method::irradiance, 300, 0, false, 80},
                                           Case{"adaptive", Method::irradiance, 256, .02f, false, 80},
                                           Case{"radiance", Method::radiance, 1024, .01f, true, 80},
                                           Case{"sky", Method::irradiance, 64, .05f, false, 80, true},
                                           Case{"path", Method::path, 300, 0, false, 30},
                                           Case{"gather", Method::gather, 3, 0, false, 20}),
                         [](const auto& c) { return std::string(c.param.name); });

// Renders with a target error, dropped after every step and gone on with from a file.
RenderResult searched(const Scene& scene, const RenderSettings& s, int& interruptions) {
    const CheckpointFile file;
    interruptions = 0;
    for (;;) {
        Device device({});
        Renderer renderer(scene, device, s);
        bool first = true;  // the place where it was interrupted comes again
        renderer.on_rest([&](bool whole) {
            if (!whole || (interruptions > 0 && std::exchange(first, false))) return;
            Checkpoint out = Checkpoint::write(file.path(), identity);
            renderer.save(out);
            out.finish();
            throw Interrupted{};
        });
        try {
            if (interruptions > 0) {
                Checkpoint in = Checkpoint::read(file.path(), identity);
                return renderer.resume(in);
            }
            renderer.render(scene.info.camera);
        } catch (const Interrupted&) {
            ++interruptions;
        }
    }
}

// What a search had found and made is there again: it makes the same picture as one that was never dropped, in as many
// steps, and meets its target. How many steps that takes is chance: with caches one search in two is right after the
// first. Then another seed is taken, until one was gone on with twice.
TEST(Checkpoints, SearchesGoOnBetweenTheirSteps) {
    const Scene scene = load_text(room(grey_floor, ""));
    for (const Method method : {Method::irradiance, Method::path}) {
        RenderSettings s;
        s.method = method;
        s.target_error = method == Method::path ? .02f : .004f;
        int interruptions = 0;
        std::optional<RenderResult> result;
        for (s.seed = 0; interruptions < 2 && s.seed < 12; ++s.seed) {
            result = searched(scene, s, interruptions);
            ASSERT_TRUE(result->error.has_value());
            EXPECT_TRUE(result->error->reached);
            EXPECT_LE(result->error->rel_rmse.high, static_cast<double>(s.target_error));
            EXPECT_EQ(result->error->steps, interruptions);
            expect_same(run(scene, s), *result);
        }
        std::printf("%d steps, error %.2f %%\n", interruptions, 100 * result->error->rel_rmse.value);
        EXPECT_GE(interruptions, 2);
        // Against paths of other seeds: the product of the differences to two of them has no noise of theirs in it.
        RenderSettings reference;
        reference.method = Method::path;
        reference.spp = 1024;
        reference.seed = 5;
        const Image one = run(scene, reference).image;
        reference.seed = 6;
        const Image two = run(scene, reference).image;
        double square = 0, mean = 0, count = 0;
        for (std::size_t i = 0; i < one.layers[0].data.size(); ++i) {
            const double a = static_cast<double>(one.layers[0].data[i]), b = static_cast<double>(two.layers[0].data[i]);
            if (a > 4 || b > 4) continue;  // the lamp
            const double x = static_cast<double>(result->image.layers[0].data[i]);
            square += (x - a) * (x - b);
            mean += 0.5 * (a + b);
            count += 1;
        }
        EXPECT_LT(std::sqrt(square / count) / (mean / count), 1.3 * static_cast<double>(s.target_error));
    }
}

// A file that is not whole, or not what it should be, is refused; what is there is never used in part.
TEST(CheckpointFiles, OnlyWholeOnesOfTheSameRenderAreRead) {
    const CheckpointFile file;
    std::vector<double> numbers(300000, 1.5);
    std::string text = "a text";
    std::map<std::string, std::uint64_t> map = {{"a", 1}, {"b", 2}};
    const auto write = [&] {
        Checkpoint out = Checkpoint::write(file.path(), identity);
        out(numbers)(text)(map);
        out.finish();
    };
    const auto read = [&](const CheckpointIdentity& wanted) {
        Checkpoint in = Checkpoint::read(file.path(), wanted);
        std::vector<double> numbers_again;
        std::string text_again;
        std::map<std::string, std::uint64_t> map_again;
        in(numbers_again)(text_again)(map_again);
        in.finish();
        EXPECT_EQ(numbers, numbers_again);
        EXPECT_EQ(text, text_again);
        EXPECT_EQ(map, map_again);
    };
    const auto message = [&](const auto& what) -> std::string {
        try {
            what();
        } catch (const Error& error) {
            return error.what();
        }
        return "";
    };
    EXPECT_NE(message([&] { read(identity); }).find("No such file"), std::string::npos);
    write();
    read(identity);
    EXPECT_NE(message([&] { read({{"scene", "a"}, {"spp", "64"}}); }).find("spp was 16, is 64"), std::string::npos);
    EXPECT_NE(message([&] { read({{"scene", "a"}}); }).find("options that are not given"), std::string::npos);
    {
        Checkpoint out = Checkpoint::write(file.path(), identity);  // dropped: the old one stays
        out(numbers);
    }
    read(identity);
    std::string bytes;
    {
        std::ifstream in(file.path(), std::ios::binary);
        bytes.assign(std::istreambuf_iterator<char>(in), {});
    }
    const auto with = [&](const std::string& changed) {
        std::ofstream(file.path(), std::ios::binary) << changed;
        return message([&] { read(identity); });
    };
    for (const std::size_t length :
         {std::size_t{0}, std::size_t{5}, std::size_t{20}, bytes.size() / 2, bytes.size() - 1})
        EXPECT_NE(with(bytes.substr(0, length)), "") << length;
    for (std::size_t i = 0; i < 2000; ++i) {
        std::string flipped = bytes;
        const std::size_t bit = i < 400 ? i : i * 0x9e3779b97f4a7c15u % (8 * bytes.size());
        flipped[bit / 8] = static_cast<char>(flipped[bit / 8] ^ (1 << bit % 8));
        ASSERT_NE(with(flipped), "") << "bit " << bit;
    }
    EXPECT_NE(with(bytes + "x"), "");
    std::string other = bytes;
    other[12] = 9;
    EXPECT_NE(with(other).find("version 9, expected"), std::string::npos);
}

}  // namespace
}  // namespace irradia::test
