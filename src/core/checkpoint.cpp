#include <algorithm>
#include <cstring>

#include "core/aside_file.h"
#include "core/checksum.h"
#include "core/input_file.h"
#include "core/one_line.h"
#include "irradia/Checkpoint.h"
#include "irradia/Error.h"

namespace irradia {
namespace {

struct Header {
    char magic[8] = {'\x89', 'I', 'R', 'C', 'H', 'K', '\r', '\n'};
    std::uint32_t byte_order = 0x01020304;
    std::uint32_t version = 8;  ///< to be raised whenever any object exchanges something else
};
/// Ends the file: of all bytes before it.
struct Trailer {
    std::uint64_t bytes = 0, checksum = 0;
};
constexpr std::size_t block = std::size_t{1} << 20;  // bytes of a step of the checksum

}  // namespace

struct Checkpoint::Impl {
    std::string path;
    std::unique_ptr<AsideFile> out;
    std::unique_ptr<InputFile> in;
    std::uint64_t end = 0;  // of what is read, less the trailer
    std::vector<char> buffer;
    Trailer trailer;

    void flush() {
        if (buffer.empty()) return;
        trailer.checksum = checksum(buffer.data(), buffer.size(), trailer.checksum);
        trailer.bytes += buffer.size();
        out->write(buffer.data(), buffer.size());
        buffer.clear();
    }
    [[noreturn]] void damaged(const std::string& what) const { throw Error(path + ": damaged checkpoint: " + what); }
    /// All of it, before any of it is used.
    void verify() {
        const Header expected;
        Header header;
        if (in->size() < sizeof header) throw Error(path + ": is no checkpoint");
        in->read(&header, sizeof header);
        if (std::memcmp(header.magic, expected.magic, sizeof header.magic) != 0)
            throw Error(path + ": is no checkpoint");
        if (header.byte_order != expected.byte_order)
            throw Error(path + ": checkpoint of a machine of other byte order");
        if (header.version != expected.version)
            throw Error(path + ": checkpoint of version " + std::to_string(header.version) + ", expected " +
                        std::to_string(expected.version));
        if (in->size() < sizeof header + sizeof(Trailer)) damaged("it is cut off");
        end = in->size() - sizeof(Trailer);
        InputFile whole(path);
        Trailer found, given;
        std::vector<char> bytes(block);
        while (whole.at() < end) {
            const std::uint64_t n = std::min<std::uint64_t>(block, end - whole.at());
            whole.read(bytes.data(), n);
            found.checksum = checksum(bytes.data(), static_cast<std::size_t>(n), found.checksum);
            found.bytes += n;
        }
        whole.read(&given, sizeof given);
        if (found.bytes != given.bytes || found.checksum != given.checksum)
            damaged("its checksum is not that of its bytes");
    }
};

Checkpoint::Checkpoint(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
Checkpoint::Checkpoint(Checkpoint&&) noexcept = default;
Checkpoint::~Checkpoint() = default;

Checkpoint Checkpoint::write(const std::string& path, const CheckpointIdentity& identity) {
    auto impl = std::make_unique<Impl>();
    impl->path = path;
    impl->out = std::make_unique<AsideFile>(path);
    impl->buffer.reserve(block);
    Checkpoint out(std::move(impl));
    Header header;
    out(header);
    std::vector<std::string> words;
    for (const auto& [name, value] : identity) words.insert(words.end(), {name, value});
    out(words);
    return out;
}

Checkpoint Checkpoint::read(const std::string& path, const CheckpointIdentity& identity) {
    auto impl = std::make_unique<Impl>();
    impl->path = path;
    impl->in = std::make_unique<InputFile>(path);
    impl->verify();
    Checkpoint in(std::move(impl));
    std::vector<std::string> words;
    in(words);
    std::map<std::string, std::string> found;
    for (std::size_t i = 0; i + 1 < words.size(); i += 2) found[words[i]] = words[i + 1];
    std::string what;
    for (const auto& [name, value] : identity) {
        const auto there = found.find(name);
        if (there != found.end() && there->second == value) continue;
        what += (what.empty() ? "" : "; ") + name + " was " + (there == found.end() ? "not known" : there->second) +
                ", is " + value;
    }
    if (what.empty() && found.size() != identity.size()) what = "it was made with options that are not given";
    if (!what.empty())
        throw Error(path + ": checkpoint of another render: " + one_line(what) + " (remove it to begin anew)");
    return in;
}

bool Checkpoint::reading() const noexcept { return impl_->in != nullptr; }

void Checkpoint::bytes(void* data, std::uint64_t size) {
    if (reading()) {
        if (size > impl_->end - impl_->in->at()) impl_->damaged("it ends too early");
        impl_->in->read(data, size);
        return;
    }
    const char* from = static_cast<const char*>(data);
    while (size > 0) {
        const std::size_t n = static_cast<std::size_t>(std::min<std::uint64_t>(size, block - impl_->buffer.size()));
        impl_->buffer.insert(impl_->buffer.end(), from, from + n);
        if (impl_->buffer.size() == block) impl_->flush();
        from += n;
        size -= n;
    }
}

std::uint64_t Checkpoint::count(std::uint64_t n, std::uint64_t size) {
    (*this)(n);
    if (reading() && n > (impl_->end - impl_->in->at()) / size) impl_->damaged("it ends too early");
    return n;
}

Checkpoint& Checkpoint::operator()(std::string& text) {
    const std::uint64_t n = count(text.size(), 1);
    if (reading()) text.resize(static_cast<std::size_t>(n));
    bytes(text.data(), n);
    return *this;
}

void Checkpoint::finish() {
    if (reading()) {
        if (impl_->in->at() != impl_->end) impl_->damaged("it holds more than it should");
        return;
    }
    impl_->flush();
    impl_->out->write(&impl_->trailer, sizeof impl_->trailer);
    impl_->out->commit();
}

}  // namespace irradia
