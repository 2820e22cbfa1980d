// --save-records, --load-records, --points as a user calls them.
#include <nlohmann/json.hpp>

#include "command.h"
#include "irradia/RecordFile.h"

namespace irradia {
namespace {

const std::string kScene = std::string(IRRADIA_SOURCE_DIR) + "/scenes/cornell-box.xml";

class RecordsCommand : public test::CommandTest {
protected:
    test::Outcome render(const std::vector<std::string>& arguments) const { return call(RENDER, arguments); }
    test::Outcome render_small(std::vector<std::string> arguments, const std::string& scene = kScene) const {
        arguments.insert(arguments.begin(), {scene, "--spp", "1", "--width", "24", "--height", "24", "--hemisphere",
                                             "4x16", "--grid-paths", "1024", "--quiet"});
        return render(arguments);
    }
    /// The scene with one piece of its text replaced.
    std::string changed_scene(const std::string& from, const std::string& to) const {
        std::string text = test::file_text(kScene);
        const std::size_t at = text.find(from);
        EXPECT_NE(at, std::string::npos) << from;
        text.replace(at, from.size(), to);
        std::ofstream(in_folder("changed.xml")) << text;
        return "changed.xml";
    }
    void write(const std::string& name, const std::string& text) const { std::ofstream(in_folder(name)) << text; }
    std::uint64_t records_of(const std::string& stats) const {
        return nlohmann::json::parse(test::file_text(in_folder(stats)))["records"];
    }
};

TEST_F(RecordsCommand, AreSavedLoadedAndAppendedTo) {
    ASSERT_EQ(render_small({"-o", "a.pfm", "--save-records", "r", "--stats", "a.json"}).status, 0);
    const RecordSet first = read_records(in_folder("r"));
    EXPECT_EQ(first.irradiance.size(), records_of("a.json"));
    ASSERT_GT(first.irradiance.size(), 20u);
    // Loaded alone: the file stays as it is; no record is made.
    const std::string bytes = test::file_text(in_folder("r"));
    ASSERT_EQ(render_small({"-o", "b.pfm", "--load-records", "r", "--stats", "b.json"}).status, 0);
    EXPECT_EQ(records_of("b.json"), records_of("a.json"));
    EXPECT_EQ(test::file_text(in_folder("r")), bytes);
    // Another camera, more samples, another size: no mismatch. What is new is appended.
    const std::string moved = changed_scene("origin=\"0, 1, 4\"", "origin=\"0.5, 1, 4\"");
    const test::Outcome outcome =
        render({moved, "-o", "c.pfm", "--spp", "2", "--width", "30", "--height", "20", "--hemisphere", "4x16",
                "--grid-paths", "1024", "--load-records", "r", "--save-records", "r", "--seed", "5"});
    ASSERT_EQ(outcome.status, 0) << outcome.err;
    EXPECT_NE(outcome.err.find("appended to r: "), std::string::npos) << outcome.err;
    const std::string after = test::file_text(in_folder("r"));
    ASSERT_GT(after.size(), bytes.size());
    EXPECT_EQ(after.substr(0, bytes.size()), bytes);
    const RecordSet second = read_records(in_folder("r"));
    EXPECT_GT(second.irradiance.size(), first.irradiance.size());
    EXPECT_EQ(second.views.size(), 2u);
    // Both pictures are known now.
    ASSERT_EQ(render_small({"-o", "b.pfm", "--load-records", "r", "--save-records", "s"}).status, 0);
    EXPECT_EQ(read_records(in_folder("s")).irradiance.size(), second.irradiance.size());
}

TEST_F(RecordsCommand, OfAnotherRenderAreRefusedByName) {
    ASSERT_EQ(render_small({"-o", "a.pfm", "--save-records", "r"}).status, 0);
    const auto refused = [&](const std::vector<std::string>& more, const std::string& what,
                             const std::string& scene = kScene) {
        std::vector<std::string> arguments = {"-o", "b.pfm", "--load-records", "r"};
        arguments.insert(arguments.end(), more.begin(), more.end());
        expect_one_line(render_small(arguments, scene), 1, "render", what);
        arguments.push_back("--force-records");
        const test::Outcome forced = render_small(arguments, scene);
        EXPECT_EQ(forced.status, 0) << forced.err;
    };
    refused({"--accuracy", "0.5"}, "r: made for another render: --accuracy is 0.2 there, 0.5 here");
    refused({"--radius", "minimum", "--no-neighbour-clamp"},
            "--radius is hessian there, minimum here; --neighbour-clamp is on");
    refused({}, "made for another render: other emitters", changed_scene("value=\"16, 12, 5\"", "value=\"16, 12, 6\""));
    refused({}, "made for another render: other geometry",
            changed_scene("<shape type=\"cube\" id=\"tall-block\">",
                          "<shape type=\"sphere\"><float name=\"radius\" value=\".1\"/></shape>"
                          "<shape type=\"cube\" id=\"tall-block\">"));
    // The warning tells what was forced.
    const test::Outcome loud = render({kScene, "-o", "b.pfm", "--width", "8", "--height", "8", "--spp", "1",
                                       "--load-records", "r", "--force-records"});
    EXPECT_NE(
        loud.err.find("warning: r: used although made for another render: --hemisphere is 4x16 there, 16x32 here"),
        std::string::npos)
        << loud.err;
}

TEST_F(RecordsCommand, DamageIsToldInOneLine) {
    ASSERT_EQ(render_small({"-o", "a.pfm", "--save-records", "r"}).status, 0);
    const std::string bytes = test::file_text(in_folder("r"));
    // Forced or not: a header is right or wrong.
    for (const std::vector<std::string>& more : {std::vector<std::string>{}, {"--force-records"}}) {
        const auto refused = [&](const std::string& text, const std::string& what) {
            std::ofstream(in_folder("d"), std::ios::binary) << text;
            std::vector<std::string> arguments = {"-o", "b.pfm", "--load-records", "d"};
            arguments.insert(arguments.end(), more.begin(), more.end());
            expect_one_line(render_small(arguments), 1, "render", what);
        };
        refused("", "d: not a record file");
        refused(bytes.substr(0, 100), "d: cut off");
        std::string other = bytes;
        other[12] = 9;
        refused(other, "d: record file of version 9, expected 1");
        other = bytes;
        other[40] = static_cast<char>(other[40] ^ 1);
        refused(other, "d: damaged record file");
    }
    // A tail that is cut off costs itself; saved again, the file is whole.
    std::ofstream(in_folder("d"), std::ios::binary) << bytes.substr(0, bytes.size() - 5);
    const test::Outcome recovered =
        render({kScene, "-o", "b.pfm", "--spp", "1", "--width", "24", "--height", "24", "--hemisphere", "4x16",
                "--grid-paths", "1024", "--load-records", "d", "--save-records", "d"});
    EXPECT_EQ(recovered.status, 0);
    EXPECT_NE(recovered.err.find("warning: d: cut off from byte"), std::string::npos) << recovered.err;
    EXPECT_NE(recovered.err.find("wrote d: "), std::string::npos) << recovered.err;
    EXPECT_EQ(read_records(in_folder("d")).irradiance.size(), read_records(in_folder("r")).irradiance.size());

    expect_one_line(render({kScene, "-o", "b.pfm", "--load-records", "none"}), 1, "render", "none: cannot be read");
    expect_one_line(render({kScene, "-o", "b.pfm", "--save-records", "none/r"}), 1, "render", "none/r: ");
}

TEST_F(RecordsCommand, PointsAreAnsweredInTheirOrder) {
    write("p.csv", "x,y,z,nx,ny,nz\n# on the floor\n0.5,0,0.25,0,1,0\n\n-0.5\t0 0.25  0 2 0\r\n0,1,-1,0,0,1");
    ASSERT_EQ(render_small({"--points", "p.csv", "-o", "e.csv", "--save-records", "r"}).status, 0);
    std::istringstream lines(test::file_text(in_folder("e.csv")));
    std::string line;
    std::getline(lines, line);
    EXPECT_EQ(line, "x,y,z,nx,ny,nz,E_r,E_g,E_b,direct_r,direct_g,direct_b,indirect_r,indirect_g,indirect_b");
    std::vector<std::string> answers;
    while (std::getline(lines, line)) answers.push_back(line);
    ASSERT_EQ(answers.size(), 3u);
    EXPECT_EQ(answers[0].rfind("0.5,0,0.25,0,1,0,", 0), 0u) << answers[0];
    EXPECT_EQ(answers[1].rfind("-0.5,0,0.25,0,2,0,", 0), 0u) << answers[1];
    EXPECT_EQ(answers[2].rfind("0,1,-1,0,0,1,", 0), 0u) << answers[2];
    EXPECT_EQ(std::count(answers[2].begin(), answers[2].end(), ','), 14);
    // Asked again of the records alone: the same answers.
    EXPECT_EQ(read_records(in_folder("r")).irradiance.size(), 3u);
    ASSERT_EQ(render_small({"--points", "p.csv", "-o", "f.csv", "--load-records", "r", "--save-records", "r"}).status,
              0);
    EXPECT_EQ(test::file_text(in_folder("e.csv")), test::file_text(in_folder("f.csv")));
    EXPECT_EQ(read_records(in_folder("r")).irradiance.size(), 3u);
}

TEST_F(RecordsCommand, WrongPointsAreToldByLine) {
    const std::vector<std::pair<std::string, std::string>> wrong = {
        {"", "p.csv: no points, expected lines x,y,z,nx,ny,nz"},
        {"x,y,z,nx,ny,nz\n", "p.csv: no points"},
        {"0,0,0,0,1,0\n1,2,3\n", "p.csv:2: 3 values, expected 6"},
        {"0,0,0,0,1,0,7\n", "p.csv:1: 7 values, expected 6"},
        {"0,0,0,0,1,0\n\n0,0,zero,0,1,0\n", "p.csv:3: 'zero', expected a finite number"},
        {"0,0,0,0,1,nan\n", "p.csv:1: 'nan', expected a finite number"},
        {"0,0,1e999,0,1,0\n", "p.csv:1: '1e999', expected a finite number"},
        {"0,0,0,0,0,0\n", "p.csv:1: a normal of length zero"},
        {"1e30,0,0,0,1,0\n", "p.csv:1: a position out of reach"},
        {"a,b,c\nd,e,f\n", "p.csv:2: 3 values"},
    };
    for (const auto& [text, what] : wrong) {
        SCOPED_TRACE(what);
        write("p.csv", text);
        expect_one_line(render({"none.xml", "--points", "p.csv", "-o", "e.csv"}), 1, "render", what);
    }
    expect_one_line(render({kScene, "--points", "none.csv", "-o", "e.csv"}), 1, "render", "none.csv: cannot be read");
    EXPECT_EQ(files(), 1u);
}

TEST_F(RecordsCommand, WrongCommandLinesExitWithTwo) {
    const std::vector<std::pair<std::vector<std::string>, std::string>> wrong = {
        {{kScene, "-o", "a.pfm", "--method", "path", "--save-records", "r"},
         "--save-records: --method path has no records"},
        {{kScene, "-o", "a.pfm", "--method", "gather", "--load-records", "r"}, "--load-records: --method gather"},
        {{kScene, "-o", "a.csv", "--method", "path", "--points", "p"}, "--points: --method path"},
        {{kScene, "--pack", "a", "--save-records", "r"}, "--save-records: nothing is rendered"},
        {{kScene, "-o", "a.pfm", "--force-records"}, "--force-records: expected --load-records"},
        {{kScene, "-o", "a.csv"}, "only --points writes .csv"},
        {{kScene, "-o", "a.pfm", "--points", "p"}, "--points writes a .csv"},
        {{kScene, "-o", "a.csv", "--points", "p", "--stats", "s.json"}, "--points: has no --stats"},
    };
    for (const auto& [arguments, what] : wrong) {
        SCOPED_TRACE(what);
        expect_one_line(render(arguments), 2, "render", what);
    }
    EXPECT_EQ(files(), 0u);
}

}  // namespace
}  // namespace irradia
