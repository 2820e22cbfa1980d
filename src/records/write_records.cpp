#include <fcntl.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <functional>
#include <string>

#include "core/aside_file.h"
#include "irradia/Error.h"
#include "irradia/RecordFile.h"
#include "records/record_input.h"

namespace irradia {
namespace records {
namespace {

// Records of a block: what a cut-off file loses at most.
constexpr std::size_t kIrradianceBlock = 256, kRadianceBlock = 32, kSupportBlock = 4096;

using Sink = std::function<void(const void*, std::size_t)>;

/// Writes blocks, one after the other.
class BlockWriter {
public:
    BlockWriter(Sink sink, std::uint64_t header_checksum, std::uint64_t offset)
        : sink_(std::move(sink)), header_checksum_(header_checksum), offset_(offset) {}

    void write(Block block, std::vector<char> payload) {
        payload.resize(padded(payload.size()), '\0');
        const std::uint64_t seed = block_seed(header_checksum_, offset_);
        block.bytes = payload.size();
        block.checksum = checksum(payload.data(), payload.size(), seed);
        block.own_checksum = own_checksum(block, seed);
        sink_(&block, sizeof block);
        sink_(payload.data(), payload.size());
        offset_ += sizeof block + payload.size();
    }

private:
    Sink sink_;
    std::uint64_t header_checksum_, offset_;
};

template <class T>
void append(std::vector<char>& to, const std::vector<T>& from, std::size_t first, std::size_t count) {
    const char* data = reinterpret_cast<const char*>(from.data());
    to.insert(to.end(), data + first * sizeof(T), data + (first + count) * sizeof(T));
}

/// Calls f(first, count) for pieces of [first, end).
template <class F>
void in_pieces(std::size_t first, std::size_t end, std::size_t piece, F&& f) {
    for (; first < end; first += piece) f(first, std::min(piece, end - first));
}

void write_irradiance(BlockWriter& out, const Records& records, std::size_t first) {
    in_pieces(first, records.size(), kIrradianceBlock, [&](std::size_t at, std::size_t count) {
        std::vector<char> payload;
        append(payload, records.keys, at, count);
        append(payload, records.values, at, count);
        out.write({kIrradiance, static_cast<std::uint32_t>(count), 0, 0, 0, 0, 0}, std::move(payload));
    });
}

void write_radiance(BlockWriter& out, const RadianceRecords& r, std::size_t first) {
    in_pieces(first, r.size(), kRadianceBlock, [&](std::size_t at, std::size_t count) {
        std::vector<char> payload;
        append(payload, r.keys, at, count);
        append(payload, r.values, at, count);
        append(payload, r.samples, at * r.sample_floats(), count * r.sample_floats());
        append(payload, r.harmonics, at * r.harmonic_floats(), count * r.harmonic_floats());
        out.write({kRadiance, static_cast<std::uint32_t>(count), r.stride, r.order, 0, 0, 0}, std::move(payload));
    });
}

void write_views(BlockWriter& out, const std::vector<RecordView>& views, std::size_t first) {
    if (first == views.size()) return;
    std::vector<char> payload;
    append(payload, views, first, views.size() - first);
    out.write({kView, static_cast<std::uint32_t>(views.size() - first), 0, 0, 0, 0, 0}, std::move(payload));
}

void write_shrunk(BlockWriter& out, BlockKind kind, const Records& written, const Records& now) {
    std::vector<Support> shrunk;
    for (std::size_t i = 0; i < written.size(); ++i) {
        const shared::RecordKey &a = written.keys[i], &b = now.keys[i];
        if (a.support1 != b.support1 || a.support2 != b.support2)
            shrunk.push_back({static_cast<std::uint32_t>(i), b.support1, b.support2});
    }
    in_pieces(0, shrunk.size(), kSupportBlock, [&](std::size_t at, std::size_t count) {
        std::vector<char> payload;
        append(payload, shrunk, at, count);
        out.write({kind, static_cast<std::uint32_t>(count), 0, 0, 0, 0, 0}, std::move(payload));
    });
}

std::string settings_text(const RecordOrigin& origin) {
    std::string text;
    for (const auto& [name, value] : origin.settings) {
        text += name;
        text += ' ';
        text += value;
        text += '\n';
    }
    return text;
}

Header make_header(const RecordOrigin& origin, std::string& text) {
    Header h{};
    std::memcpy(h.magic, kMagic, sizeof kMagic);
    h.byte_order = kByteOrder;
    h.version = kVersion;
    h.text_bytes = static_cast<std::uint32_t>(text.size());
    h.header_bytes = static_cast<std::uint32_t>(padded(sizeof h + text.size()));
    text.resize(h.header_bytes - sizeof h, '\0');
    h.geometry = origin.geometry, h.materials = origin.materials, h.emitters = origin.emitters;
    std::copy_n(origin.centre.begin(), 3, h.centre);
    std::copy_n(origin.lower.begin(), 3, h.lower);
    std::copy_n(origin.upper.begin(), 3, h.upper);
    h.checksum = header_checksum(h, text);
    return h;
}

/// Keys that are the same but for supports, which may have shrunk.
bool continues(const Records& written, const Records& now) {
    if (written.size() > now.size()) return false;
    for (std::size_t i = 0; i < written.size(); ++i)
        if (now.keys[i].px != written.keys[i].px || now.keys[i].support1 > written.keys[i].support1 ||
            now.keys[i].support2 > written.keys[i].support2)
            return false;
    return true;
}

/// The file's header, once it is certain that it is whole and holds as much as `written`.
OpenFile check_file(const std::string& path, const RecordSet& written) {
    InputFile in(path);
    const OpenFile file = read_header(in);
    std::uint64_t counts[kView + 1] = {};
    while (in.at() < in.size()) {
        Block block{};
        if (const std::string wrong = next_block(in, file, block); !wrong.empty())
            throw Error(path + ": " + wrong + " from byte " + std::to_string(in.at()) + " on: nothing is appended");
        counts[block.kind] += block.count;
        in.skip(block.bytes);
    }
    if (!(file.origin == written.origin)) throw Error(path + ": holds records of another origin: nothing is appended");
    if (counts[kIrradiance] != written.irradiance.size() || counts[kRadiance] != written.radiance.size() ||
        counts[kView] != written.views.size())
        throw Error(path + ": holds " + std::to_string(counts[kIrradiance]) + " records and " +
                    std::to_string(counts[kRadiance]) + " radiance records, expected " +
                    std::to_string(written.irradiance.size()) + " and " + std::to_string(written.radiance.size()) +
                    ": it was changed meanwhile, nothing is appended");
    return file;
}

/// A file open to be appended to.
class Tail {
public:
    explicit Tail(const std::string& path) : path_(path), file_(::open(path.c_str(), O_WRONLY | O_APPEND | O_CLOEXEC)) {
        if (file_ < 0) fail();
    }
    ~Tail() { ::close(file_); }
    Tail(const Tail&) = delete;
    Tail& operator=(const Tail&) = delete;

