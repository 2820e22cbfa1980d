// Packed scenes: what is written is read back; what was damaged is refused.
#include "irradia/PackedScene.h"

#include <gtest/gtest.h>

#include <bit>
#include <cstring>
#include <random>
#include <string>
#include <vector>

#include "core/checksum.h"
#include "small_scene.h"

namespace {

using irradia::read_packed_scene;
using irradia::Scene;
using irradia::write_packed_scene;
using namespace irradia::test;

template <class T>
void expect_same(const std::vector<T>& a, const std::vector<T>& b, const char* what) {
    ASSERT_EQ(a.size(), b.size()) << what;
    if (!a.empty()) {
        EXPECT_EQ(std::memcmp(a.data(), b.data(), a.size() * sizeof(T)), 0) << what;
    }
}

void expect_same(const Scene& a, const Scene& b) {
    expect_same(a.vertices, b.vertices, "vertices");
    expect_same(a.triangles, b.triangles, "triangles");
    expect_same(a.analytics, b.analytics, "analytics");
    expect_same(a.materials, b.materials, "materials");
    expect_same(a.textures, b.textures, "textures");
    expect_same(a.texels, b.texels, "texels");
    expect_same(a.lights, b.lights, "lights");
    expect_same(a.accel.bvh8_nodes, b.accel.bvh8_nodes, "bvh8_nodes");
    expect_same(a.accel.bvh8_triangles, b.accel.bvh8_triangles, "bvh8_triangles");
    expect_same(a.accel.bvh2_nodes, b.accel.bvh2_nodes, "bvh2_nodes");
    expect_same(a.accel.bvh2_triangles, b.accel.bvh2_triangles, "bvh2_triangles");
    EXPECT_EQ(std::memcmp(&a.info, &b.info, sizeof a.info), 0);
    EXPECT_EQ(a.centre, b.centre);
    EXPECT_EQ(a.features, b.features);
    EXPECT_EQ(a.sample_count, b.sample_count);
    EXPECT_EQ(a.source, b.source);
}

// Offsets of the header and of a table entry, as src/core/packed_scene.cpp describes them.
constexpr std::size_t kHeader = 64, kEntry = 64, kByteOrderAt = 8, kVersionAt = 12, kFileBytesAt = 16, kCountAt = 24,
                      kChecksumAt = 32, kEntryOffsetAt = 24, kEntryBytesAt = 32, kEntryChecksumAt = 48;

template <class T>
T get(const std::string& bytes, std::size_t at) {
    T value;
    std::memcpy(&value, bytes.data() + at, sizeof value);
    return value;
}
template <class T>
void put(std::string& bytes, std::size_t at, T value) {
    std::memcpy(bytes.data() + at, &value, sizeof value);
}

/// Makes every checksum right again, as far as the table's ranges are within the file.
void forge_checksums(std::string& bytes) {
    const auto count = get<std::uint32_t>(bytes, kCountAt);
    for (std::size_t i = 0; i < count; ++i) {
        const std::size_t entry = kHeader + i * kEntry;
        const auto offset = get<std::uint64_t>(bytes, entry + kEntryOffsetAt),
                   n = get<std::uint64_t>(bytes, entry + kEntryBytesAt);
        if (offset <= bytes.size() && n <= bytes.size() - offset)
            put(bytes, entry + kEntryChecksumAt, irradia::checksum(bytes.data() + offset, n));
    }
    put<std::uint64_t>(bytes, kChecksumAt, 0);
    put(bytes, kChecksumAt,
        irradia::checksum(bytes.data() + kHeader, count * kEntry, irradia::checksum(bytes.data(), kHeader)));
}

class PackedScene : public ::testing::Test {
protected:
    TemporaryFolder folder;
    std::string path = folder.file("scene.irradia"), bytes;

