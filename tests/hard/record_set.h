// Sets of irradiance records in device memory, what the device's look-up answers, and what asking every record in
// double answers from the same (rounded) numbers, with the error that float32 may have there.
#pragma once
#include <array>
#include <random>

#include "../cl/device.h"
#include "cache/RecordCache.h"
#include "hard_case.h"

namespace irradia::test {

using host::real3;

struct CachedRecord {
    shared::RecordKey key{};
    shared::RecordValue value{};
};

/// A surface point that asks; rounded to float32 once, like records.
struct LookupPoint {
    real3 p, n;
};

/// Through memory: GCC 12 at -O2 leaves the rounding out where it takes two such conversions together as a vector.
inline double rounded(double x) {
    const volatile float single = static_cast<float>(x);
    return static_cast<double>(single);
}
inline real3 rounded(real3 v) { return {rounded(v.x), rounded(v.y), rounded(v.z)}; }
inline LookupPoint lookup_point(real3 p, real3 n) { return {rounded(p), rounded(n)}; }

inline real3 position_of(const shared::RecordKey& k) {
    return {static_cast<double>(k.px), static_cast<double>(k.py), static_cast<double>(k.pz)};
}
inline real3 normal_of(const shared::RecordKey& k) {
    return {static_cast<double>(k.nx), static_cast<double>(k.ny), static_cast<double>(k.nz)};
}
inline real3 long_axis_of(const shared::RecordKey& k) {
    return {static_cast<double>(k.t2x), static_cast<double>(k.t2y), static_cast<double>(k.t2z)};
}

/// A record without gradients; the long axis lies along the local frame's T.
inline CachedRecord flat_record(real3 p, real3 n, double support, double e, double aspect = 1) {
    const auto f = [](double x) { return static_cast<float>(x); };
    const real3 t = host::make_frame(n).t;
    CachedRecord r;
    r.key.px = f(p.x), r.key.py = f(p.y), r.key.pz = f(p.z);
    r.key.nx = f(n.x), r.key.ny = f(n.y), r.key.nz = f(n.z);
    r.key.t2x = f(t.x), r.key.t2y = f(t.y), r.key.t2z = f(t.z);
    r.key.support1 = f(support);
    r.key.support2 = f(aspect * support);
    for (float& c : r.value.e) c = f(e);
    return r;
}

/// Bounds of a cube of edge `size` about `centre`; no neighbour clamp, so that records stay as they were written.
inline CacheSettings cube_settings(double size, real3 centre = {0, 0, 0}) {
    const auto f = [](double x) { return static_cast<float>(x); };
    CacheSettings s;
    s.lower = {f(centre.x - .5 * size), f(centre.y - .5 * size), f(centre.z - .5 * size)};
    s.upper = {f(centre.x + .5 * size), f(centre.y + .5 * size), f(centre.z + .5 * size)};
    s.clamp_slope = 0;
    return s;
}

/// Sums of (1.6).
struct Sums {
    real3 weighted{0, 0, 0};
    double weight = 0;
    [[nodiscard]] bool is_sane() const {
        for (const double x : {weighted.x, weighted.y, weighted.z, weight})
            if (!std::isfinite(x) || x < 0) return false;
        return true;
    }
    [[nodiscard]] double e() const { return weighted.x / weight; }  ///< of the first channel
};

class RecordSet {
public:
    RecordSet(const std::vector<CachedRecord>& records, const CacheSettings& settings) : cache_(device(), settings) {
        cache_.reserve(records.size());
        std::vector<shared::RecordValue> values;
        for (const CachedRecord& r : records) {
            keys_.push_back(r.key);
            values.push_back(r.value);
        }
        write_keys(keys_);
        device().write(const_cast<Buffer&>(cache_.values()), values.data(), values.size() * sizeof values[0]);
        // Some packed, some in lists. No neighbour clamp: points are not read.
        const std::size_t packed = records.size() - records.size() / 3;
        cache_.insert(packed, cache_.keys(), cache_.keys());
        cache_.settle();
        cache_.insert(records.size() - packed, cache_.keys(), cache_.keys());
    }

    [[nodiscard]] const RecordCache& cache() const { return cache_; }
    [[nodiscard]] shared::CacheParameters parameters() const { return cache_.parameters(false); }

    /// Lets only records answer for which active(i) holds: the others become records of another coat. The octree keeps
    /// all of them.
    template <class F>
    void activate(const F& active) {
        std::vector<shared::RecordKey> keys = keys_;
        for (std::size_t i = 0; i < keys.size(); ++i) keys[i].coat = active(i) ? 0 : 1;
        write_keys(keys);
    }

