// The format, version 3. All numbers in the byte order of the machine that wrote the file; the mark tells which.
//
//   offset  bytes  header
//        0      8  magic: 0x89 "IRSCN" CR LF
//        8      4  byte order mark: the number 0x01020304
//       12      4  version
//       16      8  bytes of the whole file
//       24      4  number of sections
//       28      4  bytes of a section's entry (64)
//       32      8  checksum (checksum.h) of header and table, with this field zero
//       40     24  zero
//       64         table: an entry a section
//                    24  name, padded with zeros
//                     8  offset in the file, a multiple of 64
//                     8  bytes
//                     4  bytes of one element
//                     4  zero
//                     8  checksum of the section's bytes
//                     8  zero
//
// The sections follow in the order of for_each_section(), each at the next multiple of 64 after the one before it, the
// gaps zero, nothing after the last. An element is the struct of include/irradia/shared/scene_types.h as it lies in
// memory. When one of them changes its layout or meaning, kVersion has to change.
#include <fcntl.h>
#include <unistd.h>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <limits>
#include <string>
#include <type_traits>
#include <vector>

#include "core/aside_file.h"
#include "core/checksum.h"
#include "core/input_file.h"
#include "irradia/Error.h"
#include "irradia/PackedScene.h"

namespace irradia {
namespace {

constexpr char kMagic[8] = {'\x89', 'I', 'R', 'S', 'C', 'N', '\r', '\n'};
constexpr std::uint32_t kByteOrder = 0x01020304u, kOtherByteOrder = 0x04030201u;
constexpr std::uint32_t kVersion = 3;
constexpr std::uint64_t kAlignment = 64;

struct Header {
    char magic[8];
    std::uint32_t byte_order, version;
    std::uint64_t file_bytes;
    std::uint32_t section_count, entry_bytes;
    std::uint64_t checksum;
    std::uint64_t zero[3];
};
struct Entry {
    char name[24];
    std::uint64_t offset, bytes;
    std::uint32_t element_bytes, zero0;
    std::uint64_t checksum, zero1;
};
static_assert(sizeof(Header) == 64 && sizeof(Entry) == 64);

/// What Scene holds besides its arrays.
struct Settings {
    double centre[3];
    std::uint32_t features, sample_count;
};
static_assert(sizeof(Settings) == 32);

/// The scene as arrays alone.
struct Extra {
    std::vector<shared::SceneInfo> info;
    std::vector<Settings> settings;
    std::vector<char> source;
};

/// Calls f(name, array) for every section, in the file's order.
template <class S, class E, class F>
void for_each_section(S& scene, E& extra, F&& f) {
    f("settings", extra.settings);
    f("source", extra.source);
    f("info", extra.info);
    f("vertices", scene.vertices);
    f("triangles", scene.triangles);
    f("analytics", scene.analytics);
    f("materials", scene.materials);
    f("textures", scene.textures);
    f("texels", scene.texels);
    f("lights", scene.lights);
    f("bvh8_nodes", scene.accel.bvh8_nodes);
    f("bvh8_triangles", scene.accel.bvh8_triangles);
    f("bvh2_nodes", scene.accel.bvh2_nodes);
    f("bvh2_triangles", scene.accel.bvh2_triangles);
}

std::uint64_t aligned(std::uint64_t offset) { return (offset + kAlignment - 1) / kAlignment * kAlignment; }

std::uint64_t header_checksum(Header header, const std::vector<Entry>& table) {
    header.checksum = 0;
    return checksum(table.data(), table.size() * sizeof(Entry), checksum(&header, sizeof header));
}

[[noreturn]] void damaged(const std::string& path, const std::string& what) {
    throw Error(path + ": damaged packed scene: " + what);
}

/// The header, once it is certain that the file is a whole one of this version.
Header read_header(const std::string& path, InputFile& in) {
    Header header{};
    const std::uint64_t bytes = std::min<std::uint64_t>(in.size(), sizeof header);
    in.read(&header, bytes);
    if (bytes < sizeof kMagic || std::memcmp(header.magic, kMagic, sizeof kMagic) != 0)
        throw Error(path + ": not a packed scene");
    if (bytes < sizeof header)
        throw Error(path + ": truncated: " + std::to_string(in.size()) + " bytes, the header alone has " +
                    std::to_string(sizeof header));
    if (header.byte_order == kOtherByteOrder)
        throw Error(path + ": packed on a machine of the other byte order: pack the scene again on one like this");
    if (header.byte_order != kByteOrder) damaged(path, "no byte order mark");
    if (header.version != kVersion)
        throw Error(path + ": packed scene of version " + std::to_string(header.version) + ", expected " +
                    std::to_string(kVersion) + ": pack the scene again");
    if (header.file_bytes != in.size())
        throw Error(path + ": truncated or extended: " + std::to_string(in.size()) + " bytes, expected " +
                    std::to_string(header.file_bytes));
    return header;
}

std::vector<Entry> read_table(const std::string& path, InputFile& in, const Header& header, std::size_t section_count) {
    if (header.section_count != section_count || header.entry_bytes != sizeof(Entry))
        damaged(path, std::to_string(header.section_count) + " sections, expected " + std::to_string(section_count));
    std::vector<Entry> table(section_count);
    if (in.size() < sizeof header + table.size() * sizeof(Entry)) damaged(path, "no room for the table of sections");
    in.read(table.data(), table.size() * sizeof(Entry));
    if (header_checksum(header, table) != header.checksum) damaged(path, "checksum of the header does not match");
    return table;
}

}  // namespace

bool is_packed_scene(const std::string& path) {
    const int file = ::open(path.c_str(), O_RDONLY | O_CLOEXEC);
    if (file < 0) return false;
    char magic[sizeof kMagic] = {};
    const ssize_t done = ::read(file, magic, sizeof magic);
    ::close(file);
    return done == static_cast<ssize_t>(sizeof magic) && std::memcmp(magic, kMagic, sizeof magic) == 0;
}

void write_packed_scene(const std::string& path, const Scene& scene) {
    check_scene(path + ": not packed", scene);
    Extra extra;
    extra.info = {scene.info};
    extra.settings = {{{scene.centre[0], scene.centre[1], scene.centre[2]}, scene.features, scene.sample_count}};
    extra.source.assign(scene.source.begin(), scene.source.end());

    std::vector<Entry> table;
    for_each_section(scene, extra, [&](const char* name, const auto& array) {
        Entry e{};
        std::strncpy(e.name, name, sizeof e.name - 1);
        e.element_bytes = sizeof(array[0]);
        e.bytes = array.size() * sizeof(array[0]);
        e.checksum = checksum(array.data(), e.bytes);
        table.push_back(e);
    });
    std::uint64_t end = sizeof(Header) + table.size() * sizeof(Entry);
    for (Entry& e : table) {
        e.offset = aligned(end);
        end = e.offset + e.bytes;
    }
    Header header{};
    std::memcpy(header.magic, kMagic, sizeof kMagic);
    header.byte_order = kByteOrder;
    header.version = kVersion;
    header.file_bytes = end;
    header.section_count = static_cast<std::uint32_t>(table.size());
    header.entry_bytes = sizeof(Entry);
    header.checksum = header_checksum(header, table);

    AsideFile out(path);
    out.write(&header, sizeof header);
    out.write(table.data(), table.size() * sizeof(Entry));
    std::uint64_t at = sizeof header + table.size() * sizeof(Entry);
    std::size_t section = 0;
    for_each_section(scene, extra, [&](const char*, const auto& array) {
        const Entry& e = table[section++];
        const char zeros[kAlignment] = {};
        out.write(zeros, static_cast<std::size_t>(e.offset - at));
        out.write(array.data(), static_cast<std::size_t>(e.bytes));
        at = e.offset + e.bytes;
    });
    out.commit();
}

Scene read_packed_scene(const std::string& path) {
    InputFile in(path);
    const Header header = read_header(path, in);
    Scene scene;
    Extra extra;
    std::size_t section_count = 0;
    for_each_section(scene, extra, [&](const char*, const auto&) { ++section_count; });
    const std::vector<Entry> table = read_table(path, in, header, section_count);

    std::uint64_t at = sizeof header + table.size() * sizeof(Entry);
    std::size_t section = 0;
    for_each_section(scene, extra, [&](const char* name, auto& array) {
        using Element = typename std::remove_reference_t<decltype(array)>::value_type;
        const Entry& e = table[section++];
        char expected[sizeof e.name] = {};
        std::strncpy(expected, name, sizeof expected - 1);
        if (std::memcmp(e.name, expected, sizeof expected) != 0)
            damaged(path, std::string("section '") + name + "' is missing");
        const std::string what = std::string("section '") + name + "'";
        if (e.element_bytes != sizeof(Element) || e.bytes % sizeof(Element) != 0)
            damaged(path, what + " has elements of another size");
        // In order, without overlaps and within the file: so all sections together cannot exceed the file's size.
        if (e.offset != aligned(at) || e.offset > in.size() || e.bytes > in.size() - e.offset)
            damaged(path, what + " is out of place");
        char gap[kAlignment] = {};
        in.read(gap, e.offset - at);
        if (std::any_of(gap, gap + sizeof gap, [](char c) { return c != 0; }))
            damaged(path, "the gap before " + what + " is not empty");
        array.resize(static_cast<std::size_t>(e.bytes / sizeof(Element)));
        in.read(array.data(), e.bytes);
        if (checksum(array.data(), static_cast<std::size_t>(e.bytes)) != e.checksum)
            damaged(path, "checksum of " + what + " does not match");
        at = e.offset + e.bytes;
    });
    if (at != in.size()) damaged(path, "something follows the last section");
    if (extra.info.size() != 1 || extra.settings.size() != 1)
        damaged(path, "sections 'info' and 'settings' hold " + std::to_string(extra.info.size()) + " and " +
                          std::to_string(extra.settings.size()) + " elements, expected one each");

    const Settings& s = extra.settings[0];
    scene.info = extra.info[0];
    scene.centre = {s.centre[0], s.centre[1], s.centre[2]};
    scene.features = s.features;
    scene.sample_count = s.sample_count;
    scene.source.assign(extra.source.begin(), extra.source.end());
    check_scene(path, scene);
    return scene;
}

}  // namespace irradia
