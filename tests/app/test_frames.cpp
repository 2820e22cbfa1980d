// Lists of frames, shards, names of files; lists of jobs.
#include <gtest/gtest.h>

#include <algorithm>
#include <fstream>

#include "../image/pictures.h"
#include "app/batch_file.h"
#include "app/frames.h"
#include "irradia/Error.h"

namespace irradia::app {
namespace {

std::vector<int> frames(const std::string& text) {
    std::vector<int> out;
    EXPECT_EQ(read_frames(text, out), "") << text;
    return out;
}

TEST(Frames, ListsAreRead) {
    EXPECT_EQ(frames("7"), (std::vector<int>{7}));
    EXPECT_EQ(frames("0-3"), (std::vector<int>{0, 1, 2, 3}));
    EXPECT_EQ(frames("1-10x4"), (std::vector<int>{1, 5, 9}));
    EXPECT_EQ(frames("5-10x2147483647"), (std::vector<int>{5}));
    EXPECT_EQ(frames("9,1-3,2-4"), (std::vector<int>{1, 2, 3, 4, 9}));
    for (const char* text : {"", "a", "3-1", "1-", "-1", "1,,2", "1-5x0", "1-5x", "1 - 5", "1-5,", "1-99999999"}) {
        std::vector<int> out;
        EXPECT_NE(read_frames(text, out), "") << text;
    }
    EXPECT_EQ(frames_text({1, 2, 3, 5, 7, 8}), "1-3, 5, 7, 8");
    EXPECT_EQ(frames_text({}), "");
}

TEST(Frames, ShardsTogetherAreAllFrames) {
    for (const int n : {1, 2, 3, 7, 30}) {
        const std::vector<int> all = frames("1-23");
        std::vector<int> together;
        std::size_t least = all.size(), most = 0;
        for (int i = 1; i <= n; ++i) {
            const std::vector<int> part = shard_of(all, i, n);
            together.insert(together.end(), part.begin(), part.end());
            least = std::min(least, part.size());
            most = std::max(most, part.size());
        }
        EXPECT_EQ(together, all);
        EXPECT_LE(most - least, 1u);
    }
    int i = 0, n = 0;
    EXPECT_EQ(read_shard("2/8", i, n), "");
    EXPECT_EQ(i, 2);
    EXPECT_EQ(n, 8);
    for (const char* text : {"0/4", "5/4", "1", "1/", "/4", "1/4x", "-1/4"}) EXPECT_NE(read_shard(text, i, n), "");
}

TEST(Frames, NamesHaveAPlaceForThem) {
    EXPECT_EQ(frame_path("out.####.exr", 12), "out.0012.exr");
    EXPECT_EQ(frame_path("a#b/x#.exr", 12), "a#b/x12.exr");
    EXPECT_EQ(frame_path("####", 123456), "123456");
    EXPECT_TRUE(has_frame_place("x.#.exr"));
    EXPECT_FALSE(has_frame_place("#/x.exr"));
    EXPECT_FALSE(has_frame_place("#.#.exr"));
    EXPECT_EQ(frame_path("plain.exr", 1), "plain.exr");
}

class BatchFile : public test::InFolder {
protected:
    std::vector<BatchJob> read(const std::string& text, const GivenOptions& given = {}) const {
        std::ofstream(in_folder("jobs.json")) << text;
        return read_batch(in_folder("jobs.json"), given);
    }
    std::string complaint(const std::string& text) const {
        try {
            read(text);
        } catch (const Error& error) {
            return error.what();
        }
        return "";
    }
};

TEST_F(BatchFile, OptionsOfAJobWinOverDefaultsAndThoseOverTheCommandLine) {
    const std::vector<BatchJob> jobs = read(
        R"({"defaults": {"spp": 16, "accuracy": 0.25, "no-grid": true},
            "jobs": [{"scene": "a.xml", "output": "a.exr"},
                     {"name": "b", "scene": "-b.xml", "output": ["b.exr", "b.png"],
                      "options": {"spp": 64, "no-grid": false, "define": ["x=1", "y=2"], "max-depth": -1}}]})",
        {{"batch", {"jobs.json"}}, {"threads", {"1"}}, {"spp", {"4"}}, {"quiet", {"true"}}});
    ASSERT_EQ(jobs.size(), 2u);
    EXPECT_EQ(jobs[0].name, "1");
    EXPECT_EQ(jobs[0].arguments, (std::vector<std::string>{"--accuracy=0.25", "--no-grid", "--output=a.exr", "--spp=16",
                                                           "--threads=1", "--", "a.xml"}));
    EXPECT_EQ(jobs[1].name, "b");
    EXPECT_EQ(jobs[1].arguments, (std::vector<std::string>{"--accuracy=0.25", "--define=x=1", "--define=y=2",
                                                           "--max-depth=-1", "--output=b.exr", "--output=b.png",
                                                           "--spp=64", "--threads=1", "--", "-b.xml"}));
}

TEST_F(BatchFile, WhatIsWrongIsNamed) {
    const auto expect = [&](const std::string& text, const std::string& what) {
        EXPECT_NE(complaint(text).find(what), std::string::npos) << complaint(text);
        EXPECT_EQ(complaint(text).find('\n'), std::string::npos);
    };
    expect("{", "jobs.json: parse error at line 1");
    expect(R"({"jobs": [1e999]})", "number overflow");
    expect("{\"a\\nb\": 1}", "unknown key 'a?b'");
    expect("[]", "found [], expected an object");
    expect("{}", "jobs: expected a list");
    expect(R"({"jobs": []})", "jobs: expected a list");
    expect(R"({"jobs": [{"output": "a.exr"}]})", "jobs[0]: has no \"scene\"");
    expect(R"({"jobs": [{"scene": 3}]})", "jobs[0].scene: found 3, expected a text");
    expect(R"({"jobs": [{"scene": "a", "outptu": "b"}]})",
           "unknown key 'outptu', expected name, options, output, scene");
    expect(R"({"jobs": [{"scene": "a", "options": {"spp": {}}}]})", "jobs[0].options.spp: found {}");
    expect(R"({"jobs": [{"scene": "a", "options": {"--spp": 1}}]})", "long name without dashes");
    expect(R"({"jobs": [{"scene": "a", "options": {"batch": "x"}}]})", "is no option of a job");
    expect(R"({"jobs": [{"scene": "a", "name": "x"}, {"scene": "a", "name": "x"}]})", "'x' is another job's, too");
    expect(R"({"jobs": [{"scene": "a", "name": "x/y"}]})", "without '/'");
}

}  // namespace
}  // namespace irradia::app
