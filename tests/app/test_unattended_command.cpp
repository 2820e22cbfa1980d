// Signals, checkpoints, frames and lists of jobs, as who renders unattended meets them. tools/unattended does more of
// this, at random moments.
#include <fcntl.h>
#include <signal.h>

#include <chrono>
#include <thread>

#include "command.h"

namespace irradia {
namespace {

const std::string kScene = std::string(IRRADIA_SOURCE_DIR) + "/scenes/cornell-box.xml";
using Arguments = std::vector<std::string>;

class UnattendedCommand : public test::CommandTest {
protected:
    void SetUp() override {
        CommandTest::SetUp();
        write("scene.xml", test::file_text(kScene));
        std::filesystem::create_directory_symlink(std::string(IRRADIA_SOURCE_DIR) + "/scenes/models",
                                                  in_folder("models"));
    }
    test::Outcome render(const Arguments& arguments) const { return call(RENDER, arguments); }
    void write(const std::string& name, const std::string& text) const { std::ofstream(in_folder(name)) << text; }
    [[nodiscard]] std::string text(const std::string& name) const { return test::file_text(in_folder(name)); }
    [[nodiscard]] bool there(const std::string& name) const { return std::filesystem::exists(in_folder(name)); }
    static bool says(const test::Outcome& outcome, const std::string& what) {
        return outcome.err.find(what) != std::string::npos;
    }

    /// Sends the signal as soon as `file` is there.
    test::Outcome render_until(const std::string& file, int signal, const Arguments& arguments) const {
        const std::string err = folder_.string() + ".err";
        const pid_t child = ::fork();
        if (child == 0) {
            Arguments words = arguments;
            words.insert(words.begin(), RENDER);
            std::vector<char*> argv;
            for (std::string& word : words) argv.push_back(word.data());
            argv.push_back(nullptr);
            const int to = ::open(err.c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0666);
            if (to < 0 || ::dup2(to, STDERR_FILENO) < 0 || ::chdir(folder_.c_str()) != 0) ::_exit(126);
            ::execv(RENDER, argv.data());
            ::_exit(127);
        }
        int status = 0;
        bool sent = false;
        while (::waitpid(child, &status, WNOHANG) == 0) {
            if (!sent && there(file)) sent = ::kill(child, signal) == 0;
            std::this_thread::sleep_for(std::chrono::milliseconds(2));
        }
        test::Outcome outcome{WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status), "",
                              test::file_text(err)};
        std::filesystem::remove(err);
        return outcome;
    }

