#include "app/stage_log.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "packets.h"

namespace irradia::app {
namespace {

using nlohmann::json;

Progress at(const std::string& stage, double fraction, double elapsed) {
    Progress p;
    p.stage = stage;
    p.fraction = fraction;
    p.elapsed = elapsed;
    p.records = 5321;
    p.rays = static_cast<std::uint64_t>(elapsed * 2.5e6);
    return p;
}

/// What a log gets while `play` reports to a StageLog, which is finished afterwards.
template <class Play>
std::vector<std::string> written(int columns, const Play& play) {
    test::Packets err, out;
    Log log({}, columns, err.end(), out.end());
    StageLog stages(log);
    std::vector<std::string> packets;
    const auto report = [&](const Progress& p) {
        stages(p);
        for (std::string& packet : err.take()) packets.push_back(std::move(packet));
    };
    play(report);
    stages.finish();
    for (std::string& packet : err.take()) packets.push_back(std::move(packet));
    return packets;
}

TEST(StageLog, TerminalGetsTenBarsASecondAtMostAndIsClearedAfterwards) {
    const std::vector<std::string> packets = written(80, [](const auto& report) {
        for (int i = 0; i <= 1000; ++i) report(at("records", i / 1000.0, i / 1000.0));  // one second
    });
    EXPECT_GE(packets.size(), 10u);
    EXPECT_LE(packets.size(), 12u);
    EXPECT_EQ(test::joined(packets).find('\n'), std::string::npos);
    EXPECT_EQ(packets.back(), "\r\033[K");
}

TEST(StageLog, LogGetsALineEveryFiveSecondsThenFewerAndNoControlCharacters) {
    const auto lines_after = [](double seconds) {
        const std::vector<std::string> lines = written(0, [&](const auto& report) {
            for (double t = 0; t <= seconds; t += 0.25) report(at("records", t / (seconds + 1), t));
        });
        EXPECT_EQ(test::joined(lines).find('\r'), std::string::npos);
        return lines.size();
    };
    EXPECT_EQ(lines_after(4.5), 1u);  // the stage's end
    EXPECT_GE(lines_after(60), 10u);
    EXPECT_LE(lines_after(60), 14u);
    EXPECT_LE(lines_after(3600), 100u);
}

TEST(StageLog, LogGetsALineAStageUnlessItIsShort) {
    const std::vector<std::string> lines = written(0, [](const auto& report) {
        report(at("grid", 0, 0));
        report(at("records", 0.1, 2));
        report(at("records", 0.5, 4));
        report(at("upload", 0.5, 6));
        report(at("shade", 0.6, 6.05));
        report(at("shade", 1, 8.05));
    });
    EXPECT_EQ(lines, (std::vector<std::string>{"render: grid: 2.0 s, 5 321 records, 2.5 M rays/s\n",
                                               "render: records: 4.0 s, 5 321 records, 2.5 M rays/s\n",
                                               "render: shade: 2.0 s, 5 321 records, 2.5 M rays/s\n"}));
}

TEST(StageLog, StreamTellsStagesInOrderAtABearableRate) {
    test::Packets err, out;
    Log log({.quiet = true, .progress = true}, 80, err.end(), out.end());
    StageLog stages(log);
    std::vector<json> events;
    const auto take = [&] {
        for (const std::string& packet : out.take()) events.push_back(json::parse(packet));
    };
    for (int i = 0; i <= 3000; ++i) {
        const double t = i / 1000.0;
        Progress p = at(t < 1 ? "grid" : "shade", t / 3, t);
        if (i % 7 == 3) p.fraction -= 0.01;  // threads that report out of order
        stages(p);
        take();
    }
    stages.finish(3.5);
    take();
    std::string story, stage;
    double fraction = 0;
    int progress = 0;
    for (const json& event : events) {
        if (event["event"] == "stage") {
            story += event["stage"].get<std::string>() + " " + event["seconds"].dump() + ";";
            continue;
        }
        ASSERT_EQ(event["event"], "progress");
        ++progress;
        if (event["stage"] == stage) {
            EXPECT_GE(event["fraction"].get<double>(), fraction);
        }
        stage = event["stage"].get<std::string>();
        fraction = event["fraction"].get<double>();
    }
    EXPECT_EQ(story, "grid 1.0;shade 2.5;");
    EXPECT_GE(progress, 15);
    EXPECT_LE(progress, 18);  // five a second, one for each stage, the last
    EXPECT_EQ(events[events.size() - 2]["elapsed"], 3.5);
    EXPECT_EQ(events[events.size() - 2]["fraction"], 1.0);
    EXPECT_TRUE(err.take().empty());
}

}  // namespace
}  // namespace irradia::app
