// Device memory in a checkpoint.
#pragma once
#include <vector>

#include "irradia/Checkpoint.h"
#include "irradia/Device.h"

namespace irradia {

/// The first `bytes` of a buffer. When reading, the buffer is made anew, with `capacity` bytes, zeros at its end.
inline void exchange(Checkpoint& checkpoint, Device& device, Buffer& buffer, std::size_t bytes,
                     std::size_t capacity = 0) {
    std::vector<char> host;
    if (!checkpoint.reading()) {
        host.resize(bytes);
        if (bytes > 0) device.read(buffer, host.data(), bytes);
    }
    checkpoint(host);
    if (!checkpoint.reading()) return;
    const std::size_t size = std::max({capacity, host.size(), sizeof(std::uint32_t)});
    buffer = device.allocate(size);
    device.fill(buffer, 0, size / sizeof(std::uint32_t) * sizeof(std::uint32_t));
    if (!host.empty()) device.write(buffer, host.data(), host.size());
}

}  // namespace irradia
