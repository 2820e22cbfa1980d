// The octree answers what a search over all records answers, always; it grows without losing anything; the order in
// which work-items insert does not show.
#include "cache/RecordCache.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <random>

namespace irradia {
namespace {

struct Record {
    shared::RecordKey key{};
    shared::RecordValue value{};
};

// Random records on the walls, floor and inside of a box of edge `size`, supports over three orders of magnitude.
std::vector<Record> random_records(std::size_t count, float size, unsigned seed, float largest = 0.3f) {
    std::mt19937 random(seed);
    std::uniform_real_distribution<float> u(0, 1);
    std::vector<Record> records(count);
    for (Record& r : records) {
        float p[3] = {u(random) * size, u(random) * size, u(random) * size}, n[3] = {0, 0, 0};
        const int axis = static_cast<int>(u(random) * 3) % 3;
        p[axis] = u(random) < 0.5f ? 0.0f : size;
        n[axis] = p[axis] > 0 ? -1.0f : 1.0f;
        float t[3] = {0, 0, 0};
        t[(axis + 1) % 3] = 1;
        r.key.px = p[0], r.key.py = p[1], r.key.pz = p[2];
        r.key.nx = n[0], r.key.ny = n[1], r.key.nz = n[2];
        r.key.t2x = t[0], r.key.t2y = t[1], r.key.t2z = t[2];
        r.key.support1 = size * largest * std::pow(0.001f, u(random));
        r.key.support2 = r.key.support1 * (1 + 2 * u(random));
        for (float& e : r.value.e) e = 1 + u(random);
        for (float& g : r.value.translation) g = (u(random) - 0.5f) / r.key.support2;
        for (float& g : r.value.rotation) g = u(random) - 0.5f;
    }
    return records;
}

class Cache {
public:
    /// Records in a cube of edge `size`, whose lower corner lies at `corner` along each axis.
    Cache(const std::vector<Record>& records, float size, std::size_t batch, float corner = 0,
          const DeviceOptions& options = {})
        : device_(options), cache_(device_, settings(size, corner)) {
        for (std::size_t first = 0; first < records.size(); first += batch) {
            const std::size_t n = std::min(batch, records.size() - first);
            const std::uint32_t at = cache_.reserve(n);
            std::vector<shared::RecordKey> keys;
            std::vector<shared::RecordValue> values;
            for (std::size_t i = 0; i < n; ++i) {
                keys.push_back(records[first + i].key);
                values.push_back(records[first + i].value);
            }
            device_.write(const_cast<Buffer&>(cache_.keys()), keys.data(), n * sizeof keys[0], at * sizeof keys[0]);
            device_.write(const_cast<Buffer&>(cache_.values()), values.data(), n * sizeof values[0],
                          at * sizeof values[0]);
            cache_.insert(n, cache_.keys(), cache_.keys());  // no neighbour clamp: points and stack are not read
        }
    }

