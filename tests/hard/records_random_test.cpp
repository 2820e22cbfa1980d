// Property: whatever the records, the octree's look-up in float32 answers what asking every record in double answers:
// the same records with the same weights, and the same irradiance. Hundreds of random sets, from seeds.
#include "random_records.h"

namespace irradia::test {
namespace {

constexpr unsigned kSets = 800;
/// What a rule makes of all sets: the largest errors in units of what is allowed, and how often a question was decided
/// by rounding.
struct Findings {
    double weight = 0, irradiance = 0, sums = 0;  // |error| / allowed
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
        const Agreement together = compare_with_search(device_set, set.records, rule, set.points);
        EXPECT_LE(together.worst, 1) << where << ": the sums of all records";
        found.sums = std::max(found.sums, together.worst);
        found.answers += together.answers;
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
    EXPECT_GT(found.answers, 10 * kSets) << "the question was void";
    EXPECT_GT(found.rims, 0u) << "no record was at its rim";
    EXPECT_LE(found.undecided, found.pairs / 1000) << "rounding decides too often for the test to say much";
    const double worst = std::max({found.weight, found.irradiance, found.sums});
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
