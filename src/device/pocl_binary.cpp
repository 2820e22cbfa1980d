#include "device/pocl_binary.h"

#include <cstdint>
#include <cstring>
#include <optional>
#include <string>
#include <string_view>

namespace irradia::device {
namespace {

// Little-endian, without gaps:
//     8 bytes magic, 8 device, u32 format, u32 kernels, 8 flags, u32 files of the program itself
//     41 bytes: the folder of PoCL's cache that the files are put back to, "AB/CDEF...", with a 0 at the end
//     from format 10 on: u64 bytes of the program's variables
//     u64 bytes of the program's files, which follow: one, the LLVM code
//     for each kernel: u64 bytes of all this, u64 bytes of its files; u32; its name; its arguments; its files
// where a name is a u32 and so many characters, and a file a name (its path) and a u32 with so many bytes.
constexpr char magic[] = "poclbin";
constexpr std::uint32_t first_format = 9, last_format = 11, only_llvm_code = 1;  // of PoCL 3.1 to 5
constexpr std::size_t format_at = 16, kernels_at = 20, files_at = 32, folder_at = 36, folder_length = 41;
constexpr std::string_view code_name = "/program.bc";

/// Reads what lies at `at` and on; nothing once that is beyond the end.
class Reader {
public:
    Reader(const std::vector<unsigned char>& bytes, std::size_t at, std::size_t end)
        : bytes_(bytes), at_(at), end_(end) {}

    template <class T>
    std::optional<T> number() {
        T value;
        if (end_ - at_ < sizeof value) return std::nullopt;
        std::memcpy(&value, bytes_.data() + at_, sizeof value);
        at_ += sizeof value;
        return value;
    }
    std::optional<std::string_view> text() {
        const auto length = number<std::uint32_t>();
        if (!length || end_ - at_ < *length) return std::nullopt;
        const std::string_view found(reinterpret_cast<const char*>(bytes_.data()) + at_, *length);
        at_ += *length;
        return found;
    }
    [[nodiscard]] std::size_t at() const { return at_; }

private:
    const std::vector<unsigned char>& bytes_;
    std::size_t at_, end_;
};

template <class T>
T number_at(const std::vector<unsigned char>& bytes, std::size_t at) {
    T value;
    std::memcpy(&value, bytes.data() + at, sizeof value);
    return value;
}

/// Does the kernel that starts at `at` bring machine code for any group size? Its end, if so.
std::optional<std::size_t> kernel_end(const std::vector<unsigned char>& binary, std::size_t at) {
    Reader reader(binary, at, binary.size());
    const auto bytes = reader.number<std::uint64_t>(), of_files = reader.number<std::uint64_t>();
    if (!bytes || !of_files || *bytes > binary.size() - at || *of_files > *bytes) return std::nullopt;
    if (!reader.number<std::uint32_t>()) return std::nullopt;
    const auto name = reader.text();
    if (!name) return std::nullopt;
    const std::string wanted = "/" + std::string(*name) + "/0-0-0/" + std::string(*name) + ".so";
    const std::size_t end = at + static_cast<std::size_t>(*bytes);
    Reader files(binary, end - static_cast<std::size_t>(*of_files), end);
    for (bool found = false;;) {
        if (files.at() == end) return found ? std::optional(end) : std::nullopt;
        const auto path = files.text(), content = files.text();
        if (!path || !content) return std::nullopt;
        found = found || (*path == wanted && !content->empty());
    }
}

bool is_folder(std::string_view text) {
    if (text.back() != '\0') return false;
    for (std::size_t i = 0; i + 1 < text.size(); ++i)
        if (i == 2 ? text[i] != '/' : text[i] < 'A' || text[i] > 'P') return false;
    return true;
}

/// Where the size of the program's files is, of a binary that is known and has neither variables nor other files.
std::optional<std::size_t> sizes_place(const std::vector<unsigned char>& binary) {
    constexpr std::size_t at = folder_at + folder_length;
    if (binary.size() < at + 2 * sizeof(std::uint64_t) || std::memcmp(binary.data(), magic, sizeof magic) != 0 ||
        number_at<std::uint32_t>(binary, files_at) != only_llvm_code ||
        !is_folder({reinterpret_cast<const char*>(binary.data()) + folder_at, folder_length}))
        return std::nullopt;
    const auto format = number_at<std::uint32_t>(binary, format_at);
    if (format < first_format || format > last_format) return std::nullopt;
    if (format == first_format) return at;
    if (number_at<std::uint64_t>(binary, at) != 0) return std::nullopt;
    return at + sizeof(std::uint64_t);
}

}  // namespace

std::vector<unsigned char> without_llvm_code(std::vector<unsigned char> binary) {
    const std::optional<std::size_t> sizes_at = sizes_place(binary);
    if (!sizes_at) return binary;
    const std::size_t code_at = *sizes_at + sizeof(std::uint64_t);
    Reader reader(binary, code_at, binary.size());
    const auto name = reader.text(), code = reader.text();
    if (!name || !code || *name != code_name || code->empty()) return binary;
    const std::size_t code_end = reader.at();
    if (number_at<std::uint64_t>(binary, *sizes_at) != code_end - code_at) return binary;
    std::size_t end = code_end;
    for (std::uint32_t left = number_at<std::uint32_t>(binary, kernels_at); left > 0; --left) {
        const auto next = kernel_end(binary, end);
        if (!next) return binary;
        end = *next;
    }
    if (end != binary.size()) return binary;

    // A file of another name and one byte, as there must be one, in a folder of its own: where the program was compiled
    // PoCL's has the code.
    const std::size_t last = code_at + sizeof(std::uint32_t) + code_name.size() - 1;
    binary[last] = 'x';
    binary[folder_at + 3] = binary[folder_at + 3] == 'P' ? 'A' : static_cast<unsigned char>(binary[folder_at + 3] + 1);
    const std::uint32_t one = 1;
    std::memcpy(binary.data() + last + 1, &one, sizeof one);
    const std::size_t content = last + 1 + sizeof one;
    const std::uint64_t bytes = content + one - code_at;
    std::memcpy(binary.data() + *sizes_at, &bytes, sizeof bytes);
    binary.erase(binary.begin() + static_cast<std::ptrdiff_t>(content + one),
                 binary.begin() + static_cast<std::ptrdiff_t>(code_end));
    return binary;
}

}  // namespace irradia::device
