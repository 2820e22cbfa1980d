// Every kernel of cl/ under oclgrind, an OpenCL device that checks: no data race, no access out of bounds, no use of
// uninitialised memory, no barrier that part of a group does not reach, no wrong call of the API. Small pictures; what
// the kernels compute is tested elsewhere.
#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <regex>
#include <set>
#include <sstream>

#include "../app/command.h"
#include "device/kernel_source.h"

namespace irradia::test {
namespace {

using Names = std::set<std::string>;

const Names kUngridded{"find_misses",    "sample_hemispheres", "clamp_records",
                       "insert_records", "pack_records",       "shade_pixels"};
const Names kIrradiance{"trace_grid_paths", "merge_grid_level", "grid_means",   "find_misses", "sample_hemispheres",
                        "clamp_records",    "insert_records",   "pack_records", "shade_pixels"};
const Names kRadianceSamples = [] {
    Names names = kIrradiance;
    names.insert("tabulate_lobes");
    names.insert("find_disagreements");
    return names;
}();
const Names kRadianceHarmonics = [] {
    Names names = kRadianceSamples;
    names.insert("project_harmonics");
    return names;
}();
const Names kUnclamped = [] {
    Names names = kIrradiance;
    names.erase("clamp_records");
    return names;
}();
const Names kUnderSky = [] {
    Names names = kUnclamped;
    names.insert("learn_sky");
    return names;
}();
const Names kGather{"gather_points", "sample_hemispheres", "gather_irradiance"};
const Names kPath{"trace_paths"};
const Names kProbes{"find_lamps", "probe_pixels"};
const Names kPoints{"trace_grid_paths", "merge_grid_level",   "grid_means",     "find_point_misses",
                    "point_irradiance", "sample_hemispheres", "insert_records", "pack_records"};
Names with_lamps(Names names) {  // --aov all: counted
    names.insert("find_lamps");
    return names;
}
const Names kTraversal{"test_closest", "test_occluded", "test_tile", "test_tile_occluded"};
const Names kFormulas{"formula_angle",      "formula_crease", "formula_edge_flux", "formula_ellipse",
                      "formula_filter",     "formula_frame",  "formula_ggx",       "formula_harmonics",
                      "formula_hemisphere", "formula_limits", "formula_probe",     "formula_rectangle",
                      "formula_reproject",  "formula_ring",   "formula_shapes",    "formula_stratum",
                      "formula_triangle",   "formula_weight", "test_sum_cells"};
const Names kCache{"insert_records", "move_nodes", "pack_records", "look_up"};
const Names kEchoSizes{"echo_sizes"};
const Names kShapes{"test_cylinder", "test_lens_ray", "test_lens_centre"};
const Names kGrid{"test_grid_deposit", "test_grid_keys", "test_grid_lookup", "merge_grid_level", "grid_means"};

const Names kLights{"test_light_samples", "test_light_tile", "test_environment", "test_area_light", "test_grid_keys"};
const Names kTextures{"test_textures"};
const Names kSamplePoints{"test_sobol_points", "test_strata_points"};
const Names kRadianceTests{"insert_records",    "project_harmonics",    "tabulate_lobes",  "test_lobe_values",
                           "test_lobe_weights", "test_radiance_lookup", "test_record_sums"};
const Names kBsdfs{"test_bsdf_evaluate", "test_bsdf_at", "test_bsdf_sample", "test_microfacets", "test_fresnel"};

/// The first and last line of function `name` of the device code `file`.
std::pair<int, int> lines_of(const std::string& file, const std::string& name) {
    std::string text;
    EXPECT_TRUE(device::find_source(file, text)) << file;
    const std::size_t begin = text.find(" " + name + "("), end = text.find("\n}\n", begin);
    if (begin == std::string::npos || end == std::string::npos) {
        ADD_FAILURE() << "no function " << name << " in " << file;
        return {0, -1};
    }
    const auto line = [&](std::size_t at) {
        return 1 + static_cast<int>(std::count(text.begin(), text.begin() + static_cast<std::ptrdiff_t>(at), '\n'));
    };
    return {line(begin), line(end + 1)};
}

/// The one thing that oclgrind says of this code by right and that is meant: insertion into the octree is lock-free.
/// Words that others set by compare-and-swap, and entries published by it, are read by plain loads (OpenCL 1.2 has no
/// atomic ones). So a read-write race is no finding if both sides lie in octree_make(), or in octree_enter() and the
/// function before it, which reads ahead for it.
bool is_lock_free_insertion(const std::string& message) {
    if (message.find("Read-write data race at global memory address") != 0) return false;
    if (message.find("\tKernel: insert_records\n") == std::string::npos) return false;
    const std::regex place("At line ([0-9]+) \\(column [0-9]+\\) of ([^:]+):");
    std::vector<int> lines;
    for (std::sregex_iterator i(message.begin(), message.end(), place), end; i != end; ++i) {
        if ((*i)[2] != "octree.h") return false;
        lines.push_back(std::stoi((*i)[1]));
    }
    if (lines.size() != 2) return false;
    for (const auto& [from, to] :
         {std::pair("octree_make", "octree_make"), std::pair("octree_send_for", "octree_enter")}) {
        const int first = lines_of("octree.h", from).first, last = lines_of("octree.h", to).second;
        const auto within = [&](int line) { return line >= first && line <= last; };
        if (within(lines[0]) && within(lines[1])) return true;
    }
    return false;
}

/// The messages of a log, without those that are no finding. A message begins at the margin; what follows is indented.
std::vector<std::string> findings(const std::string& log) {
    std::vector<std::string> messages;
    std::istringstream lines(log);
    for (std::string line; std::getline(lines, line);) {
        if (line.empty()) continue;
        if (line[0] != '\t' || messages.empty()) messages.emplace_back();
        messages.back() += line + "\n";
    }
    std::erase_if(messages, is_lock_free_insertion);
    return messages;
}

class Oclgrind : public CommandTest {
protected:
    void SetUp() override {
        CommandTest::SetUp();
        if (std::system("command -v oclgrind >/dev/null") != 0)
            GTEST_SKIP() << "oclgrind is not installed (Debian package oclgrind)";
    }

