#include "app/log.h"

#include <gtest/gtest.h>

#include <regex>
#include <thread>

#include "packets.h"

namespace irradia::app {
namespace {

using nlohmann::json;

struct Ears {
    test::Packets err, out;
};

TEST(Log, PlainLinesByLevel) {
    Ears ears;
    const auto said = [&](const LogSettings& settings) {
        Log log(settings, 0, ears.err.end(), ears.out.end());
        log.detail("d");
        log.info("i");
        log.warn("w");
        log.error("e");
        log.table("t", "  a 1\n  b 2\n", {});
        return test::joined(ears.err.take());
    };
    EXPECT_EQ(said({}), "render: i\nrender: warning: w\nrender: e\n");
    EXPECT_EQ(said({.verbose = true}), "render: d\nrender: i\nrender: warning: w\nrender: e\n  a 1\n  b 2\n");
    EXPECT_EQ(said({.quiet = true}), "render: e\n");
    EXPECT_TRUE(ears.out.take().empty());
}

TEST(Log, JsonObjectsHaveTimeLevelMessageAndFields) {
    Ears ears;
    Log log({.verbose = true, .json = true}, 80, ears.err.end(), ears.out.end());
    log.detail("d");
    log.info("two\nlines", {{"stage", "grid"}, {"seconds", 1.5}});
    log.warn("not UTF-8: \xff");
    log.error("e");
    log.table("t", "  a 1\n", {{"a", 1}});
    log.bar("no bar among objects");
    const std::vector<std::string> packets = ears.err.take();
    ASSERT_EQ(packets.size(), 5u);
    const char* const levels[] = {"detail", "info", "warning", "error", "detail"};
    for (std::size_t i = 0; i < 5; ++i) {
        EXPECT_EQ(packets[i].find('\n'), packets[i].size() - 1);
        const json object = json::parse(packets[i]);
        EXPECT_EQ(object["level"], levels[i]);
        EXPECT_TRUE(std::regex_match(object["time"].get<std::string>(),
                                     std::regex(R"(\d{4}-\d\d-\d\dT\d\d:\d\d:\d\d\.\d{3}Z)")));
    }
    const json object = json::parse(packets[1]);
    EXPECT_EQ(object["message"], "two\nlines");
    EXPECT_EQ(object["stage"], "grid");
    EXPECT_EQ(object["seconds"], 1.5);
    EXPECT_EQ(json::parse(packets[4])["a"], 1);
}

TEST(Log, ContextPrefixesLinesAndIsAFieldOfObjects) {
    Ears ears;
    Log log({.progress = true}, 0, ears.err.end(), ears.out.end());
    log.context({{"job", "kitchen"}, {"frame", 12}});
    log.info("one\ntwo");
    log.event("progress", {{"fraction", 0.5}});
    log.context({{"frame", 13}});
    log.warn("w");
    log.failed("f", 1);
    log.context({});
    log.info("i");
    log.done({"a.exr"}, 2.5);
    EXPECT_EQ(test::joined(ears.err.take()),
              "render: [job kitchen, frame 12] one\nrender: [job kitchen, frame 12] two\n"
              "render: [frame 13] warning: w\nrender: i\n");
    EXPECT_EQ(test::joined(ears.out.take()),
              "{\"event\":\"progress\",\"job\":\"kitchen\",\"frame\":12,\"fraction\":0.5}\n"
              "{\"event\":\"error\",\"frame\":13,\"message\":\"f\",\"status\":1}\n"
              "{\"event\":\"done\",\"outputs\":[\"a.exr\"],\"seconds\":2.5}\n");

    Log objects({.json = true}, 0, ears.err.end(), ears.out.end());
    objects.context({{"frame", 12}});
    objects.info("i");
    EXPECT_EQ(json::parse(test::joined(ears.err.take()))["frame"], 12);
}

// Eight threads: whatever order the lines come in, each is whole and came by one write.
TEST(Log, OneWriteALine) {
    Ears ears;
    Log log({.json = true, .progress = true}, 0, ears.err.end(), ears.out.end());
    std::vector<std::thread> threads;
    for (int t = 0; t < 8; ++t)
        threads.emplace_back([&, t] {
            for (int i = 0; i < 5; ++i) {
                log.info(std::string(1000, 'x'), {{"thread", t}});
                log.event("progress", {{"thread", t}});
            }
        });
    std::vector<std::string> packets;
    for (int i = 0; i < 10000 && packets.size() < 40; ++i) {
        for (std::string& packet : ears.err.take()) packets.push_back(std::move(packet));
        std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
    for (std::thread& thread : threads) thread.join();
    EXPECT_EQ(packets.size(), 40u);
    for (const std::string& packet : packets) EXPECT_EQ(json::parse(packet)["message"], std::string(1000, 'x'));
    const std::vector<std::string> events = ears.out.take();
    EXPECT_EQ(events.size(), 40u);
    for (const std::string& event : events) EXPECT_EQ(json::parse(event)["event"], "progress");
}

TEST(Log, ALineTakesTheBarsPlace) {
    Ears ears;
    Log log({}, 80, ears.err.end(), ears.out.end());
    log.bar("[==  ]");
    log.info("i");
    log.info("j");
    EXPECT_EQ(ears.err.take(), (std::vector<std::string>{"\r\033[K[==  ]", "\r\033[Krender: i\n", "render: j\n"}));
}

TEST(Log, AStreamThatNobodyReadsIsSwitchedOffWithOneWarning) {
    ignore_closed_pipes();
    Ears ears;
    Log log({.progress = true}, 0, ears.err.end(), ears.out.end());
    ears.out.close_reader();
    for (int i = 0; i < 3; ++i) log.event("progress", {{"i", i}});
    EXPECT_EQ(test::joined(ears.err.take()),
              "render: warning: --progress: stdout cannot be written (Broken pipe): nothing more is sent\n");
}

}  // namespace
}  // namespace irradia::app