    [[nodiscard]] std::uint64_t size() const { return static_cast<std::uint64_t>(::lseek(file_, 0, SEEK_END)); }
    void write(const void* data, std::size_t bytes) {
        const char* at = static_cast<const char*>(data);
        while (bytes > 0) {
            const ssize_t done = ::write(file_, at, bytes);
            if (done < 0 && errno == EINTR) continue;
            if (done < 0) fail();
            at += done;
            bytes -= static_cast<std::size_t>(done);
        }
    }
    void synchronise() {
        if (::fsync(file_) != 0) fail();
    }

private:
    [[noreturn]] void fail() const { throw Error(path_ + ": cannot be written: " + std::strerror(errno)); }
    std::string path_;
    int file_;
};

}  // namespace
}  // namespace records

void write_records(const std::string& path, const RecordSet& set) {
    using namespace records;
    check_records(path + ": not written", set);
    std::string text = settings_text(set.origin);
    if (text.size() > kLargestText) throw Error(path + ": not written: its settings are too long");
    const Header header = make_header(set.origin, text);
    AsideFile file(path);
    file.write(&header, sizeof header);
    file.write(text.data(), text.size());
    BlockWriter out([&](const void* data, std::size_t bytes) { file.write(data, bytes); }, header.checksum,
                    header.header_bytes);
    write_irradiance(out, set.irradiance, 0);
    write_radiance(out, set.radiance, 0);
    write_views(out, set.views, 0);
    file.commit();
}

void append_records(const std::string& path, const RecordSet& written, const RecordSet& now) {
    using namespace records;
    check_records(path + ": not appended to", now);
    if (!(written.origin == now.origin) || !continues(written.irradiance, now.irradiance) ||
        !continues(written.radiance, now.radiance) || written.views.size() > now.views.size() ||
        (written.radiance.size() > 0 &&
         (written.radiance.stride != now.radiance.stride || written.radiance.order != now.radiance.order)))
        throw Error(path + ": not appended to: the records do not continue those that it holds");
    const OpenFile file = check_file(path, written);
    Tail tail(path);
    BlockWriter out([&](const void* data, std::size_t bytes) { tail.write(data, bytes); }, file.header.checksum,
                    tail.size());
    // Supports last: a record that is not there yet must not have shrunk others.
    write_irradiance(out, now.irradiance, written.irradiance.size());
    write_radiance(out, now.radiance, written.radiance.size());
    write_shrunk(out, kIrradianceSupport, written.irradiance, now.irradiance);
    write_shrunk(out, kRadianceSupport, written.radiance, now.radiance);
    write_views(out, now.views, written.views.size());
    tail.synchronise();
}

}  // namespace irradia
