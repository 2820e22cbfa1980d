#include "core/aside_file.h"

#include <fcntl.h>
#include <unistd.h>

#include <atomic>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <random>

#include "irradia/Error.h"

namespace irradia {

namespace fs = std::filesystem;

AsideFile::AsideFile(const std::string& path) : path_(path), target_(path) {
    std::error_code error;
    if (fs::is_symlink(path, error)) {
        const fs::path resolved = fs::canonical(path, error);
        if (!error) target_ = resolved.string();
    }
    const fs::file_status status = fs::status(target_, error);
    if (fs::exists(status) && !fs::is_regular_file(status))
        throw Error(path + ": cannot be written: it is " + (fs::is_directory(status) ? "a folder" : "no regular file"));
    // Writers of one file may be on several machines.
    static std::atomic<unsigned> count{0};
    static const unsigned mark = std::random_device()();
    aside_ =
        target_ + ".part-" + std::to_string(::getpid()) + "-" + std::to_string(mark) + "-" + std::to_string(count++);
    // Without a name until it is whole, where the file system can do that: then a killed process leaves nothing behind.
    const fs::path folder = fs::path(target_).has_parent_path() ? fs::path(target_).parent_path() : fs::path(".");
    if (::access("/proc/self/fd", X_OK) == 0) file_ = ::open(folder.c_str(), O_WRONLY | O_TMPFILE | O_CLOEXEC, 0666);
    named_ = file_ < 0;
    if (named_) file_ = ::open(aside_.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0666);
    if (file_ < 0) fail(errno);
}

AsideFile::~AsideFile() {
    if (file_ >= 0) ::close(file_);
    if (named_) ::unlink(aside_.c_str());
}

void AsideFile::fail(int error) const { throw Error(path_ + ": cannot be written: " + std::strerror(error)); }

void AsideFile::write(const void* data, std::size_t bytes) {
    const char* at = static_cast<const char*>(data);
    while (bytes > 0) {
        const ssize_t done = ::write(file_, at, bytes);
        if (done < 0 && errno == EINTR) continue;
        if (done < 0) fail(errno);
        at += done;
        bytes -= static_cast<std::size_t>(done);
    }
}

void AsideFile::commit() {
    if (::fsync(file_) != 0) fail(errno);
    if (!named_) {
        const std::string open_file = "/proc/self/fd/" + std::to_string(file_);
        if (::linkat(AT_FDCWD, open_file.c_str(), AT_FDCWD, aside_.c_str(), AT_SYMLINK_FOLLOW) != 0) fail(errno);
        named_ = true;
    }
    const int file = file_;
    file_ = -1;
    if (::close(file) != 0) fail(errno);
    if (std::rename(aside_.c_str(), target_.c_str()) != 0) fail(errno);
    named_ = false;
    // The rename itself, as far as the file system lets one.
    const fs::path folder = fs::path(target_).has_parent_path() ? fs::path(target_).parent_path() : fs::path(".");
    if (const int f = ::open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC); f >= 0) {
        ::fsync(f);
        ::close(f);
    }
}

}  // namespace irradia
