#include "cache/RecordCache.h"

#include <algorithm>
#include <bit>
#include <cmath>

#include "cache/buffer_state.h"

namespace irradia {
namespace {
constexpr std::size_t first_records = 4096, first_nodes = 4096, first_entries = 32768;
// IR_NODE_STRIDE of cl/octree.h, an entry, IR_PACKED_WORDS of cl/packed.h
constexpr std::size_t node_bytes = 8 * sizeof(std::uint32_t), entry_bytes = 2 * sizeof(std::uint32_t);
constexpr std::size_t packed_bytes = 4 * sizeof(std::uint32_t);
constexpr std::size_t clamp_bytes = IR_CLAMP_WORDS * sizeof(std::uint32_t);
constexpr std::size_t packed_slack = 8;         // look-ups read as many at once: the last ones beyond the end
constexpr std::size_t items = 64;               // work-group size of the insertion kernels
constexpr std::uint32_t launch_records = 4096;  // records entered by one launch, at most
constexpr std::uint64_t guessed_nodes = 2, guessed_entries = 12;  // a record, before any
constexpr std::uint64_t least_packed = 1024;                      // entries in lists that are worth packing
constexpr std::uint64_t settled_share = 16;  // lists hold one entry in so many, at most, when many look-ups come

std::size_t groups_of(std::size_t count) { return (count + items - 1) / items; }
}  // namespace

RecordCache::RecordCache(Device& device, const CacheSettings& settings) : device_(device), settings_(settings) {
    float size = 0, coordinate = 0;
    for (int i = 0; i < 3; ++i) {
        size = std::max(size, settings.upper[i] - settings.lower[i]);
        coordinate = std::max({coordinate, std::abs(settings.upper[i]), std::abs(settings.lower[i])});
    }
    // A margin, so that points that rounding puts outside the bounds still fall into the right cell.
    if (!(size > 0)) size = std::max(coordinate, 1.0f);
    parameters_.size = size * 1.02f;
    parameters_.origin_x = 0.5f * (settings.lower[0] + settings.upper[0]) - 0.5f * parameters_.size;
    parameters_.origin_y = 0.5f * (settings.lower[1] + settings.upper[1]) - 0.5f * parameters_.size;
    parameters_.origin_z = 0.5f * (settings.lower[2] + settings.upper[2]) - 0.5f * parameters_.size;
    set_weights();
    parameters_.coordinate = coordinate;
    parameters_.stretch = 1;
    state_ = device_.allocate(sizeof(shared::OctreeState));
    grow_records(first_records);
    node_capacity_ = first_nodes;
    nodes_ = device_.allocate(node_capacity_ * node_bytes);
    entry_capacity_ = first_entries;
    entries_ = device_.allocate(entry_capacity_ * entry_bytes);
    clear_octree();
}

void RecordCache::clear_octree() {
    device_.fill(nodes_, 0, node_capacity_ * node_bytes);
    const shared::OctreeState empty{};
    device_.write(state_, &empty, sizeof empty);
    packed_ = device_.allocate(packed_slack * packed_bytes);
    packed_count_ = 0;
    octree_ = {0, 0, 0, octree_.growths};
    parameters_.levels = 0;
}

// How look-ups weigh, from the settings.
void RecordCache::set_weights() {
    // Under a > 1 (1.8) would take records that face away, of a wall's other side for one.
    parameters_.inverse_angle = std::max(settings_.inverse_angle, 1.0f);
    parameters_.in_front = settings_.in_front_slope;
}

void RecordCache::grow_records(std::size_t capacity) {
    Buffer keys = device_.allocate(capacity * sizeof(shared::RecordKey));
    Buffer values = device_.allocate(capacity * sizeof(shared::RecordValue));
    if (size_ > 0) {
        device_.copy(keys_, keys, size_ * sizeof(shared::RecordKey));
        device_.copy(values_, values, size_ * sizeof(shared::RecordValue));
        device_.finish();
    }
    keys_ = std::move(keys);
    values_ = std::move(values);
    capacity_ = capacity;
}

void RecordCache::grow_nodes() {
    Buffer fresh = device_.allocate(2 * node_capacity_ * node_bytes);
    device_.fill(fresh, 0, 2 * node_capacity_ * node_bytes);
    device_.kernel("insert_records.cl", "move_nodes", defines())
        .arg(nodes_)
        .arg(fresh)
        .arg(node_mask())
        .arg(static_cast<std::uint32_t>(2 * node_capacity_ - 1))
        .run(groups_of(node_capacity_), items);
    device_.finish();
    nodes_ = std::move(fresh);
    node_capacity_ *= 2;
    ++octree_.growths;
}

void RecordCache::grow_entries(std::size_t capacity) {
    Buffer fresh = device_.allocate(capacity * entry_bytes);
    if (listed() > 0) device_.copy(entries_, fresh, static_cast<std::size_t>(listed()) * entry_bytes);
    device_.finish();
    entries_ = std::move(fresh);
    entry_capacity_ = capacity;
    ++octree_.growths;
}

std::uint32_t RecordCache::reserve(std::size_t count) {
    if (size_ + count > capacity_) grow_records(std::max(2 * capacity_, size_ + count));
    return static_cast<std::uint32_t>(size_);
}

void RecordCache::insert(std::size_t count, const Buffer& points, const Buffer& stack) {
    if (count == 0) return;
    const auto first = static_cast<std::uint32_t>(size_), n = static_cast<std::uint32_t>(count);
    if (settings_.clamp_slope > 0 && size_ > 0) {
        if (count > near_capacity_) {
            near_ = device_.allocate(count * clamp_bytes);
            near_capacity_ = count;
        }
        for (const std::uint32_t limit_old : {0u, 1u})
            device_.kernel("insert_records.cl", "clamp_records", defines())
                .arg(nodes_)
                .arg(entries_)
                .arg(packed_)
                .arg(node_mask())
                .arg(keys_)
                .arg(parameters_)
                .arg(points)
                .arg(stack)
                .arg(near_)
                .arg(settings_.clamp_slope)
                .arg(settings_.min_spacing)
                .arg(limit_old)
                .arg(first)
                .arg(n)
                .run(groups_of(count), items);
    }
    enter(first, n);
    size_ += count;
}

void RecordCache::load(const std::vector<shared::RecordKey>& keys, const std::vector<shared::RecordValue>& values) {
    if (keys.empty()) return;
    const std::uint32_t first = reserve(keys.size());
    device_.write(keys_, keys.data(), keys.size() * sizeof keys[0], first * sizeof keys[0]);
    device_.write(values_, values.data(), values.size() * sizeof values[0], first * sizeof values[0]);
    enter(first, static_cast<std::uint32_t>(keys.size()));
    size_ += keys.size();
}

// Records [first, first + count) into the octree. A record finds its place in a list by walking past those of its
// launch that came first, and past all that follow it when it is entered again: in launches of a bounded number a
// million records of one cell take linear time.
void RecordCache::enter(std::uint32_t first, std::uint32_t count) {
    for (std::uint32_t done = 0; done < count; done += launch_records) {
        enter_launch(first + done, std::min(launch_records, count - done));
        if (listed() >= std::max<std::uint64_t>(least_packed, packed_count_)) pack();
    }
}

void RecordCache::settle() {
    if (listed() > packed_count_ / settled_share) pack();
}

// All lists into their nodes' packed parts. Whenever those have doubled, and before many look-ups: the work for an
// entry is bounded, whatever their number.
void RecordCache::pack() {
    if (listed() == 0) return;
    Buffer fresh = device_.allocate((octree_.entries + packed_slack) * packed_bytes);
    const shared::OctreeState emptied{static_cast<std::uint32_t>(octree_.nodes), 0, 0, parameters_.levels};
    device_.write(state_, &emptied, sizeof emptied);
    device_.kernel("insert_records.cl", "pack_records", defines())
        .arg(nodes_)
        .arg(entries_)
        .arg(node_mask())
        .arg(keys_)
        .arg(parameters_)
        .arg(packed_)
        .arg(fresh)
        .arg(state_)
        .run(groups_of(node_capacity_ / (device_.cpu_traversal() ? IR_PACKED_PLACES : 1u)), items);
    device_.write(state_, &emptied, sizeof emptied);
    device_.finish();
    packed_ = std::move(fresh);
    packed_count_ = octree_.entries;
}

void RecordCache::enter_launch(std::uint32_t first, std::uint32_t count) {
    // Room for what so many records are likely to take, so that few launches have to be run again: entries as those
    // before took and a quarter more; of nodes each new one needs fewer the more there are.
    const auto expected = [&](std::uint64_t taken, std::uint64_t guess) {
        if (first == 0) return guess * count;
        return static_cast<std::uint64_t>(1.25 * count / first * static_cast<double>(taken));
    };
    const std::uint64_t most = guessed_nodes * count;
    const std::uint64_t nodes = octree_.nodes + std::min(expected(octree_.nodes, guessed_nodes), most);
    while (2 * octree_.nodes > node_capacity_ || 4 * nodes > 3 * node_capacity_) grow_nodes();
    if (const std::uint64_t entries = listed() + expected(octree_.entries, guessed_entries); entries > entry_capacity_)
        grow_entries(std::max<std::uint64_t>(2 * entry_capacity_, entries));
    const std::size_t work_items = count * std::size_t{device_.cpu_traversal() ? 1 : IR_INSERT_LANES};
    for (std::uint32_t again = 0;; again = 1) {
        device_.kernel("insert_records.cl", "insert_records", defines())
            .arg(nodes_)
            .arg(entries_)
            .arg(state_)
            .arg(node_mask())
            .arg(keys_)
            .arg(parameters_)
            .arg(static_cast<std::uint32_t>(node_capacity_ / 4 * 3))
            .arg(static_cast<std::uint32_t>(entry_capacity_))
            .arg(again)
            .arg(first)
            .arg(count)
            .run(groups_of(work_items), items);
        shared::OctreeState state{};
        device_.read(state_, &state, sizeof state);
        octree_.nodes = state.node_count;
        octree_.entries = packed_count_ + std::min<std::uint64_t>(state.entry_count, entry_capacity_);
        parameters_.levels = state.levels;
        octree_.depth = state.levels > 0 ? static_cast<std::uint64_t>(std::bit_width(state.levels) - 1) : 0;
        if (state.overflow == 0) break;
        // What did fit stays; entering a record twice is harmless, so the whole launch is simply run again.
        if (state.entry_count > entry_capacity_)
            grow_entries(2 * entry_capacity_);
        else
            grow_nodes();
        state.entry_count = static_cast<std::uint32_t>(listed());
        state.overflow = 0;
        device_.write(state_, &state, sizeof state);
    }
}

void RecordCache::rescale(float factor, const CacheSettings& settings) {
    settings_ = settings;
    set_weights();
    if (size_ == 0) return;
    std::vector<shared::RecordKey> keys = download_keys();
    for (shared::RecordKey& k : keys) {
        k.support1 *= factor;
        k.support2 *= factor;
    }
    device_.write(keys_, keys.data(), keys.size() * sizeof keys[0]);
    clear_octree();
    enter(0, static_cast<std::uint32_t>(size_));
}

void RecordCache::state(Checkpoint& c) {
    std::uint64_t sizes[] = {size_, capacity_, node_capacity_, entry_capacity_, packed_count_};
    c(sizes)(octree_)(settings_)(parameters_);
    size_ = sizes[0], capacity_ = sizes[1], node_capacity_ = sizes[2], entry_capacity_ = sizes[3];
    packed_count_ = sizes[4];
    exchange(c, device_, keys_, size_ * sizeof(shared::RecordKey), capacity_ * sizeof(shared::RecordKey));
    exchange(c, device_, values_, size_ * sizeof(shared::RecordValue), capacity_ * sizeof(shared::RecordValue));
    exchange(c, device_, nodes_, node_capacity_ * node_bytes);
    exchange(c, device_, entries_, listed() * entry_bytes, entry_capacity_ * entry_bytes);
    exchange(c, device_, packed_, packed_count_ * packed_bytes, (packed_count_ + packed_slack) * packed_bytes);
    exchange(c, device_, state_, sizeof(shared::OctreeState));
}

shared::CacheParameters RecordCache::parameters(bool placement) const noexcept {
    shared::CacheParameters p = parameters_;
    if (placement) {
        p.stretch = settings_.placement_stretch;
        p.minimum_weight = settings_.minimum_weight;
        p.gap_least = settings_.gap_least;
        p.gap_reach = settings_.gap_reach;
    }
    return p;
}

Kernel& RecordCache::bind(Kernel& kernel, bool placement) const {
    return kernel.arg(nodes_)
        .arg(entries_)
        .arg(packed_)
        .arg(node_mask())
        .arg(keys_)
        .arg(values_)
        .arg(parameters(placement));
}

std::map<std::string, std::string> RecordCache::defines() const {
    return {{"IR_WEIGHT", std::to_string(settings_.weight)}};
}

std::vector<shared::RecordKey> RecordCache::download_keys() const {
    std::vector<shared::RecordKey> keys(size_);
    if (size_ > 0) device_.read(keys_, keys.data(), size_ * sizeof keys[0]);
    return keys;
}

std::vector<shared::RecordValue> RecordCache::download_values() const {
    std::vector<shared::RecordValue> values(size_);
    if (size_ > 0) device_.read(values_, values.data(), size_ * sizeof values[0]);
    return values;
}

}  // namespace irradia
