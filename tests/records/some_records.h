// Records made up for tests of the file: every number different, all of them such as look-ups can bear.
#pragma once
#include <cmath>
#include <cstring>
#include <string>

#include "../core/small_scene.h"
#include "irradia/RecordFile.h"
#include "irradia/Renderer.h"

namespace irradia::test {

inline void add_records(Records& records, std::size_t count, std::size_t seed) {
    for (std::size_t i = 0; i < count; ++i) {
        const float x = static_cast<float>((seed + i) % 97) / 97;
        shared::RecordKey k{};
        k.px = 2 * x - 1, k.py = x * x, k.pz = -x;
        k.nx = 0.6f, k.nz = 0.8f;
        k.t2y = 1;
        k.support1 = 0.01f + x;
        k.support2 = 0.02f + 2 * x;
        k.coat = static_cast<std::uint32_t>(i % 3);
        shared::RecordValue v{};
        for (int c = 0; c < 3; ++c) v.e[c] = x + static_cast<float>(c);
        for (int c = 0; c < 9; ++c) {
            v.rotation[c] = x - static_cast<float>(c);
            v.translation[c] = static_cast<float>(c) - 3 * x;
        }
        v.minimum = 0.1f + x;
        v.harmonic = 0.2f + x;
        v.pixel = static_cast<std::uint32_t>(seed + i);
        records.keys.push_back(k);
        records.values.push_back(v);
    }
}

inline void add_radiance(RadianceRecords& r, std::size_t count, std::size_t seed) {
    add_records(r, count, seed);
    for (std::size_t i = 0; i < count * r.sample_floats(); ++i)
        r.samples.push_back(0.01f + static_cast<float>((seed + i) % 89) / 89 * 0.9f);
    for (std::size_t i = 0; i < count * r.harmonic_floats(); ++i)
        r.harmonics.push_back(static_cast<float>((seed + i) % 83) - 40);
}

inline RecordSet some_records(std::size_t irradiance = 5000, std::size_t radiance = 150) {
    RecordSet set;
    set.origin = record_origin(small_scene(), RenderSettings{});
    add_records(set.irradiance, irradiance, 1);
    set.radiance.stride = radiance > 0 ? 16 : 0;
    set.radiance.order = radiance > 0 ? 3 : 0;
    add_radiance(set.radiance, radiance, 7);
    set.views = {{small_scene().info.camera, 16, 9, RecordView::irradiance, 0}};
    return set;
}

template <class T>
bool same(const std::vector<T>& a, const std::vector<T>& b) {
    return a.size() == b.size() && (a.empty() || std::memcmp(a.data(), b.data(), a.size() * sizeof(T)) == 0);
}
inline bool same(const RecordSet& a, const RecordSet& b) {
    return a.origin == b.origin && same(a.irradiance.keys, b.irradiance.keys) &&
           same(a.irradiance.values, b.irradiance.values) && same(a.radiance.keys, b.radiance.keys) &&
           same(a.radiance.values, b.radiance.values) && same(a.radiance.samples, b.radiance.samples) &&
           same(a.radiance.harmonics, b.radiance.harmonics) && a.radiance.stride == b.radiance.stride &&
           a.radiance.order == b.radiance.order && same(a.views, b.views);
}
}  // namespace irradia::test
