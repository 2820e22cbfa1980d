// Property: whatever the records, the octree's look-up in float32 answers what asking every record in double answers:
// the same records with the same weights, and the same irradiance. Hundreds of random sets, from seeds.
#include "record_set.h"

namespace irradia::test {
namespace {

constexpr unsigned kSets = 800;
constexpr std::size_t kPoints = 48;

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

real3 into_box(real3 p, double half) {
    return {std::clamp(p.x, -half, half), std::clamp(p.y, -half, half), std::clamp(p.z, -half, half)};
}

CachedRecord random_record(const Set& set, real3 facing, Random& random) {
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

Set random_set(unsigned seed) {
    Random random(seed);
    Set set;
    set.size = random.magnitude(-4, 6);
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

/// What a rule makes of all sets: the largest errors in units of what is allowed, and how often a question was decided
/// by rounding.
struct Findings {
    double weight = 0, irradiance = 0;  // |error| / allowed
    std::size_t pairs = 0, undecided = 0, rims = 0, answers = 0, printed_bad = 0, printed_asked = 0;
};

using Weights = std::vector<std::vector<RecordWeight>>;  // [record][point]

/// Classes of records such that at no point more than one of a class may count: asked class by class, the device tells
/// each record's own weight.
std::vector<std::vector<std::size_t>> classes_of(const Weights& weights) {
    std::vector<std::vector<std::size_t>> classes;
    std::vector<std::vector<bool>> taken;  // [class][point]
    for (std::size_t r = 0; r < weights.size(); ++r) {
        std::size_t c = 0;
        for (;; ++c) {
            if (c == classes.size()) {
                classes.emplace_back();
                taken.emplace_back(kPoints, false);
            }
            bool free = true;
            for (std::size_t q = 0; q < kPoints; ++q) free = free && !(taken[c][q] && weights[r][q].may_count());
            if (free) break;
        }
        classes[c].push_back(r);
        for (std::size_t q = 0; q < kPoints; ++q)
            if (weights[r][q].may_count()) taken[c][q] = true;
    }
    return classes;
}

void check_one_by_one(RecordSet& device_set, const Set& set, const Weights& weights, const std::string& where,
                      Findings* found) {
    for (const std::vector<std::size_t>& members : classes_of(weights)) {
        device_set.activate(
            [&](std::size_t i) { return std::find(members.begin(), members.end(), i) != members.end(); });
        const std::vector<Sums> sums = device_set.look_up(set.points);
        for (std::size_t q = 0; q < kPoints; ++q) {
            const Sums& s = sums[q];
            ASSERT_TRUE(s.is_sane()) << where << " point " << q;
            const auto counts =
                std::find_if(members.begin(), members.end(), [&](std::size_t r) { return weights[r][q].may_count(); });
            if (counts == members.end()) {
                EXPECT_EQ(s.weight, 0) << where << " point " << q << ": a record counts that should not";
                continue;
            }
            const RecordWeight& w = weights[*counts][q];
            ++found->pairs;
            found->undecided += w.undecided;
            found->rims += w.value == 0 || w.value <= w.error;
            if (s.weight == 0 && (w.undecided || w.value <= w.error)) continue;
            EXPECT_GT(s.weight, 0) << where << " point " << q << ": record " << *counts << " is missing";
            EXPECT_NEAR(s.weight, w.value, w.error) << where << " point " << q << " record " << *counts;
            found->weight = std::max(found->weight, std::abs(s.weight - w.value) / w.error);
            for (std::size_t c = 0; c < 3; ++c) {
                const Rounded e = irradiance_in_double(set.records[*counts], set.points[q], c);
                const double is = channel_of(s.weighted, c) / s.weight, allowed = e.error + 2 * kEps * e.value;
                EXPECT_NEAR(is, e.value, allowed) << where << " point " << q << " record " << *counts;
                if (allowed > 0) found->irradiance = std::max(found->irradiance, std::abs(is - e.value) / allowed);
            }
        }
    }
    device_set.activate([](std::size_t) { return true; });
}

void check_together(RecordSet& device_set, const Set& set, const Weights& weights, const std::string& where,
                    Findings* found) {
    const std::vector<Sums> sums = device_set.look_up(set.points);
    for (std::size_t q = 0; q < kPoints; ++q) {
        const Sums& s = sums[q];
        ASSERT_TRUE(s.is_sane()) << where << " point " << q;
        double weight = 0, weight_error = 0, weighted = 0, weighted_error = 0;
        std::size_t count = 0;
        bool undecided = false;
        for (std::size_t r = 0; r < set.records.size(); ++r) {
            const RecordWeight& w = weights[r][q];
            if (!w.may_count()) continue;
            const Rounded e = irradiance_in_double(set.records[r], set.points[q], 0);
            ++count;
            undecided = undecided || w.undecided;
            weight += w.value;
            weight_error += w.error;
            weighted += w.value * e.value;
            weighted_error += w.error * e.value + w.value * e.error;
        }
        if (undecided || count == 0) continue;  // one by one, above
        const double roundings = static_cast<double>(count + 2) * kEps;
        EXPECT_NEAR(s.weight, weight, weight_error + roundings * weight) << where << " point " << q;
        EXPECT_NEAR(s.weighted.x, weighted, weighted_error + roundings * weighted) << where << " point " << q;
        ++found->answers;
    }
}

Findings check_rule(std::uint32_t rule, bool in_front) {
    Findings found;
    for (unsigned seed = 1; seed <= kSets; ++seed) {
        const Set set = random_set(seed);
        CacheSettings settings = cube_settings(set.size);
        settings.weight = rule;
        if (!in_front) settings.in_front_slope = 0;
        RecordSet device_set(set.records, settings);
        Weights weights;
        for (const CachedRecord& r : set.records) {
            weights.emplace_back();
            for (const LookupPoint& q : set.points)
                weights.back().push_back(weight_in_double(device_set.parameters(), rule, r.key, q));
        }
        const std::string where = "set " + std::to_string(seed);
        check_together(device_set, set, weights, where, &found);
        check_one_by_one(device_set, set, weights, where, &found);
        for (const LookupPoint& q : set.points) {
            ++found.printed_asked;
            found.printed_bad += printed_sums(set.records, settings.inverse_angle, q).is_broken();
        }
        if (::testing::Test::HasFailure()) break;  // one set says it
    }
    return found;
}

class RandomRecords : public ::testing::TestWithParam<std::tuple<std::uint32_t, bool>> {};

TEST_P(RandomRecords, LookUpEqualsASearchInDouble) {
    const auto [rule, in_front] = GetParam();
    const Findings found = check_rule(rule, in_front);
    const char* const names[] = {"1.8, Ward", "1.11, Tabellion", "cubic"};
    EXPECT_GT(found.answers, 20 * kSets) << "the question was void";
    EXPECT_GT(found.rims, 0u) << "no record was at its rim";
    EXPECT_LE(found.undecided, found.pairs / 1000) << "rounding decides too often for the test to say much";
    const double worst = std::max(found.weight, found.irradiance);
    EXPECT_LE(worst, 1);
    hard_case(std::to_string(kSets) + " random sets of up to 160 records, weight " + names[rule] +
                  (in_front ? ", records in front left out" : "") + ": " + std::to_string(found.pairs) +
                  " pairs of point and record one by one, and their sums",
              "search over all records in double",
              "weights and E_i, in units of the roundings allowed (10 to 140 of 2^-24); records that count: the same",
              worst, 1,
              "NaN or infinite E at " + std::to_string(found.printed_bad) + " of " +
                  std::to_string(found.printed_asked) + " points");
}

std::string rule_name(const ::testing::TestParamInfo<std::tuple<std::uint32_t, bool>>& info) {
    const char* const names[] = {"ward", "tabellion", "cubic"};
    return names[std::get<0>(info.param)] + std::string(std::get<1>(info.param) ? "_in_front" : "");
}
INSTANTIATE_TEST_SUITE_P(Rules, RandomRecords,
                         ::testing::Combine(::testing::Values(IR_WEIGHT_WARD, IR_WEIGHT_TABELLION, IR_WEIGHT_CUBIC),
                                            ::testing::Bool()),
                         rule_name);

}  // namespace
}  // namespace irradia::test
