// The irradiance grid's table: sums, keys, levels, answers (cl/irradiance_grid.h, cl/merge_grid.cl).
#include <algorithm>
#include <map>
#include <random>

#include "device.h"
#include "irradia/shared/grid_types.h"

namespace irradia::test {
namespace {
using shared::GridCell;
using shared::GridParameters;
using shared::GridSum;

using V = std::array<float, 3>;
struct Deposit {
    V p, n, irradiance;
};
struct Question {
    V p, n;
    float distance;
};
struct Answer {
    bool found;
    V irradiance;
};
constexpr V kUp{0, 0, 1};

// Cells of edge 1 with a corner in the origin, answers from 16 samples on, for rays longer than 2 cells.
GridParameters parameters(std::uint32_t slots, float unit = 0x1p-20f) {
    GridParameters p{};
    p.cell = 1;
    p.unit = unit;
    p.shortest = 2;
    p.slots = slots;
    p.least = 16;
    return p;
}

/// The kernels one by one, as src/render/irradiance_grid.cpp calls them.
class Table {
public:
    /// `defines`: of the kernels that take slots.
    explicit Table(const GridParameters& p, std::map<std::string, std::string> defines = {})
        : parameters_(p),
          defines_(std::move(defines)),
          sums_(zero(p.slots * sizeof(GridSum))),
          taken_(zero((p.slots + 1) * sizeof(std::uint32_t))),
          cells_(zero(64 * sizeof(GridCell))) {}

