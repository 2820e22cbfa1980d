#include "core/checksum.h"

#include <gtest/gtest.h>

#include <set>
#include <string>

namespace {

using irradia::checksum;
using irradia::checksums;

TEST(Checksum, SeesEveryBit) {
    std::string data(100, 'x');
    std::set<std::uint64_t> seen{checksum(data.data(), data.size())};
    for (std::size_t bit = 0; bit < data.size() * 8; ++bit) {
        std::string altered = data;
        altered[bit / 8] = static_cast<char>(altered[bit / 8] ^ (1 << bit % 8));
        EXPECT_TRUE(seen.insert(checksum(altered.data(), altered.size())).second) << "bit " << bit;
    }
}

TEST(Checksum, SeesLengthOrderAndSeed) {
    const std::string zeros(64, '\0');
    std::set<std::uint64_t> seen;
    for (std::size_t n = 0; n <= zeros.size(); ++n) EXPECT_TRUE(seen.insert(checksum(zeros.data(), n)).second) << n;
    const std::string a = "12345678abcdefgh", b = "abcdefgh12345678";
    EXPECT_NE(checksum(a.data(), 16), checksum(b.data(), 16));
    EXPECT_NE(checksum(a.data(), 16, 1), checksum(a.data(), 16, 2));
}

// Each of the two by itself; lengths with and without whole blocks of 32 bytes and a rest.
TEST(Checksums, BothSeeEveryBitLengthAndSeed) {
    std::set<std::uint64_t> seen;
    const auto add = [&](const std::string& text, irradia::Checksums seed = {}) {
        const irradia::Checksums sums = checksums(text.data(), text.size(), seed);
        return seen.insert(sums.first).second && seen.insert(sums.second).second;
    };
    const std::string data(100, 'x');
    EXPECT_TRUE(add(data));
    EXPECT_FALSE(add(data));
    for (std::size_t bit = 0; bit < data.size() * 8; ++bit) {
        std::string altered = data;
        altered[bit / 8] = static_cast<char>(altered[bit / 8] ^ (1 << bit % 8));
        EXPECT_TRUE(add(altered)) << "bit " << bit;
    }
    for (std::size_t n = 0; n < 100; ++n) EXPECT_TRUE(add(std::string(n, '\0'))) << n;
    EXPECT_TRUE(add("abcdefgh12345678abcdefgh1234567812345678abcdefgh"));
    EXPECT_TRUE(add("12345678abcdefghabcdefgh1234567812345678abcdefgh"));
    const irradia::Checksums plain = checksums(data.data(), 100), other = checksums(data.data(), 100, {1, 0}),
                             third = checksums(data.data(), 100, {0, 1});
    EXPECT_NE(plain.first, other.first);
    EXPECT_EQ(plain.second, other.second);
    EXPECT_EQ(plain.first, third.first);
    EXPECT_NE(plain.second, third.second);
}

}  // namespace
