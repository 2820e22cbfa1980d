// Property: the look-up of radiance records answers what all records say one by one, weighted in double: the same
// records, the same radiance. What one record says is compared with double in tests/cl/radiance_record_test.cpp.
#include "../cl/radiance_records.h"
#include "random_records.h"

namespace irradia::test {
namespace {

using Question = RadianceRecords::Question;

constexpr unsigned kRadianceSets = 200;

std::vector<shared::Material> materials() {
    return {coated(1.5, .3), coated(1.9, .1, true), metal("Cu", .2), metal("Al", .5, true), metal("none", .1)};
}

/// Records on the floor of the room about (1, 1), some of them identical, some facing away, some of a coat.
std::vector<PlacedRecord> random_placed(Random& random, std::mt19937& jitter) {
    const auto count = static_cast<std::size_t>(random.magnitude(0, 1.5));
    std::vector<PlacedRecord> placed;
    while (placed.size() < count) {
        if (!placed.empty() && random.chance(.15)) {
            placed.push_back(placed[random.below(placed.size())]);
            continue;
        }
        const real3 p = rounded({random.uniform(.5, 1.5), random.uniform(.5, 1.5), random.chance(.1) ? .01 : 0});
        real3 n = host::normalize(real3{0, 0, 1} + random.magnitude(-6, -.7) * random.direction());
        if (random.chance(.1)) n = -n;
        placed.push_back(room_record(p, n, 4, 8, jitter, rounded(random.magnitude(-1.5, .3))));
        if (random.chance(.1)) placed.back().coat = 1;
    }
    return placed;
}

shared::RecordKey key_of(const PlacedRecord& r) {  // as RadianceRecords writes it
    CachedRecord record = flat_record(r.p, r.h.frame.n, r.support, 0);
    const auto f = [](double x) { return static_cast<float>(x); };
    record.key.t2x = f(r.h.frame.t.x), record.key.t2y = f(r.h.frame.t.y), record.key.t2z = f(r.h.frame.t.z);
    return record.key;
}

struct RadianceFindings {
    double worst = 0;  // |error| / allowed
    std::size_t answers = 0, none = 0, undecided = 0, printed_bad = 0;
};

void check_question(const RadianceRecords::Answer& found, const std::vector<RecordWeight>& weights,
                    const std::vector<RadianceRecords::Sums>& said, const std::vector<double>& albedo,
                    RadianceFindings* all) {
    for (const double x : {found.radiance.x, found.radiance.y, found.radiance.z}) {
        ASSERT_TRUE(std::isfinite(x));
        ASSERT_GE(x, 0);
    }
    double weight = 0, error = 0, count = 0;
    for (const RecordWeight& w : weights) {
        if (w.undecided || (w.may_count() && w.value <= w.error)) {
            ++all->undecided;
            return;
        }
        weight += w.value;
        count += w.value > 0;
    }
    ASSERT_EQ(found.found, weight > 0);
    if (weight == 0) {
        ++all->none;
        return;
    }
    ++all->answers;
    for (std::size_t c = 0; c < 3; ++c) {
        double weighted = 0, total = 0;
        for (std::size_t i = 0; i < weights.size(); ++i) {
            weighted += weights[i].value * channel_of(said[i].weighted, c);
            total += weights[i].value * channel_of(said[i].total, c);
        }
        if (!(total > 0)) continue;
        const double ratio = weighted / total;
        error = 0;
        for (std::size_t i = 0; i < weights.size(); ++i)
            error +=
                weights[i].error * (channel_of(said[i].weighted, c) + ratio * channel_of(said[i].total, c)) / total;
        error += (2 * count + 8) * kEps * ratio;
        const double is = channel_of(found.radiance, c), want = albedo[c] * ratio, allowed = albedo[c] * error;
        EXPECT_NEAR(is, want, allowed);
        if (allowed > 0) all->worst = std::max(all->worst, std::abs(is - want) / allowed);
    }
}

class HardRadiance : public ::testing::TestWithParam<std::tuple<const char*, bool>> {};

TEST_P(HardRadiance, LookUpEqualsASearchInDouble) {
    const auto [traversal, harmonics] = GetParam();
    Device& d = device(traversal);
    LobeTables tables(d, materials(), harmonics ? 3 : 0, 8, 2);
    RadianceFindings all;
    std::size_t asked = 0;
    for (unsigned seed = 1; seed <= kRadianceSets; ++seed) {
        Random random(seed);
        std::mt19937 jitter(seed);
        const std::vector<PlacedRecord> placed = random_placed(random, jitter);
        RadianceRecords records(d, tables, placed);
        records.parameters.full_reach = .2f;  // of harmonics: lobes of roughness .1 use them 1/sqrt 2 as far
        records.parameters.harmonics_from = harmonics ? 0.0f : 1e30f;
        std::vector<CachedRecord> keys;
        for (const PlacedRecord& r : placed) {
            keys.push_back({key_of(r), {}});
            keys.back().value.e[0] = 1;
        }
        std::vector<Question> questions;
        for (std::size_t i = 0; i < 20; ++i) {
            const PlacedRecord& r = placed[random.below(placed.size())];
            real3 p = r.p, n = r.h.frame.n;
            if (random.chance(.8)) p += r.support * real3{random.uniform(-1, 1), random.uniform(-1, 1), 0};
            if (random.chance(.5)) n = host::normalize(n + random.magnitude(-7, -1) * random.direction());
            const host::Frame f = host::make_frame(n);
            const auto m = static_cast<std::uint32_t>(random.below(materials().size()));
            questions.push_back({m, static_cast<double>(materials()[m].alpha_u), rounded(p), rounded(n),
                                 rounded(to_world(f, to_real3(direction_at(.8, random.uniform(0, 6)))))});
        }
        const auto found = records.look_up(questions);
        std::vector<Question> each;
        std::vector<std::uint32_t> of;
        for (const Question& q : questions)
            for (std::uint32_t r = 0; r < placed.size(); ++r) each.push_back(q), of.push_back(r);
        const auto said = records.sums(each, of);
        for (std::size_t i = 0; i < questions.size(); ++i) {
            const Question& q = questions[i];
            shared::CacheParameters c{};
            c.inverse_angle = 5;
            c.in_front = .05f;
            c.coordinate = 5;
            c.stretch = harmonics ? std::max(std::sqrt(.2f / materials()[q.material].alpha_u), 1.0f) : 1.0f;
            std::vector<RecordWeight> weights;
            std::vector<RadianceRecords::Sums> one;
            for (std::size_t r = 0; r < placed.size(); ++r) {
                weights.push_back(placed[r].coat == 0 ? weight_in_double(c, IR_WEIGHT_WARD, keys[r].key, {q.p, q.n})
                                                      : RecordWeight{});
                const auto& both = said[i * placed.size() + r];
                one.push_back(harmonics ? both.harmonics : both.samples);
            }
            ASSERT_TRUE(found[i].cached);
            const auto albedo = tables.values(q.material, {{false, q.alpha, host::dot(q.n, q.view)}});
            check_question(found[i], weights, one, albedo, &all);
            all.printed_bad += printed_sums(keys, 5, {q.p, q.n}).is_broken();
            ++asked;
        }
        if (HasFailure()) FAIL() << "set " << seed;
    }
    EXPECT_GT(all.answers, 1000u);
    EXPECT_GT(all.none, 10u);
    EXPECT_LE(all.undecided, asked / 50);
    EXPECT_LE(all.worst, 1);
    hard_case(
        std::to_string(kRadianceSets) + " random sets of up to 31 radiance records, " +
            (harmonics ? "harmonics" : "samples") + ", dialect " + traversal + ": " + std::to_string(asked) +
            " look-ups",
        "all records one by one, weighted in double", "reflected radiance, in units of the roundings allowed",
        all.worst, 1,
        "weights NaN or infinite at " + std::to_string(all.printed_bad) + " of " + std::to_string(asked) + " points");
}

std::string kind_name(const ::testing::TestParamInfo<std::tuple<const char*, bool>>& kind) {
    return std::string(std::get<0>(kind.param)) + (std::get<1>(kind.param) ? "_harmonics" : "_samples");
}
INSTANTIATE_TEST_SUITE_P(Representations, HardRadiance,
                         ::testing::Combine(::testing::Values("cpu", "gpu"), ::testing::Bool()), kind_name);

}  // namespace
}  // namespace irradia::test
