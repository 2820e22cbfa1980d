// Writes the size of every struct that host and device share, and the offsets of some of its members: a test holds
// them against the host's, so that no compiler's layout can drift apart unnoticed.
#include "portable.h"
#include "irradia/shared/grid_types.h"
#include "irradia/shared/radiance_types.h"
#include "irradia/shared/record_types.h"
#include "irradia/shared/scene_types.h"

// The offset of a member, by the address it has in global memory (OpenCL C 1.2 has no offsetof).
#define IR_OFFSET(type, member) ((uint)((IR_GLOBAL const char*)&((IR_GLOBAL const type*)base)->member - base))

// One work-item. `base`: at least 512 bytes, not read. `sizes`: the order is that of tests/device/echo_sizes_test.cpp.
IR_KERNEL void echo_sizes(IR_GLOBAL const char* base, IR_GLOBAL uint* sizes) {
    uint n = 0;
    sizes[n++] = (uint)sizeof(Vertex);
    sizes[n++] = IR_OFFSET(Vertex, nx);
    sizes[n++] = IR_OFFSET(Vertex, v);
    sizes[n++] = (uint)sizeof(Triangle);
    sizes[n++] = IR_OFFSET(Triangle, flags);
    sizes[n++] = IR_OFFSET(Triangle, material);
    sizes[n++] = IR_OFFSET(Triangle, light);
    sizes[n++] = IR_OFFSET(Triangle, reach);
    sizes[n++] = (uint)sizeof(Analytic);
    sizes[n++] = IR_OFFSET(Analytic, kind);
    sizes[n++] = IR_OFFSET(Analytic, light);
    sizes[n++] = IR_OFFSET(Analytic, sign);
    sizes[n++] = (uint)sizeof(Material);
    sizes[n++] = IR_OFFSET(Material, texture);
    sizes[n++] = IR_OFFSET(Material, r);
    sizes[n++] = IR_OFFSET(Material, eta);
    sizes[n++] = IR_OFFSET(Material, map_scale);
    sizes[n++] = (uint)sizeof(Texture);
    sizes[n++] = IR_OFFSET(Texture, format);
    sizes[n++] = IR_OFFSET(Texture, m00);
    sizes[n++] = IR_OFFSET(Texture, m12);
    sizes[n++] = (uint)sizeof(Light);
    sizes[n++] = IR_OFFSET(Light, kind);
    sizes[n++] = IR_OFFSET(Light, area);
    sizes[n++] = IR_OFFSET(Light, probability);
    sizes[n++] = IR_OFFSET(Light, cdf);
    sizes[n++] = IR_OFFSET(Light, table);
    sizes[n++] = (uint)sizeof(Camera);
    sizes[n++] = IR_OFFSET(Camera, near_clip);
    sizes[n++] = IR_OFFSET(Camera, pixel_size);
    sizes[n++] = IR_OFFSET(Camera, forwardz);
    sizes[n++] = (uint)sizeof(SceneInfo);
    sizes[n++] = IR_OFFSET(SceneInfo, width);
    sizes[n++] = IR_OFFSET(SceneInfo, triangle_count);
    sizes[n++] = IR_OFFSET(SceneInfo, diagonal);
    sizes[n++] = IR_OFFSET(SceneInfo, max_z);
    sizes[n++] = (uint)sizeof(Bvh8Node);
    sizes[n++] = IR_OFFSET(Bvh8Node, hi_x);
    sizes[n++] = IR_OFFSET(Bvh8Node, child);
    sizes[n++] = (uint)sizeof(TriangleBlock);
    sizes[n++] = IR_OFFSET(TriangleBlock, v0z);
    sizes[n++] = IR_OFFSET(TriangleBlock, primitive);
    sizes[n++] = (uint)sizeof(Bvh2Node);
    sizes[n++] = IR_OFFSET(Bvh2Node, child1);
    sizes[n++] = IR_OFFSET(Bvh2Node, hi1x);
    sizes[n++] = (uint)sizeof(TrianglePacked);
    sizes[n++] = IR_OFFSET(TrianglePacked, primitive);
    sizes[n++] = IR_OFFSET(TrianglePacked, pad1);
    sizes[n++] = (uint)sizeof(ShadingPoint);
    sizes[n++] = IR_OFFSET(ShadingPoint, state);
    sizes[n++] = IR_OFFSET(ShadingPoint, footprint);
    sizes[n++] = IR_OFFSET(ShadingPoint, offset);
    sizes[n++] = IR_OFFSET(ShadingPoint, pixel);
    sizes[n++] = IR_OFFSET(ShadingPoint, largest);
    sizes[n++] = (uint)sizeof(RecordKey);
    sizes[n++] = IR_OFFSET(RecordKey, support1);
    sizes[n++] = IR_OFFSET(RecordKey, support2);
    sizes[n++] = IR_OFFSET(RecordKey, coat);
    sizes[n++] = (uint)sizeof(RecordValue);
    sizes[n++] = IR_OFFSET(RecordValue, rotation);
    sizes[n++] = IR_OFFSET(RecordValue, translation);
    sizes[n++] = IR_OFFSET(RecordValue, minimum);
    sizes[n++] = IR_OFFSET(RecordValue, harmonic);
    sizes[n++] = (uint)sizeof(OctreeState);
    sizes[n++] = IR_OFFSET(OctreeState, overflow);
    sizes[n++] = IR_OFFSET(OctreeState, levels);
    sizes[n++] = (uint)sizeof(CacheParameters);
    sizes[n++] = IR_OFFSET(CacheParameters, size);
    sizes[n++] = IR_OFFSET(CacheParameters, coordinate);
    sizes[n++] = IR_OFFSET(CacheParameters, stretch);
    sizes[n++] = (uint)sizeof(RecordParameters);
    sizes[n++] = IR_OFFSET(RecordParameters, accuracy);
    sizes[n++] = IR_OFFSET(RecordParameters, tau);
    sizes[n++] = IR_OFFSET(RecordParameters, firefly);
    sizes[n++] = IR_OFFSET(RecordParameters, reach);
    sizes[n++] = (uint)sizeof(RadianceParameters);
    sizes[n++] = IR_OFFSET(RadianceParameters, trace_below);
    sizes[n++] = IR_OFFSET(RadianceParameters, least);
    sizes[n++] = IR_OFFSET(RadianceParameters, share);
    sizes[n++] = (uint)sizeof(GridParameters);
    sizes[n++] = IR_OFFSET(GridParameters, unit);
    sizes[n++] = IR_OFFSET(GridParameters, slots);
    sizes[n++] = IR_OFFSET(GridParameters, edges);
    sizes[n++] = (uint)sizeof(GridSum);
    sizes[n++] = IR_OFFSET(GridSum, samples);
    sizes[n++] = IR_OFFSET(GridSum, b);
    sizes[n++] = (uint)sizeof(GridCell);
    sizes[n++] = IR_OFFSET(GridCell, b);
}
