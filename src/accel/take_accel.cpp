#include <tbb/blocked_range.h>
#include <tbb/parallel_reduce.h>

#include <cstring>
#include <functional>

#include "irradia/Accel.h"

namespace irradia {
namespace {

// What the builder reads of a primitive, bit for bit: positions, not the normals and materials beside them.
bool same(const shared::Vertex& a, const shared::Vertex& b) { return std::memcmp(&a.px, &b.px, 3 * sizeof a.px) == 0; }

bool same(const shared::Triangle& a, const shared::Triangle& b) { return a.v0 == b.v0 && a.v1 == b.v1 && a.v2 == b.v2; }

bool same(shared::Analytic a, shared::Analytic b) {
    a.material = b.material = 0;
    a.light = b.light = 0;
    a.sign = b.sign = a.pad0 = b.pad0 = a.pad1 = b.pad1 = 0;
    return std::memcmp(&a, &b, sizeof a) == 0;
}

template <class T>
bool same(const std::vector<T>& a, const std::vector<T>& b) {
    return tbb::parallel_reduce(
        tbb::blocked_range<std::size_t>(0, a.size(), 1 << 15), true,
        [&](const auto& range, bool equal) {
            for (std::size_t i = range.begin(); equal && i != range.end(); ++i) equal = same(a[i], b[i]);
            return equal;
        },
        std::logical_and<>());
}

}  // namespace

bool take_accel(Scene& to, Scene& from, AccelLayouts layouts, AccelQuality quality) {
    if (from.accel.quality != quality) return false;
    if (to.vertices.size() != from.vertices.size() || to.triangles.size() != from.triangles.size() ||
        to.analytics.size() != from.analytics.size())
        return false;
    if ((layouts != AccelLayouts::bvh2 && from.accel.bvh8_nodes.empty()) ||
        (layouts != AccelLayouts::bvh8 && from.accel.bvh2_nodes.empty()))
        return false;
    if (!same(to.triangles, from.triangles) || !same(to.analytics, from.analytics) || !same(to.vertices, from.vertices))
        return false;
    to.accel = std::move(from.accel);
    from.accel = {};
    if (layouts == AccelLayouts::bvh8) to.accel.bvh2_nodes = {}, to.accel.bvh2_triangles = {};
    if (layouts == AccelLayouts::bvh2) to.accel.bvh8_nodes = {}, to.accel.bvh8_triangles = {};
    return true;
}

}  // namespace irradia