    void SetUp() override {
        write_packed_scene(path, small_scene());
        bytes = read_file(path);
    }
    std::string refusal(const std::string& altered) {
        write_file(path, altered);
        const std::string message = error_of([&] { read_packed_scene(path); });
        EXPECT_TRUE(message.empty() || (one_line(message) && message.starts_with(path + ": "))) << message;
        return message;
    }
};

TEST_F(PackedScene, ReadsBackWhatWasWritten) {
    expect_same(read_packed_scene(path), small_scene());
    EXPECT_TRUE(irradia::is_packed_scene(path));
    EXPECT_EQ(folder.count(), 1u);  // nothing is left beside it
    write_packed_scene(path, read_packed_scene(path));
    EXPECT_EQ(read_file(path), bytes);
}

TEST_F(PackedScene, EmptyArraysSurvive) {
    Scene s = small_scene();
    s.textures.clear();
    s.texels.clear();
    s.materials[0].texture = IR_NO_TEXTURE;
    s.source.clear();
    write_packed_scene(path, s);
    expect_same(read_packed_scene(path), s);
}

TEST_F(PackedScene, OtherFilesAreNone) {
    EXPECT_FALSE(irradia::is_packed_scene(folder.file("missing")));
    EXPECT_FALSE(irradia::is_packed_scene(folder.path.string()));
    write_file(path, "<scene/>");
    EXPECT_FALSE(irradia::is_packed_scene(path));
    EXPECT_TRUE(has(refusal("<scene/>"), "not a packed scene"));
    EXPECT_TRUE(has(refusal(""), "not a packed scene"));
    EXPECT_TRUE(has(error_of([&] { read_packed_scene(folder.file("missing")); }), "cannot be read: No such file"));
    EXPECT_TRUE(has(error_of([&] { read_packed_scene(folder.path.string()); }), "no regular file"));
}

TEST_F(PackedScene, TruncationAnywhereIsRefused) {
    for (std::size_t n = 0; n < bytes.size(); n += n < 1200 ? 1 : 37) {
        const std::string message = refusal(bytes.substr(0, n));
        EXPECT_TRUE(has(message, n < 8 ? "not a packed scene" : "truncated")) << n << ": " << message;
    }
    EXPECT_TRUE(has(refusal(bytes + '\0'), "truncated or extended"));
}

TEST_F(PackedScene, EveryBitCounts) {
    std::mt19937 random(1);
    for (int i = 0; i < 4000; ++i) {
        std::string altered = bytes;
        const std::size_t flips = 1 + random() % 3;
        for (std::size_t k = 0; k < flips; ++k) {
            const std::size_t bit = random() % (bytes.size() * 8);
            altered[bit / 8] = static_cast<char>(altered[bit / 8] ^ (1 << bit % 8));
        }
        if (altered == bytes) continue;  // flipped there and back
        EXPECT_NE(refusal(altered), "") << "change " << i;
    }
    // The header and the table entirely.
    for (std::size_t bit = 0; bit < (kHeader + 14 * kEntry) * 8; ++bit) {
        std::string altered = bytes;
        altered[bit / 8] = static_cast<char>(altered[bit / 8] ^ (1 << bit % 8));
        EXPECT_NE(refusal(altered), "") << "bit " << bit;
    }
}

TEST_F(PackedScene, VersionAndByteOrder) {
    std::string altered = bytes;
    put<std::uint32_t>(altered, kVersionAt, 1);
    forge_checksums(altered);
    EXPECT_TRUE(has(refusal(altered), "version 1, expected 3"));
    altered = bytes;
    put<std::uint32_t>(altered, kByteOrderAt, 0x04030201u);
    EXPECT_TRUE(has(refusal(altered), "other byte order"));
    altered = bytes;
    put<std::uint32_t>(altered, kByteOrderAt, 0x01020305u);
    EXPECT_TRUE(has(refusal(altered), "byte order"));
}

// The checks behind the checksums: sizes that lie, to make the reader allocate or read too much.
TEST_F(PackedScene, ForgedTableIsRefused) {
    for (std::size_t section = 0; section < 14; ++section) {
        for (const std::uint64_t value :
             {std::uint64_t{1}, std::uint64_t{1} << 40, ~std::uint64_t{0}, ~std::uint64_t{63}}) {
            for (const std::size_t field : {kEntryOffsetAt, kEntryBytesAt}) {
                std::string altered = bytes;
                put(altered, kHeader + section * kEntry + field, value);
                forge_checksums(altered);
                EXPECT_TRUE(has(refusal(altered), "damaged packed scene")) << section << " " << field << " " << value;
            }
        }
    }
    std::string altered = bytes;
    put<std::uint32_t>(altered, kCountAt, 13);
    forge_checksums(altered);
    EXPECT_TRUE(has(refusal(altered), "13 sections"));
    altered = bytes;
    put<std::uint64_t>(altered, kFileBytesAt, bytes.size() + 64);
    forge_checksums(altered);
    EXPECT_TRUE(has(refusal(altered), "expected"));
}

// Random damage with the checksums made right: refused, or a scene that passes check_scene(); never a crash.
TEST_F(PackedScene, ForgedDamageIsRefusedOrHarmless) {
    std::mt19937 random(2);
    const std::size_t data = kHeader + 14 * kEntry;
    int refused = 0;
    for (int i = 0; i < 4000; ++i) {
        std::string altered = bytes;
        const std::size_t at = data + random() % (bytes.size() - data);
        if (i % 2 == 0)
            altered[at] = static_cast<char>(altered[at] ^ (1 << random() % 8));
        else
            put(altered, at / 4 * 4 < altered.size() - 4 ? at / 4 * 4 : at / 4 * 4 - 4,
                static_cast<std::uint32_t>(random()));
        forge_checksums(altered);
        const std::string message = refusal(altered);
        if (!message.empty()) {
            ++refused;
            continue;
        }
        const Scene s = read_packed_scene(path);
        for (const auto& t : s.triangles) ASSERT_LT(std::max({t.v0, t.v1, t.v2}), s.vertices.size());
    }
    EXPECT_GT(refused, 500);
}

TEST_F(PackedScene, InvalidSceneIsNotWritten) {
    Scene s = small_scene();
    s.triangles[1].v2 = 4;
    const std::string message = error_of([&] { write_packed_scene(folder.file("other"), s); });
    EXPECT_TRUE(one_line(message) && has(message, "other: not packed: triangle 1: vertex 4 is not below 4")) << message;
    EXPECT_EQ(folder.count(), 1u);
    s = small_scene();
    s.accel = {};
    EXPECT_TRUE(has(error_of([&] { write_packed_scene(path, s); }), "no acceleration structure"));
    EXPECT_EQ(read_file(path), bytes);  // the old file is untouched
}

TEST_F(PackedScene, UnwritablePathIsOneLine) {
    for (const std::string& where : {folder.file("no/folder/x"), folder.path.string(), std::string("/dev/null")}) {
        const std::string message = error_of([&] { write_packed_scene(where, small_scene()); });
        EXPECT_TRUE(one_line(message) && message.starts_with(where + ": cannot be written: ")) << message;
    }
    EXPECT_EQ(folder.count(), 1u);
}

TEST_F(PackedScene, SymbolicLinkIsFollowed) {
    const std::string link = folder.file("link");
    std::filesystem::create_symlink(path, link);
    Scene s = small_scene();
    s.sample_count = 3;
    write_packed_scene(link, s);
    EXPECT_TRUE(std::filesystem::is_symlink(link));
    EXPECT_EQ(read_packed_scene(path).sample_count, 3u);
}

}  // namespace
