// A file being read front to back.
#pragma once
#include <cstdint>
#include <string>

namespace irradia {

/// Every function throws Error "<path>: ...".
class InputFile {
public:
    /// Throws Error: unreadable, or no regular file.
    explicit InputFile(const std::string& path);
    ~InputFile();
    InputFile(const InputFile&) = delete;
    InputFile& operator=(const InputFile&) = delete;

    [[nodiscard]] const std::string& path() const { return path_; }
    [[nodiscard]] std::uint64_t size() const { return size_; }
    [[nodiscard]] std::uint64_t at() const { return at_; }
    /// The next `bytes` bytes; throws Error if there are fewer.
    void read(void* data, std::uint64_t bytes);
    void skip(std::uint64_t bytes);

private:
    std::string path_;
    int file_;
    std::uint64_t size_ = 0, at_ = 0;
};

}  // namespace irradia
