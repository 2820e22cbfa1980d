#include "device/compilers.h"

#include <fcntl.h>
#include <poll.h>
#include <signal.h>
#include <spawn.h>
#include <sys/mman.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <new>
#include <string>

#include "device/compilers_shared.h"
#include "irradia/Device.h"

extern char** environ;

namespace irradia::device {
namespace {

void close_file(int& file) {
    if (file >= 0) ::close(file);
    file = -1;
}

}  // namespace

Compilers::Compilers(const std::string& executable, int device_index, const std::vector<CompileJob>& jobs,
                     std::size_t count) {
    std::size_t first = sizeof(JobHeader) + jobs.size() * sizeof(Job);
    bytes_ = first;
    for (const CompileJob& job : jobs) bytes_ += job.options.size() + job.source.size();
    int memory = ::memfd_create("irradia-kernels", MFD_CLOEXEC);
    std::array<int, 2> pipe{-1, -1};
    if (memory >= 0 && ::ftruncate(memory, static_cast<off_t>(bytes_)) == 0 && ::pipe2(pipe.data(), O_CLOEXEC) == 0) {
        void* const shared = ::mmap(nullptr, bytes_, PROT_READ | PROT_WRITE, MAP_SHARED, memory, 0);
        if (shared != MAP_FAILED) header_ = new (shared) JobHeader;
    }
    if (header_ != nullptr) {
        header_->bytes = bytes_;
        header_->parent = ::getpid();
        header_->device = device_index;
        header_->count = static_cast<std::uint32_t>(jobs.size());
        for (std::size_t i = 0; i < jobs.size(); ++i) {
            Job& job = *new (header_->jobs() + i) Job;
            job.options_bytes = static_cast<std::uint32_t>(jobs[i].options.size());
            job.source_bytes = jobs[i].source.size();
            job.first = first;
            job.sums = jobs[i].sums;
            job.key = jobs[i].key.first;
            std::memcpy(header_->text(job), jobs[i].options.data(), jobs[i].options.size());
            std::memcpy(header_->text(job) + jobs[i].options.size(), jobs[i].source.data(), jobs[i].source.size());
            first += jobs[i].options.size() + jobs[i].source.size();
            keys_.push_back(jobs[i].key);
        }
        while (processes_.size() < std::min(count, jobs.size()) && start(executable, memory, pipe[1])) {
        }
    }
    news_ = pipe[0];
    close_file(pipe[1]);  // the processes have theirs: when the last one ends, so does what news_ reads
    close_file(memory);
    if (processes_.empty()) close_file(news_);
}

Compilers::~Compilers() {
    if (header_ != nullptr) header_->stop = 1;
    for (const pid_t process : processes_)
        while (::waitpid(process, nullptr, 0) < 0 && errno == EINTR) {
        }
    close_file(news_);
    if (header_ != nullptr) ::munmap(header_, bytes_);
}

bool Compilers::start(const std::string& executable, int memory, int writing) {
    posix_spawn_file_actions_t files;
    posix_spawnattr_t attributes;
    ::posix_spawn_file_actions_init(&files);
    ::posix_spawnattr_init(&attributes);
    ::posix_spawn_file_actions_adddup2(&files, memory, STDIN_FILENO);
    ::posix_spawn_file_actions_adddup2(&files, writing, STDOUT_FILENO);
    ::posix_spawn_file_actions_addopen(&files, STDERR_FILENO, "/dev/null", O_WRONLY, 0);
    sigset_t stopping;  // of these a parent finishes what it is at, and so do they; with it they go
    ::sigemptyset(&stopping);
    for (const int signal : {SIGINT, SIGTERM, SIGHUP}) ::sigaddset(&stopping, signal);
    ::posix_spawnattr_setsigmask(&attributes, &stopping);
    ::posix_spawnattr_setflags(&attributes, POSIX_SPAWN_SETSIGMASK);
    std::string name = "render", argument = kCompileForParent;
    std::array<char*, 3> arguments{name.data(), argument.data(), nullptr};
    pid_t process = 0;
    const int failed = ::posix_spawn(&process, executable.c_str(), &files, &attributes, arguments.data(), environ);
    ::posix_spawn_file_actions_destroy(&files);
    ::posix_spawnattr_destroy(&attributes);
    if (failed == 0) processes_.push_back(process);
    return failed == 0;
}

bool Compilers::listen(bool wait) {
    while (news_ >= 0) {
        pollfd news{news_, POLLIN, 0};
        const int ready = ::poll(&news, 1, wait ? -1 : 0);
        if (ready == 0) return true;
        if (ready < 0 && errno == EINTR) continue;
        char byte = 0;
        const ssize_t got = ready < 0 ? -1 : ::read(news_, &byte, 1);
        if (got < 0 && errno == EINTR) continue;
        if (got == 1) return true;
        close_file(news_);
    }
    return false;
}

void Compilers::wait_for(const ProgramKey& key) {
    const auto at = std::find(keys_.begin(), keys_.end(), key);
    if (at == keys_.end()) return;
    const Job& job = header_->jobs()[at - keys_.begin()];
    while (job.state == kJobWaits && listen(true)) {
    }
}

bool Compilers::finished() {
    if (header_ == nullptr) return true;
    for (std::uint32_t i = 0; i < header_->count; ++i)
        if (header_->jobs()[i].state == kJobWaits) return !listen(false);
    return true;
}

}  // namespace irradia::device