    /// Runs a command under oclgrind: it succeeds, runs the kernels `expected` and no others, and nothing is found.
    /// `uninitialized` false: but for uses of uninitialised memory.
    void check(const std::string& executable, const std::vector<std::string>& arguments, const Names& expected,
               bool uninitialized = true) const {
        // It has no prefetch, and running sample_hemispheres over lanes of eight it crashes: that code is checked with
        // single numbers here, and its results elsewhere (DeviceHemisphere). Kernels kept are for other drivers.
        // Code as clang emits it: optimised code holds instructions (freeze, bitreverse) that oclgrind 21.10 lacks.
        // The names of the kernels come from a library that the shell preloads before oclgrind's own; oclgrind's
        // --inst-counts, which also prints them, corrupts the heap where a kernel is large.
        std::vector<std::string> line{
            "--build-options",
            "-O0 -disable-llvm-passes -D IR_NO_PREFETCH=1 -D IR_SCALAR_LANES=1",
            "--num-threads",
            "1",
            "--data-races",
            "--check-api",
            "--max-errors",
            "100000",
            "--log",
            in_folder("log"),
            "sh",
            "-c",
            R"(KERNEL_LOG=$0 LD_PRELOAD="$1 $LD_PRELOAD"; IRRADIA_KERNEL_CACHE=; export KERNEL_LOG LD_PRELOAD IRRADIA_KERNEL_CACHE; shift; exec "$@")",
            in_folder("kernels"),
            KERNEL_LOG_LIBRARY,
            executable};
        if (uninitialized) line.insert(line.begin(), "--uninitialized");
        line.insert(line.end(), arguments.begin(), arguments.end());
        std::filesystem::remove(in_folder("kernels"));
        std::filesystem::remove(in_folder("log"));
        const Outcome outcome = call("oclgrind", line);
        ASSERT_EQ(outcome.status, 0) << outcome.err << outcome.out.substr(0, 2000) << file_text(in_folder("log"));
        Names ran;
        std::istringstream names(file_text(in_folder("kernels")));
        for (std::string name; std::getline(names, name);) ran.insert(name);
        EXPECT_EQ(ran, expected);
        ASSERT_TRUE(std::filesystem::exists(in_folder("log")));
        const std::vector<std::string> found = findings(file_text(in_folder("log")));
        EXPECT_TRUE(found.empty()) << found.size() << " messages, the first:\n" << found.front();
    }