    void deposit(const std::vector<Deposit>& deposits) {
        const Buffer in = device().upload(deposits);
        const auto count = static_cast<std::uint32_t>(deposits.size());
        Kernel kernel = device().kernel("grid_test.cl", "test_grid_deposit", defines_);
        kernel.arg(sums_).arg(parameters_).arg(taken_).arg(overflow_).arg(in).arg(count).run((count + 15) / 16, 16);
    }
    void merge() {
        std::uint32_t first = merged_;
        for (std::uint32_t level = 0; level + 1 < IR_GRID_LEVELS; ++level) {
            const std::uint32_t end = taken();
            merge_kernel("merge_grid_level")
                .arg(sums_)
                .arg(parameters_)
                .arg(taken_)
                .arg(overflow_)
                .arg(answers_)
                .arg(first)
                .arg(end - first)
                .run((end - first) / 16 + 1, 16);
            merged_ = first = end;
        }
    }
    /// Cells that may answer, at most.
    std::uint32_t answers() {
        std::uint32_t n = 0;
        device().read(answers_, &n, sizeof n);
        n += taken() - merged_;
        return n;
    }
    void means(std::uint32_t slots) {
        cells_ = zero(slots * sizeof(GridCell));
        merge_kernel("grid_means")
            .arg(sums_)
            .arg(cells_)
            .arg(parameters_)
            .arg(taken_)
            .arg(overflow_)
            .arg(slots)
            .arg(taken())
            .run(taken() / 16 + 1, 16);
        cell_slots_ = slots;
    }
    [[nodiscard]] std::uint32_t taken() const {
        std::uint32_t n = 0;
        device().read(taken_, &n, sizeof n);
        return n;
    }
    [[nodiscard]] std::vector<std::uint32_t> taken_slots() const {
        std::vector<std::uint32_t> slots(taken() + 1);
        device().read(taken_, slots.data(), slots.size() * sizeof slots[0]);
        slots.erase(slots.begin());
        return slots;
    }
    [[nodiscard]] std::vector<std::uint32_t> used_slots() const {
        std::vector<GridSum> all(parameters_.slots);
        device().read(sums_, all.data(), all.size() * sizeof(GridSum));
        std::vector<std::uint32_t> slots;
        for (std::uint32_t i = 0; i < all.size(); ++i)
            if (all[i].key != 0) slots.push_back(i);
        return slots;
    }
    [[nodiscard]] bool full() const {
        std::uint32_t flag = 0;
        device().read(overflow_, &flag, sizeof flag);
        return flag != 0;
    }
    [[nodiscard]] std::map<std::uint32_t, GridSum> sums() const {  // by key; no key twice
        std::vector<GridSum> all(parameters_.slots);
        device().read(sums_, all.data(), all.size() * sizeof(GridSum));
        std::map<std::uint32_t, GridSum> by_key;
        for (const GridSum& s : all)
            if (s.key != 0 && !by_key.emplace(s.key, s).second) ADD_FAILURE() << "key " << s.key << " twice";
        return by_key;
    }
    [[nodiscard]] std::vector<Answer> look_up(const std::vector<Question>& questions, std::uint32_t seed) const {
        const Buffer in = device().upload(questions);
        std::vector<std::array<float, 4>> out(questions.size());
        Buffer to = device().upload(out);
        GridParameters p = parameters_;
        p.slots = cell_slots_;
        const auto count = static_cast<std::uint32_t>(questions.size());
        Kernel kernel = device().kernel("grid_test.cl", "test_grid_lookup", {});
        kernel.arg(cells_).arg(p).arg(in).arg(to).arg(count).arg(seed).run((count + 15) / 16, 16);
        device().read(to, out.data(), out.size() * sizeof out[0]);
        std::vector<Answer> answers;
        for (const auto& o : out) answers.push_back({o[0] != 0, {o[1], o[2], o[3]}});
        return answers;
    }

private:
    static Buffer zero(std::size_t bytes) {
        Buffer b = device().allocate(bytes);
        device().fill(b, 0, bytes);
        return b;
    }
    [[nodiscard]] Kernel merge_kernel(const std::string& name) const {
        return device().kernel("merge_grid.cl", name, defines_);
    }
    GridParameters parameters_;
    std::map<std::string, std::string> defines_;
    Buffer sums_, taken_, cells_, overflow_ = zero(sizeof(std::uint32_t)), answers_ = zero(sizeof(std::uint32_t));
    std::uint32_t cell_slots_ = 64, merged_ = 0;  // merged_: cells whose levels are merged
};

std::vector<std::array<std::uint32_t, 8>> keys_of(const std::vector<std::array<V, 2>>& points,
                                                  const GridParameters& p) {
    const Buffer in = device().upload(points);
    std::vector<std::array<std::uint32_t, 8>> keys(points.size());
    Buffer to = device().upload(keys);
    const auto count = static_cast<std::uint32_t>(points.size());
    Kernel kernel = device().kernel("grid_test.cl", "test_grid_keys", {});
    kernel.arg(to).arg(p).arg(in).arg(count).run((count + 15) / 16, 16);
    device().read(to, keys.data(), keys.size() * sizeof keys[0]);
    return keys;
}

// ---- sums ----------------------------------------------------------------------------------------------------------

std::uint64_t wide(const std::uint32_t (&words)[2]) { return (static_cast<std::uint64_t>(words[1]) << 32) | words[0]; }

/// What a deposit adds: the nearest number of units (a power of two: the division is exact), at most 4.6e18.
std::uint64_t units(float irradiance) {
    const float u = irradiance * 0x1p20f;
    return static_cast<std::uint64_t>(std::floor(std::min(u + 0.5f, 4.6e18f)));
}

// The grid's own key of a cell's middle, by its definition: coordinates from 1 in 9 bits each, axis (+z: 4), level 0.
std::uint32_t key_of(int x, int y, int z) {
    return static_cast<std::uint32_t>(x + 1) | static_cast<std::uint32_t>(y + 1) << 9 |
           static_cast<std::uint32_t>(z + 1) << 18 | 4u << 27;
}
V middle(int x, int y, int z) {
    return {static_cast<float>(x) + 0.5f, static_cast<float>(y) + 0.5f, static_cast<float>(z) + 0.5f};
}

// Numbers of very different size, in cells of their own and all in one, in any order: to the last unit the sum of the
// rounded numbers, which is the sum of the numbers to half a unit, and to float32 (2^-23), each.
TEST(DeviceGrid, SumsAreExactInAnyOrder) {
    std::mt19937 random(3);
    std::uniform_real_distribution<double> exponent(-12, 12);
    std::vector<Deposit> deposits;
    const auto add = [&](int x, double lo, double hi) {
        V e{};
        for (float& c : e) c = static_cast<float>(std::pow(10, std::clamp(exponent(random), lo, hi)));
        deposits.push_back({middle(x, x % 7, x % 3), kUp, e});
    };
    for (int i = 0; i < 30000; ++i) add(0, -12, 7);            // one cell
    for (int i = 0; i < 8000; ++i) add(1 + i % 500, -12, 12);  // 16 in each of 500
    for (int i = 0; i < 3000; ++i) deposits.push_back({middle(501, 0, 0), kUp, {2861.0229f, 4095.9998f, 4096}});
    for (int order = 0; order < 3; ++order) {
        std::map<std::uint32_t, std::array<std::uint64_t, 4>> expected;
        std::map<std::uint32_t, std::array<double, 2>> real;  // sum, error allowed
        for (const Deposit& d : deposits) {
            const std::uint32_t key =
                key_of(static_cast<int>(d.p[0]), static_cast<int>(d.p[1]), static_cast<int>(d.p[2]));
            auto& e = expected[key];
            for (std::size_t c = 0; c < 3; ++c) e[c] += units(d.irradiance[c]);
            ++e[3];
            real[key][0] += static_cast<double>(d.irradiance[0]);
            real[key][1] += 0x1p-21 + 0x1p-23 * static_cast<double>(d.irradiance[0]);
        }
        Table table(parameters(4096));
        table.deposit(deposits);
        EXPECT_FALSE(table.full());
        const auto sums = table.sums();
        ASSERT_EQ(sums.size(), expected.size());
        for (const auto& [key, e] : expected) {
            ASSERT_EQ(sums.count(key), 1u);
            const GridSum& s = sums.at(key);
            EXPECT_EQ(wide(s.r), e[0]);
            EXPECT_EQ(wide(s.g), e[1]);
            EXPECT_EQ(wide(s.b), e[2]);
            EXPECT_EQ(s.samples, e[3]);
            EXPECT_NEAR(static_cast<double>(wide(s.r)) * 0x1p-20, real[key][0], real[key][1]);
        }
        EXPECT_GT(expected[key_of(501, 0, 0)][2] >> 32, 0u) << "no carry was needed";
        std::shuffle(deposits.begin(), deposits.end(), random);
    }
}

// Every slot that is in use is listed, once, those that a group has no room left to collect too.
TEST(DeviceGrid, SlotsInUseAreListedOnce) {
    std::vector<Deposit> deposits;
    for (int i = 0; i < 3000; ++i) deposits.push_back({middle(i % 37, i % 11, i % 5), kUp, {1, 1, 1}});
    for (const char* const room : {"1u", "4u", "512u"}) {
        Table table(parameters(8192), {{"IR_GRID_FRESH", room}});
        table.deposit(deposits);
        const std::uint32_t finest = table.taken();
        EXPECT_EQ(finest, 37u * 11 * 5) << room;
        table.merge();
        EXPECT_GT(table.taken(), finest);
        std::vector<std::uint32_t> slots = table.taken_slots();
        std::sort(slots.begin(), slots.end());
        EXPECT_EQ(slots, table.used_slots()) << room;
    }
}

// Of the levels that are merged those with enough estimates, of the last one all: as many slots as means may need.
TEST(DeviceGrid, CellsThatMayAnswerAreCounted) {
    std::mt19937 random(11);
    std::uniform_int_distribution<int> place(0, 40);
    std::vector<Deposit> deposits;
    for (int i = 0; i < 9000; ++i) {
        const int x = std::min(place(random), place(random));
        deposits.push_back({middle(x, place(random) / 14, place(random) / 21), kUp, {1, 1, 1}});
    }
    Table table(parameters(16384));
    table.deposit(deposits);
    table.merge();
    std::map<std::uint32_t, std::uint32_t> enough, cells;  // by level
    for (const auto& [key, sum] : table.sums()) {
        ++cells[key >> 30];
        if (sum.samples >= parameters(64).least) ++enough[key >> 30];
    }
    for (std::uint32_t level = 0; level + 1 < IR_GRID_LEVELS; ++level) {
        EXPECT_GT(enough[level], 5u) << level;
        EXPECT_LT(enough[level], cells[level]) << level;
    }
    EXPECT_EQ(table.answers(), enough[0] + enough[1] + enough[2] + cells[3]);
}

// What no sum can hold counts as 2^62 units and does not wrap; nothing and almost nothing count as nothing.
TEST(DeviceGrid, ExtremeDeposits) {
    Table table(parameters(64));
    table.deposit({{middle(3, 3, 3), kUp, {3e38f, 0, 4.7e-7f}}, {middle(3, 3, 3), kUp, {0, 1e-30f, 4.8e-7f}}});
    const GridSum s = table.sums().at(key_of(3, 3, 3));
    EXPECT_EQ(wide(s.r), units(3e38f));
    EXPECT_EQ(wide(s.g), 0u);
    EXPECT_EQ(wide(s.b), 1u);  // a unit is 9.54e-7: one below its half, one above
    EXPECT_EQ(s.samples, 2u);
}

TEST(DeviceGrid, KeysNameTheCellThatHoldsThePoint) {
    GridParameters p = parameters(64);
    p.origin_x = -3.7f, p.origin_y = 12.5f, p.origin_z = -0.01f;
    p.cell = 0.013f;
    std::mt19937 random(5);
    std::uniform_real_distribution<float> uniform(0, 1);
    std::normal_distribution<float> normal;
    std::vector<std::array<V, 2>> points;
    const float origin[3] = {p.origin_x, p.origin_y, p.origin_z};
    for (int i = 0; i < 3000; ++i) {
        V q{}, n{normal(random), normal(random), normal(random)};
        for (std::size_t c = 0; c < 3; ++c) q[c] = origin[c] + 508 * p.cell * uniform(random);
        if (i % 4 == 0) n = {i % 8 ? 1.0f : -1.0f, 0, 0};
        points.push_back({q, n});
    }
    const auto keys = keys_of(points, p);
    for (std::size_t i = 0; i < points.size(); ++i) {
        const auto& [q, n] = points[i];
        std::size_t axis = 0;
        for (std::size_t c = 1; c < 3; ++c)
            if (std::abs(n[c]) > std::abs(n[axis])) axis = c;
        for (std::uint32_t level = 0; level < IR_GRID_LEVELS; ++level) {
            const std::uint32_t key = keys[i][level];
            EXPECT_EQ(key >> 30, level);
            EXPECT_EQ((key >> 27) & 7, 2 * axis + (n[axis] < 0 ? 1 : 0));
            EXPECT_EQ(keys[i][IR_GRID_LEVELS + level], key) << "the parent's parent is another cell";
            for (std::size_t c = 0; c < 3; ++c) {
                const double edge = static_cast<double>(p.cell) * (1u << level), cell = ((key >> (9 * c)) & 511) - 1.0;
                const double at = (static_cast<double>(q[c]) - static_cast<double>(origin[c])) / edge;
                EXPECT_GE(at, cell - 508 * 4 * kEps) << "level " << level;
                EXPECT_LE(at, cell + 1 + 508 * 4 * kEps) << "level " << level;
            }
        }
    }
}

// Places outside of the grid (it covers the scene; rounding) go to the outermost cells: no field spills into the next.
TEST(DeviceGrid, KeysOutsideAreTheOutermost) {
    const V out{1000, -5, 509.5f};
    EXPECT_EQ(keys_of({{out, kUp}}, parameters(64))[0][0], key_of(509, 0, 509));
    EXPECT_EQ(keys_of({{V{-1e30f, 1e30f, 0}, kUp}}, parameters(64))[0][0], key_of(0, 509, 0));
}

std::vector<Deposit> one_in_each(int cells) {
    std::vector<Deposit> deposits;
    for (int i = 0; i < cells; ++i)
        deposits.push_back({middle(i % 50, i / 50, 2), kUp, {1.0f + static_cast<float>(i), 0, 0}});
    return deposits;
}

// 64 slots, 64 probes: 64 keys fit, however they collide; one more does not, and is reported. A larger table holds all.
TEST(DeviceGrid, ATableThatIsFullSaysSo) {
    Table fits(parameters(64)), full(parameters(64));
    fits.deposit(one_in_each(64));
    EXPECT_FALSE(fits.full());
    EXPECT_EQ(fits.sums().size(), 64u);
    full.deposit(one_in_each(65));
    EXPECT_TRUE(full.full());
    fits.merge();
    EXPECT_TRUE(fits.full()) << "no slot was left for coarser levels";
    for (std::uint32_t slots = 128;; slots *= 2) {
        ASSERT_LE(slots, 1u << 14);
        Table table(parameters(slots));
        table.deposit(one_in_each(1000));
        table.merge();
        if (table.full()) continue;
        EXPECT_GE(slots, 1024u);
        const auto sums = table.sums();
        for (int i = 0; i < 1000; ++i)
            EXPECT_EQ(wide(sums.at(key_of(i % 50, i / 50, 2)).r), (1u + static_cast<unsigned>(i)) << 20);
        std::uint64_t by_level[IR_GRID_LEVELS] = {}, samples[IR_GRID_LEVELS] = {};
        for (const auto& [key, s] : sums) {
            by_level[key >> 30] += wide(s.r);
            samples[key >> 30] += s.samples;
        }
        for (std::size_t level = 0; level < IR_GRID_LEVELS; ++level) {
            EXPECT_EQ(by_level[level], 500500ull << 20) << "level " << level;  // 1 + ... + 1000
            EXPECT_EQ(samples[level], 1000u) << "level " << level;
        }
        break;
    }
}

TEST(DeviceGrid, MeansThatDoNotFitSaySo) {
    std::vector<Deposit> deposits;
    for (int k = 0; k < 16; ++k)
        for (const Deposit& d : one_in_each(100)) deposits.push_back(d);
    Table table(parameters(1024));
    table.deposit(deposits);
    EXPECT_EQ(table.answers(), 100u);
    table.means(256);
    EXPECT_FALSE(table.full());
    table.means(64);
    EXPECT_TRUE(table.full());
}

// ---- answers -------------------------------------------------------------------------------------------------------

TEST(DeviceGrid, AnEmptyTableAnswersNothing) {
    Table table(parameters(64));
    table.merge();
    EXPECT_EQ(table.answers(), 0u);
    table.means(64);
    EXPECT_FALSE(table.full());
    keys_of({{V{1, 2, 3}, kUp}}, parameters(64));
    for (const Answer& a : table.look_up({{{1, 2, 3}, kUp, 100}, {{9, 8, 7}, {0, -1, 0}, 1e30f}}, 1))
        EXPECT_FALSE(a.found);
}

// Four regions of 32x32 cells in a plane, so sparsely filled that their 16 samples are together in cells of 1, 2, 4, 8;
// a fifth never has them. What was left in a cell depends on its x, so that the mean tells which level and cell
// answered: 1 + bit 0 of x + 10 bit 1 + 100 bit 2.
class Regions : public ::testing::Test {
protected:
    static float value(int x) { return static_cast<float>(1 + (x & 1) + 10 * (x >> 1 & 1) + 100 * (x >> 2 & 1)); }