    /// Long enough to be met in its middle; many short launches.
    [[nodiscard]] Arguments long_one(const std::string& output, const std::string& every) const {
        return {"scene.xml", "--method",  "path", "--width",      "128",   "--spp",
                "200",       "--threads", "1",    "--checkpoint", "state", "--checkpoint-every",
                every,       "-o",        output};
    }
    /// Names of files that no one has asked for.
    [[nodiscard]] std::vector<std::string> litter(const std::vector<std::string>& expected) const {
        std::vector<std::string> found;
        for (const auto& entry : std::filesystem::directory_iterator(folder_)) {
            const std::string name = entry.path().filename().string();
            if (name != "scene.xml" && name != "models" &&
                std::find(expected.begin(), expected.end(), name) == expected.end())
                found.push_back(name);
        }
        return found;
    }
    const Arguments small_ = {"--width", "16", "--spp", "1", "--hemisphere", "4x16", "--grid-paths", "1024"};
    [[nodiscard]] Arguments with(Arguments more) const {
        more.insert(more.end(), small_.begin(), small_.end());
        return more;
    }
};

TEST_F(UnattendedCommand, GoesOnAfterSigtermToTheSameBytes) {
    ASSERT_EQ(render(long_one("whole.pfm", "600s")).status, 0);
    EXPECT_FALSE(there("state"));
    const test::Outcome stopped = render_until("state", SIGTERM, long_one("a.pfm", "0.2s"));
    ASSERT_EQ(stopped.status, 143) << stopped.err;
    EXPECT_TRUE(says(stopped, "render: wrote state: the same command goes on from there\n")) << stopped.err;
    EXPECT_TRUE(stopped.err.ends_with("render: stopped by SIGTERM\n")) << stopped.err;
    EXPECT_EQ(litter({"whole.pfm", "state"}), std::vector<std::string>());
    const test::Outcome done = render(long_one("a.pfm", "0.2s"));
    ASSERT_EQ(done.status, 0) << done.err;
    EXPECT_TRUE(says(done, "going on from state")) << done.err;
    EXPECT_EQ(text("a.pfm"), text("whole.pfm"));
    EXPECT_EQ(litter({"whole.pfm", "a.pfm"}), std::vector<std::string>());
}

TEST_F(UnattendedCommand, GoesOnAfterSigkillToTheSameBytes) {
    ASSERT_EQ(render(long_one("whole.pfm", "600s")).status, 0);
    const test::Outcome killed = render_until("state", SIGKILL, long_one("a.pfm", "0.2s"));
    ASSERT_EQ(killed.status, 128 + SIGKILL) << killed.err;
    const test::Outcome interrupted = render_until("state", SIGINT, long_one("a.pfm", "0.2s"));
    ASSERT_EQ(interrupted.status, 130) << interrupted.err;
    const test::Outcome done = render(long_one("a.pfm", "0.2s"));
    ASSERT_EQ(done.status, 0) << done.err;
    EXPECT_TRUE(says(done, "going on from state")) << done.err;
    EXPECT_EQ(text("a.pfm"), text("whole.pfm"));
    EXPECT_EQ(litter({"whole.pfm", "a.pfm"}), std::vector<std::string>());
}

TEST_F(UnattendedCommand, RefusesCheckpointsOfOtherRenders) {
    ASSERT_EQ(render_until("state", SIGTERM, long_one("a.pfm", "0.2s")).status, 143);
    const std::string state = text("state");
    const auto refused = [&](const std::string& option, const std::string& value, const std::string& what) {
        Arguments arguments = long_one("a.pfm", "0.2s");
        arguments.insert(arguments.end(), {option, value});
        if (const auto at = std::find(arguments.begin(), arguments.end() - 2, option); at != arguments.end() - 2)
            arguments.erase(at, at + 2);
        const test::Outcome outcome = render(arguments);
        EXPECT_EQ(outcome.status, 1);
        EXPECT_TRUE(says(outcome, "render: state: checkpoint of another render: " + what)) << outcome.err;
        EXPECT_EQ(text("state"), state);
    };
    refused("--spp", "201", "spp was 200, is 201 (remove it to begin anew)");
    refused("--seed", "5", "seed was 0, is 5");
    refused("--width", "64", "width was 128, is 64");
    refused("-o", "b.pfm", "output 1 was a.pfm, is b.pfm");
    // The same words, but another scene: a material, the camera.
    const std::string before = text("scene.xml");
    for (const auto& [from, to] : {std::pair<std::string, std::string>{"0.61, 0.07", "0.62, 0.07"},
                                   {"origin=\"0, 1, 4\"", "origin=\"0, 1, 5\""}}) {
        std::string changed = before;
        ASSERT_NE(changed.find(from), std::string::npos) << from;
        write("scene.xml", changed.replace(changed.find(from), from.size(), to));
        const test::Outcome outcome = render(long_one("a.pfm", "0.2s"));
        EXPECT_EQ(outcome.status, 1) << to;
        EXPECT_TRUE(says(outcome, "render: state: checkpoint of another scene: found ")) << outcome.err;
    }
    // Cut off, and none at all.
    write("scene.xml", before);
    write("state", state.substr(0, state.size() / 2));
    EXPECT_TRUE(says(render(long_one("a.pfm", "0.2s")), "render: state: damaged checkpoint"));
    write("state", "not one");
    expect_one_line(render(long_one("a.pfm", "0.2s")), 1, "render", "state: is no checkpoint");
    EXPECT_FALSE(there("a.pfm"));
}

TEST_F(UnattendedCommand, SkipsFramesThatAreThere) {
    const Arguments frames = with({"scene.xml", "--frames", "1-4", "-o", "a.##.pfm", "--save-records", "r"});
    test::Outcome outcome = render(frames);
    ASSERT_EQ(outcome.status, 0) << outcome.err;
    EXPECT_TRUE(says(outcome, "frames: 4 rendered")) << outcome.err;
    const std::string records = text("r"), third = text("a.03.pfm");
    ASSERT_GT(records.size(), 1000u);
    // All of them: nothing is rendered, and the record file keeps what it has.
    outcome = render(frames);
    EXPECT_EQ(outcome.status, 0);
    EXPECT_TRUE(says(outcome, "left as they are, since their files are there (--overwrite): frames 1-4"));
    EXPECT_EQ(text("r"), records);
    std::filesystem::remove(in_folder("a.03.pfm"));
    write("a.01.pfm", "no picture");
    outcome = render(frames);
    EXPECT_EQ(outcome.status, 0);
    EXPECT_TRUE(says(outcome, "frames 1, 2, 4")) << outcome.err;
    EXPECT_EQ(text("a.03.pfm").size(), third.size());
    EXPECT_EQ(text("a.01.pfm"), "no picture");
    Arguments again = frames;
    again.emplace_back("--overwrite");
    EXPECT_EQ(render(again).status, 0);
    EXPECT_EQ(text("a.03.pfm"), third);
    EXPECT_EQ(text("a.01.pfm").size(), third.size());
}

TEST_F(UnattendedCommand, ShardsShareTheFrames) {
    for (const char* shard : {"2/3", "1/3", "3/3"}) {
        const test::Outcome outcome =
            render(with({"scene.xml", "--frames", "1-5", "--shard", shard, "-o", "a.#.pfm", "--method", "path"}));
        EXPECT_EQ(outcome.status, 0) << outcome.err;
        EXPECT_FALSE(says(outcome, "left as they are")) << outcome.err;  // no frame is two shards'
    }
    EXPECT_EQ(litter({"a.1.pfm", "a.2.pfm", "a.3.pfm", "a.4.pfm", "a.5.pfm"}), std::vector<std::string>());
    EXPECT_EQ(files(), 7u);
}

TEST_F(UnattendedCommand, FramesFailAlone) {
    write("s.1.xml", text("scene.xml"));
    write("s.3.xml", text("scene.xml"));
    const Arguments frames = with({"s.#.xml", "--frames", "1-4", "-o", "a.#.pfm", "--save-records", "r"});
    test::Outcome outcome = render(frames);
    EXPECT_EQ(outcome.status, 3) << outcome.err;
    EXPECT_TRUE(says(outcome, "render: [frame 2] scene file 's.2.xml' does not exist\n")) << outcome.err;
    EXPECT_TRUE(says(outcome, "frames: 2 rendered in ")) << outcome.err;
    EXPECT_TRUE(outcome.err.ends_with(", failed: 2, 4\n")) << outcome.err;
    EXPECT_TRUE(there("a.1.pfm") && there("a.3.pfm"));
    EXPECT_GT(text("r").size(), 1000u);  // of the frames that were rendered
    EXPECT_EQ(litter({"s.1.xml", "s.3.xml", "a.1.pfm", "a.3.pfm", "r"}), std::vector<std::string>());
}

// Between a frame's file and the next checkpoint, a killed run must not go on without that frame's records.
TEST_F(UnattendedCommand, AFrameIsNeverThereWithoutACheckpoint) {
    const auto frames = [](const std::string& state) {
        return Arguments{
            "scene.xml", "--frames", "1-3",          "-o",  state + ".#.pfm", "--width", "64",
            "--threads", "1",        "--checkpoint", state, "--spp",          "256"};  // --checkpoint-every: a minute
    };
    ASSERT_EQ(render(frames("whole")).status, 0);
    const test::Outcome killed = render_until("a.1.pfm", SIGKILL, frames("a"));
    ASSERT_EQ(killed.status, 128 + SIGKILL) << killed.err;
    EXPECT_TRUE(there("a"));
    const test::Outcome done = render(frames("a"));
    ASSERT_EQ(done.status, 0) << done.err;
    for (const char* frame : {".1.pfm", ".2.pfm", ".3.pfm"})
        EXPECT_EQ(text(std::string("a") + frame), text(std::string("whole") + frame)) << frame;
    EXPECT_FALSE(there("a"));
}

TEST_F(UnattendedCommand, JobsFailAlone) {
    write("jobs.json", R"({"defaults": {"width": 16, "method": "path", "spp": 1}, "jobs": [
        {"name": "gone", "scene": "gone.xml", "output": "gone.pfm"},
        {"name": "wrong", "scene": "scene.xml", "output": "wrong.pfm", "options": {"sppp": 3}},
        {"name": "good", "scene": "scene.xml", "output": ["good.pfm", "good.png"]}]})");
    test::Outcome outcome = render({"--batch", "jobs.json"});
    EXPECT_EQ(outcome.status, 3);
    EXPECT_TRUE(says(outcome, "render: [job gone] scene file 'gone.xml' does not exist\n")) << outcome.err;
    EXPECT_TRUE(says(outcome, "render: jobs.json: job wrong: ")) << outcome.err;
    EXPECT_TRUE(says(outcome, "sppp")) << outcome.err;
    EXPECT_TRUE(says(outcome, "render: jobs: 1 done in ")) << outcome.err;
    EXPECT_TRUE(outcome.err.ends_with(", failed: wrong, gone\n")) << outcome.err;
    EXPECT_EQ(litter({"jobs.json", "good.pfm", "good.png"}), std::vector<std::string>());
    // What is there is left; half of it is not all.
    const std::string good = text("good.pfm");
    write("gone.xml", text("scene.xml"));
    outcome = render({"--batch", "jobs.json"});
    EXPECT_EQ(outcome.status, 3);
    EXPECT_TRUE(says(outcome, "jobs: 1 done")) << outcome.err;
    EXPECT_TRUE(says(outcome, "there already (--overwrite): good, failed: wrong")) << outcome.err;
    std::filesystem::remove(in_folder("good.png"));
    outcome = render({"--batch", "jobs.json"});
    EXPECT_TRUE(says(outcome, "there already (--overwrite): gone, failed: wrong")) << outcome.err;
    EXPECT_TRUE(there("good.png"));
    EXPECT_EQ(text("good.pfm"), good);
}