    void render(const std::string& scene, const std::string& traversal, std::vector<std::string> options,
                const Names& expected, bool uninitialized = true) const {
        options.insert(options.begin(), {scene, "-o", "a.exr", "--traversal", traversal, "--threads", "1"});
        check(RENDER, options, expected, uninitialized);
    }

    static std::string project_scene(const std::string& name) {
        return std::string(IRRADIA_SOURCE_DIR) + "/scenes/" + name + ".xml";
    }

    /// Rough surfaces of each kind that radiance records answer.
    std::string glossy_scene() const {
        std::ofstream(in_folder("glossy.xml")) << R"(<scene version="3.0.0">
<sensor type="perspective"><float name="fov" value="50"/>
    <transform name="to_world"><lookat origin="0, 2, 5" target="0, 0.7, 0" up="0, 1, 0"/></transform>
    <film type="hdrfilm"><rfilter type="gaussian"/></film></sensor>
<shape type="rectangle"><transform name="to_world"><scale value="3"/><rotate x="1" angle="-90"/></transform>
    <bsdf type="roughplastic"><rgb name="diffuse_reflectance" value="0.4"/><float name="alpha" value="0.3"/></bsdf></shape>
<shape type="rectangle"><transform name="to_world"><scale value="3"/><translate z="-1.5"/></transform>
    <bsdf type="roughconductor"><string name="material" value="Cu"/><float name="alpha" value="0.4"/></bsdf></shape>
<shape type="sphere"><point name="center" x="0.5" y="0.5" z="1"/><float name="radius" value="0.5"/>
    <bsdf type="diffuse"/></shape>
<shape type="rectangle"><transform name="to_world"><rotate x="1" angle="90"/><translate y="3"/></transform>
    <emitter type="area"><rgb name="radiance" value="3, 2, 1"/></emitter></shape>
</scene>)";
        return in_folder("glossy.xml");
    }

