// The octree of records by the renderer's kernels: look-ups and insertion for 10^3 to 10^6 records of equal density.
// The records lie on the six walls of a room that grows as the root of their number, so that a look-up meets equally
// many. It stands askew to the octree's axes: along them the walls of a small room would lie in the outermost cells,
// where a record meets half as many cells as the same one elsewhere. Records come in as many iterations whatever their
// number, as those of a picture do: a larger one makes more in each. So a new record finds equally many others, too.
#include <benchmark/benchmark.h>
#include <malloc.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <memory>
#include <random>
#include <tuple>
#include <utility>
#include <vector>

#include "bench.h"
#include "cache/RecordCache.h"
#include "core/spatial_order.h"

namespace irradia::bench {
namespace {

constexpr std::size_t iterations = 16;
constexpr float least_support = 0.8f;  // in units of the mean distance of records; at most 4 times that
constexpr float pixel = 0.5f;          // distance of neighbouring pixels, in the same units
constexpr std::size_t least_points = 1u << 17;
constexpr std::size_t remembered = 100000;                // records, whose branches no core knows any more
constexpr float clamp_slope = 1.75f, min_spacing = 1.5f;  // the renderer's defaults

struct Record {
    shared::RecordKey key{};
    shared::RecordValue value{};
    int wall = 0;
    float row = 0, column = 0;  // of the batch's on its wall
};

using Vector = std::array<float, 3>;

// From the room's axes to the world's: a turn by 25 degrees about z, then by 15 about x.
Vector turned(const Vector& v) {
    constexpr float cz = 0.9063078f, sz = 0.4226183f, cx = 0.9659258f, sx = 0.2588190f;
    const float x = cz * v[0] - sz * v[1], y = sz * v[0] + cz * v[1];
    return {x, cx * y - sx * v[2], sx * y + cx * v[2]};
}

// Point (a, b) of wall 0..5 of a room of edge `size`: position, inward normal, a tangent.
struct WallPoint {
    Vector p, n, t;
};
WallPoint wall_point(int wall, float a, float b, float size) {
    const int axis = wall / 2;
    Vector p{}, n{}, t{};
    p[axis] = wall % 2 ? size : 0.0f;
    n[axis] = wall % 2 ? -1.0f : 1.0f;
    p[(axis + 1) % 3] = a, p[(axis + 2) % 3] = b;
    t[(axis + 1) % 3] = 1;
    return {turned(p), turned(n), turned(t)};
}

std::size_t batch_of(std::size_t records) { return (records + iterations - 1) / iterations; }

float room_size(std::size_t records) { return std::sqrt(static_cast<float>(records) / 6.0f); }

// In the order of a picture: an iteration makes records all over it, row by row, so that those of one neighbourhood
// come from different iterations and lie far apart in memory.
std::vector<Record> make_records(std::size_t count, unsigned seed) {
    std::mt19937 random(seed);
    std::uniform_real_distribution<float> u(0, 1);
    const std::size_t batch = batch_of(count);
    const float size = room_size(count);
    const float row = size * std::sqrt(6.0f / static_cast<float>(batch));
    std::vector<Record> records(count);
    for (Record& r : records) {
        const int wall = std::min(static_cast<int>(6 * u(random)), 5);
        const float a = u(random) * size, b = u(random) * size;
        const auto [p, n, t] = wall_point(wall, a, b, size);
        r.wall = wall, r.row = std::floor(b / row), r.column = a;
        r.key.px = p[0], r.key.py = p[1], r.key.pz = p[2];
        r.key.nx = n[0], r.key.ny = n[1], r.key.nz = n[2];
        r.key.t2x = t[0], r.key.t2y = t[1], r.key.t2z = t[2];
        r.key.support1 = least_support * std::exp2(2 * u(random));
        r.key.support2 = r.key.support1 * (1 + u(random));
        for (float& e : r.value.e) e = 1 + u(random);
        for (float& g : r.value.translation) g = 0.1f * (u(random) - 0.5f);
    }
    const auto place = [](const Record& r) { return std::tuple(r.wall, r.row, r.column); };
    for (std::size_t first = 0; first < count; first += batch)
        std::sort(records.begin() + static_cast<std::ptrdiff_t>(first),
                  records.begin() + static_cast<std::ptrdiff_t>(std::min(first + batch, count)),
                  [&](const Record& a, const Record& b) { return place(a) < place(b); });
    return records;
}

// The places that are looked up: every pixel of every wall, in tiles of 4x4, as the renderer shades them; as many at
// random places; the same put in order first, as the renderer does with points that it is given.
enum class Places { coherent, random, ordered };

// Six floats each.
std::vector<float> make_points(std::size_t records, Places places) {
    const float size = room_size(records);
    std::vector<float> points;
    const auto add = [&](int wall, float a, float b) {
        const auto [p, n, t] = wall_point(wall, a, b, size);
        points.insert(points.end(), {p[0], p[1], p[2], n[0], n[1], n[2]});
    };
    if (places == Places::coherent) {
        const int tiles = static_cast<int>(std::ceil(size / pixel / 4));
        const float step = size / static_cast<float>(4 * tiles);
        while (points.size() < 6 * least_points)
            for (int wall = 0; wall < 6; ++wall)
                for (int row = 0; row < tiles; ++row)
                    for (int column = 0; column < tiles; ++column)
                        for (int i = 0; i < 16; ++i)
                            add(wall, (static_cast<float>(4 * column + i % 4) + 0.5f) * step,
                                (static_cast<float>(4 * row + i / 4) + 0.5f) * step);
    } else {
        std::mt19937 random(2);
        std::uniform_real_distribution<float> u(0, 1);
        for (std::size_t i = 0; i < 2 * least_points; ++i)
            add(std::min(static_cast<int>(6 * u(random)), 5), u(random) * size, u(random) * size);
    }
    return points;
}

// The points along the curve.
std::vector<float> ordered(const std::vector<float>& points) {
    std::vector<Vector> positions(points.size() / 6);
    for (std::size_t i = 0; i < positions.size(); ++i)
        positions[i] = {points[6 * i], points[6 * i + 1], points[6 * i + 2]};
    std::vector<float> along;
    along.reserve(points.size());
    for (const std::uint32_t i : spatial_order(positions))
        along.insert(along.end(), &points[6 * i], &points[6 * i] + 6);
    return along;
}

// Where buffers lie. Pages that a process touches first cost time, and glibc hands out again what small blocks were
// freed of, but gives that of large ones back: left alone, large octrees would pay for new pages and small ones not.
enum class Pages {
    held,  // in what the process has touched before, whatever their size
    fresh  // in what it has not
};

void take_pages(Pages pages) {
    const bool held = pages == Pages::held;
    mallopt(M_MMAP_MAX, held ? 0 : 1 << 16);
    mallopt(M_MMAP_THRESHOLD, 4096);
    mallopt(M_TRIM_THRESHOLD, held ? -1 : 4096);
    if (!held) malloc_trim(0);
}

class Octree {
public:
    Octree(const DeviceOptions& options, std::size_t count, bool clamp, Pages pages = Pages::held)
        : device_(options), batch_(batch_of(count)), clamp_(clamp), pages_(pages) {
        // Others each time, where they are few: a core would know every branch of a small octree from the time before.
        const std::size_t sets = std::max<std::size_t>(1, remembered / count);
        for (unsigned seed = 1; seed <= sets; ++seed) sets_.push_back(make_records(count, seed));
        shared::ShadingPoint point{};
        point.footprint = pixel;
        points_ = device_.upload(&point, sizeof point);
        stack_ = device_.upload(std::vector<std::uint32_t>(batch_, 0));
        fill();  // compiles, and touches what the next one is to have
    }

