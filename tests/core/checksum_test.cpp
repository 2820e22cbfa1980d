#include "core/checksum.h"

#include <gtest/gtest.h>

#include <set>
#include <string>

namespace {

using irradia::checksum;

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

}  // namespace
