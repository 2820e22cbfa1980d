// Records and their octree in device memory, grown by the host as they fill: nothing is lost and there is no maximum
// but the memory. The kernels are cl/insert_records.cl; what a record is: shared/record_types.h.
#pragma once
#include <array>
#include <cstdint>
#include <vector>

#include "irradia/Checkpoint.h"
#include "irradia/Device.h"
#include "irradia/shared/record_types.h"

namespace irradia {

/// The stack of points that want a record: indices into a device array of ShadingPoint, in a fixed order.
struct RecordStack {
    std::vector<std::uint32_t> indices;
    [[nodiscard]] bool empty() const noexcept { return indices.empty(); }
    [[nodiscard]] std::size_t size() const noexcept { return indices.size(); }
};

/// Where the octree lies and how look-ups weigh.
struct CacheSettings {
    std::array<float, 3> lower{}, upper{};  ///< bounds of all surfaces, world units after centring
    float inverse_angle = 5;                ///< e_n = inverse_angle |n - n_i| / sqrt 2; at least 1 is taken
    float in_front_slope = 0.05f;           ///< theory 4.3; 0 = the test is off
    float placement_stretch = 1;            ///< see CacheParameters::stretch; for coverage tests
    float minimum_weight = 0;               ///< see CacheParameters::minimum_weight
    std::uint32_t weight = IR_WEIGHT_WARD;  ///< IR_WEIGHT_*
    float clamp_slope = 1;                  ///< neighbour clamp; 0 = off
    float min_spacing = 1.5f;               ///< footprints: neighbour clamping does not shrink a record below this
    float gap_least = 0, gap_reach = 0;     ///< see CacheParameters; 0 = narrow places are not looked for
};

class RecordCache {
public:
    RecordCache(Device& device, const CacheSettings& settings);

    /// Room for `count` more records; returns the index of the first. Call before the kernel that writes them.
    std::uint32_t reserve(std::size_t count);
    /// Enters records [size(), size() + count), which a kernel has written, made at points[stack[i]].
    void insert(std::size_t count, const Buffer& points, const Buffer& stack);
    /// Enters records made elsewhere as they are: their supports have been clamped.
    void load(const std::vector<shared::RecordKey>& keys, const std::vector<shared::RecordValue>& values);

    /// Supports times `factor`, and look-ups by `settings` (whose bounds are the old ones) from now on.
    void rescale(float factor, const CacheSettings& settings);

    /// Before many look-ups: what was entered last becomes as quick to find as the rest.
    void settle();

    [[nodiscard]] std::size_t size() const noexcept { return size_; }
    [[nodiscard]] const Buffer& keys() const noexcept { return keys_; }
    [[nodiscard]] const Buffer& values() const noexcept { return values_; }

    /// Parameters for look-ups: for the picture, or for the question whether a point is covered.
    [[nodiscard]] shared::CacheParameters parameters(bool placement) const noexcept;
    /// Sets IR_CACHE_ARGS.
    Kernel& bind(Kernel& kernel, bool placement) const;
    /// Definitions that kernels with look-ups are compiled with.
    [[nodiscard]] std::map<std::string, std::string> defines() const;

    /// Copies to the host.
    [[nodiscard]] std::vector<shared::RecordKey> download_keys() const;
    [[nodiscard]] std::vector<shared::RecordValue> download_values() const;

    /// Of a cache by the same settings. Records and octree come back as they were, so that sums over records do too.
    void state(Checkpoint& checkpoint);

    struct Octree {
        std::uint64_t nodes = 0, entries = 0, depth = 0, growths = 0;
    };
    [[nodiscard]] const Octree& octree() const noexcept { return octree_; }

private:
    void grow_records(std::size_t capacity);
    void enter(std::uint32_t first, std::uint32_t count);
    void enter_launch(std::uint32_t first, std::uint32_t count);
    void grow_nodes();
    void grow_entries(std::size_t capacity);
    void clear_octree();
    void pack();
    [[nodiscard]] std::uint64_t listed() const noexcept { return octree_.entries - packed_count_; }  ///< not packed
    [[nodiscard]] std::uint32_t node_mask() const noexcept { return static_cast<std::uint32_t>(node_capacity_ - 1); }
    void set_weights();

    Device& device_;
    CacheSettings settings_;
    shared::CacheParameters parameters_{};
    Buffer keys_, values_, nodes_, entries_, packed_, state_;
    Buffer near_;  // of each new record, which old ones it may shrink
    std::size_t near_capacity_ = 0;
    std::size_t size_ = 0, capacity_ = 0, node_capacity_ = 0, entry_capacity_ = 0;
    std::uint64_t packed_count_ = 0;
    Octree octree_;
};

}  // namespace irradia
