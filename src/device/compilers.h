// Programs compiled by processes started for that. PoCL compiles one program a process at a time, on one core; other
// processes use the other cores, and what they have compiled is handed over in the cache of programs.
#pragma once
#include <sys/types.h>

#include <cstdint>
#include <string>
#include <vector>

#include "device/program_cache.h"

namespace irradia::device {

struct JobHeader;  // compilers_shared.h

/// A program to compile.
struct CompileJob {
    ProgramKey key;
    Checksums sums;  ///< by which its source is known
    std::string options, source;
};

/// Compiles programs in other processes while it lives.
class Compilers {
public:
    /// Starts up to `count` processes of `executable` (compile_for_parent()), which take the jobs in turn. Where none
    /// can be started there are no jobs.
    Compilers(const std::string& executable, int device_index, const std::vector<CompileJob>& jobs, std::size_t count);
    /// Lets them finish what they are at, which leaves the driver's folder tidy, and waits for them.
    ~Compilers();
    Compilers(const Compilers&) = delete;
    Compilers& operator=(const Compilers&) = delete;

    /// Returns once the program is in the cache, has failed, or will not be compiled.
    void wait_for(const ProgramKey& key);
    /// No process is at work.
    [[nodiscard]] bool finished();

private:
    bool start(const std::string& executable, int memory, int writing);
    /// Waits for news, or not; false if no process is left.
    bool listen(bool wait);

    JobHeader* header_ = nullptr;
    std::size_t bytes_ = 0;
    int news_ = -1;  // a byte for every job done; its end, once no process is left
    std::vector<pid_t> processes_;
    std::vector<ProgramKey> keys_;
};

}  // namespace irradia::device
