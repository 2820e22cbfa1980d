// The other side of Compilers: a process that compiles what its parent wants.
#include <signal.h>
#include <sys/mman.h>
#include <sys/prctl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <string>

#include "device/compile_program.h"
#include "device/compilers_shared.h"
#include "device/program_cache.h"
#include "device/session.h"
#include "irradia/Error.h"

namespace irradia::device {
namespace {

JobHeader* jobs_of_parent() {
    struct stat file {};
    if (::fstat(STDIN_FILENO, &file) != 0 || file.st_size < static_cast<off_t>(sizeof(JobHeader))) return nullptr;
    const auto bytes = static_cast<std::size_t>(file.st_size);
    void* const shared = ::mmap(nullptr, bytes, PROT_READ | PROT_WRITE, MAP_SHARED, STDIN_FILENO, 0);
    if (shared == MAP_FAILED) return nullptr;
    auto* const header = static_cast<JobHeader*>(shared);
    return header->magic == JobHeader{}.magic && header->bytes == bytes ? header : nullptr;
}

bool compile(const Session& session, JobHeader& header, const Job& job) {
    const std::string options(header.text(job), job.options_bytes);
    const std::string source(header.text(job) + job.options_bytes, job.source_bytes);
    const ProgramKey key = program_key(session, job.sums, options);
    if (key.first != job.key) return false;
    if (!load_program(key).empty()) return true;  // another render's processes were quicker
    const CompiledProgram compiled = compile_program(session, source, options);
    if (compiled.program == nullptr) return false;
    const bool stored = store_program(key, compiled.program);
    clReleaseProgram(compiled.program);
    return stored;
}

void compile_all(JobHeader& header) {
    DeviceOptions options;
    options.select = std::to_string(header.device);
    const Session session(options);
    for (;;) {
        if (header.stop != 0) return;
        const std::uint32_t i = header.next.fetch_add(1);
        if (i >= header.count) return;
        Job& job = header.jobs()[i];
        bool done = false;
        try {
            done = compile(session, header, job);
        } catch (const Error&) {  // the parent tries in turn, and says why it does not work
        }
        job.state = done ? kJobDone : kJobFailed;
        const char news = 1;
        if (::write(STDOUT_FILENO, &news, 1) != 1) return;
    }
}

}  // namespace
}  // namespace irradia::device

namespace irradia {

int compile_for_parent() {
    device::JobHeader* const header = device::jobs_of_parent();
    if (header == nullptr) return 2;
    ::prctl(PR_SET_PDEATHSIG, SIGKILL);
    if (::getppid() != header->parent) ::_exit(0);
    ::signal(SIGPIPE, SIG_IGN);
    try {
        device::compile_all(*header);
    } catch (const std::exception&) {  // no such device here: the parent compiles itself
    }
    ::_exit(0);  // nothing of the driver's is worth taking apart
}

}  // namespace irradia