TEST_F(UnattendedCommand, JobsShareNoFiles) {
    write("jobs.json", R"({"defaults": {"width": 128, "method": "path", "spp": 100, "threads": 1, "checkpoint": "s",
        "checkpoint-every": "0.2s"}, "jobs": [
        {"name": "one", "scene": "scene.xml", "output": "one.pfm"},
        {"name": "two", "scene": "scene.xml", "output": "two.pfm"},
        {"name": "three", "scene": "scene.xml", "output": "one.pfm"}]})");
    // The second job's checkpoint is its own: the first, which is done, asks for none.
    ASSERT_EQ(render_until("s.two", SIGTERM, {"--batch", "jobs.json"}).status, 143);
    EXPECT_TRUE(there("one.pfm") && there("s.two"));
    const test::Outcome outcome = render({"--batch", "jobs.json"});
    EXPECT_EQ(outcome.status, 3) << outcome.err;
    EXPECT_TRUE(says(outcome, "job three: one.pfm is written by job one, too")) << outcome.err;
    EXPECT_TRUE(says(outcome, "going on from s.two")) << outcome.err;
    EXPECT_TRUE(says(outcome, "jobs: 1 done in ")) << outcome.err;
    EXPECT_EQ(litter({"jobs.json", "one.pfm", "two.pfm"}), std::vector<std::string>());
}

