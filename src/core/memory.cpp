#include "core/memory.h"

#include <malloc.h>
#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <limits>

#include "irradia/Error.h"

namespace irradia {
namespace {

/// The least memory.max of this process's group and of those above; the largest number if there is none.
std::uint64_t group_limit() {
    std::uint64_t least = std::numeric_limits<std::uint64_t>::max();
    std::ifstream groups("/proc/self/cgroup");
    std::string line;
    while (std::getline(groups, line)) {
        if (line.rfind("0::", 0) != 0) continue;  // others are of version 1
        const std::filesystem::path root = "/sys/fs/cgroup";
        for (std::filesystem::path group = std::filesystem::path(line.substr(3)).relative_path();;
             group = group.parent_path()) {
            std::ifstream file(root / group / "memory.max");
            std::uint64_t bytes = 0;
            if (file >> bytes) least = std::min(least, bytes);  // "max" is no number
            if (group.empty()) break;
        }
    }
    return least;
}

}  // namespace

std::uint64_t resident_memory() {
    std::ifstream file("/proc/self/statm");
    std::uint64_t size = 0, resident = 0;
    if (!(file >> size >> resident)) return 0;
    return resident * static_cast<std::uint64_t>(::sysconf(_SC_PAGESIZE));
}

std::uint64_t peak_resident_memory() {
    rusage usage{};
    ::getrusage(RUSAGE_SELF, &usage);
    return static_cast<std::uint64_t>(usage.ru_maxrss) * 1024;  // Linux counts in KiB
}

std::uint64_t machine_memory() {
    const std::uint64_t machine =
        static_cast<std::uint64_t>(::sysconf(_SC_PHYS_PAGES)) * static_cast<std::uint64_t>(::sysconf(_SC_PAGESIZE));
    return std::min(machine, group_limit());
}

std::optional<std::uint64_t> parse_memory_size(const std::string& text) {
    if (text.empty() || !(text[0] == '.' || (text[0] >= '0' && text[0] <= '9'))) return std::nullopt;
    if (text.size() > 1 && (text[1] == 'x' || text[1] == 'X')) return std::nullopt;  // strtod reads 0x10
    char* end = nullptr;
    const double number = std::strtod(text.c_str(), &end);
    std::string unit = end;
    double scale = 1;
    if (unit == "%") {
        scale = static_cast<double>(machine_memory()) / 100;
    } else if (!unit.empty() && unit != "B") {
        const std::string letters = "KMGT";
        std::size_t power = letters.find(unit[0]);
        if (power == std::string::npos) power = std::string("kmgt").find(unit[0]);
        const std::string rest = unit.substr(1);
        if (power == std::string::npos || !(rest.empty() || rest == "B" || rest == "iB")) return std::nullopt;
        scale = std::ldexp(1.0, 10 * static_cast<int>(power + 1));
    }
    const double bytes = number * scale;
    if (!(bytes >= 1 && bytes < 0x1p63)) return std::nullopt;
    return static_cast<std::uint64_t>(bytes);
}

std::string memory_text(std::uint64_t bytes) {
    char text[32];
    const double mebibytes = static_cast<double>(bytes) / (1 << 20);
    if (mebibytes < 1)
        std::snprintf(text, sizeof text, "%llu bytes", static_cast<unsigned long long>(bytes));
    else if (mebibytes < 1000)
        std::snprintf(text, sizeof text, mebibytes < 10 ? "%.1f MiB" : "%.0f MiB", mebibytes);
    else
        std::snprintf(text, sizeof text, "%.2f GiB", mebibytes / 1024);
    return text;
}

void require_memory(std::uint64_t limit, std::uint64_t bytes, const std::string& what, const std::string& help,
                    std::uint64_t committed) {
    if (limit == 0) return;
    std::uint64_t in_use = 0;
    const auto fits = [&] {
        in_use = std::max(resident_memory(), committed);
        return in_use <= limit && bytes <= limit - in_use;
    };
    if (fits()) return;
#ifdef __GLIBC__
    ::malloc_trim(0);  // the allocator keeps what is freed: of a kernel's compiler, some hundred megabytes
    if (fits()) return;
#endif
    throw Error("no memory for " + what + ": " + (bytes > 0 ? "about " + memory_text(bytes) + " needed, " : "") +
                memory_text(in_use) + " in use, " + memory_text(limit) + " allowed (--memory-limit): " + help);
}

}  // namespace irradia
