#include <algorithm>
#include <cstring>
#include <string>
#include <vector>

#include "irradia/Error.h"
#include "irradia/RecordFile.h"
#include "records/record_input.h"

namespace irradia {
namespace records {

namespace {

[[noreturn]] void damaged(const std::string& path, const std::string& what) {
    throw Error(path + ": damaged record file: " + what);
}

/// "name value\n", again and again.
std::vector<std::pair<std::string, std::string>> parse_settings(const std::string& path, const std::string& text) {
    std::vector<std::pair<std::string, std::string>> settings;
    for (std::size_t at = 0; at < text.size();) {
        const std::size_t end = text.find('\n', at), space = text.find(' ', at);
        if (end == std::string::npos || space == std::string::npos || space > end)
            damaged(path, "a setting in its header is not 'name value'");
        settings.emplace_back(text.substr(at, space - at), text.substr(space + 1, end - space - 1));
        at = end + 1;
    }
    return settings;
}

}  // namespace

OpenFile read_header(InputFile& in) {
    const std::string& path = in.path();
    OpenFile file{};
    Header& h = file.header;
    const std::uint64_t bytes = std::min<std::uint64_t>(in.size(), sizeof h);
    in.read(&h, bytes);
    if (bytes < sizeof kMagic || std::memcmp(h.magic, kMagic, sizeof kMagic) != 0)
        throw Error(path + ": not a record file, expected one that --save-records wrote");
    if (bytes < sizeof h)
        throw Error(path + ": cut off: " + std::to_string(in.size()) + " bytes, the header alone has " +
                    std::to_string(sizeof h));
    if (h.byte_order == kOtherByteOrder)
        throw Error(path + ": written on a machine of the other byte order, expected this one's");
    if (h.byte_order != kByteOrder) damaged(path, "no byte order mark");
    if (h.version != kVersion)
        throw Error(path + ": record file of version " + std::to_string(h.version) + ", expected " +
                    std::to_string(kVersion));
    if (h.text_bytes > kLargestText || h.header_bytes != padded(sizeof h + h.text_bytes))
        damaged(path, "the header's size does not fit its settings");
    if (h.header_bytes > in.size())
        throw Error(path + ": cut off: " + std::to_string(in.size()) + " bytes, the header alone has " +
                    std::to_string(h.header_bytes));
    std::string text(h.header_bytes - sizeof h, '\0');
    in.read(text.data(), text.size());
    if (header_checksum(h, text) != h.checksum) damaged(path, "checksum of the header does not match");
    text.resize(h.text_bytes);
    RecordOrigin& o = file.origin;
    o.geometry = h.geometry, o.materials = h.materials, o.emitters = h.emitters;
    std::copy_n(h.centre, 3, o.centre.begin());
    std::copy_n(h.lower, 3, o.lower.begin());
    std::copy_n(h.upper, 3, o.upper.begin());
    o.settings = parse_settings(path, text);
    return file;
}

std::string next_block(InputFile& in, const OpenFile& file, Block& block) {
    const std::uint64_t seed = block_seed(file.header.checksum, in.at()), left = in.size() - in.at();
    if (left < sizeof block) return "cut off";
    in.read(&block, sizeof block);
    if (own_checksum(block, seed) != block.own_checksum) return "damaged";
    // From here on the writer is at fault: the block is as it was written.
    const std::uint64_t bytes = payload_bytes(block);
    if (bytes == 0 || padded(bytes) != block.bytes)
        damaged(in.path(), "a block of kind " + std::to_string(block.kind) + " with " + std::to_string(block.count) +
                               " elements of stride " + std::to_string(block.stride) + " and order " +
                               std::to_string(block.order) + " has " + std::to_string(block.bytes) + " bytes");
    if (block.bytes > left - sizeof block) return "cut off";
    return "";
}

namespace {

/// Takes what a block's payload holds apart.
class Payload {
public:
    explicit Payload(const std::vector<char>& bytes) : at_(bytes.data()) {}
    template <class T>
    void append(std::vector<T>& to, std::size_t count) {
        const std::size_t first = to.size();
        to.resize(first + count);
        if (count > 0) std::memcpy(to.data() + first, at_, count * sizeof(T));
        at_ += count * sizeof(T);
    }

private:
    const char* at_;
};

/// Supports that have shrunk since their records were written.
void apply_supports(const std::string& path, const std::vector<Support>& supports, Records& records) {
    for (const Support& s : supports) {
        if (s.record >= records.size())
            damaged(path, "a support of record " + std::to_string(s.record) + ", of " + std::to_string(records.size()));
        shared::RecordKey& k = records.keys[s.record];
        if (!(s.support1 <= k.support1 && s.support2 <= k.support2))
            damaged(path, "the support of record " + std::to_string(s.record) + " grows");
        k.support1 = s.support1;
        k.support2 = s.support2;
    }
}

void take_block(const std::string& path, const Block& block, const std::vector<char>& bytes, RecordSet& set) {
    Payload payload(bytes);
    RadianceRecords& r = set.radiance;
    std::vector<Support> supports;
    switch (block.kind) {
        case kIrradiance:
            payload.append(set.irradiance.keys, block.count);
            payload.append(set.irradiance.values, block.count);
            break;
        case kRadiance:
            if (r.size() == 0) r.stride = block.stride, r.order = block.order;
            if (r.stride != block.stride || r.order != block.order)
                damaged(path, "radiance records of stride " + std::to_string(block.stride) + " and order " +
                                  std::to_string(block.order) + " after those of stride " + std::to_string(r.stride) +
                                  " and order " + std::to_string(r.order));
            payload.append(r.keys, block.count);
            payload.append(r.values, block.count);
            payload.append(r.samples, block.count * r.sample_floats());
            payload.append(r.harmonics, block.count * r.harmonic_floats());
            break;
        case kView:
            payload.append(set.views, block.count);
            break;
        default:
            payload.append(supports, block.count);
            apply_supports(path, supports, block.kind == kIrradianceSupport ? set.irradiance : r);
    }
}

}  // namespace
}  // namespace records

RecordSet read_records(const std::string& path, std::string* warning) {
    using namespace records;
    InputFile in(path);
    const OpenFile file = read_header(in);
    RecordSet set;
    set.origin = file.origin;
    if (warning != nullptr) warning->clear();
    std::vector<char> bytes;
    while (in.at() < in.size()) {
        const std::uint64_t begin = in.at();
        Block block{};
        std::string wrong = next_block(in, file, block);
        if (wrong.empty()) {
            bytes.resize(static_cast<std::size_t>(block.bytes));
            in.read(bytes.data(), block.bytes);
            if (checksum(bytes.data(), bytes.size(), block_seed(file.header.checksum, begin)) != block.checksum)
                wrong = "damaged";
        }
        if (!wrong.empty()) {
            const std::string what = path + ": " + wrong + " from byte " + std::to_string(begin) + " on: of " +
                                     std::to_string(in.size()) + " bytes the last " +
                                     std::to_string(in.size() - begin) + " are lost, " +
                                     std::to_string(set.irradiance.size()) + " records and " +
                                     std::to_string(set.radiance.size()) + " radiance records are left";
            if (warning == nullptr) throw Error(what);
            *warning = what;
            break;
        }
        take_block(path, block, bytes, set);
    }
    check_records(path, set);
    return set;
}

}  // namespace irradia
