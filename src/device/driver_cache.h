// Where PoCL compiles kernels.
#pragma once
#include <string>

#include "irradia/Device.h"

namespace irradia::device {

/// Why PoCL cannot write its files; empty if it can, and for other drivers.
std::string driver_cache_fault(const DeviceDescription& device);

/// PoCL works on files in a folder of its own. Where they cannot be written, its compiler fails without a word of why,
/// and where the disk is full it ends the process: throws Error before that, which names the folder.
void check_driver_cache(const DeviceDescription& device);

}  // namespace irradia::device
