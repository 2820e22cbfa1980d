// A record file being read front to back.
#pragma once
#include <string>

#include "records/record_layout.h"

namespace irradia::records {

class Input {
public:
    /// Throws Error: unreadable, or no regular file.
    explicit Input(const std::string& path);
    ~Input();
    Input(const Input&) = delete;
    Input& operator=(const Input&) = delete;

    [[nodiscard]] const std::string& path() const { return path_; }
    [[nodiscard]] std::uint64_t size() const { return size_; }
    [[nodiscard]] std::uint64_t at() const { return at_; }
    void read(void* data, std::uint64_t bytes);
    void skip(std::uint64_t bytes);

private:
    std::string path_;
    int file_;
    std::uint64_t size_ = 0, at_ = 0;
};

struct OpenFile {
    Header header;
    RecordOrigin origin;
};

/// `text`: settings with their padding.
inline std::uint64_t header_checksum(Header header, const std::string& text) {
    header.checksum = 0;
    return checksum(text.data(), text.size(), checksum(&header, sizeof header));
}

/// The header, once it is certain that it is a whole one of this version.
OpenFile read_header(Input& in);

/// The next block's head. "" if its payload follows whole; "cut off" or "damaged". Throws Error where a block is as it
/// was written, and cannot be.
std::string next_block(Input& in, const OpenFile& file, Block& block);

}  // namespace irradia::records