// A record file that is refused, or whose scene is not the last frame's, is never replaced.
TEST_F(UnattendedCommand, RecordFilesAreNotLostToOtherScenes) {
    ASSERT_EQ(render(with({"scene.xml", "-o", "a.pfm", "--save-records", "r", "--accuracy", "0.4"})).status, 0);
    const std::string records = text("r");
    test::Outcome outcome = render(with({"scene.xml", "--frames", "1-2", "-o", "b.#.pfm", "--load-records", "r",
                                         "--save-records", "r", "--accuracy", "0.2"}));
    EXPECT_EQ(outcome.status, 3) << outcome.err;
    EXPECT_TRUE(outcome.err.ends_with("failed: 1, 2\n")) << outcome.err;
    EXPECT_EQ(text("r"), records);
    std::string changed = text("scene.xml");
    write("s.1.xml", changed);
    write("s.2.xml", changed.replace(changed.find("0.61, 0.07"), 10, "0.62, 0.07"));
    outcome = render(with({"s.#.xml", "--frames", "1-2", "-o", "c.#.pfm", "--load-records", "r", "--save-records", "r",
                           "--accuracy", "0.4"}));
    EXPECT_EQ(outcome.status, 1) << outcome.err;
    EXPECT_TRUE(says(outcome, "r: left as it is: the last frame's scene is not that of its records")) << outcome.err;
    EXPECT_TRUE(there("c.1.pfm") && there("c.2.pfm"));
    EXPECT_EQ(text("r"), records);
}

