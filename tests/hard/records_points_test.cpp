// Pairs of a point and a record where the printed forms of (1.6) - (1.10) divide by zero, take the root of a negative
// number, or let light through a step.
#include "random_records.h"

namespace irradia::test {
namespace {

constexpr std::uint32_t kRules[] = {IR_WEIGHT_WARD, IR_WEIGHT_TABELLION, IR_WEIGHT_CUBIC};
const real3 kUp{0, 0, 1};

CacheSettings settings_of(std::uint32_t rule, double size = 1) {
    CacheSettings s = cube_settings(size);
    s.weight = rule;
    return s;
}

std::string of_points(std::size_t count, std::size_t all) {
    return std::to_string(count) + " of " + std::to_string(all) + " points";
}

// A point where a record lies, alone: E is that record's, to a division's rounding. (1.8) gives 1/0 or, where the
// rounding of n.n_i leaves 1 - n.n_i negative, the root of that.
TEST(RecordPoints, AtTheRecord) {
    Random random(11);
    double worst = 0;
    std::size_t broken = 0, asked = 0;
    for (const std::uint32_t rule : kRules) {
        std::vector<CachedRecord> records;
        std::vector<LookupPoint> points;
        for (int i = 0; i < 1000; ++i) {  // apart from one another
            const real3 p{.09 * (i % 10) - .4, .09 * (i / 10 % 10) - .4, .09 * (i / 100) - .4};
            records.push_back(flat_record(p, random.direction(), random.magnitude(-6, -1.2), random.magnitude(-6, 6)));
            points.push_back(lookup_point(position_of(records.back().key), normal_of(records.back().key)));
        }
        RecordSet set(records, settings_of(rule));
        const std::vector<Sums> found = set.look_up(points);
        for (std::size_t i = 0; i < found.size(); ++i) {
            ASSERT_TRUE(found[i].is_sane()) << i;
            ASSERT_GT(found[i].weight, 0) << i;
            worst = std::max(worst, std::abs(found[i].e() / static_cast<double>(records[i].value.e[0]) - 1));
            broken += printed_sums(records, 5, points[i]).is_broken();
            ++asked;
        }
    }
    EXPECT_LE(worst, 2 * kEps);
    EXPECT_GT(broken, asked / 2);
    hard_case("p = p_i and n = n_i, all three weights", "closed form: E_i", "relative error of E", worst, 2 * kEps,
              "NaN at " + of_points(broken, asked));
}

// Equal normals away from the record, whose dot product rounds above 1 (theory 4.1: one pair in twenty).
TEST(RecordPoints, CosinesThatRoundAboveOne) {
    Random random(12);
    double worst = 0;
    std::size_t broken = 0, asked = 0;
    for (const std::uint32_t rule : kRules)
        for (int i = 0; i < 3000; ++i) {
            const double support = .1;
            const CachedRecord r = flat_record(.2 * random.box(1), random.direction(), support, 2);
            const real3 n = normal_of(r.key);
            const auto f = [](double x) { return static_cast<float>(x); };
            if (!(f(n.x) * f(n.x) + f(n.y) * f(n.y) + f(n.z) * f(n.z) > 1)) continue;
            const LookupPoint q =
                lookup_point(position_of(r.key) + support * random.uniform(.05, .9) * host::make_frame(n).t, n);
            RecordSet set({r}, settings_of(rule));
            const Sums found = set.look_up({q}).at(0);
            ASSERT_TRUE(found.is_sane());
            const RecordWeight w = weight_in_double(set.parameters(), rule, r.key, q);
            EXPECT_NEAR(found.weight, w.value, w.error);
            worst = std::max(worst, std::abs(found.weight / w.value - 1));
            broken += printed_sums({r}, 5, q).is_broken();
            ++asked;
        }
    EXPECT_GT(asked, 300u);
    EXPECT_EQ(broken, asked);
    EXPECT_LE(worst, 1e-5);
    hard_case("n = n_i whose n.n_i rounds above 1, all three weights", "double on the host",
              "relative error of the weight", worst, 1e-5, "NaN at " + of_points(broken, asked));
}

// The other side of a thin wall: the record lies at the point itself and faces away, exactly or nearly, or by just over
// a right angle. It must not count, whatever angle a; printed (1.8) with a > sqrt 2 takes it.
TEST(RecordPoints, OppositeNormals) {
    Random random(13);
    double leaked = 0;
    std::size_t asked = 0, printed = 0;
    for (const std::uint32_t rule : kRules)
        for (const float inverse_angle : {5.0f, 1.0f, .5f, .01f})
            for (int i = 0; i < 30; ++i) {
                const real3 n = random.direction(), p = .4 * random.box(1);
                const host::Frame f = host::make_frame(n);
                const real3 away = i % 3 == 0   ? -n
                                   : i % 3 == 1 ? -host::normalize(n + random.magnitude(-8, -.3) * random.direction())
                                                : host::normalize(f.t - random.magnitude(-5, 0) * n);
                const CachedRecord r = flat_record(p, away, .3, random.magnitude(-2, 2));
                const LookupPoint q = lookup_point(position_of(r.key), n);
                CacheSettings settings = settings_of(rule);
                settings.inverse_angle = inverse_angle;
                RecordSet set({r}, settings);
                const Sums found = set.look_up({q}).at(0);
                EXPECT_TRUE(found.is_sane());
                leaked = std::max(leaked, found.weight);
                const PrintedSums sums = printed_sums({r}, inverse_angle, q);
                printed += sums.weight > 0;
                ++asked;
            }
    EXPECT_EQ(leaked, 0);
    EXPECT_GT(printed, asked / 4);
    hard_case("normals opposite or more than 90 degrees apart at p = p_i, a of .2, 1, 2, 100", "closed form: 0",
              "weight", leaked, 0, "such records count at " + of_points(printed, asked));
}

// Copies of one record but for E: whatever the weight, all weigh the same, and E is their mean. A float32 sum of n
// terms is good to n roundings.
TEST(RecordPoints, IdenticalRecords) {
    Random random(14);
    double worst = 0, bound = 0;
    std::size_t broken = 0, asked = 0;
    for (const std::uint32_t rule : kRules)
        for (const std::size_t count : {2u, 10u, 100u, 1000u}) {
            const real3 n = random.direction();
            std::vector<CachedRecord> records(count, flat_record(.3 * random.box(1), n, .1, 1));
            double mean = 0;
            for (CachedRecord& r : records) {
                r.value.e[0] = static_cast<float>(random.uniform(1, 2));
                mean += static_cast<double>(r.value.e[0]) / static_cast<double>(count);
            }
            const real3 p = position_of(records[0].key);
            std::vector<LookupPoint> points{lookup_point(p, normal_of(records[0].key))};
            for (int i = 0; i < 20; ++i)
                points.push_back(lookup_point(p + random.uniform(0, .05) * host::make_frame(n).t, n));
            for (const Sums& s : RecordSet(records, settings_of(rule)).look_up(points)) {
                ASSERT_TRUE(s.is_sane());
                const double allowed = 2 * static_cast<double>(count + 2) * kEps;
                EXPECT_LE(std::abs(s.e() / mean - 1), allowed) << count << " records";
                worst = std::max(worst, std::abs(s.e() / mean - 1));
                bound = std::max(bound, allowed);
            }
            for (const LookupPoint& q : points) broken += printed_sums(records, 5, q).is_broken();
            asked += points.size();
        }
    hard_case("2 to 1000 identical records, all three weights", "closed form: their mean", "relative error of E", worst,
              bound, "NaN or infinite at " + of_points(broken, asked));
}

// A floor of E = 1, and a step .001 of the scene above it of E = 10 (a sheet of paper on a table): neither may take the
// other's records. In front: theory 4.3 tells a step of height h from a curved surface up to h/slope = .02 away, and a
// record below up to h/.3. (1.6) without the test mixes the two.
TEST(RecordPoints, RecordsOnSteps) {
    constexpr double height = .001;
    Random random(15);
    double worst = 0, mixed = 0;
    std::size_t asked = 0;
    for (const std::uint32_t rule : kRules) {
        std::vector<CachedRecord> records;
        std::vector<LookupPoint> on_floor, on_step;
        // Floor x < 0, step x > 0; supports end where the test is still sure of itself.
        for (int i = 0; i < 400; ++i) {
            const double y = random.uniform(-.01, .01);
            records.push_back(flat_record({-random.uniform(0, .01), y, 0}, kUp, .9 * height / .05, 1));
            records.push_back(flat_record({random.uniform(0, .01), y, height}, kUp, .9 * height / .3, 10));
            on_floor.push_back(lookup_point({-random.uniform(0, .01), y, 0}, kUp));
            on_step.push_back(lookup_point({random.uniform(0, .002), y, height}, kUp));
        }
        // The step's own records reach the floor farther than the floor's reach the step.
        std::vector<CachedRecord> high = records, low = records;
        for (std::size_t i = 0; i < records.size(); ++i) {
            const bool step = records[i].key.pz > 0;
            high[i].key.support1 = high[i].key.support2 = static_cast<float>(step ? .9 * height / .05 : 1e-2);
            low[i].key.support1 = low[i].key.support2 = static_cast<float>(step ? 1e-2 : .9 * height / .3);
        }
        const auto check = [&](const std::vector<CachedRecord>& of, const std::vector<LookupPoint>& points, double e) {
            RecordSet set(of, settings_of(rule));
            CacheSettings off = settings_of(rule);
            off.in_front_slope = 0;
            const std::vector<Sums> found = set.look_up(points), without = RecordSet(of, off).look_up(points);
            for (std::size_t q = 0; q < points.size(); ++q) {
                ASSERT_TRUE(found[q].is_sane());
                ASSERT_GT(found[q].weight, 0);
                worst = std::max(worst, std::abs(found[q].e() / e - 1));
                mixed = std::max(mixed, std::abs(without[q].e() / e - 1));
                ++asked;
            }
        };
        check(high, on_floor, 1);
        check(low, on_step, 10);
    }
    EXPECT_GT(mixed, .5) << "nothing would have leaked";
    EXPECT_LE(worst, 1e-5);
    hard_case("records in front and below: a step .001 of the scene high, E = 1 below, 10 above",
              "closed form: 1 and 10", "relative error of E", worst, 1e-5, "without (1.10): " + figure(mixed));
}

}  // namespace
}  // namespace irradia::test