    static Table filled() {
        std::vector<Deposit> deposits;
        const auto times = [](int x, int y) {
            if (x < 96) return x < 32 ? 16 : x < 64 ? 4 : 1;
            if (x < 128) return x % 2 == 0 && y % 2 == 0 ? 1 : 0;
            return x % 8 < 5 && y % 8 < 3 ? 1 : 0;  // 15 in every cell of 8
        };
        for (int y = 0; y < 32; ++y)
            for (int x = 0; x < 160; ++x)
                for (int i = 0; i < times(x, y); ++i)
                    deposits.push_back({middle(x, y, 0), kUp, {value(x), 2 * value(x), 3 * value(x)}});
        Table table(parameters(1u << 14));
        table.deposit(deposits);
        table.merge();
        table.means(1u << 13);
        EXPECT_FALSE(table.full());
        return table;
    }
    // The mean that a cell of a level in its region answers; in the last one samples lie at even x: 1 + 5 + 50.
    static float mean(int level, int cell) {
        return level == 0   ? value(cell)
               : level == 1 ? value(2 * cell) + 0.5f
               : level == 2 ? value(4 * cell) + 5.5f
                            : 56;
    }
};

TEST_F(Regions, TheFinestLevelWithEnoughSamplesAnswers) {
    const Table table = filled();
    std::mt19937 random(7);
    std::uniform_real_distribution<float> uniform(8, 24);  // no look-up leaves its region
    for (int level = 0; level < 4; ++level) {
        std::vector<Question> questions;
        for (int i = 0; i < 4000; ++i)
            questions.push_back({{uniform(random) + 32 * static_cast<float>(level), uniform(random), 0.4f}, kUp, 100});
        int elsewhere = 0;
        const std::vector<Answer> answers = table.look_up(questions, 5);
        for (std::size_t i = 0; i < questions.size(); ++i) {
            ASSERT_TRUE(answers[i].found) << "level " << level;
            const double at = static_cast<double>(questions[i].p[0]) / (1 << level);
            const float own = mean(level, static_cast<int>(at)), before = mean(level, static_cast<int>(at - 0.5)),
                        behind = mean(level, static_cast<int>(at + 0.5));
            const V& e = answers[i].irradiance;
            // Sums are exact, their mean is three float32 operations.
            const auto is = [&](float m) { return std::abs(e[0] - m) <= 4e-7f * m; };
            EXPECT_TRUE(is(own) || is(before) || is(behind)) << "level " << level << ": " << e[0] << " at " << at;
            elsewhere += !is(own);
            EXPECT_NEAR(e[1], 2 * e[0], 4e-7f * e[1]);
            EXPECT_NEAR(e[2], 3 * e[0], 4e-7f * e[2]);
        }
        // Spread evenly over a cell's width, a quarter of look-ups end in a neighbour in x: 5 standard deviations.
        const double quarter = level < 3 ? 0.25 : 0;  // all cells of the last level answer the same
        EXPECT_NEAR(elsewhere / 4000.0, quarter, 5 * std::sqrt(quarter * 0.75 / 4000)) << "level " << level;
    }
}

TEST_F(Regions, TooFewSamplesDoNotAnswer) {
    for (const Answer& a : filled().look_up({{{140, 10, 0.5f}, kUp, 100}, {{143.9f, 20, 0.5f}, kUp, 100}}, 1))
        EXPECT_FALSE(a.found);
}

// Only rays longer than 2 of the cells that would answer are answered.
TEST_F(Regions, ShortRaysAreRefused) {
    const Table table = filled();
    for (int level = 0; level < 4; ++level)
        for (int power = 0; power < 4; ++power)
            for (const float side : {0.99f, 1.01f}) {
                const float distance = 2 * static_cast<float>(1 << power) * side;
                const bool expected = side > 1 ? power >= level : power > level;
                for (const Answer& a :
                     table.look_up({{{16 + 32 * static_cast<float>(level), 16, 0.5f}, kUp, distance}}, 1))
                    EXPECT_EQ(a.found, expected) << "level " << level << " distance " << distance;
            }
}

// The other side of a surface has cells of its own; so has another height.
TEST_F(Regions, OtherFacesDoNotAnswer) {
    for (const Answer& a : filled().look_up(
             {{{16, 16, 0.5f}, {0, 0, -1}, 100}, {{16, 16, 0.5f}, {0.8f, 0, 0.6f}, 100}, {{16, 16, 8.5f}, kUp, 100}},
             1))
        EXPECT_FALSE(a.found);
}

}  // namespace
}  // namespace irradia::test