// Frames that failed have another chance, from the checkpoint, with the records of the others.
TEST_F(UnattendedCommand, FailedFramesKeepTheCheckpoint) {
    for (const char* name : {"s.1.xml", "s.3.xml"}) write(name, text("scene.xml"));
    const Arguments frames = with({"s.#.xml", "--frames", "1-3", "-o", "a.#.pfm", "--checkpoint", "state"});
    EXPECT_EQ(render(frames).status, 3);
    EXPECT_TRUE(there("state"));
    const std::string third = text("a.3.pfm");
    write("s.2.xml", text("scene.xml"));
    const test::Outcome outcome = render(frames);
    EXPECT_EQ(outcome.status, 0) << outcome.err;
    EXPECT_TRUE(there("a.2.pfm"));
    EXPECT_EQ(text("a.3.pfm"), third);
    EXPECT_FALSE(there("state"));
}

TEST_F(UnattendedCommand, SaysWhatIsWrongWithTheCommandLine) {
    const auto wrong = [&](const Arguments& arguments, const std::string& what) {
        expect_one_line(render(arguments), 2, "render", what);
    };
    wrong({"scene.xml", "-o", "a.#.pfm", "--frames", "5-1"}, "'5-1' is not a list of frames");
    wrong({"scene.xml", "-o", "a.#.pfm", "--frames", "1-x"}, "'1-x' is not a list of frames");
    wrong({"scene.xml", "-o", "a.pfm", "--frames", "1-3"}, "-o a.pfm: expected one place for the frame's number");
    wrong({"scene.xml", "-o", "a.#.b.#.pfm", "--frames", "1-3"}, "expected one place for the frame's number");
    wrong({"s.#.xml", "-o", "a.pfm"}, "SCENE s.#.xml: has a place for a frame");
    wrong({"scene.xml", "-o", "a.#.pfm", "--frames", "1-3", "--shard", "4/3"}, "'4/3' is not I/N");
    wrong({"scene.xml", "-o", "a.pfm", "--shard", "1/3"}, "--shard: expected --frames too");
    wrong({"scene.xml", "-o", "a.pfm", "--camera-path", "p.json"}, "--camera-path: expected --frames too");
    wrong({"scene.xml", "-o", "a.pfm", "--checkpoint", "c", "--checkpoint-every", "0s"}, "is not a time above 0");
    wrong({"scene.xml", "-o", "c", "--checkpoint", "c"}, "--checkpoint c: is another option's file, too");
    wrong({"scene.xml", "-o", "a.#.pfm", "--frames", "1-3", "--checkpoint", "a.2.pfm"}, "is another option's file");
    wrong({"scene.xml", "-o", "a.pfm", "--load-records", "r", "--target-error", "2%"}, "--load-records: ");
    wrong({"scene.xml", "--batch", "jobs.json"}, "--batch: its jobs have scenes of their own");
    EXPECT_EQ(files(), 2u);
}

}  // namespace
}  // namespace irradia
