#include <tbb/parallel_invoke.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <cmath>

#include "flatten.h"
#include "irradia/Accel.h"

namespace irradia {
namespace {

// Boxes grow by a few units in the last place of the scene's extent: the traversal's slab test rounds by that much, and
// so does the clipping of triangles at spatial splits. A ray that grazes an edge then still visits the box.
float box_pad(const accel::HostTree& tree) {
    float extent = 0;
    for (int k = 0; k < 3 && !tree.nodes.empty(); ++k)
        extent = std::max({extent, std::abs(tree.nodes[0].box.lo[k]), std::abs(tree.nodes[0].box.hi[k])});
    return extent * 0x1p-21f;
}

}  // namespace

void build_accel(Scene& scene, int threads, const std::function<void(double)>& progress, AccelLayouts layouts,
                 AccelQuality quality) {
    accel::check_primitive_count(scene.triangles.size() + scene.analytics.size(), scene.source);
    tbb::task_arena arena(threads > 0 ? threads : tbb::task_arena::automatic);
    arena.execute([&] {
        const accel::HostTree tree = accel::build_host_tree(scene, quality, layouts, progress);
        const float pad = box_pad(tree);
        scene.accel = {};
        scene.accel.quality = quality;
        tbb::parallel_invoke(  // each fills arrays of its own
            [&] {
                if (layouts != AccelLayouts::bvh2) accel::flatten_bvh8(scene, tree, pad, scene.accel);
            },
            [&] {
                if (layouts != AccelLayouts::bvh8) accel::flatten_bvh2(scene, tree, pad, scene.accel);
            });
    });
}

// Measured, per triangle: splits take another 1.7 to 3 µs of a core; they save a ray on a CPU device nothing in most
// rooms, a tenth in some and a quarter in rooms that stand askew, 25 ns on average, and a GPU less than a hundredth of
// that, beside more cores that build. Small scenes are built in no time.
AccelQuality accel_quality_for(const Scene& scene, double rays, AccelLayouts layouts) {
    constexpr double few = 1u << 14;
    const double count = static_cast<double>(scene.triangles.size()),
                 worth = layouts == AccelLayouts::bvh2 ? 5000 : 100;
    return layouts == AccelLayouts::both || count <= few || rays >= worth * count ? AccelQuality::best
                                                                                  : AccelQuality::quick;
}

// Measured: 134 to 184 bytes a triangle for one layout, 215 to 241 for both, of 0.3 to 4 million triangles; built
// quickly, of pairs, 138 to 158 for one.
std::uint64_t accel_memory(const Scene& scene, AccelLayouts layouts) {
    return (scene.triangles.size() + scene.analytics.size()) * (layouts == AccelLayouts::both ? 225u : 150u);
}

}  // namespace irradia
