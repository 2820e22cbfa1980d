// Memory of this process and of the machine, and a limit that is kept by refusing what would pass it.
#pragma once
#include <cstdint>
#include <optional>
#include <string>

namespace irradia {

/// Resident set of this process, bytes; 0 where the system does not tell.
std::uint64_t resident_memory();
/// The largest it has been so far.
std::uint64_t peak_resident_memory();
/// The machine's memory, or what a control group (cgroup v2's memory.max, of the process's group and those above)
/// allows, if that is less.
std::uint64_t machine_memory();

/// "4G", "512M", "3.5GiB", "800000000": K, M, G and T are powers of 1024, with or without B or iB; "80%": of
/// machine_memory(). Nothing if it is none of these, or less than a byte.
std::optional<std::uint64_t> parse_memory_size(const std::string& text);
/// "812 MiB", "3.50 GiB".
std::string memory_text(std::uint64_t bytes);

/// Throws Error "no memory for WHAT: about 3.20 GiB needed, 1.10 GiB in use, 4.00 GiB allowed (--memory-limit): HELP"
/// if `bytes` more than are in use pass `limit`; 0: there is no limit. In use is the resident set, but no less than
/// `committed`: memory that has been asked for becomes resident as it is written to.
void require_memory(std::uint64_t limit, std::uint64_t bytes, const std::string& what, const std::string& help,
                    std::uint64_t committed = 0);

}  // namespace irradia
