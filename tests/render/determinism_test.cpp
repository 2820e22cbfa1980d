// Same seed, device and flags: the same bytes, whatever the number of threads; and both traversals see one scene.
#include "irradia/Metrics.h"
#include "room.h"

namespace irradia::test {
namespace {

DeviceOptions threads(int n) {
    DeviceOptions options;
    options.threads = n;
    return options;
}

class Determinism : public ::testing::TestWithParam<Method> {};

TEST_P(Determinism, ThreadsDoNotChangeABit) {
    const char* const name = GetParam() == Method::radiance ? "glossy-box.xml" : "cornell-box.xml";
    const Scene scene = load(project_scene(name), {}, 48, 40);
    RenderSettings settings;
    settings.method = GetParam();
    settings.spp = GetParam() == Method::gather ? 1 : 16;
    settings.aovs = aov_names();
    const RenderResult one = run(scene, settings, threads(1));
    const RenderResult two = run(scene, settings, threads(2));
    ASSERT_EQ(one.image.layers.size(), two.image.layers.size());
    for (std::size_t l = 0; l < one.image.layers.size(); ++l)
        EXPECT_EQ(one.image.layers[l].data, two.image.layers[l].data) << "layer '" << one.image.layers[l].name << "'";
    settings.seed = 1;
    EXPECT_NE(one.image.layers[0].data, run(scene, settings, threads(1)).image.layers[0].data) << "another seed";
}
INSTANTIATE_TEST_SUITE_P(Methods, Determinism,
                         ::testing::Values(Method::irradiance, Method::radiance, Method::gather, Method::path));

TEST(DeterminismUnderASky, ThreadsDoNotChangeABit) {
    const Scene scene = load_text(window_room(40));
    RenderSettings settings;
    settings.spp = 64;
    EXPECT_EQ(run(scene, settings, threads(1)).image.layers[0].data,
              run(scene, settings, threads(2)).image.layers[0].data);
}

// The one-ray BVH2 traversal of GPU devices, run here on the CPU: the same random numbers meet the same surfaces, but
// for rays through edges and rounding, so they differ by a small part of what another seed changes.
TEST(Traversals, SeeTheSamePicture) {
    for (const Method method : {Method::path, Method::irradiance, Method::radiance}) {
        const char* const name = method == Method::radiance ? "glossy-box.xml" : "cornell-box.xml";
        const Scene scene = load(project_scene(name), {}, 48, 48);
        RenderSettings settings;
        settings.method = method;
        settings.spp = 16;
        DeviceOptions cpu, gpu;
        cpu.traversal = "cpu";
        gpu.traversal = "gpu";
        const Image by_cpu = run(scene, settings, cpu).image;
        const Metrics m = compare_images(run(scene, settings, gpu).image, by_cpu);
        settings.seed = 1;
        const Metrics noise = compare_images(run(scene, settings, cpu).image, by_cpu);
        EXPECT_LT(m.rel_rmse, 0.2 * noise.rel_rmse);
        EXPECT_LT(std::abs(m.mean_bias), 0.002);
    }
}

// Work-items of GPUs share out the samples of a pixel, each finds its own misses, and one of a pixel's counts: which
// one does not depend on who was first.
TEST(Traversals, SharesOfAPixelDoNotDependOnThreads) {
    const Scene scene = load(project_scene("glossy-box.xml"), {}, 24, 24);
    RenderSettings settings;
    settings.method = Method::radiance;
    settings.spp = 64;
    settings.accuracy = 0.1f;
    DeviceOptions one, three;
    one.traversal = three.traversal = "gpu";
    one.threads = 1, three.threads = 3;
    const RenderResult a = run(scene, settings, one), b = run(scene, settings, three);
    EXPECT_EQ(a.image.layers[0].data, b.image.layers[0].data);
    EXPECT_EQ(a.statistics.records, b.statistics.records);
    EXPECT_GT(a.statistics.radiance_records, 0u);
}

// Samples on one smooth surface share a look-up: those of a packet on CPU devices, those of a pixel on GPUs, which take
// one at a time. What they miss is the second derivative of E over a pixel, here a 48th of the box: .16 and .19 % of
// the picture, .02 % of its mean.
TEST(Traversals, SharedLookUpsHardlyShow) {
    const Scene scene = load(project_scene("cornell-box.xml"), {}, 48, 48);
    for (const char* const traversal : {"cpu", "gpu"}) {
        RenderSettings settings;
        settings.spp = 16;
        DeviceOptions device;
        device.traversal = traversal;
        const Image shared = run(scene, settings, device).image;
        settings.share_lookups = false;
        const Image apart = run(scene, settings, device).image;
        const Metrics m = compare_images(shared, apart);
        RecordProperty(traversal, std::to_string(m.rel_rmse) + ", " + std::to_string(m.mean_bias));
        EXPECT_GT(m.rel_rmse, 0) << traversal;
        EXPECT_LT(m.rel_rmse, 0.003) << traversal;
        EXPECT_LT(std::abs(m.mean_bias), 0.0004) << traversal;
    }
}

}  // namespace
}  // namespace irradia::test
