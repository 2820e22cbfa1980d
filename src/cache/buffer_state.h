// Device memory in a checkpoint.
#pragma once
#include <algorithm>
#include <vector>

#include "irradia/Checkpoint.h"
#include "irradia/Device.h"

namespace irradia {

/// The first `bytes` of a buffer, a block at a time. When reading, the buffer is made anew, with `capacity` bytes,
/// zeros at its end.
inline void exchange(Checkpoint& checkpoint, Device& device, Buffer& buffer, std::size_t bytes,
                     std::size_t capacity = 0) {
    constexpr std::uint64_t block = std::uint64_t{4} << 20;
    std::uint64_t size = bytes;
    checkpoint(size);
    if (checkpoint.reading()) {
        const std::size_t whole = std::max<std::size_t>({capacity, size, sizeof(std::uint32_t)});
        buffer = device.allocate(whole);
        device.fill(buffer, 0, whole / sizeof(std::uint32_t) * sizeof(std::uint32_t));
    }
    std::vector<char> host(static_cast<std::size_t>(std::min(size, block)));
    for (std::uint64_t at = 0; at < size; at += block) {
        const std::size_t n = static_cast<std::size_t>(std::min(block, size - at));
        if (!checkpoint.reading()) device.read(buffer, host.data(), n, at);
        checkpoint.bytes(host.data(), n);
        if (checkpoint.reading()) device.write(buffer, host.data(), n, at);
    }
}

}  // namespace irradia
