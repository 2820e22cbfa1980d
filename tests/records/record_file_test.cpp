// Record files: what is written is read back, appended to, compared with what a render asks for.
#include <gtest/gtest.h>

#include <functional>
#include <limits>

#include "some_records.h"

namespace irradia::test {
namespace {

class RecordFile : public ::testing::Test {
protected:
    TemporaryFolder folder_;
    std::string path_ = folder_.file("a.records");
};

TEST_F(RecordFile, GivesBackEveryKind) {
    for (const auto& [irradiance, radiance] :
         {std::pair<std::size_t, std::size_t>{0, 0}, {1, 0}, {9000, 0}, {0, 300}, {5000, 150}}) {
        const RecordSet set = some_records(irradiance, radiance);
        write_records(path_, set);
        std::string warning = "?";
        EXPECT_TRUE(same(read_records(path_, &warning), set)) << irradiance << ", " << radiance;
        EXPECT_EQ(warning, "");
        EXPECT_TRUE(same(read_records(path_), set));
        EXPECT_EQ(folder_.count(), 1u);
    }
}

TEST_F(RecordFile, GivesBackSamplesOrHarmonicsAlone) {
    for (const auto& [stride, order] : {std::pair<std::uint32_t, std::uint32_t>{24, 0}, {0, 12}}) {
        RecordSet set = some_records(3, 0);
        set.radiance.stride = stride;
        set.radiance.order = order;
        add_radiance(set.radiance, 5, 3);
        write_records(path_, set);
        EXPECT_TRUE(same(read_records(path_), set));
    }
}

// docs/record-format.md: sizes of header and blocks.
TEST_F(RecordFile, HasTheDocumentedSize) {
    RecordSet set = some_records(2, 1);
    std::size_t text = 0;
    for (const auto& [name, value] : set.origin.settings) text += name.size() + value.size() + 2;
    write_records(path_, set);
    const std::size_t header = (120 + text + 7) / 8 * 8, irradiance = 40 + 2 * (48 + 96),
                      radiance = 40 + 48 + 96 + 4 * (10 * 16 + 9 * 9), view = 40 + 80 + 16;
    EXPECT_EQ(read_file(path_).size(), header + irradiance + (radiance + 7) / 8 * 8 + view);
}

TEST_F(RecordFile, GrowsAtItsEndAlone) {
    RecordSet set = some_records(100, 10);
    write_records(path_, set);
    std::string before = read_file(path_);
    for (int round = 0; round < 3; ++round) {
        const RecordSet written = set;
        add_records(set.irradiance, 5000, 31);
        add_radiance(set.radiance, 20, 17);
        set.irradiance.keys[7].support1 *= 0.75f;  // clamped by new neighbours
        set.irradiance.keys[99].support2 = set.irradiance.keys[99].support1;
        set.radiance.keys[3].support1 *= 0.5f;
        set.views.push_back(set.views.front());
        append_records(path_, written, set);
        const std::string after = read_file(path_);
        EXPECT_EQ(after.substr(0, before.size()), before);
        EXPECT_TRUE(same(read_records(path_), set));
        before = after;
    }
    // Nothing new: nothing written.
    append_records(path_, set, set);
    EXPECT_EQ(read_file(path_), before);
}

TEST_F(RecordFile, IsNotAppendedToUnlessItHoldsWhatItShould) {
    const RecordSet set = some_records(100, 10);
    RecordSet more = set;
    add_records(more.irradiance, 5, 3);
    const auto complaint = [&](const RecordSet& written, const RecordSet& now) {
        const std::string before = read_file(path_);
        const std::string what = error_of([&] { append_records(path_, written, now); });
        EXPECT_EQ(read_file(path_), before);
        EXPECT_TRUE(one_line(what)) << what;
        return what;
    };
    write_records(path_, more);
    EXPECT_TRUE(has(complaint(set, more), "holds 105 records and 10 radiance records, expected 100 and 10"));
    write_records(path_, set);
    RecordSet other = set;
    other.origin.emitters ^= 1;
    EXPECT_TRUE(has(complaint(other, more), "do not continue"));
    more.origin = other.origin;
    EXPECT_TRUE(has(complaint(other, more), "another origin"));
    more = set;
    more.irradiance.keys[5].support2 *= 2;
    EXPECT_TRUE(has(complaint(set, more), "do not continue"));
    EXPECT_TRUE(has(complaint(set, some_records(50, 10)), "do not continue"));
    write_file(path_, read_file(path_).substr(0, read_file(path_).size() - 3));
    EXPECT_TRUE(has(complaint(set, set), "cut off"));
}

// Every field that could make a look-up go wrong. What is refused is neither written nor, forged, read.
TEST_F(RecordFile, RefusesNumbersThatLookUpsCannotBear) {
    using Change = std::function<void(RecordSet&)>;
    constexpr float nan = std::numeric_limits<float>::quiet_NaN(), infinity = std::numeric_limits<float>::infinity();
    const std::vector<std::pair<const char*, Change>> changes = {
        {"not finite", [&](RecordSet& s) { s.irradiance.keys[3].px = nan; }},
        {"outside the scene", [&](RecordSet& s) { s.irradiance.keys[3].pz = 1.1f; }},
        {"outside the scene", [&](RecordSet& s) { s.radiance.keys[3].py = -7; }},
        {"unit length", [&](RecordSet& s) { s.irradiance.keys[3].nz = 0; }},
        {"unit length", [&](RecordSet& s) { s.irradiance.keys[3].t2y = nan; }},
        {"supports are not positive", [&](RecordSet& s) { s.irradiance.keys[3].support1 = 0; }},
        {"supports are not positive", [&](RecordSet& s) { s.irradiance.keys[3].support1 = -1; }},
        {"not finite", [&](RecordSet& s) { s.irradiance.keys[3].support2 = nan; }},
        {"supports are not positive and in order", [&](RecordSet& s) { s.radiance.keys[3].support2 = 0.001f; }},
        {"not finite", [&](RecordSet& s) { s.irradiance.keys[3].support2 = infinity; }},
        {"larger than the scene", [&](RecordSet& s) { s.irradiance.keys[3].support2 = 1e6f; }},
        {"too small", [&](RecordSet& s) { s.irradiance.keys[3].support1 = 1e-30f; }},
        {"irradiance is not a number", [&](RecordSet& s) { s.irradiance.values[3].e[1] = -1; }},
        {"irradiance is not a number", [&](RecordSet& s) { s.irradiance.values[3].e[2] = nan; }},
        {"irradiance is not a number", [&](RecordSet& s) { s.radiance.values[3].e[0] = infinity; }},
        {"gradient", [&](RecordSet& s) { s.irradiance.values[3].rotation[8] = nan; }},
        {"gradient", [&](RecordSet& s) { s.irradiance.values[3].translation[0] = -infinity; }},
        {"distance", [&](RecordSet& s) { s.irradiance.values[3].harmonic = 0; }},
        {"distance", [&](RecordSet& s) { s.irradiance.values[3].minimum = nan; }},
        {"point or normal", [&](RecordSet& s) { s.radiance.samples[3 * 160 + 5] = nan; }},
        {"out of reach", [&](RecordSet& s) { s.radiance.samples[3 * 160 + 5] = 1e12f; }},
        {"at the record itself",
         [&](RecordSet& s) {
             for (std::size_t k : {0u, 16u, 32u}) s.radiance.samples[k] = 0;
         }},
        {"normal is longer", [&](RecordSet& s) { s.radiance.samples[160 + 5 * 16] = 2; }},
        {"solid angle or radiance", [&](RecordSet& s) { s.radiance.samples[160 + 6 * 16] = -1; }},
        {"solid angle or radiance", [&](RecordSet& s) { s.radiance.samples[160 + 9 * 16] = infinity; }},
        {"harmonic", [&](RecordSet& s) { s.radiance.harmonics[80] = nan; }},
        {"bounds are inverted", [&](RecordSet& s) { s.origin.lower[1] = 2; }},
        {"header 0", [&](RecordSet& s) { s.origin.upper[1] = nan; }},
        {"setting", [&](RecordSet& s) { s.origin.settings[2].second = "a\nb"; }},
        {"view 0", [&](RecordSet& s) { s.views[0].camera.dxx = nan; }},
        {"unknown kinds", [&](RecordSet& s) { s.views[0].kinds = 2; }},
        {"no pixels", [&](RecordSet& s) { s.views[0].width = 0; }},
        {"one of each", [&](RecordSet& s) { s.irradiance.values.pop_back(); }},
        {"stride", [&](RecordSet& s) { s.radiance.samples.pop_back(); }},
        {"stride", [&](RecordSet& s) { s.radiance.order = 13; }},
    };
    const RecordSet good = some_records(20, 5);
    EXPECT_EQ(error_of([&] { check_records("x", good); }), "");
    for (const auto& [what, change] : changes) {
        RecordSet set = good;
        change(set);
        const std::string error = error_of([&] { write_records(path_, set); });
        EXPECT_TRUE(one_line(error) && has(error, what)) << what << ": " << error;
        EXPECT_EQ(folder_.count(), 0u);
    }
}

// ---- origins -------------------------------------------------------------------------------------------------------

TEST(RecordOrigin, IsThatOfTheSceneWithoutItsCamera) {
    const Scene scene = small_scene();
    const RenderSettings settings;
    const RecordOrigin origin = record_origin(scene, settings);
    const auto differs = [&](const std::function<void(Scene&, RenderSettings&)>& change, bool radiance = true) {
        Scene s = scene;
        RenderSettings t = settings;
        change(s, t);
        return record_mismatch(origin, record_origin(s, t), radiance);
    };
    EXPECT_EQ(differs([](Scene&, RenderSettings&) {}), "");
    EXPECT_EQ(differs([](Scene& s, RenderSettings& t) {
                  s.info.camera.ox = 3;
                  s.info.width = 77;
                  s.info.rfilter = IR_RFILTER_BOX;
                  s.sample_count = 3;
                  s.source = "elsewhere.xml";
                  t.spp = 9;
                  t.seed = 4;
                  t.pixel_error = 0.1f;
                  t.aovs = {"depth"};
                  t.method = Method::radiance;
              }),
              "");
    EXPECT_EQ(differs([](Scene& s, RenderSettings&) { s.vertices[2].py += 0.5f; }), "other geometry");
    EXPECT_EQ(differs([](Scene& s, RenderSettings&) { s.analytics[0].radius = 0.25f; }), "other geometry");
    EXPECT_EQ(differs([](Scene& s, RenderSettings&) { s.centre[2] += 1e-9; }), "other geometry");
    EXPECT_EQ(differs([](Scene& s, RenderSettings&) { s.materials[1].r = 0.5f; }), "other materials or textures");
    EXPECT_EQ(differs([](Scene& s, RenderSettings&) { s.texels[3] ^= 1; }), "other materials or textures");
    EXPECT_EQ(differs([](Scene& s, RenderSettings&) { s.lights[1].g = 0.5f; }), "other emitters");
    EXPECT_EQ(differs([](Scene&, RenderSettings& t) { t.accuracy = 0.1f; }), "--accuracy is 0.2 there, 0.1 here");
    EXPECT_EQ(differs([](Scene& s, RenderSettings& t) {
                  s.lights[0].r = 0;
                  t.hemisphere_n = 64;
                  t.max_depth = 4;
              }),
              "other emitters; --hemisphere is 16x32 there, 16x64 here; --max-depth is -1 there, 4 here");
    EXPECT_EQ(differs([](Scene&, RenderSettings& t) { t.glossy_accuracy = 0.5f; }),
              "--glossy-accuracy is 0.2 there, 0.5 here");
    EXPECT_EQ(differs([](Scene&, RenderSettings& t) { t.glossy_accuracy = 0.5f; }, false), "");
    RecordOrigin other = origin;
    other.settings.emplace_back("phase", "moon");
    EXPECT_EQ(record_mismatch(other, origin, false), "--phase is moon there, unknown here");
}

}  // namespace
}  // namespace irradia::test
