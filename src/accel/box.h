// Bounds of primitives.
#pragma once
#include <array>
#include <cstdint>

#include "irradia/Scene.h"

namespace irradia::accel {

struct Box {
    std::array<float, 3> lo{1e30f, 1e30f, 1e30f}, hi{-1e30f, -1e30f, -1e30f};
    void add(const Box& b);
    /// Half the surface area.
    [[nodiscard]] float area() const {
        const float x = hi[0] - lo[0], y = hi[1] - lo[1], z = hi[2] - lo[2];
        return x * y + y * z + z * x;
    }
};

/// What both share; where they do not meet, without extent along an axis.
Box overlap(const Box& a, const Box& b);

/// World bounds (after centring) of a primitive: a triangle or an analytic sphere, disk or cylinder.
Box primitive_box(const Scene& scene, std::uint32_t primitive);

}  // namespace irradia::accel
