// Mitsuba's .serialized files, versions 3 and 4: zlib streams, a mesh each, and where they begin at the end of the
// file.
#include <fmt/format.h>
#include <zlib.h>

#include <bit>
#include <cstring>

#include "scene/build.h"

namespace irradia::loader {
namespace {

static_assert(std::endian::native == std::endian::little, "the files are little endian and are read as they stand");

constexpr std::uint16_t kMagic = 0x041c;
constexpr std::uint32_t kNormals = 0x1, kUvs = 0x2, kColours = 0x8, kDouble = 0x2000;
constexpr std::uint64_t kMostCompression = 1032;  // of deflate: a bound on what a file can hold

class SerializedReader {
public:
    SerializedReader(const std::string& path, long long index) : path_(path), file_(read_file(path)) {
        const std::size_t begin = find(index);
        version_ = header(begin);
        stream_.next_in = reinterpret_cast<Bytef*>(file_.data() + begin + 4);
        left_ = file_.size() - begin - 4;
        if (inflateInit(&stream_) != Z_OK) throw std::bad_alloc();
    }
    SerializedReader(const SerializedReader&) = delete;
    SerializedReader& operator=(const SerializedReader&) = delete;
    ~SerializedReader() { inflateEnd(&stream_); }

    Mesh read(bool colours) {
        const auto flags = value<std::uint32_t>();
        if (version_ >= 4)
            while (value<char>() != '\0') {
            }  // the mesh's name
        const auto vertices = value<std::uint64_t>(), triangles = value<std::uint64_t>();
        const std::uint64_t scalar = flags & kDouble ? sizeof(double) : sizeof(float);
        const std::uint64_t scalars =
            3 + (flags & kNormals ? 3 : 0) + (flags & kUvs ? 2 : 0) + (flags & kColours ? 3 : 0);
        const std::uint64_t most = (file_.size() + 64) * kMostCompression;
        if (vertices > 0xffffffffu || vertices > most / (scalars * scalar) || triangles > most / 12)
            bad(fmt::format("announces {} vertices and {} triangles, more than it can hold", vertices, triangles));
        Mesh mesh;
        numbers(mesh.positions, vertices, scalar);
        if (flags & kNormals) numbers(mesh.normals, vertices, scalar);
        if (flags & kUvs) numbers(mesh.uvs, vertices, scalar);
        if (flags & kColours) numbers(mesh.colours, vertices, scalar);
        if (!colours) mesh.colours = {};
        mesh.triangles = fetch<std::array<std::uint32_t, 3>>(triangles);
        return mesh;
    }

private:
    std::string path_, file_;
    z_stream stream_{};
    std::size_t left_ = 0;  // bytes of the file not handed to zlib yet: it counts in 32 bits
    std::uint16_t version_ = 0;

    [[noreturn]] void bad(const std::string& message) const {
        throw Error(fmt::format("mesh '{}' {}", path_, message));
    }

    template <class T>
    T in_file(std::size_t at) const {
        if (at > file_.size() || file_.size() - at < sizeof(T)) bad("is truncated");
        T v;
        std::memcpy(&v, file_.data() + at, sizeof(T));
        return v;
    }

    std::uint16_t header(std::size_t at) const {
        const auto magic = in_file<std::uint16_t>(at), version = in_file<std::uint16_t>(at + 2);
        if (magic != kMagic) bad("is not a serialized mesh");
        if (version != 3 && version != 4) bad(fmt::format("has version {}; 3 or 4 was expected", version));
        return version;
    }

    /// Where mesh `index` begins. The last four bytes say how many there are, before them lie the offsets: 64 bits each
    /// from version 4 on, otherwise 32.
    std::size_t find(long long index) const {
        const std::uint16_t version = header(0);
        if (index == 0) return 0;
        const std::size_t size = version >= 4 ? sizeof(std::uint64_t) : sizeof(std::uint32_t);
        if (file_.size() < 4) bad("is truncated");
        const auto count = in_file<std::uint32_t>(file_.size() - 4);
        if (index < 0 || index >= count)
            bad(fmt::format("holds {} meshes; shape_index is {}, counted from 0", count, index));
        if (count > (file_.size() - 4) / size) bad("is truncated: the table of its meshes is incomplete");
        const std::size_t at = file_.size() - 4 - size * (count - static_cast<std::size_t>(index));
        const std::uint64_t begin = version >= 4 ? in_file<std::uint64_t>(at) : in_file<std::uint32_t>(at);
        if (begin >= file_.size()) bad(fmt::format("has mesh {} beyond its end", index));
        return begin;
    }

    void inflate_to(void* to, std::size_t bytes) {
        stream_.next_out = static_cast<Bytef*>(to);
        while (bytes > 0) {
            if (stream_.avail_in == 0) {
                stream_.avail_in = static_cast<uInt>(std::min<std::size_t>(left_, 1u << 30));
                left_ -= stream_.avail_in;
            }
            const auto room = static_cast<uInt>(std::min<std::size_t>(bytes, 1u << 30));
            stream_.avail_out = room;
            const int status = inflate(&stream_, Z_NO_FLUSH);
            bytes -= room - stream_.avail_out;
            if (bytes == 0) return;
            if (status == Z_STREAM_END || status == Z_BUF_ERROR) bad("is truncated");
            if (status != Z_OK) bad("is damaged: it cannot be decompressed");
        }
    }
    template <class T>
    T value() {
        T v;
        inflate_to(&v, sizeof v);
        return v;
    }
    /// Grows with what is really there, so that a false count costs no memory.
    template <class T>
    std::vector<T> fetch(std::uint64_t count) {
        std::vector<T> out;
        constexpr std::size_t kAtOnce = std::size_t{1} << 20;
        while (out.size() < count) {
            const std::size_t from = out.size(), more = std::min<std::size_t>(count - from, std::max(kAtOnce, from));
            out.resize(from + more);
            inflate_to(out.data() + from, more * sizeof(T));
        }
        return out;
    }
    template <class Vector>
    void numbers(std::vector<Vector>& out, std::uint64_t count, std::uint64_t scalar) {
        using Scalar = typename Vector::value_type;
        constexpr int kSize = Vector::length();
        const auto convert = [&](const auto& in) {
            out.resize(count);
            for (std::size_t i = 0; i < count; ++i)
                for (int k = 0; k < kSize; ++k) out[i][k] = static_cast<Scalar>(in[i][k]);
        };
        if (scalar == sizeof(double))
            convert(fetch<glm::vec<kSize, double>>(count));
        else
            convert(fetch<glm::vec<kSize, float>>(count));
    }
};

}  // namespace

Mesh read_serialized(const std::string& path, long long index, bool colours) {
    return SerializedReader(path, index).read(colours);
}

}  // namespace irradia::loader