    // Seconds of inserting all records into an empty cache, with its growth; without writing the records themselves,
    // which sample_hemispheres does.
    double fill() {
        CacheSettings settings;
        settings.lower = settings.upper = turned({0, 0, 0});
        const float size = room_size(sets_.front().size());
        for (int corner = 0; corner < 8; ++corner) {
            const auto at = [&](int axis) { return corner >> axis & 1 ? size : 0.0f; };
            const Vector p = turned({at(0), at(1), at(2)});
            for (int i = 0; i < 3; ++i) {
                settings.lower[i] = std::min(settings.lower[i], p[i]);
                settings.upper[i] = std::max(settings.upper[i], p[i]);
            }
        }
        settings.weight = IR_WEIGHT_CUBIC;
        settings.clamp_slope = clamp_ ? clamp_slope : 0.0f;
        settings.min_spacing = min_spacing;
        const std::vector<Record>& records = sets_[fills_++ % sets_.size()];
        cache_.reset();
        take_pages(pages_);
        cache_ = std::make_unique<RecordCache>(device_, settings);
        double seconds = 0;
        for (std::size_t first = 0; first < records.size(); first += batch_) {
            const std::size_t n = std::min(batch_, records.size() - first);
            DeviceClock growth(device_);
            const std::uint32_t at = cache_->reserve(n);
            seconds += growth.seconds();
            std::vector<shared::RecordKey> keys(n);
            std::vector<shared::RecordValue> values(n);
            for (std::size_t i = 0; i < n; ++i) keys[i] = records[first + i].key, values[i] = records[first + i].value;
            device_.write(const_cast<Buffer&>(cache_->keys()), keys.data(), n * sizeof keys[0], at * sizeof keys[0]);
            device_.write(const_cast<Buffer&>(cache_->values()), values.data(), n * sizeof values[0],
                          at * sizeof values[0]);
            device_.finish();
            DeviceClock insertion(device_);
            cache_->insert(n, points_, stack_);
            seconds += insertion.seconds();
        }
        DeviceClock settling(device_);
        cache_->settle();
        return seconds + settling.seconds();
    }

