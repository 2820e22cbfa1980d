// The irradiance grid on the device: filled by tracing paths, then read by hemispheres (cl/irradiance_grid.h).
#pragma once
#include <cstdint>
#include <map>
#include <string>

#include "irradia/shared/grid_types.h"
#include "render/run.h"

namespace irradia {

class IrradianceGrid {
public:
    /// Empty, and off: hemispheres go on as paths.
    explicit IrradianceGrid(Run& run);

    /// Announces that fill() may follow: kernels are those that ask it, and find nothing.
    void announce();
    /// Traces settings.grid_paths paths through the picture. Does nothing if the grid is off by settings, or nothing
    /// but direct light is wanted behind a hemisphere's rays.
    void fill();

    /// Will fill() do anything?
    [[nodiscard]] bool wanted() const;
    /// Are kernels those that ask it?
    [[nodiscard]] bool used() const noexcept { return on_; }
    /// Definitions of kernels that take IR_GRID's arguments: at present, and once fill() is announced.
    [[nodiscard]] std::map<std::string, std::string> defines() const;
    [[nodiscard]] std::map<std::string, std::string> defines_to_come() const;
    /// Sets the two arguments: cells and parameters.
    Kernel& bind(Kernel& kernel) const;

    void state(Checkpoint& checkpoint);

private:
    // False if a table of that many slots turned out too small.
    bool try_fill(std::size_t slots);
    [[nodiscard]] std::map<std::string, std::string> defines(bool on) const;
    void make_cells(const Buffer& sums, const Buffer& taken, std::uint32_t cells, std::uint32_t answers);

    Run& run_;
    shared::GridParameters parameters_{};
    Buffer cells_, overflow_;
    bool on_ = false;
};

}  // namespace irradia
