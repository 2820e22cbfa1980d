// What Compilers and its processes share: memory without a name, which is the standard input of each of them.
#pragma once
#include <array>
#include <atomic>
#include <cstdint>

#include "core/checksum.h"

namespace irradia::device {

enum JobState : std::uint32_t { kJobWaits, kJobDone, kJobFailed };

/// Options and source lie one after the other from `first` on.
struct Job {
    std::atomic<std::uint32_t> state{kJobWaits};
    std::uint32_t options_bytes = 0;
    std::uint64_t first = 0, source_bytes = 0;
    Checksums sums;         ///< by which the source is known
    std::uint64_t key = 0;  ///< of the program: a process that sees another device finds another one
};

/// At the beginning; the jobs follow, then their texts.
struct JobHeader {
    std::array<char, 8> magic{'I', 'R', 'J', 'O', 'B', 'S', '0', '2'};
    std::uint64_t bytes = 0;  ///< of all
    std::int32_t parent = 0, device = 0;
    std::uint32_t count = 0;
    std::atomic<std::uint32_t> next{0};  ///< job that nobody has taken yet
    std::atomic<std::uint32_t> stop{0};

    [[nodiscard]] Job* jobs() { return reinterpret_cast<Job*>(this + 1); }
    [[nodiscard]] char* text(const Job& job) { return reinterpret_cast<char*>(this) + job.first; }
};

static_assert(std::atomic<std::uint32_t>::is_always_lock_free, "atomics are shared by processes");

}  // namespace irradia::device