    /// A scene that needs everything that kernels are specialised by: textures, analytic surfaces, smooth normals,
    /// an environment, lights at points, a textured light; and area lights of both kinds.
    std::string whole_scene() const {
        std::ofstream(in_folder("a.obj")) << "v -1 0 -1\nv 1 0 -1\nv 0 0 1\nv 0 1 0\nvn -1 0 -1\nvn 1 0 -1\nvn 0 0 1\n"
                                             "vn 0 1 0\nf 1//1 2//2 3//3\nf 1//1 4//4 2//2\nf 2//2 4//4 3//3\n"
                                             "f 3//3 4//4 1//1\n";
        std::ofstream(in_folder("whole.xml")) << R"(<scene version="3.0.0">
<sensor type="perspective"><float name="fov" value="50"/>
    <transform name="to_world"><lookat origin="0, 2, 5" target="0, 0.7, 0" up="0, 1, 0"/></transform>
    <film type="hdrfilm"><rfilter type="gaussian"/></film></sensor>
<shape type="rectangle"><transform name="to_world"><scale value="3"/><rotate x="1" angle="-90"/></transform>
    <bsdf type="twosided"><bsdf type="diffuse"><texture type="bitmap" name="reflectance">
    <string name="filename" value=")" << IRRADIA_SOURCE_DIR
                                              << R"(/scenes/textures/tiles.png"/></texture></bsdf></bsdf></shape>
<shape type="obj"><string name="filename" value="a.obj"/>
    <bsdf type="diffuse"><rgb name="reflectance" value="0.7, 0.5, 0.3"/></bsdf></shape>
<shape type="sphere"><point name="center" x="1.2" y="0.5" z="1"/><float name="radius" value="0.5"/></shape>
<shape type="disk"><transform name="to_world"><translate x="-1.2" y="1" z="-1"/></transform></shape>
<shape type="sphere"><point name="center" x="-1" y="0.3" z="1.2"/><float name="radius" value="0.3"/>
    <emitter type="area"><rgb name="radiance" value="3, 2, 1"/></emitter></shape>
<shape type="rectangle"><transform name="to_world"><rotate x="1" angle="90"/><translate y="3"/></transform>
    <emitter type="area"><texture type="bitmap" name="radiance"><string name="filename" value=")"
                                              << IRRADIA_SOURCE_DIR << R"(/scenes/textures/tiles.png"/></texture>
    </emitter></shape>
<emitter type="point"><point name="position" x="2" y="2" z="2"/><rgb name="intensity" value="5"/></emitter>
<emitter type="spot"><rgb name="intensity" value="5"/><transform name="to_world"><lookat origin="-2, 2, 2"
    target="0, 0, 0" up="0, 1, 0"/></transform></emitter>
<emitter type="constant"><rgb name="radiance" value="0.3"/></emitter>
</scene>)";
        return in_folder("whole.xml");
    }
};

// ---- `render`: both traversals, scenes that need nothing special and everything, the variants of each method
// ----------

// Two blocks of 4x4 pixels, so that records are made and inserted several at once; two tiles of strata.
const std::vector<std::string> kTwoTiles{"--width", "8", "--height",     "4", "--hemisphere", "4x8",
                                         "--spp",   "2", "--grid-paths", "64"};

// Without the check for uninitialised memory, as all that make records: oclgrind 21.10 takes points for uninitialised
// that find_misses has pushed whole (cl/point_list.h), and all but the first word of packed entries (constants written
// there, too), and from there everything. Cache has the same insertion, packing and look-ups, with that check.
TEST_F(Oclgrind, IrradianceCpu) { render(project_scene("cornell-box"), "cpu", kTwoTiles, kIrradiance, false); }
TEST_F(Oclgrind, IrradianceGpu) { render(project_scene("cornell-box"), "gpu", kTwoTiles, kIrradiance, false); }

// Between two walls, under a picture: paths that learn what is seen of it, and samples of the tiles they have met.
TEST_F(Oclgrind, IrradianceUnderASky) {
    std::ofstream(in_folder("sky.xml")) << R"(<scene version="3.0.0">
<sensor type="perspective"><float name="fov" value="20"/>
    <transform name="to_world"><lookat origin="0, 0.3, 0.4" target="0, 0.3, 0" up="0, 1, 0"/></transform></sensor>
<shape type="rectangle"/>
<shape type="rectangle"><transform name="to_world"><rotate y="1" angle="180"/><translate z="0.5"/></transform></shape>
<emitter type="envmap"><string name="filename" value=")"
                                        << IRRADIA_SOURCE_DIR << R"(/scenes/textures/tiles.png"/></emitter>
</scene>)";
    const std::vector<std::string> options{"--width", "8",  "--height",     "4", "--hemisphere", "4x8",
                                           "--spp",   "16", "--grid-paths", "64"};
    for (const std::string traversal : {"cpu", "gpu"})
        render(in_folder("sky.xml"), traversal, options, kUnderSky, false);
}

TEST_F(Oclgrind, IrradianceWithoutGrid) {
    std::vector<std::string> options = kTwoTiles;
    options.emplace_back("--no-grid");
    render(project_scene("cornell-box"), "cpu", options, kUngridded, false);
}