    // Four floats a point (sums of w E, sum of w) for points of six floats (position, normal).
    std::vector<float> look_up(const std::vector<float>& points, bool brute_force) {
        const std::size_t count = points.size() / 6;
        std::vector<float> out(4 * count);
        const Buffer in = device_.upload(points);
        const Buffer to = device_.upload(out);
        Kernel kernel = device_.kernel("cache_test.cl", "look_up", cache_.defines());
        cache_.bind(kernel, false)
            .arg(in)
            .arg(to)
            .arg(static_cast<std::uint32_t>(cache_.size()))
            .arg(std::uint32_t{brute_force})
            .arg(static_cast<std::uint32_t>(count))
            .run((count + 15) / 16, 16);
        device_.read(to, out.data(), out.size() * sizeof(float));
        return out;
    }
    [[nodiscard]] const RecordCache& cache() const { return cache_; }
    void settle() { cache_.settle(); }
    void rescale(float factor, float size, float inverse_angle) {
        CacheSettings s = settings(size);
        s.inverse_angle = inverse_angle;
        cache_.rescale(factor, s);
    }

private:
    static CacheSettings settings(float size, float corner = 0) {
        CacheSettings s;
        s.lower = {corner, corner, corner};
        s.upper = {corner + size, corner + size, corner + size};
        s.clamp_slope = 0;
        return s;
    }
    Device device_;
    RecordCache cache_;
};

std::vector<float> points_near(const std::vector<Record>& records, std::size_t count, float size, unsigned seed) {
    std::mt19937 random(seed);
    std::uniform_real_distribution<float> u(0, 1);
    std::vector<float> points;
    for (std::size_t i = 0; i < count; ++i) {
        const shared::RecordKey& k = records[random() % records.size()].key;
        // On the record's plane (where most questions are), sometimes off it, sometimes exactly at the record.
        const float reach = i % 7 == 0 ? 0.0f : 1.2f * k.support2,
                    off = i % 5 == 0 ? 0.5f * k.support1 * u(random) : 0.0f;
        const auto place = [&](float p, float n) {
            return std::clamp(p + (n == 0.0f ? reach * (2 * u(random) - 1) : n * off), 0.0f, size);
        };
        points.insert(points.end(), {place(k.px, k.nx), place(k.py, k.ny), place(k.pz, k.nz), k.nx, k.ny, k.nz});
    }
    return points;
}

void expect_same(const std::vector<float>& tree, const std::vector<float>& all) {
    ASSERT_EQ(tree.size(), all.size());
    std::size_t covered = 0;
    for (std::size_t i = 0; i < tree.size(); ++i) {
        // The same terms in another order: float32 sums of up to a few hundred positive numbers.
        EXPECT_NEAR(tree[i], all[i], 2e-5f * std::abs(all[i])) << "point " << i / 4 << " component " << i % 4;
        covered += i % 4 == 3 && all[i] > 0;
    }
    EXPECT_GT(covered, tree.size() / 16);  // the question was not void
}

TEST(RecordCache, AnswersWhatASearchOverAllRecordsAnswers) {
    for (const float size : {1e-4f, 1.0f, 1e6f}) {
        const auto records = random_records(3000, size, 1);
        Cache cache(records, size, 500);
        const auto points = points_near(records, 4000, size, 2);
        expect_same(cache.look_up(points, false), cache.look_up(points, true));
    }
}

// Far from the origin what rounding may do to a coordinate is more than a small support: it touches hundreds of cells.
TEST(RecordCache, FarFromTheOrigin) {
    constexpr float corner = 1000;
    auto records = random_records(200, 1.0f, 11);
    for (Record& r : records) {
        r.key.support1 = 2.5e-4f + 8e-4f * r.key.support1;  // rounding: up to 1e-3
        r.key.support2 = 1.5f * r.key.support1;
    }
    auto points = points_near(records, 4000, 1.0f, 12);
    for (Record& r : records) r.key.px += corner, r.key.py += corner, r.key.pz += corner;
    for (std::size_t i = 0; i < points.size(); ++i)
        if (i % 6 < 3) points[i] += corner;
    Cache cache(records, 1.0f, 64, corner);
    EXPECT_GT(cache.cache().octree().entries, 64 * records.size());
    expect_same(cache.look_up(points, false), cache.look_up(points, true));
}

// 60 000 records: ten times the first capacities of records, nodes and entries.
TEST(RecordCache, GrowsAndLosesNothing) {
    const auto records = random_records(60000, 1, 3, 0.03f);
    Cache cache(records, 1, 30000);
    EXPECT_EQ(cache.cache().size(), records.size());
    EXPECT_GT(cache.cache().octree().growths, 2u);
    const auto points = points_near(records, 500, 1, 4);
    expect_same(cache.look_up(points, false), cache.look_up(points, true));
    const auto keys = cache.cache().download_keys();
    for (std::size_t i = 0; i < records.size(); i += 997) EXPECT_EQ(keys[i].px, records[i].key.px);
}

// All records in one place: one list of a thousand entries.
TEST(RecordCache, HoldsIdenticalRecords) {
    auto records = random_records(1000, 1, 5);
    for (Record& r : records) r = records[0];
    Cache cache(records, 1, 1000);
    const shared::RecordKey& k = records[0].key;
    const std::vector<float> point{k.px, k.py, k.pz, k.nx, k.ny, k.nz};
    const auto out = cache.look_up(point, false);
    // e = 0 for all: equal capped weights (theory 4.8), 99 each in the form of theory 4.1 normalised by a.
    // A float32 sum of n terms is good to n 2^-24: 6e-5 here, in numerator and denominator.
    for (int c = 0; c < 3; ++c) EXPECT_NEAR(out[c] / out[3], records[0].value.e[c], 1.2e-4f * records[0].value.e[c]);
    EXPECT_NEAR(out[3], 1000 * 100.0f, 6e-5f * 1e5f);
}

// In one batch or many: lists end up in the same order, so sums are the same bits.
TEST(RecordCache, OrderOfInsertionDoesNotShow) {
    const auto records = random_records(2000, 1, 6);
    const auto points = points_near(records, 2000, 1, 7);
    Cache one(records, 1, 2000), many(records, 1, 37);
    EXPECT_EQ(one.look_up(points, false), many.look_up(points, false));
}

// On GPUs many work-items enter a record, each into some of its cells: into the same ones as one does. 3000 records at
// once use more nodes than there is room for at first, so that some are entered again.
TEST(RecordCache, ManyWorkItemsEnterARecordAsOneDoes) {
    const auto records = random_records(3000, 1, 19, 0.1f);
    const auto points = points_near(records, 1000, 1, 20);
    DeviceOptions gpu;
    gpu.traversal = "gpu";
    Cache one(records, 1, 3000), many(records, 1, 3000, 0, gpu);
    EXPECT_GT(many.cache().octree().growths, 0u);
    EXPECT_EQ(many.cache().octree().nodes, one.cache().octree().nodes);
    EXPECT_EQ(many.cache().octree().entries, one.cache().octree().entries);
    expect_same(many.look_up(points, false), many.look_up(points, true));
    expect_same(many.look_up(points, false), one.look_up(points, false));
}

// Packed records are asked by bounds on the safe side, in eights on CPU devices; those in lists one by one: the same
// records answer, in the same order, and the sums are the same bits. 400 records use more nodes than there is room for
// at first.
TEST(RecordCache, PackingDoesNotShow) {
    for (const float size : {1e-4f, 1e6f}) {
        const auto records = random_records(400, size, 10, 0.1f);
        const auto points = points_near(records, 60, size, 11);
        Cache cache(records, size, 150);
        EXPECT_GT(cache.cache().octree().growths, 0u);
        const std::vector<float> listed = cache.look_up(points, false);
        cache.settle();
        EXPECT_EQ(cache.look_up(points, false), listed);
        expect_same(listed, cache.look_up(points, true));
    }
}

// Of many records: packed as they come, whenever lists hold as many as is packed.
TEST(RecordCache, ManyRecordsArePackedAsTheyCome) {
    const auto records = random_records(30000, 1, 12, 0.05f);
    const auto points = points_near(records, 500, 1, 13);
    Cache one(records, 1, 30000), many(records, 1, 1000);
    const std::vector<float> some = one.look_up(points, false);
    EXPECT_EQ(many.look_up(points, false), some);
    one.settle();
    EXPECT_EQ(one.look_up(points, false), some);
    expect_same(some, one.look_up(points, true));
}

TEST(RecordCache, AnEmptyCacheCoversNothing) {
    const auto records = random_records(1, 1, 8);
    Cache cache({}, 1, 1);
    for (const float x : cache.look_up(points_near(records, 16, 1, 9), false)) EXPECT_EQ(x, 0.0f);
}

// Records with their supports scaled are those that would have been entered with such supports.
TEST(RecordCache, RescaledRecordsAreThoseOfTheOtherSize) {
    constexpr float size = 4, factor = .375f;
    const std::vector<Record> records = random_records(3000, size, 17);
    std::vector<Record> small = records;
    for (Record& r : small) r.key.support1 *= factor, r.key.support2 *= factor;
    Cache rescaled(records, size, 500), other(small, size, 500);
    const std::vector<float> points = points_near(small, 4000, size, 18);
    EXPECT_NE(rescaled.look_up(points, false), other.look_up(points, false));
    rescaled.rescale(factor, size, 5);
    EXPECT_EQ(rescaled.look_up(points, false), other.look_up(points, false));
    EXPECT_EQ(rescaled.cache().octree().entries, other.cache().octree().entries);
}

// Neighbours limit each other's supports (theory 4.4): new records by those there before, then these by the new ones,
// the same in double precision by all pairs. On one plane, with supports so alike that none is limited by a record that
// does not reach it: so the octree knows of every pair that counts. Beside a cluster of old records a new one limits
// more of them than it keeps a list of.
TEST(RecordCache, NeighboursLimitEachOther) {
    constexpr float slope = 1.75f, min_spacing = 1.5f, support = 0.1f;
    constexpr std::size_t old_count = 800, new_count = 300;
    std::mt19937 random(21);
    std::uniform_real_distribution<float> u(0, 1);
    std::vector<shared::RecordKey> keys(old_count + new_count);
    std::vector<shared::ShadingPoint> points(new_count);
    for (std::size_t i = 0; i < keys.size(); ++i) {
        shared::RecordKey& k = keys[i];
        const bool is_new = i >= old_count, lone = i == old_count || i == old_count + 1;
        // Half of the old ones crowd around two places; there is one new record at each, the others stay away.
        const bool crowded = !is_new && i % 4 < 2;
        const float x = i % 2 == 0 ? 0.25f : 0.75f, y = 0.2f, edge = 0.05f;
        k.px = lone ? x : crowded ? x + edge * (u(random) - 0.5f) : u(random);
        k.py = lone ? y : crowded ? y + edge * (u(random) - 0.5f) : is_new ? 0.4f + 0.6f * u(random) : u(random);
        k.pz = 0.25f, k.nz = i % 10 == 5 ? -1.0f : 1.0f, k.t2x = 1;
        k.support1 = i < old_count ? support * (0.5f + 0.5f * u(random)) : support * (0.7f + 0.5f * u(random));
        if (lone) k.support1 = support * (i == old_count ? 0.1f : 1.2f);
        k.support2 = k.support1 * (1 + 0.1f * u(random));
    }
    std::vector<std::uint32_t> stack(new_count);
    for (std::size_t i = 0; i < new_count; ++i) {
        stack[i] = static_cast<std::uint32_t>(new_count - 1 - i);
        points[stack[i]].footprint = i % 3 == 0 ? 0.05f : 0.001f;
        points[stack[i]].least = i % 4 == 0 ? 0.001f : 0.0f;
    }

    std::size_t most = 0, limited = 0, limited_old = 0;
    const auto limit = [](double s, double other, double reach) { return std::min(s, other + reach); };
    const auto distance = [&](std::size_t i, std::size_t j) {
        return std::hypot(double{keys[i].px} - keys[j].px, double{keys[i].py} - keys[j].py);
    };
    std::vector<std::array<double, 2>> s(keys.size());
    for (std::size_t i = 0; i < keys.size(); ++i) s[i] = {keys[i].support1, keys[i].support2};
    for (std::size_t i = old_count; i < keys.size(); ++i) {
        const double least = std::min(s[i][0], double{min_spacing} * points[stack[i - old_count]].footprint);
        const double before = s[i][0];
        for (std::size_t j = 0; j < old_count; ++j)
            if (keys[i].nz == keys[j].nz)
                for (int axis : {0, 1})
                    s[i][axis] =
                        limit(s[i][axis], axis == 0 ? keys[j].support1 : keys[j].support2, slope * distance(i, j));
        s[i][0] = std::max(s[i][0], least);
        s[i][1] = std::max(s[i][1], s[i][0]);
        limited += s[i][0] < before;
    }
    for (std::size_t i = old_count; i < keys.size(); ++i) {
        std::size_t found = 0;
        const double old_slope = points[stack[i - old_count]].least > 0 ? 1.0 : slope;
        for (std::size_t j = 0; j < old_count; ++j) {
            if (keys[i].nz != keys[j].nz) continue;
            found += s[i][0] + old_slope * distance(i, j) < keys[j].support2;
            for (int axis : {0, 1}) s[j][axis] = limit(s[j][axis], s[i][axis], old_slope * distance(i, j));
        }
        most = std::max(most, found);
    }
    for (std::size_t j = 0; j < old_count; ++j) limited_old += s[j][0] < keys[j].support1;
    EXPECT_GE(most, IR_CLAMP_WORDS);  // the questions were not void
    EXPECT_GT(limited, new_count / 10);
    EXPECT_GT(limited_old, old_count / 4);

    Device device({});
    CacheSettings settings;
    settings.lower = {0, 0, 0}, settings.upper = {1, 1, 1};
    settings.clamp_slope = slope, settings.min_spacing = min_spacing;
    RecordCache cache(device, settings);
    const Buffer shading_points = device.upload(points), order = device.upload(stack);
    for (const auto& [first, count] : {std::pair(std::size_t{0}, old_count), {old_count, new_count}}) {
        const std::uint32_t at = cache.reserve(count);
        device.write(const_cast<Buffer&>(cache.keys()), &keys[first], count * sizeof keys[0], at * sizeof keys[0]);
        cache.insert(count, shading_points, order);
    }
    const std::vector<shared::RecordKey> clamped = cache.download_keys();
    for (std::size_t i = 0; i < keys.size(); ++i) {
        EXPECT_NEAR(clamped[i].support1, s[i][0], 1e-6 * s[i][0]) << "record " << i;
        EXPECT_NEAR(clamped[i].support2, s[i][1], 1e-6 * s[i][1]) << "record " << i;
    }
}

}  // namespace
}  // namespace irradia
