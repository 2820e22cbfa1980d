#include "scene/picture_check.h"

#include <fmt/format.h>
#include <zlib.h>

#include <algorithm>
#include <bit>
#include <cctype>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <vector>

#include "irradia/Error.h"

namespace irradia::loader {
namespace {

// Deflate packs at most 1032 bytes into one; other compressions of pictures stay below that too, but for a constant
// picture in JPEG. A small picture is no danger whatever its file.
constexpr std::uint64_t kMostCompression = 2048, kSmall = std::uint64_t{64} << 20;

std::uint32_t big_endian(const unsigned char* p) {
    return static_cast<std::uint32_t>(p[0]) << 24 | static_cast<std::uint32_t>(p[1]) << 16 |
           static_cast<std::uint32_t>(p[2]) << 8 | static_cast<std::uint32_t>(p[3]);
}

/// A file that is read from front to back; every function throws if it ends.
class Front {
public:
    explicit Front(const std::string& path) : path_(path), file_(path, std::ios::binary) {
        std::error_code ignored;
        const std::uintmax_t size = std::filesystem::file_size(path, ignored);
        left_ = ignored ? 0 : size;
    }
    [[noreturn]] void bad(const std::string& what) const {
        throw Error(fmt::format("texture '{}' cannot be read: {}", path_, what));
    }
    [[nodiscard]] std::uintmax_t left() const { return left_; }
    /// Without complaint: false if the file is too short.
    bool try_read(void* to, std::size_t bytes) {
        if (bytes > left_ || !file_.read(static_cast<char*>(to), static_cast<std::streamsize>(bytes))) return false;
        left_ -= bytes;
        return true;
    }
    void read(void* to, std::size_t bytes) {
        if (!try_read(to, bytes)) bad("it is truncated");
    }
    void skip(std::size_t bytes) {
        if (bytes > left_ || !file_.seekg(static_cast<std::streamoff>(bytes), std::ios::cur)) bad("it is truncated");
        left_ -= bytes;
    }

private:
    const std::string& path_;
    std::ifstream file_;
    std::uintmax_t left_;
};

/// Every chunk as its checksum says, up to the last one.
void check_png(Front& file) {
    static const unsigned char rest_of_signature[4] = {'\r', '\n', 0x1a, '\n'};
    unsigned char head[8];
    file.read(head, 4);
    if (std::memcmp(head, rest_of_signature, 4) != 0) file.bad("the signature of a PNG file is damaged");
    std::vector<unsigned char> buffer(1 << 14);
    for (bool end = false; !end;) {
        file.read(head, sizeof head);
        end = std::memcmp(head + 4, "IEND", 4) == 0;
        uLong sum = crc32(crc32(0, nullptr, 0), head + 4, 4);
        std::uint32_t left = big_endian(head);
        if (left > file.left()) file.bad("it is truncated");
        while (left > 0) {
            const auto bytes = std::min<std::size_t>(left, buffer.size());
            file.read(buffer.data(), bytes);
            sum = crc32(sum, buffer.data(), static_cast<uInt>(bytes));
            left -= static_cast<std::uint32_t>(bytes);
        }
        file.read(buffer.data(), 4);
        if (big_endian(buffer.data()) == sum) continue;
        std::string name(reinterpret_cast<const char*>(head + 4), 4);
        for (char& c : name)
            if (!std::isalnum(static_cast<unsigned char>(c))) c = '?';
        file.bad(fmt::format("its chunk {} is damaged", name));
    }
}

/// No attribute of the headers is larger than what is left of the file (OpenEXR allocates what it reads there), no data
/// window larger than its pixels could be.
void check_exr(const std::string& path, Front& file) {
    std::uint32_t version = 0;
    file.read(&version, sizeof version);
    const bool several = (version & 0x1000u) != 0;  // headers, the last one empty
    const auto text = [&] {
        std::string out;
        for (char c = 1; c != '\0';) {
            file.read(&c, 1);
            if (c != '\0') out += c;
            if (out.size() > 255) file.bad("its header is damaged");
        }
        return out;
    };
    for (bool first_of_header = true;;) {
        const std::string name = text();
        if (name.empty()) {
            if (!several || first_of_header) return;
            first_of_header = true;
            continue;
        }
        first_of_header = false;
        const std::string type = text();
        std::int32_t size = 0;
        file.read(&size, sizeof size);
        if (size < 0 || static_cast<std::uintmax_t>(size) > file.left()) file.bad("its header is damaged");
        std::int32_t box[4];
        if (type != "box2i" || size != sizeof box) {
            file.skip(static_cast<std::size_t>(size));
            continue;
        }
        file.read(box, sizeof box);
        const std::int64_t width = std::int64_t{box[2]} - box[0] + 1, height = std::int64_t{box[3]} - box[1] + 1;
        constexpr std::int64_t kMost = 0x7fffffff;
        if (name == "dataWindow")
            check_picture_size(path, static_cast<int>(std::clamp<std::int64_t>(width, 0, kMost)),
                               static_cast<int>(std::clamp<std::int64_t>(height, 0, kMost)), 1, 2);
    }
}

}  // namespace

void check_picture_file(const std::string& path) {
    static_assert(std::endian::native == std::endian::little, "EXR files are, and are read as they stand");
    static const unsigned char png[4] = {0x89, 'P', 'N', 'G'}, exr[4] = {0x76, 0x2f, 0x31, 0x01};
    Front file(path);
    unsigned char head[4];
    if (!file.try_read(head, sizeof head)) return;
    if (std::memcmp(head, png, sizeof head) == 0) check_png(file);
    if (std::memcmp(head, exr, sizeof head) == 0) check_exr(path, file);
}

void check_picture_size(const std::string& path, int width, int height, int channels, std::size_t bytes_a_channel) {
    std::error_code ignored;
    const std::uintmax_t size = std::filesystem::file_size(path, ignored);
    if (ignored || width < 1 || height < 1 || channels < 1) return;  // others say what is wrong then
    const double bytes = static_cast<double>(width) * height * channels * static_cast<double>(bytes_a_channel);
    if (bytes <= static_cast<double>(kSmall) || bytes <= static_cast<double>(size) * kMostCompression) return;
    throw Error(
        fmt::format("texture '{}' cannot be read: it announces {} x {} pixels of {} channels in a file of {} bytes",
                    path, width, height, channels, size));
}

}  // namespace irradia::loader