// Strata that fill no tile; every other rule, the layers.
const std::vector<std::string> kOtherRules{"--width",
                                           "4",
                                           "--height",
                                           "4",
                                           "--hemisphere",
                                           "3x7",
                                           "--spp",
                                           "3",
                                           "--gradients",
                                           "ward",
                                           "--radius",
                                           "minimum",
                                           "--weight",
                                           "tabellion",
                                           "--direct-mis",
                                           "off",
                                           "--no-share-lookups",
                                           "--aov",
                                           "all",
                                           "--grid-paths",
                                           "32"};

TEST_F(Oclgrind, IrradianceOfAWholeSceneCpu) {
    render(whole_scene(), "cpu", kOtherRules, with_lamps(kIrradiance), false);
}
TEST_F(Oclgrind, IrradianceOfAWholeSceneGpu) {
    render(whole_scene(), "gpu", kOtherRules, with_lamps(kIrradiance), false);
}

TEST_F(Oclgrind, IrradianceWithoutRefinements) {
    render(project_scene("furnace"), "cpu",
           {"--width", "4", "--height", "4", "--hemisphere", "4x4", "--spp", "1", "--gradients", "none", "--radius",
            "harmonic", "--no-neighbour-clamp", "--no-gradient-limit", "--no-in-front", "--max-depth", "4",
            "--grid-paths", "32"},
           kUnclamped, false);
}

// Both representations, a traversal each; records' cells fill whole vectors or not. Without the check for uninitialised
// memory: oclgrind 21.10 takes all but the first word of a point for uninitialised that find_misses has written whole
// to `lobe_points` (word by word, too), as soon as sample_hemispheres reads it, and from there everything.
TEST_F(Oclgrind, RadianceBySamples) {
    render(glossy_scene(), "cpu",
           {"--method", "radiance", "--glossy", "samples", "--trace-below", "0.05", "--width", "6", "--height", "4",
            "--hemisphere", "3x7", "--spp", "1", "--grid-paths", "64", "--lobe-table", "4"},
           kRadianceSamples, false);
}

TEST_F(Oclgrind, RadianceByHarmonics) {
    render(glossy_scene(), "gpu",
           {"--method",     "radiance", "--glossy",     "harmonics", "--order",      "3",   "--trace-below", "0.05",
            "--width",      "6",        "--height",     "4",         "--hemisphere", "4x4", "--spp",         "1",
            "--grid-paths", "64",       "--lobe-table", "4"},
           kRadianceHarmonics, false);
}

TEST_F(Oclgrind, Gather) {
    const std::vector<std::string> options{"--method", "gather",       "--width", "3",     "--height",
                                           "3",        "--hemisphere", "4x8",     "--spp", "1"};
    render(project_scene("cornell-box"), "cpu", options, kGather);
    std::vector<std::string> more = options;
    more.insert(more.end(), {"--aov", "all", "--direct-mis", "off"});
    render(whole_scene(), "cpu", more, with_lamps(kGather));
    render(whole_scene(), "gpu", more, with_lamps(kGather));
}

TEST_F(Oclgrind, Path) {
    for (const std::string traversal : {"cpu", "gpu"}) {
        for (const std::string scene : {"cornell-box", "spheres", "textured", "integrating-sphere", "occluder",
                                        "glossy-box", "glossy-window", "glossy-knot"})
            render(project_scene(scene), traversal, {"--method", "path", "--width", "5", "--height", "4", "--spp", "1"},
                   kPath);
        render(whole_scene(), traversal,
               {"--method", "path", "--width", "5", "--height", "4", "--spp", "2", "--aov", "all"}, with_lamps(kPath));
    }
}

// Without the check for uninitialised memory: see RadianceBySamples, of the words of packed entries.
TEST_F(Oclgrind, Points) {
    std::ofstream(in_folder("points.csv")) << "0,-0.9,0.2,0,1,0\n0.1,-0.9,0.2,0,1,0\n";
    check(RENDER,
          {project_scene("cornell-box"), "--points", in_folder("points.csv"), "-o", in_folder("e.csv"), "--traversal",
           "cpu", "--threads", "1", "--hemisphere", "4x8", "--grid-paths", "64", "--width", "4", "--height", "4"},
          kPoints, false);
}

