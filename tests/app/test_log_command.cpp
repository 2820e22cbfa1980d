// --log-json, --progress, --quiet as a collector, a program and a person hear them.

#include <nlohmann/json.hpp>
#include <set>

#include "command.h"
#include "packets.h"

namespace irradia {
namespace {

using nlohmann::json;
const std::string kScene = std::string(IRRADIA_SOURCE_DIR) + "/scenes/cornell-box.xml";

std::vector<json> objects_in(const std::string& text) {
    std::vector<json> objects;
    std::istringstream lines(text);
    std::string line;
    while (std::getline(lines, line)) objects.push_back(json::parse(line));
    return objects;
}

class LogCommand : public test::CommandTest {
protected:
    test::Outcome render_small(std::vector<std::string> arguments) const {
        arguments.insert(arguments.begin(), {kScene, "--quality", "draft", "--width", "64", "--height", "64"});
        return call(RENDER, arguments);
    }
    static std::vector<std::string> stages(const std::vector<json>& objects) {
        std::vector<std::string> names;
        for (const json& object : objects)
            if (object["event"] == "stage") names.push_back(object["stage"]);
        return names;
    }
};

TEST_F(LogCommand, JsonLinesSayWhatPlainOnesSay) {
    const test::Outcome outcome = render_small({"-o", "a.pfm", "--log-json", "--verbose"});
    ASSERT_EQ(outcome.status, 0) << outcome.err;
    EXPECT_EQ(outcome.out, "");
    std::set<std::string> levels;
    bool wrote = false, statistics = false;
    for (const json& object : objects_in(outcome.err)) {
        for (const char* key : {"time", "level", "message"}) EXPECT_TRUE(object.contains(key)) << object;
        levels.insert(object["level"]);
        if (object.contains("output")) {
            wrote = true;
            EXPECT_EQ(object["output"], json({"a.pfm"}));
            EXPECT_GT(object["records"], 100);
            EXPECT_GT(object["seconds"], 0);
        }
        if (object.contains("statistics")) {
            statistics = true;
            EXPECT_EQ(object["statistics"]["scene"]["width"], 64);
        }
    }
    EXPECT_EQ(levels, (std::set<std::string>{"detail", "info"}));
    EXPECT_TRUE(wrote);
    EXPECT_TRUE(statistics);
}

TEST_F(LogCommand, ErrorsAreObjectsTooButForTheCommandLine) {
    for (const char* quiet : {"--quiet", "--verbose"}) {
        const test::Outcome outcome = call(RENDER, {"none.xml", "-o", "a.pfm", "--log-json", "--progress", quiet});
        EXPECT_EQ(outcome.status, 1);
        const std::vector<json> said = objects_in(outcome.err), events = objects_in(outcome.out);
        ASSERT_FALSE(said.empty());
        ASSERT_FALSE(events.empty());
        EXPECT_EQ(said.back()["level"], "error");
        EXPECT_NE(said.back()["message"].get<std::string>().find("none.xml"), std::string::npos);
        EXPECT_EQ(events.back()["event"], "error");
        EXPECT_EQ(events.back()["message"], said.back()["message"]);
        EXPECT_EQ(events.back()["status"], 1);
    }
    expect_one_line(render_small({"-o", "a.pfm", "--log-json", "--spp", "0"}), 2, "render", "--spp");
}

TEST_F(LogCommand, StreamGoesThroughTheStagesAndEnds) {
    const test::Outcome outcome = render_small({"-o", "a.pfm", "-o", "b.pfm", "--progress", "--quiet"});
    ASSERT_EQ(outcome.status, 0) << outcome.err;
    EXPECT_EQ(outcome.err, "");
    const std::vector<json> events = objects_in(outcome.out);
    EXPECT_EQ(stages(events), (std::vector<std::string>{"loading: parsing", "loading: meshes", "loading: textures",
                                                        "loading: assembly", "loading: hierarchy", "loading: checks",
                                                        "grid", "records", "shade", "writing"}));
    EXPECT_EQ(events.back()["event"], "done");
    EXPECT_EQ(events.back()["outputs"], json({"a.pfm", "b.pfm"}));
    EXPECT_GT(events.back()["seconds"], 0);
    std::string stage;
    double fraction = 0;
    for (const json& event : events) {
        if (event["event"] != "progress") continue;
        if (event["stage"] == stage) {
            EXPECT_GE(event["fraction"].get<double>(), fraction) << event;
        }
        stage = event["stage"].get<std::string>();
        fraction = event["fraction"].get<double>();
        EXPECT_GE(fraction, 0);
        EXPECT_LE(fraction, 1);
        EXPECT_GE(event["elapsed"], 0);
    }
}

TEST_F(LogCommand, AReaderThatGoesAwayDoesNotEndTheRender) {
    const std::string line = "cd " + test::quoted(folder_.string()) + " && { " + test::quoted(RENDER) + " " +
                             test::quoted(kScene) +
                             " -o a.pfm --quality draft --width 64 --height 64 --progress 2>err; echo $? >status; } | "
                             "head -n 1 >first";
    ASSERT_EQ(std::system(line.c_str()), 0);
    EXPECT_EQ(test::file_text(in_folder("status")), "0\n");
    EXPECT_TRUE(std::filesystem::exists(in_folder("a.pfm")));
    const std::string err = test::file_text(in_folder("err"));
    const std::size_t warning = err.find("warning: --progress: stdout cannot be written");
    EXPECT_NE(warning, std::string::npos) << err;
    EXPECT_EQ(err.find("--progress", warning + 20), std::string::npos) << err;
}

// Both streams are sockets on which every write is one packet.
TEST_F(LogCommand, OneWriteALine) {
    test::Packets out, err;
    const pid_t child = ::fork();
    ASSERT_GE(child, 0);
    if (child == 0) {
        ::dup2(out.end(), STDOUT_FILENO);
        ::dup2(err.end(), STDERR_FILENO);
        const std::string picture = in_folder("a.pfm");
        ::execl(RENDER, RENDER, kScene.c_str(), "-o", picture.c_str(), "--quality", "draft", "--log-json", "--progress",
                static_cast<char*>(nullptr));
        ::_exit(127);
    }
    out.close_end();
    err.close_end();
    const std::vector<std::string> events = out.take(true), lines = err.take(true);
    int status = 0;
    ASSERT_EQ(::waitpid(child, &status, 0), child);
    EXPECT_EQ(WEXITSTATUS(status), 0);
    EXPECT_GT(events.size(), 10u);
    EXPECT_GT(lines.size(), 1u);
    for (const std::vector<std::string>* packets : {&events, &lines})
        for (const std::string& packet : *packets) {
            EXPECT_EQ(packet.find('\n'), packet.size() - 1) << packet;
            EXPECT_TRUE(json::accept(packet)) << packet;
        }
}

}  // namespace
}  // namespace irradia
