// What look-ups rely on. A checksum tells damage; this tells a writer that was wrong, or wicked.
#include <algorithm>
#include <cmath>
#include <string>

#include "core/check.h"
#include "irradia/RecordFile.h"
#include "records/record_layout.h"

namespace irradia {
namespace {

using check::Place;

constexpr float kLargest = 1e30f;  ///< distances to nothing are IR_INFINITY of cl/portable.h
constexpr float kLargestSupport = 1e4f, kFarthest = 10 * IR_FAR_DIAGONALS;  ///< diagonals of the scene

bool is_unit(float x, float y, float z) { return std::abs(x * x + y * y + z * z - 1.0f) < 1e-3f; }
// Up to 1e30: what is computed from them stays finite too. False for NaN.
bool finite(const float* v, std::size_t count) {
    return std::all_of(v, v + count, [](float x) { return std::abs(x) <= kLargest; });
}
bool not_negative(const float* v, std::size_t count) {
    return std::all_of(v, v + count, [](float x) { return x >= 0.0f && x <= kLargest; });
}

/// Where records may lie: the bounds, and as much beyond as RecordCache has its octree reach.
struct Bounds {
    float lower[3], upper[3], diagonal;

    explicit Bounds(const RecordOrigin& origin) {
        float size = 0, coordinate = 0;
        for (std::size_t i = 0; i < 3; ++i) {
            size = std::max(size, origin.upper[i] - origin.lower[i]);
            coordinate = std::max({coordinate, std::abs(origin.lower[i]), std::abs(origin.upper[i])});
        }
        if (!(size > 0)) size = std::max(coordinate, 1.0f);
        for (std::size_t i = 0; i < 3; ++i) {
            lower[i] = origin.lower[i] - 0.01f * size;
            upper[i] = origin.upper[i] + 0.01f * size;
        }
        diagonal = 1.7320508f * size;
    }
    [[nodiscard]] bool hold(const shared::RecordKey& k) const {
        return k.px >= lower[0] && k.px <= upper[0] && k.py >= lower[1] && k.py <= upper[1] && k.pz >= lower[2] &&
               k.pz <= upper[2];
    }
};

void check_support(const Place& p, const Bounds& bounds, float support1, float support2) {
    p.require(support1 > 0.0f && support1 <= support2, "its supports are not positive and in order");
    p.require(support2 <= kLargestSupport * bounds.diagonal, "its support is larger than the scene");
    // Weights divide by the squares.
    p.require(support1 * support1 > 1e-37f && support2 * support2 < 1e37f, "its support is too small or too large");
}

void check_array(const std::string& where, const char* what, const Records& records, const Bounds& bounds) {
    if (records.values.size() != records.size())
        throw Error(where + ": " + std::to_string(records.size()) + " keys of " + what + "s and " +
                    std::to_string(records.values.size()) + " values, expected one of each a record");
    if (records.size() >= 0x7fffffffu)
        throw Error(where + ": " + std::to_string(records.size()) + " " + what + "s, expected fewer than 2^31");
    for (std::size_t i = 0; i < records.size(); ++i) {
        const shared::RecordKey& k = records.keys[i];
        const shared::RecordValue& v = records.values[i];
        const Place p{where, what, i};
        p.finite(k.px, k.py, k.pz, k.support1, k.support2);
        p.require(bounds.hold(k), "it lies outside the scene");
        p.require(is_unit(k.nx, k.ny, k.nz) && is_unit(k.t2x, k.t2y, k.t2z), "a direction is not of unit length");
        check_support(p, bounds, k.support1, k.support2);
        p.require(not_negative(v.e, 3), "its irradiance is not a number of at least 0");
        p.require(finite(v.rotation, 9) && finite(v.translation, 9), "a gradient is not finite");
        p.require(v.minimum >= 0.0f && v.minimum <= kLargest && v.harmonic > 0.0f && v.harmonic <= kLargest,
                  "a distance is not a positive number");
    }
}

/// Samples of one record: arrays over the directions.
void check_samples(const Place& p, const float* s, std::size_t stride, float farthest) {
    p.require(finite(s, 6 * stride), "a sample's point or normal is not finite");
    for (std::size_t i = 0; i < 3 * stride; ++i) p.require(std::abs(s[i]) <= farthest, "a sample is out of reach");
    for (std::size_t i = 3 * stride; i < 6 * stride; ++i)
        p.require(std::abs(s[i]) <= 1.001f, "a sample's normal is longer than 1");
    p.require(not_negative(s + 6 * stride, 4 * stride), "a sample's solid angle or radiance is negative or not finite");
    for (std::size_t i = 0; i < stride; ++i)  // look-ups divide by the square
        p.require(s[i] * s[i] + s[stride + i] * s[stride + i] + s[2 * stride + i] * s[2 * stride + i] > 0.0f,
                  "a sample lies at the record itself");
}

void check_origin(const std::string& where, const RecordOrigin& origin) {
    const Place p{where, "header", 0};
    for (std::size_t i = 0; i < 3; ++i) {
        p.finite(origin.lower[i], origin.upper[i], origin.centre[i]);
        p.require(origin.lower[i] <= origin.upper[i], "the bounds are inverted");
        p.require(origin.upper[i] - origin.lower[i] < 1e15f, "the bounds are too wide");
    }
    for (const auto& [name, value] : origin.settings)
        for (const std::string& word : {name, value})
            p.require(!word.empty() && std::all_of(word.begin(), word.end(), [](char c) { return c > 32 && c < 127; }),
                      "a setting is not a word");
}

}  // namespace

void check_records(const std::string& where, const RecordSet& set) {
    check_origin(where, set.origin);
    const Bounds bounds(set.origin);
    check_array(where, "irradiance record", set.irradiance, bounds);
    check_array(where, "radiance record", set.radiance, bounds);
    const RadianceRecords& r = set.radiance;
    if (r.stride > records::kLargestStride || r.stride % 8 != 0 || r.order > records::kLargestOrder ||
        r.samples.size() != r.size() * r.sample_floats() || r.harmonics.size() != r.size() * r.harmonic_floats())
        throw Error(where + ": radiance records hold " + std::to_string(r.samples.size()) + " and " +
                    std::to_string(r.harmonics.size()) + " floats, which is not what stride " +
                    std::to_string(r.stride) + " and order " + std::to_string(r.order) + " make of " +
                    std::to_string(r.size()));
    for (std::size_t i = 0; i < r.size(); ++i) {
        const Place p{where, "radiance record", i};
        p.require(r.stride > 0 || r.order > 0, "it holds neither samples nor harmonics");
        check_samples(p, r.samples.data() + i * r.sample_floats(), r.stride, kFarthest * bounds.diagonal);
        p.require(finite(r.harmonics.data() + i * r.harmonic_floats(), r.harmonic_floats()),
                  "a harmonic's coefficient is not finite");
    }
    for (std::size_t i = 0; i < set.views.size(); ++i) {
        const shared::Camera& c = set.views[i].camera;
        const Place p{where, "view", i};
        p.finite(c.ox, c.oy, c.oz, c.near_clip, c.cornerx, c.cornery, c.cornerz, c.far_clip, c.dxx, c.dxy, c.dxz);
        p.finite(c.pixel_size, c.dyx, c.dyy, c.dyz, c.aperture_radius, c.forwardx, c.forwardy, c.forwardz,
                 c.focus_distance);
        p.require(set.views[i].kinds == RecordView::irradiance ||
                      set.views[i].kinds == (RecordView::irradiance | RecordView::radiance),
                  "unknown kinds of records");
        p.require(set.views[i].width > 0 && set.views[i].height > 0, "its picture has no pixels");
    }
}

}  // namespace irradia
