#include "app/loading.h"

#include <gtest/gtest.h>

#include <chrono>
#include <sstream>
#include <thread>

#include "packets.h"

namespace irradia::app {
namespace {

double now() { return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count(); }

TEST(LoadMonitor, TakesTheTimeOfEachStage) {
    LoadMonitor monitor(nullptr, now());
    monitor("parsing", 0);
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
    monitor("meshes", 0);
    monitor("meshes", 0.5);
    std::this_thread::sleep_for(std::chrono::milliseconds(40));
    monitor("meshes", 1);
    monitor.finish();
    ASSERT_EQ(monitor.phases().size(), 2u);
    EXPECT_EQ(monitor.phases()[0].first, "parsing");
    EXPECT_EQ(monitor.phases()[1].first, "meshes");
    EXPECT_GE(monitor.phases()[0].second, 0.02);
    EXPECT_GE(monitor.phases()[1].second, 0.04);
}

// The bar of a terminal: stage by stage it only grows, and is gone at the end.
TEST(LoadMonitor, ShowsABarThatGrows) {
    test::Packets err;
    Log log({}, 80, err.end());
    StageLog stages(log);
    LoadMonitor monitor(&stages, now() - 1);  // a second ago
    int before = -1;
    for (const char* stage : {"parsing", "meshes", "textures", "assembly", "hierarchy", "checks"})
        for (const double fraction : {0.0, 0.9}) {
            std::this_thread::sleep_for(std::chrono::milliseconds(110));  // more often nothing is printed
            err.take();
            monitor(stage, fraction);
            const std::string text = test::joined(err.take());
            ASSERT_NE(text.find(std::string("loading: ") + stage), std::string::npos) << text;
            const int percent = std::stoi(text.substr(text.find(": ", text.find(stage)) + 2));
            EXPECT_GE(percent, before) << text;
            EXPECT_LT(percent, 100);
            before = percent;
        }
    EXPECT_GT(before, 90);
    monitor.finish();
    EXPECT_TRUE(test::joined(err.take()).ends_with("\r\033[K"));
}

TEST(LoadText, NamesPhasesAndMemory) {
    Scene scene;
    scene.source = "a.xml";
    scene.info.width = 4, scene.info.height = 3;
    scene.vertices.resize(3);
    scene.triangles.resize(2);
    scene.texels.resize(1000);  // is not what a triangle costs
    EXPECT_EQ(
        load_text(scene, {{"parsing", 0.01}, {"meshes", 2}, {"hierarchy", 7.99}}, 3u << 20),
        "a.xml: 4 x 3 pixels, 2 triangles, 0 spheres, disks and cylinders, 0 emitters, 0 textures, loaded in 10 s "
        "(meshes 2.0 s, hierarchy 8.0 s), 96 bytes a triangle, peak memory 3 MiB");
    EXPECT_EQ(scene_bytes(scene), 3u * 32 + 2 * 48 + 4000);
}

}  // namespace
}  // namespace irradia::app
