// Pixels whose surroundings need not be asked whether they want records.
#pragma once
#include <cstdint>
#include <vector>

#include "irradia/Checkpoint.h"
#include "irradia/Device.h"
#include "render/film.h"

namespace irradia {

/// What find_misses tells of the pixels whose coordinates are even, which the first iterations look at
/// (lattice_iterations): plain ones, and the plane that they show. A pixel between plain ones of one plane is as well
/// served as they are, unless it shows something that is less than two pixels wide, whose record shading asks for, or
/// unless other records have been made near by since.
class PlainPixels {
public:
    PlainPixels(Device& device, std::uint32_t width, std::uint32_t height)
        : device_(device), width_(width), height_(height) {}

    /// None is, before a view.
    void forget();
    /// IR_PLAIN_WORDS each, row by row.
    [[nodiscard]] const Buffer& words() const noexcept { return words_; }
    /// A record is made at this pixel, or soon near it, and may shorten those around: whether these suffice within four
    /// pixels is not known any more.
    void disturb(std::uint32_t pixel);
    /// Drops the pixels that lie between plain ones of one plane. `apart`: of two planes, world units. From the first
    /// time on words() must stay as they are.
    void drop(PixelList& pixels, float apart);
    void state(Checkpoint& checkpoint);

private:
    [[nodiscard]] std::uint32_t columns() const { return (width_ + 1) / 2; }
    [[nodiscard]] std::uint32_t rows() const { return (height_ + 1) / 2; }

    Device& device_;
    std::uint32_t width_, height_;
    Buffer words_;
    UntouchedVector<std::uint32_t> read_;  // words_, once they are asked for
    std::vector<std::uint8_t> disturbed_;  // 2x2 pixels each: as many as there are of even coordinates
};

}  // namespace irradia
