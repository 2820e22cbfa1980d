// Damaged record files: refused, or recovered to records that were written; never others, never a crash.
#include <gtest/gtest.h>

#include <algorithm>
#include <functional>
#include <random>

#include "records/record_input.h"
#include "some_records.h"

namespace irradia::test {
namespace {

using records::Block;
using records::Header;

/// A file of several appends, the states that it went through, and where its blocks begin.
class DamagedRecords : public ::testing::Test {
protected:
    void SetUp() override {
        RecordSet set = some_records(40, 6);
        write_records(path_, set);
        for (int round = 0; round < 3; ++round) {
            const RecordSet written = set;
            add_records(set.irradiance, 30, 11);
            add_radiance(set.radiance, 4, 13);
            set.irradiance.keys[5].support1 *= 0.9f;
            set.radiance.keys[2].support1 *= 0.9f;
            append_records(path_, written, set);
        }
        whole_ = set;
        bytes_ = read_file(path_);
        std::memcpy(&header_, bytes_.data(), sizeof header_);
        for (std::size_t at = header_.header_bytes; at < bytes_.size();) {
            begins_.push_back(at);
            Block block{};
            std::memcpy(&block, bytes_.data() + at, sizeof block);
            at += sizeof block + block.bytes;
        }
        ASSERT_GE(begins_.size(), 13u);
        for (const std::size_t begin : begins_) {
            write_file(path_, bytes_.substr(0, begin));
            states_.push_back(read_records(path_));
        }
        states_.push_back(whole_);
    }

    /// Is it what the file held after some number of blocks?
    [[nodiscard]] bool is_state(const RecordSet& set) const {
        return std::any_of(states_.begin(), states_.end(), [&](const RecordSet& s) { return same(s, set); });
    }

    /// Reads `bytes` as a file.
    std::string read(const std::string& bytes, RecordSet& set, std::string& warning) {
        write_file(path_, bytes);
        return error_of([&] { set = read_records(path_, &warning); });
    }

    /// A block replaced by one of the same place, with right checksums.
    std::string forged(std::size_t block, const std::function<void(Block&, std::string&)>& change) const {
        const std::size_t at = begins_[block];
        Block b{};
        std::memcpy(&b, bytes_.data() + at, sizeof b);
        std::string payload = bytes_.substr(at + sizeof b, b.bytes);
        const std::size_t end = at + sizeof b + b.bytes;
        change(b, payload);
        const std::uint64_t seed = records::block_seed(header_.checksum, at);
        b.checksum = checksum(payload.data(), payload.size(), seed);
        b.own_checksum = records::own_checksum(b, seed);
        return bytes_.substr(0, at) + std::string(reinterpret_cast<const char*>(&b), sizeof b) + payload +
               bytes_.substr(end);
    }

