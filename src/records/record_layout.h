// The bytes of a record file, version 1, which docs/record-format.md describes. A header, then blocks; a block holds
// records of one kind, or corrects or concludes those before it, so that every whole number of blocks is a state of the
// cache, and a file grows at its end alone. When a struct or its meaning changes, kVersion has to.
#pragma once
#include <cstddef>
#include <cstdint>

#include "core/checksum.h"
#include "irradia/RecordFile.h"

namespace irradia::records {

constexpr char kMagic[8] = {'\x89', 'I', 'R', 'R', 'E', 'C', '\r', '\n'};
constexpr std::uint32_t kByteOrder = 0x01020304u, kOtherByteOrder = 0x04030201u;
constexpr std::uint32_t kVersion = 1;
constexpr std::size_t kLargestText = 1u << 16;  ///< bytes of the settings
constexpr std::uint32_t kLargestStride = 1u << 21, kLargestOrder = 12;

struct Header {
    char magic[8];
    std::uint32_t byte_order, version;
    std::uint32_t header_bytes;  ///< of this struct and the settings, padded to a multiple of 8: where blocks begin
    std::uint32_t text_bytes;    ///< of the settings: lines "name value\n"
    std::uint64_t geometry, materials, emitters;
    double centre[3];
    float lower[3], upper[3];
    std::uint64_t zero[2];
    std::uint64_t checksum;  ///< of header_bytes bytes, with this field zero
};
static_assert(sizeof(Header) == 120);

enum BlockKind : std::uint32_t {
    kIrradiance = 1,         ///< count keys, count values
    kRadiance = 2,           ///< count keys, count values, the samples of each, the harmonics of each
    kIrradianceSupport = 3,  ///< count Supports: those of earlier records have shrunk
    kRadianceSupport = 4,
    kView = 5  ///< count RecordViews
};

struct Block {
    std::uint32_t kind, count;
    std::uint32_t stride, order;  ///< kRadiance; otherwise 0
    std::uint64_t bytes;          ///< of what follows, a multiple of 8 (padded with zeros)
    std::uint64_t checksum;       ///< of what follows
    std::uint64_t own_checksum;   ///< of the fields above
};
static_assert(sizeof(Block) == 40);

struct Support {
    std::uint32_t record;
    float support1, support2;
};
static_assert(sizeof(Support) == 12 && sizeof(RecordView) == 96);

constexpr std::uint64_t padded(std::uint64_t bytes) { return (bytes + 7) / 8 * 8; }

/// Bytes of a block's payload without padding; 0: no such kind, or a stride or order that cannot be.
inline std::uint64_t payload_bytes(const Block& b) {
    const std::uint64_t n = b.count, both = sizeof(shared::RecordKey) + sizeof(shared::RecordValue);
    if (b.kind != kRadiance && (b.stride != 0 || b.order != 0)) return 0;
    switch (b.kind) {
        case kIrradiance:
            return n * both;
        case kRadiance:
            if (b.stride > kLargestStride || b.stride % 8 != 0 || b.order > kLargestOrder) return 0;
            return n * (both + sizeof(float) * (std::uint64_t{IR_SAMPLE_FLOATS} * b.stride +
                                                std::uint64_t{IR_HARMONIC_SETS} * b.order * b.order));
        case kIrradianceSupport:
        case kRadianceSupport:
            return n * sizeof(Support);
        case kView:
            return n * sizeof(RecordView);
        default:
            return 0;
    }
}

/// Checksums of blocks begin with the file's header and where the block lies: one that was moved, or left over from
/// another file, does not pass.
inline std::uint64_t block_seed(std::uint64_t header_checksum, std::uint64_t offset) {
    return header_checksum ^ (offset * 0x9e3779b185ebca87u);
}
inline std::uint64_t own_checksum(const Block& b, std::uint64_t seed) {
    return checksum(&b, offsetof(Block, own_checksum), seed);
}

}  // namespace irradia::records
