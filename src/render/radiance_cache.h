// Radiance records: where they lie, what they hold, the tables of the lobes that ask them (cl/radiance.h). Their keys
// and octree are those of any record; never mixed with irradiance records, which look-ups find in an octree of their
// own.
#pragma once
#include <cstdint>
#include <map>
#include <optional>
#include <string>

#include "cache/RecordCache.h"
#include "irradia/RecordFile.h"
#include "irradia/shared/radiance_types.h"
#include "render/hemispheres.h"

namespace irradia {

class RadianceCache {
public:
    /// Throws Error for settings out of range. tabulate() comes next.
    RadianceCache(Run& run, const CacheSettings& settings);
    /// Tabulates the lobes of all materials that records are to answer.
    void tabulate();
    /// Kernels that tabulate() and make() will run, once `grid` is announced.
    [[nodiscard]] KernelSource table_kernel() const;
    [[nodiscard]] KernelSource hemisphere_kernel(const IrradianceGrid& grid) const {
        return hemispheres_->kernel_to_come(grid);
    }

    /// Does any material of the scene have a lobe? If not, nothing of this is needed.
    [[nodiscard]] static bool useful(const Scene& scene);

    /// Records for points[stack[i]], sampled and entered. `salt`: see HemisphereSampler.
    void make(const Buffer& points, const RecordStack& stack, const IrradianceGrid& grid, std::uint32_t salt);

    /// Do records by these settings have as many samples as those that are there?
    [[nodiscard]] bool fits(const RenderSettings& settings) const;
    /// run.settings have changed, but for --hemisphere, and ask for supports `factor` times as large: see RecordCache.
    void rescale(float factor, const CacheSettings& settings);
    void settle() { records_.settle(); }  ///< see RecordCache
    /// Enters records made elsewhere. Throws Error if they hold other things than look-ups here ask for.
    void load(const RadianceRecords& records);
    /// Copies to the host.
    [[nodiscard]] RadianceRecords store() const;
    void state(Checkpoint& checkpoint);

    [[nodiscard]] const RecordCache& records() const noexcept { return records_; }
    /// Bytes of one record, its key and value included.
    [[nodiscard]] std::size_t record_bytes() const noexcept;
    /// Sets IR_RADIANCE_ARGS.
    Kernel& bind(Kernel& kernel, bool placement) const;

private:
    [[nodiscard]] std::uint32_t kept_stride() const noexcept { return keep_samples_ ? parameters_.stride : 0; }
    [[nodiscard]] bool asks(const shared::Material& m) const;  ///< has it a lobe that records answer?
    void grow(std::size_t records);
    void project(std::uint32_t first_kept, std::uint32_t first, std::size_t count);

    Run& run_;
    RecordCache records_;
    std::optional<HemisphereSampler> hemispheres_;
    shared::RadianceParameters parameters_{};
    bool keep_samples_ = true;  // otherwise they are needed only until they are projected
    std::size_t capacity_ = 0;  // records that samples_ and harmonics_ have room for
    Buffer samples_, harmonics_, partial_, tables_, offsets_;
};

}  // namespace irradia
