#include "device/opencl.h"

#include <sched.h>

#include <algorithm>
#include <cctype>
#include <cstdio>
#include <cstdlib>
#include <mutex>
#include <string_view>
#include <thread>

#include "irradia/Error.h"

namespace irradia::device {
namespace {

std::string lower(std::string s) {
    std::transform(s.begin(), s.end(), s.begin(), [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
    return s;
}

std::string trimmed(std::string s) {
    while (!s.empty() && (s.back() == '\0' || s.back() == ' ')) s.pop_back();
    s.erase(0, std::min(s.find_first_not_of(' '), s.size()));
    return s;
}

std::string device_string(cl_device_id id, cl_device_info what) {
    std::size_t bytes = 0;
    check(clGetDeviceInfo(id, what, 0, nullptr, &bytes), "asking a device for its name");
    std::string text(bytes, '\0');
    check(clGetDeviceInfo(id, what, bytes, text.data(), nullptr), "asking a device for its name");
    return trimmed(text);
}

std::string platform_name(cl_platform_id id) {
    std::size_t bytes = 0;
    check(clGetPlatformInfo(id, CL_PLATFORM_NAME, 0, nullptr, &bytes), "asking a platform for its name");
    std::string text(bytes, '\0');
    check(clGetPlatformInfo(id, CL_PLATFORM_NAME, bytes, text.data(), nullptr), "asking a platform for its name");
    return trimmed(text);
}

/// PoCL compiles a kernel anew for every group size, for small and for large launches, and once more, for any of them,
/// when it gives a program out for the cache. That last version serves all of them and takes no longer to run: without
/// the others a first run takes half the time. Whoever wants them sets the variable.
constexpr const char* specialization = "POCL_WORK_GROUP_SPECIALIZATION";

/// PoCL's default device wakes threads of its own for every launch, and they the host: 0.1 to 0.2 ms in a virtual
/// machine, hundreds of times a picture. The one that we ask for runs what a thread enqueues in that thread (launch.h).
/// PoCL 4 calls it cpu-minimal, and takes the old name.
constexpr const char* drivers = "POCL_DEVICES";

std::string table(const std::vector<FoundDevice>& devices) {
    std::string text;
    for (const FoundDevice& d : devices) {
        text += (text.empty() ? "" : ", ") + std::to_string(d.description.index) + " '" + d.description.name + "' (" +
                d.description.platform + ")";
    }
    return text;
}

}  // namespace

void prefer_settings() {
    [[maybe_unused]] static const int done = setenv(specialization, "0", 0) + setenv(drivers, "basic", 0);
}

unsigned usable_processors() {
    cpu_set_t usable;
    CPU_ZERO(&usable);
    if (::sched_getaffinity(0, sizeof usable, &usable) == 0) return static_cast<unsigned>(CPU_COUNT(&usable));
    return std::max(std::thread::hardware_concurrency(), 1u);
}

bool takes_generic_kernels() {
    const char* const value = std::getenv(specialization);
    return value != nullptr && std::string_view(value) == "0";
}

std::string status_name(cl_int status) {
#define IR_STATUS(s) \
    case s:          \
        return #s
    switch (status) {
        IR_STATUS(CL_SUCCESS);
        IR_STATUS(CL_DEVICE_NOT_FOUND);
        IR_STATUS(CL_DEVICE_NOT_AVAILABLE);
        IR_STATUS(CL_COMPILER_NOT_AVAILABLE);
        IR_STATUS(CL_MEM_OBJECT_ALLOCATION_FAILURE);
        IR_STATUS(CL_OUT_OF_RESOURCES);
        IR_STATUS(CL_OUT_OF_HOST_MEMORY);
        IR_STATUS(CL_PROFILING_INFO_NOT_AVAILABLE);
        IR_STATUS(CL_MEM_COPY_OVERLAP);
        IR_STATUS(CL_BUILD_PROGRAM_FAILURE);
        IR_STATUS(CL_MAP_FAILURE);
        IR_STATUS(CL_MISALIGNED_SUB_BUFFER_OFFSET);
        IR_STATUS(CL_EXEC_STATUS_ERROR_FOR_EVENTS_IN_WAIT_LIST);
        IR_STATUS(CL_COMPILE_PROGRAM_FAILURE);
        IR_STATUS(CL_LINKER_NOT_AVAILABLE);
        IR_STATUS(CL_LINK_PROGRAM_FAILURE);
        IR_STATUS(CL_DEVICE_PARTITION_FAILED);
        IR_STATUS(CL_INVALID_VALUE);
        IR_STATUS(CL_INVALID_DEVICE_TYPE);
        IR_STATUS(CL_INVALID_PLATFORM);
        IR_STATUS(CL_INVALID_DEVICE);
        IR_STATUS(CL_INVALID_CONTEXT);
        IR_STATUS(CL_INVALID_QUEUE_PROPERTIES);
        IR_STATUS(CL_INVALID_COMMAND_QUEUE);
        IR_STATUS(CL_INVALID_MEM_OBJECT);
        IR_STATUS(CL_INVALID_BINARY);
        IR_STATUS(CL_INVALID_BUILD_OPTIONS);
        IR_STATUS(CL_INVALID_PROGRAM);
        IR_STATUS(CL_INVALID_PROGRAM_EXECUTABLE);
        IR_STATUS(CL_INVALID_KERNEL_NAME);
        IR_STATUS(CL_INVALID_KERNEL_DEFINITION);
        IR_STATUS(CL_INVALID_KERNEL);
        IR_STATUS(CL_INVALID_ARG_INDEX);
        IR_STATUS(CL_INVALID_ARG_VALUE);
        IR_STATUS(CL_INVALID_ARG_SIZE);
        IR_STATUS(CL_INVALID_KERNEL_ARGS);
        IR_STATUS(CL_INVALID_WORK_DIMENSION);
        IR_STATUS(CL_INVALID_WORK_GROUP_SIZE);
        IR_STATUS(CL_INVALID_WORK_ITEM_SIZE);
        IR_STATUS(CL_INVALID_GLOBAL_OFFSET);
        IR_STATUS(CL_INVALID_EVENT_WAIT_LIST);
        IR_STATUS(CL_INVALID_EVENT);
        IR_STATUS(CL_INVALID_OPERATION);
        IR_STATUS(CL_INVALID_BUFFER_SIZE);
        IR_STATUS(CL_INVALID_GLOBAL_WORK_SIZE);
        IR_STATUS(CL_INVALID_PROPERTY);
        IR_STATUS(CL_INVALID_COMPILER_OPTIONS);
        IR_STATUS(CL_INVALID_LINKER_OPTIONS);
        IR_STATUS(CL_INVALID_DEVICE_PARTITION_COUNT);
        case -1001:
            return "CL_PLATFORM_NOT_FOUND_KHR";
        default:
            return "OpenCL status " + std::to_string(status);
    }
#undef IR_STATUS
}

void check(cl_int status, std::string_view doing) {
    if (status != CL_SUCCESS) throw Error("OpenCL: " + std::string(doing) + " failed: " + status_name(status));
}

std::vector<FoundDevice> find_devices() {
    static std::mutex one_at_a_time;  // PoCL tells a second thread of no device while the first one's call starts it up
    const std::lock_guard lock(one_at_a_time);
    prefer_settings();
    constexpr const char* hint =
        " (on Debian and Ubuntu, the package pocl-opencl-icd brings one that runs on the CPU; GPUs need their vendor's "
        "OpenCL driver)";
    cl_uint platform_count = 0;
    const cl_int status = clGetPlatformIDs(0, nullptr, &platform_count);
    // -1001: the loader's way of saying that no driver is registered.
    if (status == -1001 || (status == CL_SUCCESS && platform_count == 0))
        throw Error(std::string("no OpenCL platform found") + hint);
    check(status, "looking for platforms");
    std::vector<cl_platform_id> platforms(platform_count);
    check(clGetPlatformIDs(platform_count, platforms.data(), nullptr), "looking for platforms");

    std::vector<FoundDevice> found;
    for (cl_platform_id platform : platforms) {
        cl_uint count = 0;
        // A platform without a usable device (a driver without its hardware) says so by an error: not ours to report.
        if (clGetDeviceIDs(platform, CL_DEVICE_TYPE_ALL, 0, nullptr, &count) != CL_SUCCESS || count == 0) continue;
        std::vector<cl_device_id> ids(count);
        if (clGetDeviceIDs(platform, CL_DEVICE_TYPE_ALL, count, ids.data(), nullptr) != CL_SUCCESS) continue;
        for (cl_device_id id : ids) {
            if (!device_info<cl_bool>(id, CL_DEVICE_AVAILABLE) ||
                !device_info<cl_bool>(id, CL_DEVICE_COMPILER_AVAILABLE))
                continue;
            FoundDevice d;
            d.platform = platform;
            d.id = id;
            d.description.index = static_cast<int>(found.size());
            d.description.name = device_string(id, CL_DEVICE_NAME);
            d.description.platform = platform_name(platform);
            d.description.driver = device_string(id, CL_DRIVER_VERSION);
            d.description.is_cpu = (device_info<cl_device_type>(id, CL_DEVICE_TYPE) & CL_DEVICE_TYPE_CPU) != 0;
            d.description.compute_units = device_info<cl_uint>(id, CL_DEVICE_MAX_COMPUTE_UNITS);
            d.description.global_memory = device_info<cl_ulong>(id, CL_DEVICE_GLOBAL_MEM_SIZE);
            d.description.local_memory = device_info<cl_ulong>(id, CL_DEVICE_LOCAL_MEM_SIZE);
            d.in_caller = d.description.is_cpu && d.description.platform == "Portable Computing Language" &&
                          d.description.compute_units == 1 &&
                          (d.description.name.starts_with("basic") || d.description.name.starts_with("cpu-minimal"));
            if (d.in_caller) d.description.compute_units = usable_processors();
            found.push_back(d);
        }
    }
    if (found.empty()) throw Error(std::string("no usable OpenCL device found") + hint);
    return found;
}

FoundDevice select_device(const std::string& select) {
    const std::vector<FoundDevice> devices = find_devices();
    if (select.empty()) {
        for (const FoundDevice& d : devices)
            if (!d.description.is_cpu) return d;
        return devices.front();
    }
    if (std::all_of(select.begin(), select.end(), [](char c) { return c >= '0' && c <= '9'; })) {
        // Nine digits at most: more would not fit an int, nor name a device.
        const std::size_t index = select.size() <= 9 ? std::stoul(select) : devices.size();
        if (index < devices.size()) return devices[index];
    } else {
        for (const FoundDevice& d : devices) {
            if (lower(d.description.name).find(lower(select)) != std::string::npos ||
                lower(d.description.platform).find(lower(select)) != std::string::npos)
                return d;
        }
    }
    throw Error("no OpenCL device '" + select + "'; there are: " + table(devices));
}

std::string format_bytes(std::uint64_t bytes) {
    char text[32];
    if (bytes < 1000000)
        std::snprintf(text, sizeof text, "%llu bytes", static_cast<unsigned long long>(bytes));
    else if (bytes < 1000000000)
        std::snprintf(text, sizeof text, "%.1f MB", static_cast<double>(bytes) * 1e-6);
    else
        std::snprintf(text, sizeof text, "%.2f GB", static_cast<double>(bytes) * 1e-9);
    return text;
}

}  // namespace irradia::device