TEST_F(Oclgrind, Probes) { check(TEST_RENDER, {"--gtest_filter=ErrorProbes.AskEveryKernel*"}, kProbes); }

// ---- kernels that only tests launch, by those tests ----------------------------------------------------------------

TEST_F(Oclgrind, Traversal) { check(TEST_TRAVERSAL, {"--gtest_filter=*Inside*:*IntervalIsOpen*"}, kTraversal); }
TEST_F(Oclgrind, Shapes) { check(DEVICE_SHAPES_TEST, {}, kShapes); }
TEST_F(Oclgrind, Cache) { check(TEST_CACHE, {"--gtest_filter=*HoldsIdenticalRecords:*PackingDoesNotShow"}, kCache); }
TEST_F(Oclgrind, EchoSizes) { check(DEVICE_TEST, {"--gtest_filter=EchoSizes.*"}, kEchoSizes); }
TEST_F(Oclgrind, Grid) {
    check(DEVICE_FORMULAS_TEST, {"--gtest_filter=DeviceGrid.AnEmptyTable*:DeviceGrid.ExtremeDeposits"}, kGrid);
}
TEST_F(Oclgrind, Lights) {
    check(TEST_LIGHTS,
          {"--gtest_filter=EnvironmentLight.RadianceIsMitsubas:EnvironmentLight.OneBrightTexel:SpotLight.IsIts*:"
           "TexturedLight.RadianceAtCoordinates:CylinderLight.SamplesShowTheTexture:RectangleLight.*Alone:"
           "SkyView.*Alone"},
          kLights);
}
TEST_F(Oclgrind, Bsdfs) {
    check(TEST_BSDFS, {"--gtest_filter=Bsdf.IsDark*:Bsdf.TurnsBrushes*:BsdfFormulas.F*:BsdfMaps.OfNo*"}, kBsdfs);
}
TEST_F(Oclgrind, RadianceRecords) {
    check(TEST_RADIANCE, {"--gtest_filter=*SpreadIsTheMeanDeviation*:*SurvivesContact*:*OfATable*:*OfOneView*"},
          kRadianceTests, false);
}
TEST_F(Oclgrind, Textures) { check(DEVICE_TEXTURE_TEST, {"--gtest_filter=DeviceTextures.Checker*"}, kTextures); }
TEST_F(Oclgrind, SamplePoints) {
    check(DEVICE_FORMULAS_TEST, {"--gtest_filter=DevicePoints.FourDimensions*:DevicePoints.RaysGo*"}, kSamplePoints);
}
TEST_F(Oclgrind, Formulas) {  // the quickest tests of each kernel
    check(
        DEVICE_FORMULAS_TEST,
        {"--gtest_filter=DeviceSampling.*:DeviceFlux.AngleOverSine:DeviceFlux.Vectors:DeviceCrease.*:"
         "DeviceHemisphere.FewStrata:DeviceHemisphere.LimitsBright*:DeviceWeight.MatchesVectors:DeviceInFront."
         "MatchesVectors:DeviceRadius.*:"
         "DeviceFilter.*:DeviceHarmonics.*:DeviceGgx.*:DeviceReproject.*:DeviceProbe.*:DeviceSolidAngles.ClosedForms"},
        kFormulas);
}

// ---- the checks themselves -----------------------------------------------------------------------------------------

TEST(OclgrindCoverage, IsAllKernels) {
    Names expected, kernels;
    for (const Names& names :
         {kIrradiance,    kUngridded, kUnclamped, kUnderSky,    kGather, kPath,  kTraversal, kFormulas,
          kCache,         kEchoSizes, kGrid,      kShapes,      kLights, kBsdfs, kTextures,  kRadianceHarmonics,
          kRadianceTests, kProbes,    kPoints,    kSamplePoints})
        expected.insert(names.begin(), names.end());
    const std::regex kernel("IR_KERNEL void ([a-z_0-9]+)\\("), formula("\nIR_FORMULA\\(([a-z_0-9]+),");
    for (const device::EmbeddedFile* f = device::embedded_files(); f->name != nullptr; ++f) {
        const std::string text(reinterpret_cast<const char*>(f->text), f->bytes);
        for (const std::regex& pattern : {kernel, formula})
            for (std::sregex_iterator i(text.begin(), text.end(), pattern), end; i != end; ++i)
                if ((*i)[1] != "name") kernels.insert((*i)[1]);  // IR_FORMULA's own definition
    }
    EXPECT_EQ(kernels, expected);
}

