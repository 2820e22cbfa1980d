// Random sets of records and of points that ask them: supports over orders of magnitude, identical records, records on
// the scene's borders, on both sides of a surface, in front of one another; points at records, on rims and anywhere.
#pragma once
#include "record_set.h"

namespace irradia::test {

constexpr std::size_t kPoints = 48;  ///< that a set is asked at

/// Numbers of one set.
class Random {
public:
    explicit Random(unsigned seed) : engine_(seed) {}
    double uniform(double lo = 0, double hi = 1) { return std::uniform_real_distribution<double>(lo, hi)(engine_); }
    /// Uniform in the exponent.
    double magnitude(double lo, double hi) { return std::pow(10, uniform(lo, hi)); }
    bool chance(double p) { return uniform() < p; }
    std::size_t below(std::size_t n) { return engine_() % n; }
    real3 direction() {
        std::normal_distribution<double> g;
        const double x = g(engine_), y = g(engine_), z = g(engine_);
        return host::normalize(host::make_real3(x, y, z));
    }
    real3 box(double half) { return {uniform(-half, half), uniform(-half, half), uniform(-half, half)}; }

private:
    std::mt19937 engine_;
};

/// A set of records, points that ask, and the bounds of both.
struct Set {
    std::vector<CachedRecord> records;
    std::vector<LookupPoint> points;
    double size;
};

inline real3 into_box(real3 p, double half) {
    return {std::clamp(p.x, -half, half), std::clamp(p.y, -half, half), std::clamp(p.z, -half, half)};
}

inline CachedRecord random_record(const Set& set, real3 facing, Random& random) {
    const double half = .5 * set.size;
    if (!set.records.empty() && random.chance(.1)) return set.records[random.below(set.records.size())];  // identical
    const double support = set.size * random.magnitude(-5, -.3);
    real3 p = random.box(half);
    if (!set.records.empty() && random.chance(.7)) {  // among the others
        const shared::RecordKey& k = set.records[random.below(set.records.size())].key;
        p = into_box(position_of(k) + static_cast<double>(k.support2) * random.box(1), half);
    }
    if (random.chance(.1)) p.x = random.chance(.5) ? half : -half;  // on the scene's border
    if (random.chance(.05)) p.y = p.z = half;
    const real3 n = random.chance(.1)   ? random.direction()
                    : random.chance(.2) ? -facing
                    : random.chance(.3) ? facing
                                        : host::normalize(facing + random.magnitude(-7, -.5) * random.direction());
    CachedRecord r = flat_record(p, n, support, 1, random.uniform(1, 4));
    for (float& e : r.value.e) e = random.chance(.05) ? 0 : static_cast<float>(random.magnitude(-3, 3));
    for (std::size_t c = 0; c < 3; ++c)
        for (std::size_t i = 0; i < 3; ++i) {  // up to where the limits of (1.7) are reached
            const double e = static_cast<double>(r.value.e[c]);
            r.value.translation[3 * c + i] =
                static_cast<float>(e / static_cast<double>(r.key.support2) * random.uniform(-1.5, 1.5));
            r.value.rotation[3 * c + i] = static_cast<float>(e * random.uniform(-5, 5));
        }
    return r;
}

/// Set number `seed`; a scene of edge `size`, or of any if that is 0.
inline Set random_set(unsigned seed, double size = 0) {
    Random random(seed);
    Set set;
    set.size = random.magnitude(-4, 6);
    if (size > 0) set.size = size;
    const auto count = static_cast<std::size_t>(random.magnitude(0, 2.2));
    const real3 axes[] = {{1, 0, 0}, {0, -1, 0}, {0, 0, 1}};  // half of the sets lie along the octree's faces
    const real3 facing = random.chance(.5) ? axes[random.below(3)] : random.direction();
    while (set.records.size() < count) set.records.push_back(random_record(set, facing, random));
    while (set.points.size() < kPoints) {
        const shared::RecordKey& k = set.records[random.below(count)].key;
        real3 p = position_of(k), n = normal_of(k);
        if (random.chance(.8)) {  // on its tangent plane, or over it, or anywhere near
            const host::Frame f = host::make_frame(n);
            const double reach = 1.1 * static_cast<double>(k.support2);
            if (random.chance(.3))  // on the rim, where the octree ends: along either axis or the normal
                p += static_cast<double>(k.support1) * (1 - random.magnitude(-8, -2)) * (random.chance(.5) ? 1 : -1) *
                     (random.chance(.4) ? n : f.b);
            else if (random.chance(.2))
                p +=
                    static_cast<double>(k.support2) * (1 - random.magnitude(-8, -2)) * (random.chance(.5) ? f.t : -f.t);
            else
                p += reach * (random.uniform(-1, 1) * f.t + random.uniform(-1, 1) * f.b);
            if (random.chance(.3)) p += reach * random.magnitude(-4, 0) * random.uniform(-1, 1) * n;
            p = into_box(p, .5 * set.size);
        } else if (random.chance(.1)) {
            p = random.box(.5 * set.size);
        }
        if (random.chance(.6)) n = host::normalize(n + random.magnitude(-8, -1) * random.direction());
        set.points.push_back(lookup_point(p, n));
    }
    return set;
}

}  // namespace irradia::test