    std::vector<Sums> look_up(const std::vector<LookupPoint>& points) {
        Inputs in;
        for (const LookupPoint& q : points) in.add(q.p).add(q.n);
        std::vector<float> out(4 * points.size());
        Device& d = device();
        const Buffer from = d.upload(in.values());
        const Buffer to = d.upload(out);
        Kernel kernel = d.kernel("cache_test.cl", "look_up", cache_.defines());
        cache_.bind(kernel, false)
            .arg(from)
            .arg(to)
            .arg(static_cast<std::uint32_t>(cache_.size()))
            .arg(0u)
            .arg(static_cast<std::uint32_t>(points.size()))
            .run((points.size() + 15) / 16, 16);
        d.read(to, out.data(), out.size() * sizeof(float));
        std::vector<Sums> sums;
        for (std::size_t i = 0; i < out.size(); i += 4) {
            const auto at = [&](std::size_t k) { return static_cast<double>(out[i + k]); };
            sums.push_back({{at(0), at(1), at(2)}, at(3)});
        }
        return sums;
    }

private:
    void write_keys(const std::vector<shared::RecordKey>& keys) {
        device().write(const_cast<Buffer&>(cache_.keys()), keys.data(), keys.size() * sizeof keys[0]);
    }
    RecordCache cache_;
    std::vector<shared::RecordKey> keys_;
};

// ---- the same in double ---------------------------------------------------------------------------------------------

/// A number and by how much float32 may miss it.
struct Rounded {
    double value = 0, error = 0;
};

/// A record's weight at a point.
struct RecordWeight : Rounded {
    bool undecided = false;  ///< within rounding of a test on records that p must not see: 0 is right too
    [[nodiscard]] bool may_count() const { return value > 0 || error > 0; }
};

/// Theory 4.1 - 4.3 and 6 in double. Errors: differences of given numbers and the ratios of their lengths are good to a
/// few roundings, but what is left of |dp|^2 across the long axis only to 12 roundings of |dp|^2, which is up to
/// (support2/support1)^2 times as large.
inline RecordWeight weight_in_double(const shared::CacheParameters& c, std::uint32_t rule, const shared::RecordKey& k,
                                     const LookupPoint& q) {
    const real3 pi = position_of(k), ni = normal_of(k), dp = q.p - pi;
    const double r1 = static_cast<double>(k.support1), r2 = static_cast<double>(k.support2), aspect = r2 / r1;
    const double stretch = static_cast<double>(c.stretch);
    const double d = host::elliptic_error(dp, long_axis_of(k), r1, r2) * stretch;
    const double angle = host::normal_error(q.n, ni) * static_cast<double>(c.inverse_angle) * stretch;
    const double d_error = kEps * (8 + 8 * aspect * aspect) * d, angle_error = kEps * 12 * angle;
    RecordWeight w;
    double x = d + angle;
    if (rule == IR_WEIGHT_TABELLION) {
        x = std::max(d, angle);
        w.value = std::max(0.0, 1 - x);
        w.error = d_error + angle_error + 2 * kEps;
    } else if (rule == IR_WEIGHT_CUBIC) {
        w.value = host::cubic_weight_normalised(x);
        w.error = 1.5 * (d_error + angle_error) + 8 * kEps;
    } else {
        w.value = host::ward_weight_normalised(x);
        const double capped = std::max(x, .01);
        w.error = (d_error + angle_error + 2 * kEps * capped) / (capped * capped) + 8 * kEps * w.value;
    }
    if (x >= 1 + d_error + angle_error + 2 * kEps) return {};  // clear of the rim
    if (c.in_front > 0) {
        const double slope = static_cast<double>(c.in_front), size = static_cast<double>(c.coordinate);
        const double height = host::height_over_record(q.p, q.n, pi, ni), distance = host::length(dp);
        const double allowed = host::in_front_tolerance(distance, slope, size), roundings = 12 * kEps;
        const double facing = host::dot(q.n, ni);
        const bool front = std::abs(height + allowed) <= roundings * (distance + allowed);
        const bool below = facing > .95 - roundings && height > .3 * distance - roundings * distance &&
                           (facing < .95 + roundings || height < .3 * distance + roundings * distance);
        w.undecided = distance > 0 && (front || below);
        if (!w.undecided && (host::is_in_front(q.p, q.n, pi, ni, slope, size) || host::is_below(q.p, q.n, pi, ni)))
            return {};
    }
    return w;
}

/// One channel of (1.7) in double, within [0, 2 E_i]. The turn n_i x n of nearly equal normals cancels: it is good to
/// roundings of 1.
inline Rounded irradiance_in_double(const CachedRecord& r, const LookupPoint& q, std::size_t channel) {
    const real3 delta = q.p - position_of(r.key), turn = host::cross(normal_of(r.key), q.n);
    const auto part = [&](const float* g, real3 v, double slip) {
        const real3 at{static_cast<double>(g[3 * channel]), static_cast<double>(g[3 * channel + 1]),
                       static_cast<double>(g[3 * channel + 2])};
        const double size = std::abs(v.x * at.x) + std::abs(v.y * at.y) + std::abs(v.z * at.z);
        return Rounded{host::dot(v, at), 8 * kEps * size + slip * host::length(at)};
    };
    const double e = static_cast<double>(r.value.e[channel]);
    const Rounded turned = part(r.value.rotation, turn, 4 * kEps), moved = part(r.value.translation, delta, 0);
    return {std::clamp(e + turned.value + moved.value, 0.0, 2 * e),
            turned.error + moved.error + 4 * kEps * (e + std::abs(turned.value) + std::abs(moved.value))};
}

/// How far the device's sums over records lie from those of a search over all records in double.
struct Agreement {
    double worst = 0;  ///< |error| of sum w and sum w E in units of what is allowed, terms' errors and sums' roundings
    double relative = 0;  ///< |error| of E relative to it
    std::size_t answers = 0, undecided = 0;
};
inline Agreement compare_with_search(RecordSet& set, const std::vector<CachedRecord>& records, std::uint32_t rule,
                                     const std::vector<LookupPoint>& points) {
    Agreement all;
    const std::vector<Sums> sums = set.look_up(points);
    const shared::CacheParameters parameters = set.parameters();
    for (std::size_t q = 0; q < points.size(); ++q) {
        EXPECT_TRUE(sums[q].is_sane()) << "point " << q;
        Rounded weight, weighted;
        std::size_t count = 0;
        bool undecided = false;
        for (const CachedRecord& r : records) {
            const RecordWeight w = weight_in_double(parameters, rule, r.key, points[q]);
            if (!w.may_count()) continue;
            const Rounded e = irradiance_in_double(r, points[q], 0);
            ++count;
            undecided = undecided || w.undecided;
            weight.value += w.value;
            weight.error += w.error;
            weighted.value += w.value * e.value;
            weighted.error += w.error * e.value + w.value * e.error;
        }
        all.undecided += undecided;
        if (undecided) continue;
        if (count == 0) {
            EXPECT_EQ(sums[q].weight, 0) << "point " << q << ": a record counts that should not";
            continue;
        }
        const double roundings = static_cast<double>(count + 2) * kEps;
        weight.error += roundings * weight.value;
        weighted.error += roundings * weighted.value;
        all.worst = std::max(all.worst, std::abs(sums[q].weight - weight.value) / weight.error);
        if (weighted.error > 0)
            all.worst = std::max(all.worst, std::abs(sums[q].weighted.x - weighted.value) / weighted.error);
        if (weight.value <= 2 * weight.error || weighted.value <= 2 * weighted.error) continue;
        ++all.answers;
        all.relative = std::max(all.relative, std::abs(sums[q].e() * weight.value / weighted.value - 1));
    }
    return all;
}

inline double channel_of(real3 v, std::size_t c) { return c == 0 ? v.x : c == 1 ? v.y : v.z; }

/// (1.6) with (1.8) as the thesis prints them, in float32, first channel: w = 1/(|p - p_i|/R + sqrt(1 - n.n_i)) - 1/a
/// of the records that reach p, in units of a. Sums of none are 0.
struct PrintedSums {
    float weighted = 0, weight = 0;
    [[nodiscard]] float e() const { return weighted / weight; }
    /// Neither "no record" nor a number.
    [[nodiscard]] bool is_broken() const { return weight != 0 && !std::isfinite(e()); }
};
inline PrintedSums printed_sums(const std::vector<CachedRecord>& records, float inverse_angle, const LookupPoint& q) {
    const auto f = [](double x) { return static_cast<float>(x); };
    PrintedSums sums;
    for (const CachedRecord& r : records) {
        const shared::RecordKey& k = r.key;
        const float x = f(q.p.x) - k.px, y = f(q.p.y) - k.py, z = f(q.p.z) - k.pz;
        const float cosine = f(q.n.x) * k.nx + f(q.n.y) * k.ny + f(q.n.z) * k.nz;
        const float e = std::sqrt(x * x + y * y + z * z) / k.support1 + inverse_angle * std::sqrt(1 - cosine);
        const float w = 1 / e - 1;
        if (w <= 0) continue;  // what is not a number goes on, as in the printed sum
        sums.weighted += w * r.value.e[0];
        sums.weight += w;
    }
    return sums;
}

}  // namespace irradia::test
