// Shared structs: the device's layout is the host's.
#include <gtest/gtest.h>

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "irradia/Device.h"
#include "irradia/shared/grid_types.h"
#include "irradia/shared/radiance_types.h"
#include "irradia/shared/record_types.h"
#include "irradia/shared/scene_types.h"

namespace {

using namespace irradia::shared;

struct Expected {
    const char* what;
    std::size_t value;
};
#define SIZE(type) \
    { #type, sizeof(type) }
#define OFFSET(type, member) \
    { #type "." #member, offsetof(type, member) }

// In the order of cl/echo_sizes.cl.
const std::vector<Expected> kExpected = {
    SIZE(Vertex),
    OFFSET(Vertex, nx),
    OFFSET(Vertex, v),
    SIZE(Triangle),
    OFFSET(Triangle, flags),
    OFFSET(Triangle, material),
    OFFSET(Triangle, light),
    OFFSET(Triangle, reach),
    SIZE(Analytic),
    OFFSET(Analytic, kind),
    OFFSET(Analytic, light),
    OFFSET(Analytic, sign),
    SIZE(Material),
    OFFSET(Material, texture),
    OFFSET(Material, r),
    OFFSET(Material, eta),
    OFFSET(Material, map_scale),
    SIZE(Texture),
    OFFSET(Texture, format),
    OFFSET(Texture, m00),
    OFFSET(Texture, m12),
    SIZE(Light),
    OFFSET(Light, kind),
    OFFSET(Light, area),
    OFFSET(Light, probability),
    OFFSET(Light, cdf),
    OFFSET(Light, table),
    SIZE(Camera),
    OFFSET(Camera, near_clip),
    OFFSET(Camera, pixel_size),
    OFFSET(Camera, forwardz),
    SIZE(SceneInfo),
    OFFSET(SceneInfo, width),
    OFFSET(SceneInfo, triangle_count),
    OFFSET(SceneInfo, diagonal),
    OFFSET(SceneInfo, max_z),
    SIZE(Bvh8Node),
    OFFSET(Bvh8Node, hi_x),
    OFFSET(Bvh8Node, child),
    SIZE(TriangleBlock),
    OFFSET(TriangleBlock, v0z),
    OFFSET(TriangleBlock, primitive),
    SIZE(Bvh2Node),
    OFFSET(Bvh2Node, child1),
    OFFSET(Bvh2Node, hi1x),
    SIZE(TrianglePacked),
    OFFSET(TrianglePacked, primitive),
    OFFSET(TrianglePacked, pad1),
    SIZE(ShadingPoint),
    OFFSET(ShadingPoint, state),
    OFFSET(ShadingPoint, footprint),
    OFFSET(ShadingPoint, offset),
    OFFSET(ShadingPoint, pixel),
    OFFSET(ShadingPoint, largest),
    SIZE(RecordKey),
    OFFSET(RecordKey, support1),
    OFFSET(RecordKey, support2),
    OFFSET(RecordKey, coat),
    SIZE(RecordValue),
    OFFSET(RecordValue, rotation),
    OFFSET(RecordValue, translation),
    OFFSET(RecordValue, minimum),
    OFFSET(RecordValue, harmonic),
    SIZE(OctreeState),
    OFFSET(OctreeState, overflow),
    OFFSET(OctreeState, levels),
    SIZE(CacheParameters),
    OFFSET(CacheParameters, size),
    OFFSET(CacheParameters, coordinate),
    OFFSET(CacheParameters, stretch),
    SIZE(RecordParameters),
    OFFSET(RecordParameters, accuracy),
    OFFSET(RecordParameters, tau),
    OFFSET(RecordParameters, firefly),
    OFFSET(RecordParameters, reach),
    SIZE(RadianceParameters),
    OFFSET(RadianceParameters, trace_below),
    OFFSET(RadianceParameters, least),
    OFFSET(RadianceParameters, share),
    SIZE(GridParameters),
    OFFSET(GridParameters, unit),
    OFFSET(GridParameters, slots),
    OFFSET(GridParameters, edges),
    SIZE(GridSum),
    OFFSET(GridSum, samples),
    OFFSET(GridSum, b),
    SIZE(GridCell),
    OFFSET(GridCell, b),
};

TEST(EchoSizes, DeviceAndHostAgree) {
    irradia::Device device({});
    irradia::Buffer base = device.allocate(512);
    irradia::Buffer sizes = device.allocate((kExpected.size() + 1) * 4);
    device.fill(sizes, 0xdeadbeefu, sizes.bytes());
    irradia::Kernel kernel = device.kernel("echo_sizes.cl", "echo_sizes", {});
    kernel.arg(base).arg(sizes).run(1, 1);
    std::vector<std::uint32_t> echoed(kExpected.size() + 1);
    device.read(sizes, echoed.data(), echoed.size() * 4);
    for (std::size_t i = 0; i < kExpected.size(); ++i) EXPECT_EQ(echoed[i], kExpected[i].value) << kExpected[i].what;
    EXPECT_EQ(echoed.back(), 0xdeadbeefu) << "the kernel writes more values than this test knows of";
}

}  // namespace
