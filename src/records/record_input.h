// Reading a record file: its header, then block by block.
#pragma once
#include <string>

#include "core/input_file.h"
#include "records/record_layout.h"

namespace irradia::records {

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
OpenFile read_header(InputFile& in);

/// The next block's head. "" if its payload follows whole; "cut off" or "damaged". Throws Error where a block is as it
/// was written, and cannot be.
std::string next_block(InputFile& in, const OpenFile& file, Block& block);

}  // namespace irradia::records
