// Where PoCL compiles kernels.
#pragma once
#include "irradia/Device.h"

namespace irradia::device {

/// PoCL works on files in a folder of its own. Where they cannot be written, its compiler fails without a word of why,
/// and where the disk is full it ends the process: throws Error before that, which names the folder. Does nothing for
/// other drivers.
void check_driver_cache(const DeviceDescription& device);

}  // namespace irradia::device
