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

    /// Traces settings.grid_paths paths through the picture. Does nothing if the grid is off by settings, or the paths'
    /// depth is limited (an estimate left at a path's third vertex does not know how many edges the asker has left).
    void fill();

    /// Definitions of kernels that take IR_GRID's arguments.
    [[nodiscard]] std::map<std::string, std::string> defines() const;
    /// Sets the two arguments: cells and parameters.
    Kernel& bind(Kernel& kernel) const;

private:
    bool try_fill(std::size_t slots);

    Run& run_;
    shared::GridParameters parameters_{};
    Buffer cells_;
    bool filled_ = false;
};

}  // namespace irradia