// Faults that oclgrind is there to find are found, in kernels of this test's own.
TEST_F(Oclgrind, FindsWhatIsWrong) {
    const std::map<std::string, std::string> faults{
        {"race", "local uint a[2]; a[get_local_id(0) / 2] = get_local_id(0); out[get_global_id(0)] = a[0];"},
        {"bounds", "out[get_global_id(0) + 1] = 1;"},
        {"uninitialised", "uint a[2]; a[0] = 1; if (a[get_global_id(0) & 1] > 3) out[0] = 1;"},
        {"barrier", "if (get_local_id(0) == 0) barrier(CLK_LOCAL_MEM_FENCE); out[get_global_id(0)] = 1;"}};
    for (const auto& [name, body] : faults) {
        std::ofstream(in_folder("fault.cl")) << "kernel void fault(global uint* out) { " << body << " }\n";
        std::ofstream(in_folder("fault.sim")) << "fault.cl\nfault\n4 1 1\n4 1 1\n<size=16 fill=0 uint>\n";
        call("oclgrind-kernel", {"--build-options", "-O0 -disable-llvm-passes -D IR_NO_PREFETCH=1 -D IR_SCALAR_LANES=1",
                                 "--data-races", "--uninitialized", "--log", in_folder("log"), "fault.sim"});
        EXPECT_FALSE(findings(file_text(in_folder("log"))).empty()) << name;
        std::filesystem::remove(in_folder("log"));
    }
}

TEST(OclgrindFindings, OnlyTheLockFreeInsertionIsNone) {
    const auto race = [](const std::string& kind, const std::string& kernel, int a, int b) {
        const auto entity = [](int line) {
            return "\tentity\n\tAt line " + std::to_string(line) + " (column 3) of octree.h:\n\t  text\n\t\n";
        };
        return "\n" + kind + " data race at global memory address 0x10\n\tKernel: " + kernel + "\n\t\n" + entity(a) +
               entity(b);
    };
    const auto [make, make_end] = lines_of("octree.h", "octree_make");
    const auto [enter, enter_end] = lines_of("octree.h", "octree_enter");
    ASSERT_LT(make_end, enter);
    EXPECT_EQ(findings(race("Read-write", "insert_records", make + 1, make_end - 1)).size(), 0u);
    EXPECT_EQ(findings(race("Read-write", "insert_records", enter_end - 1, enter + 1)).size(), 0u);
    const int ahead = lines_of("octree.h", "octree_send_for").first;
    ASSERT_LT(make_end, ahead);
    EXPECT_EQ(findings(race("Read-write", "insert_records", ahead + 1, enter + 1)).size(), 0u);
    EXPECT_EQ(findings(race("Read-write", "insert_records", make + 1, enter + 1)).size(), 1u);
    EXPECT_EQ(findings(race("Read-write", "insert_records", enter + 1, enter_end + 1)).size(), 1u);
    EXPECT_EQ(findings(race("Write-write", "insert_records", enter + 1, enter + 1)).size(), 1u);
    EXPECT_EQ(findings(race("Read-write", "shade_pixels", enter + 1, enter + 1)).size(), 1u);
    EXPECT_EQ(findings("\nInvalid read of size 4\n\tKernel: insert_records\n").size(), 1u);
    EXPECT_EQ(findings("Oclgrind: 9 errors generated - suppressing further errors\n").size(), 1u);
}

}  // namespace
}  // namespace irradia::test
