#include "core/aside_file.h"

#include <fcntl.h>
#include <unistd.h>

#include <atomic>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <filesystem>

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
    static std::atomic<unsigned> count{0};  // two writers of one process never share a name
    aside_ = target_ + ".part-" + std::to_string(::getpid()) + "-" + std::to_string(count++);
    file_ = ::open(aside_.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0666);
    if (file_ < 0) fail(errno);
}

AsideFile::~AsideFile() {
    if (file_ >= 0) ::close(file_);
    if (!aside_.empty()) ::unlink(aside_.c_str());
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
    const int file = file_;
    file_ = -1;
    if (::close(file) != 0) fail(errno);
    if (std::rename(aside_.c_str(), target_.c_str()) != 0) fail(errno);
    aside_.clear();
    // The rename itself, as far as the file system lets one.
    const fs::path folder = fs::path(target_).has_parent_path() ? fs::path(target_).parent_path() : fs::path(".");
    if (const int f = ::open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC); f >= 0) {
        ::fsync(f);
        ::close(f);
    }
}

}  // namespace irradia