    TemporaryFolder folder_;
    std::string path_ = folder_.file("a.records");
    RecordSet whole_;
    std::vector<RecordSet> states_;
    std::string bytes_;
    Header header_{};
    std::vector<std::size_t> begins_;
};

TEST_F(DamagedRecords, CutOffTailCostsItsLastBlockAlone) {
    std::size_t known = 0;
    for (std::size_t b = 0; b < begins_.size(); ++b) {
        const std::size_t begin = begins_[b], end = b + 1 < begins_.size() ? begins_[b + 1] : bytes_.size();
        RecordSet set;
        std::string warning;
        // At the boundary: nothing tells that there was more.
        EXPECT_EQ(read(bytes_.substr(0, begin), set, warning), "");
        EXPECT_EQ(warning, "");
        EXPECT_TRUE(is_state(set));
        const std::size_t kept = set.irradiance.size() + set.radiance.size();
        EXPECT_TRUE(same(set, states_[b]));
        EXPECT_GE(kept, known);
        known = kept;
        for (const std::size_t cut : {begin + 1, begin + 39, begin + 40, begin + 41, (begin + end) / 2, end - 1}) {
            EXPECT_EQ(read(bytes_.substr(0, cut), set, warning), "");
            EXPECT_TRUE(one_line(warning) && has(warning, "cut off from byte " + std::to_string(begin))) << warning;
            EXPECT_TRUE(has(warning, std::to_string(set.irradiance.size()) + " records and"));
            EXPECT_TRUE(is_state(set));
            EXPECT_EQ(set.irradiance.size() + set.radiance.size(), kept);
            // Without a place for the warning it is an error.
            EXPECT_TRUE(has(error_of([&] { read_records(path_); }), "cut off"));
        }
    }
    EXPECT_EQ(known, whole_.irradiance.size() + whole_.radiance.size());  // the last blocks hold supports
}

TEST_F(DamagedRecords, HeaderIsRefusedWhole) {
    RecordSet set;
    std::string warning;
    for (std::size_t cut = 0; cut < header_.header_bytes; ++cut) {
        const std::string error = read(bytes_.substr(0, cut), set, warning);
        EXPECT_TRUE(one_line(error) && has(error, path_) && has(error, cut < 8 ? "not a record file" : "cut off"))
            << cut << ": " << error;
    }
    const auto with = [&](std::size_t at, const std::string& in) {
        std::string changed = bytes_;
        changed.replace(at, in.size(), in);
        return read(changed, set, warning);
    };
    EXPECT_TRUE(has(with(0, "\x89PNG"), "not a record file"));
    EXPECT_TRUE(has(with(8, "\x01\x02\x03\x04"), "other byte order"));
    EXPECT_TRUE(has(with(8, "\x01\x02\x03\x05"), "no byte order mark"));
    EXPECT_TRUE(has(with(12, "\x02"), "version 2, expected 1"));
    EXPECT_TRUE(has(with(16, "\xff\xff\xff\xff"), "header's size"));
    EXPECT_TRUE(has(with(20, "\xff\xff\xff\xff"), "header's size"));
    EXPECT_TRUE(has(with(30, "\x77"), "checksum of the header"));
    EXPECT_TRUE(has(with(121, "A"), "checksum of the header"));
    EXPECT_TRUE(has(error_of([&] { read_records(folder_.file("none")); }), "cannot be read"));
    EXPECT_TRUE(has(error_of([&] { read_records(folder_.path.string()); }), "no regular file"));
}

TEST_F(DamagedRecords, TenThousandFlippedBitsNeverGiveOtherRecords) {
    std::mt19937_64 random(1);
    int refused = 0, recovered = 0;
    for (int i = 0; i < 10000; ++i) {
        std::string changed = bytes_;
        const std::size_t bit = random() % (8 * bytes_.size());
        changed[bit / 8] = static_cast<char>(changed[bit / 8] ^ (1 << bit % 8));
        RecordSet set;
        std::string warning;
        const std::string error = read(changed, set, warning);
        if (!error.empty()) {
            ASSERT_TRUE(one_line(error)) << error;
            ++refused;
            continue;
        }
        ++recovered;
        ASSERT_TRUE(one_line(warning)) << "bit " << bit << " was not noticed";
        ASSERT_TRUE(is_state(set)) << "bit " << bit;
    }
    // Flips in the header are refused, others recovered.
    EXPECT_GT(refused, 10);
    EXPECT_GT(recovered, 9000);
}

// Blocks that lie elsewhere than they were written, or are another file's, do not count.
TEST_F(DamagedRecords, StrayBlocksAreNotTaken) {
    RecordSet set;
    std::string warning;
    const std::string first = bytes_.substr(begins_[0], begins_[1] - begins_[0]);
    EXPECT_EQ(read(bytes_ + first, set, warning), "");
    EXPECT_TRUE(has(warning, "damaged from byte " + std::to_string(bytes_.size())));
    EXPECT_TRUE(same(set, whole_));
    EXPECT_EQ(read(bytes_ + std::string(4096, '\0'), set, warning), "");
    EXPECT_TRUE(has(warning, "the last 4096 are lost")) << warning;
    EXPECT_TRUE(same(set, whole_));

    RecordSet other = some_records(40, 6);
    other.origin.emitters ^= 1;
    write_records(path_, other);
    EXPECT_EQ(
        read(read_file(path_).substr(0, header_.header_bytes) + bytes_.substr(header_.header_bytes), set, warning), "");
    EXPECT_EQ(set.irradiance.size() + set.radiance.size(), 0u);
    EXPECT_TRUE(has(warning, "damaged"));
}

// A file with right checksums is no less input.
TEST_F(DamagedRecords, ForgedBlocksAreRefused) {
    RecordSet set;
    std::string warning;
    const auto error = [&](std::size_t block, const std::function<void(Block&, std::string&)>& change) {
        const std::string what = read(forged(block, change), set, warning);
        EXPECT_TRUE(one_line(what)) << what;
        return what;
    };
    // Counts without the bytes that they ask for: nothing is allocated.
    EXPECT_TRUE(has(error(0, [](Block& b, std::string&) { b.count = 0xffffffffu; }), "4294967295 elements"));
    EXPECT_TRUE(has(error(0, [](Block& b, std::string&) { b.count = 0; }), "0 elements"));
    EXPECT_TRUE(has(error(1, [](Block& b, std::string&) { b.stride = 0xfffffff8u; }), "stride 4294967288"));
    EXPECT_TRUE(has(error(1, [](Block& b, std::string&) { b.order = 0xffffffffu; }), "order 4294967295"));
    EXPECT_TRUE(has(error(0, [](Block& b, std::string&) { b.kind = 6; }), "kind 6"));
    EXPECT_TRUE(has(error(0, [](Block& b, std::string&) { b.stride = 8; }), "stride 8"));
    // An honest size beyond the file's end is a tail that was cut off.
    EXPECT_EQ(read(forged(0, [](Block& b, std::string&) { b.count = 0xfffffff0u, b.bytes = b.count * 144ull; }), set,
                   warning),
              "");
    EXPECT_TRUE(has(warning, "cut off") && has(warning, " 0 records and 0 radiance records are left")) << warning;

    EXPECT_TRUE(has(error(0,
                          [](Block&, std::string& p) {
                              const float nan = NAN;
                              std::memcpy(p.data() + 3 * 48 + 12, &nan, 4);
                          }),
                    "irradiance record 3: a number is not finite"));
    const auto support = [&](std::uint32_t record, float s) {
        return error(0, [&](Block& b, std::string& p) {
            const records::Support entries[2] = {{record, s, s}, {record, s, s}};
            b.kind = records::kIrradianceSupport;
            b.count = 2;
            b.bytes = sizeof entries;
            p.assign(reinterpret_cast<const char*>(entries), sizeof entries);
        });
    };
    EXPECT_TRUE(has(support(3, 0.1f), "support of record 3, of 0"));
}

}  // namespace
}  // namespace irradia::test
