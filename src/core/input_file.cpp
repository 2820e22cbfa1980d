#include "core/input_file.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>

#include "irradia/Error.h"

namespace irradia {

InputFile::InputFile(const std::string& path) : path_(path), file_(::open(path.c_str(), O_RDONLY | O_CLOEXEC)) {
    struct stat status {};
    if (file_ < 0) throw Error(path + ": cannot be read: " + std::strerror(errno));
    if (::fstat(file_, &status) != 0 || !S_ISREG(status.st_mode)) {
        ::close(file_);
        throw Error(path + ": cannot be read: it is no regular file");
    }
    size_ = static_cast<std::uint64_t>(status.st_size);
}

InputFile::~InputFile() { ::close(file_); }

void InputFile::read(void* data, std::uint64_t bytes) {
    char* to = static_cast<char*>(data);
    while (bytes > 0) {
        const ssize_t done = ::read(file_, to, static_cast<std::size_t>(std::min<std::uint64_t>(bytes, 1u << 30)));
        if (done < 0 && errno == EINTR) continue;
        if (done < 0) throw Error(path_ + ": cannot be read: " + std::strerror(errno));
        if (done == 0) throw Error(path_ + ": truncated: the file became shorter while it was read");
        to += done;
        at_ += static_cast<std::uint64_t>(done);
        bytes -= static_cast<std::uint64_t>(done);
    }
}

void InputFile::skip(std::uint64_t bytes) {
    at_ += bytes;
    if (::lseek(file_, static_cast<off_t>(at_), SEEK_SET) < 0)
        throw Error(path_ + ": cannot be read: " + std::strerror(errno));
}

}  // namespace irradia
