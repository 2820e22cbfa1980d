#include "app/stats.h"
#include "core/memory.h"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <vector>

namespace irradia::app {
namespace {

struct Facts {
    Options options;
    Scene scene;
    DeviceDescription device;
    RenderStatistics statistics;
    Facts() {
        options.settings.method = Method::gather;
        options.settings.accuracy = 0.15f;
        options.settings.seed = 18446744073709551615u;
        options.device.threads = 3;
        scene.source = "a \"quoted\" scene.xml";
        scene.info.width = 640;
        scene.info.height = 480;
        device.name = "Device";
        statistics.rays = {{"camera", 1000}, {"shadow", 500}};
        statistics.stages = {{"short", {0.5, 1}}, {"long", {2.5, 40}}};
        statistics.records = 12;
        statistics.octree_depth = 4;
        statistics.spp = 9;
        statistics.seconds = 3;
    }
    [[nodiscard]] Run run() const {
        return {options,
                scene,
                device,
                true,
                1u << 20,
                statistics,
                {{"parsing", 0.05}, {"meshes", 0.2}, {"hierarchy", 0.5}},
                3u << 20,
                0.125,
                4};
    }
};

TEST(Stats, JsonHoldsSettingsTimesRaysAndMemory) {
    const Facts facts;
    const nlohmann::json j = nlohmann::json::parse(stats_json(facts.run()));
    EXPECT_EQ(j["settings"]["method"], "gather");
    EXPECT_EQ(j["settings"]["accuracy"].dump(), "0.15");  // as it was typed, not as the float reads
    EXPECT_EQ(j["settings"]["seed"], 18446744073709551615u);
    EXPECT_EQ(j["settings"]["spp"], 9);
    EXPECT_EQ(j["scene"]["file"], "a \"quoted\" scene.xml");
    EXPECT_EQ(j["device"]["threads"], 3);
    EXPECT_EQ(j["device"]["traversal"], "cpu");
    EXPECT_EQ(j["rays"]["total"], 1500);
    EXPECT_EQ(j["rays"]["per_second"], 500);
    EXPECT_EQ(j["stages"]["long"]["seconds"], 2.5);
    EXPECT_EQ(j["stages"]["long"]["launches"], 40);
    EXPECT_EQ(j["octree"]["depth"], 4);
    EXPECT_EQ(j["wall_seconds"]["accel"], 0.5);
    EXPECT_EQ(j["memory"]["device_peak_bytes"], 1 << 20);
    EXPECT_EQ(j["irradia"], IRRADIA_VERSION);
}

TEST(Stats, JsonHoldsThePicturesCameraInTheWorldOfTheSceneFile) {
    Facts facts;
    facts.scene.centre = {100, 0, -7};
    facts.scene.info.camera.ox = 0.5f;
    shared::Camera moved = facts.scene.info.camera;
    moved.ox = 2;
    moved.dxx = 0.25f;
    moved.cornery = -0.5f;
    auto run = facts.run();
    EXPECT_EQ(nlohmann::json::parse(stats_json(run))["camera"]["origin"], nlohmann::json({100.5, 0, -7}));
    run.camera = &moved;
    const nlohmann::json camera = nlohmann::json::parse(stats_json(run))["camera"];
    EXPECT_EQ(camera["origin"], nlohmann::json({102, 0, -7}));
    EXPECT_EQ(camera["dx"], nlohmann::json({0.25, 0, 0}));
    EXPECT_EQ(camera["corner"], nlohmann::json({0, -0.5, 0}));
}

TEST(Stats, MetadataSaysHowThePictureWasMade) {
    const Facts facts;
    const auto metadata = picture_metadata(facts.run());
    EXPECT_EQ(metadata.at("irradia.method"), "gather");
    EXPECT_EQ(metadata.at("irradia.accuracy"), "0.15");
    EXPECT_EQ(metadata.at("irradia.radius"), name_of(radius_names(), facts.options.settings.radius));
    EXPECT_EQ(metadata.at("irradia.neighbour_clamp"), "true");
    EXPECT_EQ(metadata.at("irradia.device"), "Device");
    EXPECT_EQ(metadata.at("irradia.records"), "12");
    EXPECT_EQ(metadata.count("irradia.render_seconds"), 0u);  // the same picture is the same file
}

TEST(Stats, TableBeginsWithTheLongestStage) {
    const Facts facts;
    const std::string table = stats_table(facts.run());
    EXPECT_LT(table.find("long"), table.find("short"));
    EXPECT_NE(table.find("40 launches"), std::string::npos) << table;
    EXPECT_NE(table.find("1 launch\n"), std::string::npos) << table;
    EXPECT_NE(table.find("1.0 MiB"), std::string::npos) << table;
}

TEST(Stats, PeakHostMemoryCountsWhatWasTouched) {
    const std::uint64_t before = peak_resident_memory();
    std::vector<char> block(256u << 20, 1);
    EXPECT_EQ(block[123456789], 1);
    EXPECT_GE(peak_resident_memory(), std::max<std::uint64_t>(before, 256u << 20));
}

}  // namespace
}  // namespace irradia::app
