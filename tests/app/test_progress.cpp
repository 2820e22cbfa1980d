#include "app/progress.h"

#include <gtest/gtest.h>

namespace irradia::app {
namespace {

Progress at(const std::string& stage, double fraction, double elapsed) {
    Progress p;
    p.stage = stage;
    p.fraction = fraction;
    p.elapsed = elapsed;
    p.records = 5321;
    p.rays = static_cast<std::uint64_t>(elapsed * 2.5e6);
    return p;
}

TEST(Progress, Numbers) {
    EXPECT_EQ(count_text(999), "999");
    EXPECT_EQ(count_text(5321), "5 321");
    EXPECT_EQ(count_text(12003), "12 003");
    EXPECT_EQ(count_text(2.5e6), "2.5 M");
    EXPECT_EQ(count_text(1.61e9), "1.61 G");
    EXPECT_EQ(time_text(0.84), "0.8 s");
    EXPECT_EQ(time_text(9.96), "10 s");
    EXPECT_EQ(time_text(125), "2:05");
    EXPECT_EQ(time_text(3725), "1:02:05");
}

TEST(Progress, SaysStageRecordsRateAndTimeLeft) {
    // A quarter done after 10 s: 30 s are left.
    EXPECT_EQ(progress_text(at("records", 0.25, 10)), "records: 25 %, 5 321 records, 2.5 M rays/s, 30 s left");
    EXPECT_EQ(progress_text(at("shade", 1, 10)).find("left"), std::string::npos);
    EXPECT_EQ(progress_text(at("records", 0, 0)), "records: 0 %, 5 321 records");
}

TEST(Progress, BarStaysWithinTheTerminal) {
    const Progress p = at("records", 0.5, 10);
    EXPECT_EQ(progress_bar(p, 200).rfind("[==========          ] records: 50 %", 0), 0u);
    for (const int columns : {1, 20, 40, 80}) EXPECT_LT(static_cast<int>(progress_bar(p, columns).size()), columns);
}

}  // namespace
}  // namespace irradia::app
