#include "core/memory.h"

#include <gtest/gtest.h>

#include <vector>

#include "irradia/Error.h"

namespace irradia {
namespace {

TEST(Memory, SizesAreRead) {
    EXPECT_EQ(parse_memory_size("4G"), std::uint64_t{4} << 30);
    EXPECT_EQ(parse_memory_size("512M"), 512u << 20);
    EXPECT_EQ(parse_memory_size("512MB"), 512u << 20);
    EXPECT_EQ(parse_memory_size("3.5GiB"), std::uint64_t{7} << 29);
    EXPECT_EQ(parse_memory_size("2k"), 2048u);
    EXPECT_EQ(parse_memory_size("1T"), std::uint64_t{1} << 40);
    EXPECT_EQ(parse_memory_size("800000000"), 800000000u);
    EXPECT_EQ(parse_memory_size("12B"), 12u);
    const std::uint64_t all = parse_memory_size("100%").value();
    EXPECT_EQ(all, machine_memory());
    EXPECT_NEAR(static_cast<double>(parse_memory_size("25%").value()), 0.25 * static_cast<double>(all), 1);
    for (const char* wrong : {"", "G", "-1G", "+1G", " 1G", "1 G", "1X", "1GX", "1GiBs", "0", "0G", "nan", "inf",
                              "0x10", "1e30", "%", "1%%", "0%", "Gi"})
        EXPECT_FALSE(parse_memory_size(wrong)) << wrong;
}

TEST(Memory, SizesAreSaid) {
    EXPECT_EQ(memory_text(60), "60 bytes");
    EXPECT_EQ(memory_text(3u << 19), "1.5 MiB");
    EXPECT_EQ(memory_text(812u << 20), "812 MiB");
    EXPECT_EQ(memory_text(std::uint64_t{7} << 29), "3.50 GiB");
}

TEST(Memory, ResidentSetFollowsWhatIsWritten) {
    constexpr std::uint64_t size = 64u << 20;
    const std::uint64_t before = resident_memory();
    ASSERT_GT(before, 1u << 20);
    {
        std::vector<char> block(size, 1);
        EXPECT_GE(resident_memory(), before + size - (1u << 20)) << static_cast<int>(block[size / 2]);
        EXPECT_LE(resident_memory(), peak_resident_memory() + (1u << 20));
    }
    EXPECT_LT(resident_memory(), before + size / 2);
    EXPECT_GE(peak_resident_memory(), before + size - (1u << 20));
    EXPECT_GT(machine_memory(), peak_resident_memory());
}

TEST(Memory, WhatPassesTheLimitIsRefused) {
    const std::uint64_t used = resident_memory();
    EXPECT_NO_THROW(require_memory(0, std::uint64_t{1} << 60, "a thing", "help"));  // no limit
    EXPECT_NO_THROW(require_memory(used + (200u << 20), 100u << 20, "a thing", "help"));
    EXPECT_THROW(require_memory(used + (100u << 20), 200u << 20, "a thing", "help"), Error);
    EXPECT_THROW(require_memory(1 << 20, 0, "a thing", "help"), Error);
    try {  // asked for already, if not resident
        require_memory(std::uint64_t{8} << 40, std::uint64_t{2} << 40, "a thing", "take a smaller one",
                       std::uint64_t{7} << 40);
        FAIL();
    } catch (const Error& error) {
        EXPECT_STREQ(error.what(),
                     "no memory for a thing: about 2048.00 GiB needed, 7168.00 GiB in use, 8192.00 GiB allowed "
                     "(--memory-limit): take a smaller one");
        EXPECT_EQ(error.exit_status(), 1);
    }
}

}  // namespace
}  // namespace irradia
