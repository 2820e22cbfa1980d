#include "device/program_cache.h"

#include <unistd.h>

#include <array>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <utility>

#include "core/aside_file.h"
#include "core/checksum.h"
#include "device/driver_cache.h"
#include "device/pocl_binary.h"
#include "irradia/Error.h"

namespace irradia::device {
namespace {

/// In front of a binary in its file.
struct Header {
    std::array<char, 8> magic{'I', 'R', 'K', 'E', 'R', 'N', '0', '1'};
    std::uint64_t bytes = 0, sum = 0, key = 0;
};

std::filesystem::path folder() {
    if (const char* own = std::getenv("IRRADIA_KERNEL_CACHE")) return own;
    if (const char* cache = std::getenv("XDG_CACHE_HOME"); cache != nullptr && *cache != '\0')
        return std::filesystem::path(cache) / "irradia" / "kernels";
    if (const char* home = std::getenv("HOME"); home != nullptr && *home != '\0')
        return std::filesystem::path(home) / ".cache" / "irradia" / "kernels";
    return {};
}

/// Beside the executable's folder: what cmake/CompileKernels.cmake has compiled.
std::filesystem::path shipped_folder() {
    if (const char* named = std::getenv("IRRADIA_SHIPPED_KERNELS")) return named;
    std::error_code failed;
    const std::filesystem::path executable = std::filesystem::read_symlink("/proc/self/exe", failed);
    return failed ? std::filesystem::path{} : executable.parent_path().parent_path() / "share" / "irradia" / "kernels";
}

std::filesystem::path file_of(const std::filesystem::path& in, const ProgramKey& key) {
    static constexpr char digits[] = "0123456789abcdef";
    std::uint64_t hash = key.first;
    std::string name(16, '0');
    for (std::size_t i = name.size(); i-- > 0; hash >>= 4) name[i] = digits[hash & 15];
    return in / (name + ".program");
}

std::string platform_version(cl_platform_id platform) {
    std::size_t bytes = 0;
    if (clGetPlatformInfo(platform, CL_PLATFORM_VERSION, 0, nullptr, &bytes) != CL_SUCCESS) return {};
    std::string text(bytes, '\0');
    if (clGetPlatformInfo(platform, CL_PLATFORM_VERSION, bytes, text.data(), nullptr) != CL_SUCCESS) return {};
    return text;
}

std::vector<unsigned char> load_from(const std::filesystem::path& in, const ProgramKey& key) {
    if (in.empty()) return {};
    std::ifstream file(file_of(in, key), std::ios::binary);
    Header header;
    const Header expected;
    if (!file.read(reinterpret_cast<char*>(&header), sizeof header) || header.magic != expected.magic ||
        header.key != key.second || header.bytes > (std::uint64_t{1} << 30))
        return {};
    std::vector<unsigned char> binary(header.bytes);
    if (!file.read(reinterpret_cast<char*>(binary.data()), static_cast<std::streamsize>(binary.size())) ||
        checksum(binary.data(), binary.size()) != header.sum)
        return {};
    return binary;
}

}  // namespace

ProgramKey program_key(const Session& session, const Checksums& source, const std::string& options) {
    const DeviceDescription& d = session.device.description;
    std::string rest;
    for (const std::string& part : {d.platform, platform_version(session.device.platform), d.name, d.driver, options})
        rest += part + '\n';
    return checksums(rest.data(), rest.size(), source);
}

std::vector<unsigned char> load_program(const ProgramKey& key) {
    std::vector<unsigned char> binary = load_from(folder(), key);
    return binary.empty() ? load_from(shipped_folder(), key) : binary;
}

cl_program kept_program(const Session& session, const ProgramKey& key, const std::string& options) {
    std::vector<unsigned char> binary = load_program(key);
    if (binary.empty()) return nullptr;
    // PoCL puts kernels back into files of its own; those of the program as it is may be there already.
    if (takes_generic_kernels() && driver_cache_fault(session.device.description).empty())
        binary = without_llvm_code(std::move(binary));
    const unsigned char* data = binary.data();
    const std::size_t length = binary.size();
    cl_int taken = CL_SUCCESS, status = CL_SUCCESS;
    cl_program program =
        clCreateProgramWithBinary(session.context, 1, &session.device.id, &length, &data, &taken, &status);
    if (status != CL_SUCCESS) return nullptr;
    if (taken == CL_SUCCESS &&
        clBuildProgram(program, 1, &session.device.id, options.c_str(), nullptr, nullptr) == CL_SUCCESS)
        return program;
    clReleaseProgram(program);
    return nullptr;
}

bool keeps_programs() {
    const std::filesystem::path in = folder();
    std::error_code failed;
    if (!in.empty()) std::filesystem::create_directories(in, failed);
    return !in.empty() && ::access(in.c_str(), W_OK) == 0;
}

bool has_program(const ProgramKey& key) {
    std::error_code failed;
    for (const std::filesystem::path& in : {folder(), shipped_folder()})
        if (!in.empty() && std::filesystem::exists(file_of(in, key), failed)) return true;
    return false;
}

bool store_program(const ProgramKey& key, cl_program program) {
    const std::filesystem::path in = folder();
    if (in.empty()) return false;
    std::error_code failed;
    std::filesystem::create_directories(in, failed);
    std::size_t size = 0;
    if (failed || clGetProgramInfo(program, CL_PROGRAM_BINARY_SIZES, sizeof size, &size, nullptr) != CL_SUCCESS ||
        size == 0)
        return false;
    std::vector<unsigned char> binary(size);
    unsigned char* data = binary.data();
    if (clGetProgramInfo(program, CL_PROGRAM_BINARIES, sizeof data, static_cast<void*>(&data), nullptr) != CL_SUCCESS)
        return false;
    Header header;
    header.bytes = size;
    header.sum = checksum(binary.data(), size);
    header.key = key.second;
    try {
        AsideFile file(file_of(in, key).string());
        file.write(&header, sizeof header);
        file.write(binary.data(), size);
        file.commit();
        return true;
    } catch (const Error&) {  // a full or read-only disk: the next run compiles again
        return false;
    }
}

}  // namespace irradia::device
