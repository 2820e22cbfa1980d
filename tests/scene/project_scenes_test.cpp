// The scenes that come with the project load without a warning, and are what their comments say.
#include "scene_test.h"

namespace irradia::test {
namespace {

class ProjectScenes : public SceneTest {
protected:
    Scene scene(const std::string& name, const LoadOptions& options = {}) {
        return load_file(std::string(IRRADIA_SOURCE_DIR) + "/scenes/" + name + ".xml", options);
    }
};

TEST_F(ProjectScenes, AllLoadSilently) {
    int count = 0;
    for (const auto& entry : std::filesystem::directory_iterator(std::string(IRRADIA_SOURCE_DIR) + "/scenes")) {
        if (entry.path().extension() != ".xml") continue;
        ++count;
        SCOPED_TRACE(entry.path().string());
        const Scene s = load_file(entry.path().string());
        EXPECT_TRUE(warnings_.empty()) << warnings_[0];
        EXPECT_GT(s.triangles.size() + s.analytics.size(), 0u);
        EXPECT_GT(s.lights.size(), 0u);
        EXPECT_EQ(s.lights.back().cdf, 1.0f);
    }
    EXPECT_GE(count, 9);
}

TEST_F(ProjectScenes, CornellBox) {
    const Scene s = scene("cornell-box");
    EXPECT_EQ(s.triangles.size(), 36u);
    EXPECT_EQ(s.info.width, 256u);
    EXPECT_EQ(s.info.rfilter, IR_RFILTER_BOX);
    ASSERT_EQ(s.lights.size(), 1u);
    EXPECT_NEAR(s.lights[0].area, 0.5 * 0.4, 1e-6);
    expect_near({s.lights[0].nx, s.lights[0].ny, s.lights[0].nz}, {0, -1, 0}, 1e-6);
    // walls, floor and ceiling look inward
    for (std::size_t i = 0; i < 10; ++i)
        EXPECT_LT(dot(normal(s.triangles[i]), position(s, s.triangles[i].v0) - Vec{0, 1, 0}), -0.99);
}

TEST_F(ProjectScenes, FurnaceTakesItsReflectance) {
    LoadOptions options;
    options.defines["rho"] = "0.9";
    const Scene s = scene("furnace", options);
    EXPECT_EQ(s.lights.size(), 6u);
    EXPECT_FLOAT_EQ(s.materials[s.triangles[0].material].r, 0.9f);
    for (const auto& t : s.triangles) EXPECT_NEAR(dot(normal(t), position(s, t.v0)), -1.0, 1e-6);
}

TEST_F(ProjectScenes, TexturedSharesOnePicture) {
    const Scene s = scene("textured");
    EXPECT_EQ(s.textures.size(), 2u);
    EXPECT_EQ(s.texels.size(), 64u * 64u);
    EXPECT_EQ(s.features & IR_FEATURE_TEXTURES, IR_FEATURE_TEXTURES);
}

TEST_F(ProjectScenes, LoadingTwiceGivesTheSameBytes) {
    const Scene a = scene("textured"), b = scene("textured");
    EXPECT_EQ(a.texels, b.texels);
    ASSERT_EQ(a.vertices.size(), b.vertices.size());
    for (std::size_t i = 0; i < a.vertices.size(); ++i) {
        EXPECT_EQ(a.vertices[i].px, b.vertices[i].px);
        EXPECT_EQ(a.vertices[i].u, b.vertices[i].u);
    }
}

}  // namespace
}  // namespace irradia::test