    double look_up(const Buffer& points, const Buffer& out, std::size_t count) {
        DeviceClock clock(device_);
        Kernel kernel = device_.kernel("cache_test.cl", "look_up", cache_->defines());
        cache_->bind(kernel, false)
            .arg(points)
            .arg(out)
            .arg(static_cast<std::uint32_t>(cache_->size()))
            .arg(std::uint32_t{0})
            .arg(static_cast<std::uint32_t>(count))
            .run((count + 63) / 64, 64);
        return clock.seconds();
    }

    // Records met and used by a look-up, in the mean.
    std::pair<double, double> met(const Buffer& points, std::size_t count) {
        std::vector<std::uint32_t> counts(2 * count);
        const Buffer out = device_.upload(counts);
        Kernel kernel = device_.kernel(IRRADIA_COUNT_MET, "count_met", cache_->defines());
        cache_->bind(kernel, false)
            .arg(points)
            .arg(out)
            .arg(static_cast<std::uint32_t>(count))
            .run((count + 63) / 64, 64);
        device_.read(out, counts.data(), counts.size() * sizeof counts[0]);
        double all = 0, used = 0;
        for (std::size_t i = 0; i < count; ++i) all += counts[2 * i], used += counts[2 * i + 1];
        return {all / static_cast<double>(count), used / static_cast<double>(count)};
    }

    [[nodiscard]] const RecordCache& cache() const { return *cache_; }
    Device& device() { return device_; }

private:
    Device device_;
    std::vector<std::vector<Record>> sets_;
    std::size_t fills_ = 0;
    std::size_t batch_;
    bool clamp_;
    Pages pages_;
    Buffer points_, stack_;
    std::unique_ptr<RecordCache> cache_;
};

Octree& get_octree(const DeviceOptions& options, std::size_t count) {
    static std::map<std::size_t, std::unique_ptr<Octree>> octrees;
    std::unique_ptr<Octree>& o = octrees[count];
    if (!o) o = std::make_unique<Octree>(options, count, false);
    return *o;
}

void report_octree(benchmark::State& state, const RecordCache& cache) {
    const RecordCache::Octree& o = cache.octree();
    state.counters["records"] = static_cast<double>(cache.size());
    state.counters["octree bytes"] = 32.0 * static_cast<double>(o.nodes) + 16.0 * static_cast<double>(o.entries);
    state.counters["entries a record"] = static_cast<double>(o.entries) / static_cast<double>(cache.size());
    state.counters["depth"] = static_cast<double>(o.depth);
}

void look_up(benchmark::State& state, const DeviceOptions& options, std::size_t records, Places places) {
    Octree& octree = get_octree(options, records);
    const std::vector<float> points = make_points(records, places);
    const std::size_t count = points.size() / 6;
    Buffer in = octree.device().upload(points), out = octree.device().allocate(4 * count * sizeof(float));
    octree.look_up(in, out, count);  // compiles
    double best = 1e30;
    for (auto _ : state) {
        double seconds = 0;
        if (places == Places::ordered) {
            const double start = cpu_seconds();
            const std::vector<float> along = ordered(points);
            seconds = cpu_seconds() - start;
            octree.device().write(in, along.data(), along.size() * sizeof along[0]);
        }
        seconds += octree.look_up(in, out, count);
        best = std::min(best, seconds);
        state.SetIterationTime(seconds);
    }
    const auto [met, used] = octree.met(in, count);
    state.counters["ns a look-up"] = 1e9 * best / static_cast<double>(count);
    state.counters["met"] = met;
    state.counters["used"] = used;
    report_octree(state, octree.cache());
}

void insert(benchmark::State& state, const DeviceOptions& options, std::size_t records, bool clamp, Pages pages) {
    Octree octree(options, records, clamp, pages);
    double best = 1e30;
    for (auto _ : state) {
        const double seconds = octree.fill();
        best = std::min(best, seconds);
        state.SetIterationTime(seconds);
    }
    state.counters["ns an insertion"] = 1e9 * best / static_cast<double>(records);
    report_octree(state, octree.cache());
}

}  // namespace

void register_octree(const DeviceOptions& options) {
    const auto add = [](const std::string& name, auto run) {
        benchmark::RegisterBenchmark(name.c_str(), run)->UseManualTime()->Unit(benchmark::kMillisecond);
    };
    std::vector<std::size_t> sizes{1000, 10000, 100000, 1000000};
    for (const auto& [name, places] :
         {std::pair("coherent", Places::coherent), {"random", Places::random}, {"ordered", Places::ordered}})
        for (const std::size_t n : sizes)
            add(std::string("octree/look_up/") + name + "/" + std::to_string(n),
                [=](benchmark::State& s) { look_up(s, options, n, places); });
    sizes.push_back(3000000);  // no cache holds the octree from 10^6 on: a million more cost what the first did?
    for (const auto& [name, clamp, pages] :
         {std::tuple("plain", false, Pages::held), {"clamped", true, Pages::held}, {"fresh", false, Pages::fresh}})
        for (const std::size_t n : sizes)
            add(std::string("octree/insert/") + name + "/" + std::to_string(n),
                [=](benchmark::State& s) { insert(s, options, n, clamp, pages); });
}

}  // namespace irradia::bench
