// Launching sample_hemispheres: points on a stack in, records out.
#pragma once
#include <map>
#include <string>

#include "irradia/shared/record_types.h"
#include "render/irradiance_grid.h"
#include "render/run.h"

namespace irradia {

/// What hemispheres are sampled for.
enum class Hemispheres {
    irradiance,          ///< irradiance alone (plain gathering)
    irradiance_records,  ///< with gradients and a radius
    radiance_records     ///< their samples are kept too
};

/// Where the samples of radiance records go: those of record `first` come first.
struct KeptSamples {
    const Buffer* samples;
    std::uint32_t stride, first;
};

class HemisphereSampler {
public:
    HemisphereSampler(Run& run, Hemispheres purpose);

    /// The kernel that sample() will run, once `grid` is announced.
    [[nodiscard]] KernelSource kernel_to_come(const IrradianceGrid& grid) const;

    /// Samples points[stack[i]], i < count, into keys/values[first_record + i]. Random numbers are a function of the
    /// point's pixel and `salt`. `kept`: for radiance records.
    void sample(const Buffer& points, const Buffer& stack, std::size_t count, const IrradianceGrid& grid,
                const Buffer& keys, const Buffer& values, std::uint32_t first_record, std::uint32_t salt,
                const KeptSamples* kept = nullptr);

private:
    Run& run_;
    std::map<std::string, std::string> defines_;
    shared::RecordParameters parameters_{};
    Buffer ring_weights_, cells_;
    std::size_t cell_bytes_ = 0;  // of one hemisphere
    bool global_cells_ = false;   // they do not fit into local memory
};

/// Slope of the neighbour clamp in units of the stored support; 0 = off.
float neighbour_clamp_slope(const RenderSettings& settings);

}  // namespace irradia
