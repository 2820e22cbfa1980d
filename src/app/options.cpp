#include "app/options.h"

#include <algorithm>
#include <charconv>
#include <cstdlib>
#include <ostream>

#include "app/batch_options.h"
#include "app/cache_options.h"
#include "app/help.h"
#include "app/log_options.h"
#include "app/memory_option.h"
#include "app/option_group.h"
#include "app/output.h"
#include "app/record_options.h"
#ifndef IRRADIA_MINIMAL
#include "app/report_options.h"
#endif

namespace irradia::app {
namespace {

// "2%" or "0.02" -> 0.02.
std::string read_share(const std::string& given, float& share) {
    char* end = nullptr;
    double value = std::strtod(given.c_str(), &end);
    if (end != given.c_str() && *end == '%') {
        value /= 100;
        ++end;
    }
    if (end == given.c_str() || *end != '\0' || !(value > 0 && value < 1))
        return "'" + given + "' is not a part of the picture's mean between 0 and 1, for example 2% or 0.02";
    share = static_cast<float>(value);
    return "";
}

void declare_files(CLI::App& app, Options& o, std::vector<std::string>& defines) {
    app.add_option("SCENE", o.scene, "A Mitsuba 3 scene file (.xml), or a packed scene that --pack wrote");
    Group files(app, "Files");
    files.list("-o,--output", o.outputs, "FILE",
               "Picture to write; may be repeated. Kind by extension: " + output_kinds() +
                   ". An older file is replaced "
                   "only once the new one is complete");
    files.value("--exposure", o.exposure, "STOPS", "PNG and --report: brightness, times 2^STOPS")
        ->check(number("from -60 to 60", [](double x) { return x >= -60 && x <= 60; }))
        ->capture_default_str();
    files
        .value("--aov", o.settings.aovs, "LIST",
               "Layers to add to an EXR, separated by commas, or `all`: " + join(aov_names(), ", "))
        ->delimiter(',')
        ->allow_extra_args(false)
        ->check([](const std::string& given) {
            const auto& names = aov_names();
            return given == "all" || std::find(names.begin(), names.end(), given) != names.end()
                       ? std::string()
                       : "'" + given + "' is not one of all, " + join(names, ", ");
        });
    files.value("--stats", o.stats, "FILE.json",
                "Write times of every stage, rays by kind, records, octree, peak memory, settings, device");
    files.value("--pack", o.pack, "FILE",
                "Write the loaded scene, ready to render, into one file; renders only if -o is given too");

    declare_records(app, o);
#ifndef IRRADIA_MINIMAL
    declare_report(app, o);
#endif

    Group scene(app, "Scene");
    scene
        .value("--width", o.width, "PIXELS",
               "Width of the picture [the scene's]; with one of --width and --height the "
               "other follows the scene's shape")
        ->check(CLI::Range(1, 1 << 16));
    scene.value("--height", o.height, "PIXELS", "Height of the picture [the scene's]")->check(CLI::Range(1, 1 << 16));
    scene
        .value("--rfilter", o.rfilter, "box|tent|gaussian",
               "Reconstruction filter, of Mitsuba's default width, instead of the scene's; pictures that are compared "
               "pixel by pixel must be filtered alike")
        ->check(CLI::IsMember({"box", "tent", "gaussian"}));
    scene.list("-D,--define", defines, "NAME=VALUE", "Value of $NAME in the scene file; may be repeated");
    scene.flag("--lenient", o.lenient,
               "Replace what is not supported by a stated substitute, with a warning, instead of stopping");
}

void declare_rendering(CLI::App& app, Options& o) {
    RenderSettings& s = o.settings;
    Group picture(app, "Picture");
    picture.choice(
        "--method", s.method, method_names(),
        "irradiance: irradiance caching, indirect light computed at few points and interpolated; radiance: the "
        "same also for what rough glossy surfaces reflect; gather: a hemisphere at every sample, no cache; "
        "path: unbiased path tracing, the judge of all");
    // Before the options that it sets: those given are taken in the order of their declaration, so they change it.
    picture.chosen<Quality>(
        "--quality", [&s](Quality q) { apply_quality(s, q); }, quality_names(),
        "Sets --spp, --pixel-error, --accuracy, --hemisphere, spacings and --grid-paths together; each may be given "
        "besides. On a Cornell box the error is about 3 %, 2 %, 1 % and .5 %");
    picture.value("--spp", s.spp, "N", "Samples a pixel [the scene's]; noise falls as 1/sqrt(N)")
        ->check(CLI::Range(1, 1 << 30));
    picture
        .value("--pixel-error", s.pixel_error, "E",
               "irradiance and radiance: a pixel takes samples until its standard error is below this part of the "
               "picture's mean (.01: 1 %), at least 16 and at most --spp; smooth pixels then cost little. 0: all take "
               "--spp")
        ->check(number("of at least 0", [](double x) { return x >= 0; }))
        ->default_str(option_text(s.pixel_error));
    picture
        .value("--max-depth", s.max_depth, "N",
               "Longest path, in edges: 1 emitters only, 2 and direct light, 3 and one bounce; -1 unlimited")
        ->check([](const std::string& given) {
            int depth = 0;
            const auto read = std::from_chars(given.data(), given.data() + given.size(), depth);
            const bool whole = read.ec == std::errc() && read.ptr == given.data() + given.size();
            return whole && (depth == -1 || depth >= 1) ? std::string()
                                                        : "'" + given + "' is not -1 or a whole number above 0";
        })
        ->capture_default_str();
    picture.value("--seed", s.seed, "N", "Random seed: the same seed, device and options give the same picture")
        ->capture_default_str();

    Group error(app, "Error");
    error.flag(
        "--report-error", s.report_error,
        "Estimate the picture's error, by paths traced at random pixels that the picture knows nothing of: "
        "relative RMSE and mean bias with 95 % intervals, where no lamp is in sight. On the terminal, in --stats "
        "and in the EXR's metadata");
    error
        .value("--error-share", s.error_share, "SHARE",
               "Rays for that, to those of the picture (on GPUs: time); intervals narrow with its root")
        ->check(number("above 0", [](double x) { return x > 0; }))
        ->default_str(option_text(s.error_share));

    app.add_option_function<std::string>(
           "--target-error", [&s](const std::string& given) { read_share(given, s.target_error); },
           "Render until the picture's relative RMSE, as --report-error estimates it, is below this (2%, or 0.02) "
           "with 95 % confidence. Chooses what --quality sets, from what is found on the way")
        ->check([](const std::string& given) {
            float share = 0;
            return read_share(given, share);
        })
        ->type_name("SHARE")
        ->group("Error");
    error
        .value("--time-limit", s.time_limit, "SECONDS",
               "With --target-error: stop there, with the best picture so far, and say what was reached. Without: the "
               "best picture that can be had in this time. The first, rough picture is always finished")
        ->check(number("above 0", [](double x) { return x > 0; }));
}

void declare_device(CLI::App& app, Options& o, std::string& traversal) {
    Group device(app, "Device");
    device.value("--device", o.device.select, "NAME|INDEX",
                 "OpenCL device: number of --list-devices or part of its name [a GPU if there is one, else the CPU]");
    device.flag("--list-devices", o.list_devices, "Print the OpenCL devices and stop");
    device.off("--no-specialise", o.settings.specialise,
               "Compile kernels for everything that a scene may contain, not for what this one does: the same picture, "
               "slower (to measure by how much)");
    device.value("--threads", o.device.threads, "N", "CPU devices and scene building: threads; 0 all")
        ->check(CLI::NonNegativeNumber)
        ->capture_default_str();
    device
        .value("--traversal", traversal, "auto|cpu|gpu",
               "Shape of the hierarchy rays are traced through: packets on an 8-wide tree (cpu), single rays on a "
               "binary tree (gpu); auto: by the kind of device")
        ->check(CLI::IsMember({"auto", "cpu", "gpu"}))
        ->capture_default_str();
}

const char* const kFooter =
    "Examples\n"
    "  render scenes/cornell-box.xml -o cornell.exr\n"
    "  render scene.xml -o a.exr -o a.png --exposure 1 --spp 64 --accuracy 0.1 --aov indirect,records\n"
    "  render scene.xml -o reference.exr --method path --spp 10000 --seed 7\n"
    "  render scene.xml --pack scene.irradia && render scene.irradia -o a.pfm --device nvidia\n"
    "  render scene.xml -o small.png --width 320 -D spp=16 --stats stats.json\n"
    "  render scene.xml -o a.exr --save-records r && render scene.xml -D x=2 -o b.exr --load-records r\n"
    "  render scene.xml -o a.exr --report a.html --reference reference.exr\n"
    "  render scene.xml --points sensors.csv -o irradiance.csv --load-records r\n"
    "  render scene.xml -o a.####.exr --frames 1-240 --camera-path path.json --checkpoint state\n"
    "  render scene.####.xml -o a.####.exr --frames 1-240 --shard $SLURM_ARRAY_TASK_ID/8\n"
    "  render --batch jobs.json --threads 2 --log-json 2>> log.json\n\n"
    "Exit status: 0 done, 1 bad input (scene, file, device), 2 wrong command line, 3 some frames or jobs failed,\n"
    "130 and 143 stopped by SIGINT and SIGTERM.";

GivenOptions given_options(const CLI::App& app) {
    GivenOptions given;
    for (const CLI::Option* option : app.get_options()) {
        if (option->count() == 0 || option->get_positional()) continue;
        const std::vector<std::string>& names = option->get_lnames();
        given.emplace_back(names.empty() ? option->get_snames().front() : names.front(), option->results());
    }
    return given;
}

}  // namespace

int parse_options(int argc, const char* const* argv, Options& o, std::ostream& err) {
    const auto complain = [&](const std::string& what) {
        err << "render: " << what << " (render --help lists the options)\n";
        return kBadCommandLine;
    };
    CLI::App app("Renders a Mitsuba 3 scene by irradiance caching in OpenCL.", "render");
    set_up(app, "SCENE -o OUT [-o OUT2 ...] [options]\n       render --batch JOBS.json [options]");
    std::vector<std::string> defines;
    std::string traversal = "auto";
    declare_files(app, o, defines);
    declare_rendering(app, o);
    declare_caches(app, o.settings);
    declare_batch(app, o);
    declare_device(app, o, traversal);
    declare_memory(app, o);
    declare_messages(app, o);
    app.footer(kFooter);
    if (const int status = parse(app, argc, argv, err); status >= 0) return status;
    if (o.list_devices) return -1;
    o.given = given_options(app);
    if (const std::string what = wrong_batch_options(o); !what.empty()) return complain(what);
    if (!o.batch.empty()) return -1;

    if (o.scene.empty()) return complain("no SCENE given");
    if (o.outputs.empty() && o.pack.empty()) return complain("nothing to write: give -o OUT.exr");
    if (const std::string what = wrong_record_options(o); !what.empty()) return complain(what);
#ifndef IRRADIA_MINIMAL
    if (const std::string what = wrong_report_options(o); !what.empty()) return complain(what);
#endif
    for (const std::string& define : defines) {
        const std::size_t equals = define.find('=');
        if (equals == 0 || equals == std::string::npos)
            return complain("-D " + define + ": expected NAME=VALUE, for example -D spp=16");
        o.defines[define.substr(0, equals)] = define.substr(equals + 1);
    }
    RenderSettings& s = o.settings;
    if (s.min_spacing > s.max_spacing)
        return complain("--min-spacing " + option_text(s.min_spacing) + " is larger than --max-spacing " +
                        option_text(s.max_spacing));
    if (std::find(s.aovs.begin(), s.aovs.end(), "all") != s.aovs.end()) s.aovs = aov_names();
    o.device.traversal = traversal == "auto" ? "" : traversal;
    return -1;
}

}  // namespace irradia::app
