#include "device/driver_cache.h"

#include <sys/statvfs.h>
#include <unistd.h>

#include <cerrno>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <filesystem>

#include "irradia/Error.h"

namespace irradia::device {
namespace {

// All kernels of a render took 1.3 MB, the compiler's own files for a while a tenth of that.
constexpr std::uint64_t least_bytes = std::uint64_t{4} << 20;

/// As PoCL chooses it.
std::filesystem::path folder() {
    if (const char* own = std::getenv("POCL_CACHE_DIR")) return own;
    if (const char* cache = std::getenv("XDG_CACHE_HOME")) return std::filesystem::path(cache) / "pocl" / "kcache";
    if (const char* home = std::getenv("HOME")) return std::filesystem::path(home) / ".cache" / "pocl" / "kcache";
    return {};
}

}  // namespace

std::string driver_cache_fault(const DeviceDescription& device) {
    if (device.platform != "Portable Computing Language") return {};
    const std::filesystem::path path = folder();
    std::error_code ignored;
    if (path.empty() || !std::filesystem::is_directory(path, ignored)) return {};  // it may have found another place
    const auto fault = [&](const std::string& what) {
        return path.string() + ": the driver cannot compile kernels there: " + what +
               " (POCL_CACHE_DIR names another folder)";
    };
    if (::access(path.c_str(), W_OK) != 0) return fault(std::strerror(errno));
    struct statvfs disk {};
    if (::statvfs(path.c_str(), &disk) != 0) return {};
    const std::uint64_t left = std::uint64_t{disk.f_bavail} * disk.f_frsize;
    if (left >= least_bytes) return {};
    return fault("found " + std::to_string(left >> 10) + " KiB of free space, expected " +
                 std::to_string(least_bytes >> 10));
}

void check_driver_cache(const DeviceDescription& device) {
    const std::string fault = driver_cache_fault(device);
    if (!fault.empty()) throw Error(fault);
}

}  // namespace irradia::device
