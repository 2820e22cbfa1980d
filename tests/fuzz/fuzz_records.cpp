// Record files. What is read must be what can be written and read again.
#include <cstdlib>

#include "core/checksum.h"
#include "fuzz_target.h"
#include "irradia/RecordFile.h"
#include "records/record_input.h"

namespace {

/// Makes checksums right, or the fuzzer would see them alone.
std::string forged(const std::uint8_t* data, std::size_t size) {
    using namespace irradia::records;
    std::string bytes(reinterpret_cast<const char*>(data), size);
    Header h{};
    if (size < sizeof h) return bytes;
    std::memcpy(&h, bytes.data(), sizeof h);
    if (h.header_bytes < sizeof h || h.header_bytes > size) return bytes;
    h.checksum = header_checksum(h, bytes.substr(sizeof h, h.header_bytes - sizeof h));
    std::memcpy(bytes.data(), &h, sizeof h);
    for (std::size_t at = h.header_bytes; size - at >= sizeof(Block);) {
        Block b{};
        std::memcpy(&b, bytes.data() + at, sizeof b);
        const std::uint64_t seed = block_seed(h.checksum, at);
        const bool whole = b.bytes <= size - at - sizeof b;
        if (whole) b.checksum = irradia::checksum(bytes.data() + at + sizeof b, b.bytes, seed);
        b.own_checksum = own_checksum(b, seed);
        std::memcpy(bytes.data() + at, &b, sizeof b);
        if (!whole) break;
        at += sizeof b + b.bytes;
    }
    return bytes;
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    const std::string bytes =
        size % 2 == 0 ? forged(data, size) : std::string(reinterpret_cast<const char*>(data), size);
    return irradia::test::fuzz_file(reinterpret_cast<const std::uint8_t*>(bytes.data()), bytes.size(), ".records",
                                    [](const std::string& path) {
                                        std::string warning;
                                        const irradia::RecordSet set = irradia::read_records(path, &warning);
                                        irradia::check_records("again", set);
                                    });
}
