// Files that exist whole or not at all.
#pragma once
#include <cstddef>
#include <string>

namespace irradia {

/// A file written under another name beside `path`, which becomes `path` on commit(). Destroyed before that, it
/// vanishes. A symbolic link is followed. Every function throws Error "<path>: cannot be written: ...".
class AsideFile {
public:
    explicit AsideFile(const std::string& path);
    ~AsideFile();
    AsideFile(const AsideFile&) = delete;
    AsideFile& operator=(const AsideFile&) = delete;

    void write(const void* data, std::size_t bytes);
    /// Synchronises with the disk, closes and renames.
    void commit();

private:
    std::string path_, target_, aside_;
    int file_ = -1;
    bool named_ = false;  // aside_ is there
    [[noreturn]] void fail(int error) const;
};

}  // namespace irradia
