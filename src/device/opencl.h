// The bits of OpenCL's C API that are not about one device: status names, checks, enumeration, selection.
#pragma once
#define CL_TARGET_OPENCL_VERSION 120
#include <CL/cl.h>

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "irradia/Device.h"

namespace irradia::device {

/// "CL_OUT_OF_RESOURCES" and the like; unknown codes as a number.
std::string status_name(cl_int status);

/// Throws Error "OpenCL: <doing> failed: CL_..." unless status is CL_SUCCESS.
void check(cl_int status, std::string_view doing);

/// A device of the machine with what is known of it.
struct FoundDevice {
    cl_platform_id platform = nullptr;
    cl_device_id id = nullptr;
    DeviceDescription description;
    bool in_caller = false;  ///< commands run in the thread that enqueues them: PoCL's device for one thread
};

/// All devices of all platforms, in the loader's order. Throws Error if there is none, naming the package that brings
/// one.
std::vector<FoundDevice> find_devices();

/// Sets what drivers read of the environment when they are loaded, unless the user has; find_devices() does.
void prefer_settings();

/// Processors that this process may run on.
unsigned usable_processors();

/// Does PoCL make kernels for any group size only? So that it needs their source no more once they are compiled.
bool takes_generic_kernels();

/// The device that `select` means (DeviceOptions::select). The first match counts. Throws Error, listing
/// what there is, if none matches.
FoundDevice select_device(const std::string& select);

/// 1234567 -> "1.2 MB".
std::string format_bytes(std::uint64_t bytes);

template <class T>
T device_info(cl_device_id id, cl_device_info what) {
    T value{};
    check(clGetDeviceInfo(id, what, sizeof(T), &value, nullptr), "asking a device for its properties");
    return value;
}

}  // namespace irradia::device
