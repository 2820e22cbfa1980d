// Points that want records, as kernels leave them: cl/point_list.h.
#pragma once
#include <cstdint>
#include <vector>

#include "irradia/Device.h"
#include "irradia/shared/record_types.h"
#include "render/run.h"

namespace irradia {

class PointList {
public:
    /// Room for `capacity` points.
    PointList(Device& device, std::size_t capacity);

    /// Empty, for the kernel that gets it next.
    const Buffer& emptied();
    /// Where the points lie: what stacks' indices refer to.
    [[nodiscard]] const Buffer& buffer() const noexcept { return points_; }
    /// Waits for the kernel; then points() are what it has pushed, ascending by pixel.
    void read();
    [[nodiscard]] const std::vector<shared::ShadingPoint>& points() const noexcept { return sorted_; }
    /// Index in buffer() of points()[i].
    [[nodiscard]] std::uint32_t index(std::size_t i) const { return indices_[i]; }

private:
    Device& device_;
    std::size_t capacity_;
    Buffer points_;
    std::vector<shared::ShadingPoint> host_, sorted_;
    std::vector<std::uint32_t> indices_;
};

}  // namespace irradia
