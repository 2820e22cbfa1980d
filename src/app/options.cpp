#include "app/options.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstdlib>
#include <functional>
#include <iostream>
#include <sstream>

#include "app/batch_options.h"
#include "app/help.h"
#include "app/log_options.h"
#include "app/memory_option.h"
#include "app/output.h"
#include "app/record_options.h"
#ifndef IRRADIA_MINIMAL
#include "app/report_options.h"
#endif

namespace irradia::app {

const Names<Method>& method_names() {
    static const Names<Method> names = {{Method::irradiance, "irradiance"},
                                        {Method::radiance, "radiance"},
                                        {Method::gather, "gather"},
                                        {Method::path, "path"}};
    return names;
}
const Names<GradientRule>& gradient_names() {
    static const Names<GradientRule> names = {
        {GradientRule::none, "none"}, {GradientRule::ward, "ward"}, {GradientRule::crease, "crease"}};
    return names;
}
const Names<RadiusRule>& radius_names() {
    static const Names<RadiusRule> names = {
        {RadiusRule::harmonic, "harmonic"}, {RadiusRule::minimum, "minimum"}, {RadiusRule::hessian, "hessian"}};
    return names;
}
const Names<WeightRule>& weight_names() {
    static const Names<WeightRule> names = {
        {WeightRule::ward, "ward"}, {WeightRule::tabellion, "tabellion"}, {WeightRule::cubic, "cubic"}};
    return names;
}
const Names<GlossyRule>& glossy_names() {
    static const Names<GlossyRule> names = {{GlossyRule::automatic, "auto"},
                                            {GlossyRule::samples, "samples"},
                                            {GlossyRule::harmonics, "harmonics"},
                                            {GlossyRule::traced, "traced"}};
    return names;
}
const Names<DirectMis>& direct_mis_names() {
    static const Names<DirectMis> names = {
        {DirectMis::automatic, "auto"}, {DirectMis::on, "on"}, {DirectMis::off, "off"}};
    return names;
}
const Names<Quality>& quality_names() {
    static const Names<Quality> names = {
        {Quality::draft, "draft"}, {Quality::medium, "medium"}, {Quality::fine, "fine"}, {Quality::finest, "finest"}};
    return names;
}

namespace {

std::string text(double value) {
    std::ostringstream out;
    out << value;
    return out.str();
}

std::string join(const std::vector<std::string>& parts, const char* between) {
    std::string out;
    for (const std::string& part : parts) out += (out.empty() ? "" : between) + part;
    return out;
}

/// Adds options to one group of --help.
class Group {
public:
    Group(CLI::App& app, std::string name) : app_(app), name_(std::move(name)) {}

    template <class T>
    CLI::Option* value(const std::string& names, T& target, const std::string& unit, const std::string& help) {
        return app_.add_option(names, target, help)->type_name(unit)->group(name_);
    }

    /// May be given several times, with one value each.
    CLI::Option* list(const std::string& names, std::vector<std::string>& target, const std::string& unit,
                      const std::string& help) {
        return value(names, target, unit, help)->allow_extra_args(false);
    }

    template <class E>
    CLI::Option* choice(const std::string& names, E& target, const Names<E>& values, const std::string& help) {
        return chosen<E>(
                   names, [&target](E v) { target = v; }, values, help)
            ->default_str(name_of(values, target));
    }

    /// Hands the value chosen to `take`.
    template <class E>
    CLI::Option* chosen(const std::string& names, const std::function<void(E)>& take, const Names<E>& values,
                        const std::string& help) {
        std::vector<std::string> words;
        for (const auto& [v, word] : values) words.push_back(word);
        const std::string all = join(words, "|");
        const auto check = [words, all](const std::string& given) {
            return std::find(words.begin(), words.end(), given) != words.end() ? std::string()
                                                                               : "'" + given + "' is not one of " + all;
        };
        const auto set = [take, &values](const std::string& given) {
            for (const auto& [v, word] : values)
                if (word == given) take(v);
        };
        return app_.add_option_function<std::string>(names, set, help)->check(check)->type_name(all)->group(name_);
    }

    CLI::Option* flag(const std::string& names, bool& target, const std::string& help) {
        return app_.add_flag(names, target, help)->group(name_);
    }

    /// `--no-x`: clears `target`, which is on by default.
    CLI::Option* off(const std::string& name, bool& target, const std::string& help) {
        return app_
            .add_flag_callback(
                name, [&target] { target = false; }, help)
            ->group(name_);
    }

private:
    CLI::App& app_;
    std::string name_;
};

// A check of one number; CLI11's own let "nan" pass.
std::function<std::string(const std::string&)> number(const std::string& what,
                                                      const std::function<bool(double)>& good) {
    return [what, good](const std::string& given) {
        char* end = nullptr;
        const double value = std::strtod(given.c_str(), &end);
        return end != given.c_str() && *end == '\0' && std::isfinite(value) && good(value)
                   ? std::string()
                   : "'" + given + "' is not a number " + what;
    };
}

// "16x64" -> 16, 64.
std::string read_hemisphere(const std::string& given, int& m, int& n) {
    const char* const end = given.data() + given.size();
    int rings = 0, sectors = 0;
    const auto first = std::from_chars(given.data(), end, rings);
    if (first.ec == std::errc() && first.ptr != end && (*first.ptr == 'x' || *first.ptr == 'X')) {
        const auto second = std::from_chars(first.ptr + 1, end, sectors);
        if (second.ec == std::errc() && second.ptr == end && rings > 0 && sectors > 0) {
            m = rings;
            n = sectors;
            return "";
        }
    }
    return "'" + given + "' is not MxN: two whole numbers above 0, for example 16x64";
}

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
        ->default_str(text(s.pixel_error));
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
               "Time for that, to the time that the picture took; intervals narrow with its root")
        ->check(number("above 0", [](double x) { return x > 0; }))
        ->default_str(text(s.error_share));

    app.add_option_function<std::string>(
           "--target-error", [&s](const std::string& given) { read_share(given, s.target_error); },
           "Render until the picture's relative RMSE, as --report-error estimates it, is below this with 95 % "
           "confidence. Chooses what --quality sets, from what is found on the way")
        ->check([](const std::string& given) {
            float share = 0;
            return read_share(given, share);
        })
        ->type_name("PERCENT")
        ->group("Error");
    error
        .value("--time-limit", s.time_limit, "SECONDS",
               "With --target-error: stop there, with the best picture so far, and say what was reached. Without: the "
               "best picture that can be had in this time. The first, rough picture is always finished")
        ->check(number("above 0", [](double x) { return x > 0; }));

    Group cache(app, "Irradiance caching");
    cache
        .value("--accuracy", s.accuracy, "A",
               "Error allowed in interpolation, `a` of (1.8); records, and time, grow as 1/A^2")
        ->check(number("above 0", [](double x) { return x > 0; }))
        ->default_str(text(s.accuracy));
    // --hemisphere also sets what --method gather computes at each sample.
    app.add_option_function<std::string>(
           "--hemisphere", [&s](const std::string& given) { read_hemisphere(given, s.hemisphere_m, s.hemisphere_n); },
           "Directions of a hemisphere: M rings of N sectors, N near pi M; also for --method gather")
        ->check([](const std::string& given) {
            int m = 0, n = 0;
            return read_hemisphere(given, m, n);
        })
        ->type_name("MxN")
        ->default_str(std::to_string(s.hemisphere_m) + "x" + std::to_string(s.hemisphere_n))
        ->group("Irradiance caching");
    cache
        .value("--overlap", s.overlap, "X",
               "How much farther a record is used than the spacing at which records are placed: more are averaged, "
               "which hides their noise, and smears more")
        ->check(number("of at least 1", [](double x) { return x >= 1; }))
        ->default_str(text(s.overlap));
    cache.value("--min-spacing", s.min_spacing, "PIXELS", "Least radius of a record on the screen")
        ->check(number("of at least 0", [](double x) { return x >= 0; }))
        ->default_str(text(s.min_spacing));
    cache.value("--max-spacing", s.max_spacing, "PIXELS", "Largest radius of a record on the screen")
        ->check(number("above 0", [](double x) { return x > 0; }))
        ->default_str(text(s.max_spacing));
    cache.choice("--gradients", s.gradients, gradient_names(),
                 "How irradiance is carried from a record to a point: none, Ward and Heckbert's translational "
                 "gradient, or the crease rule");
    cache.choice("--radius", s.radius, radius_names(),
                 "How far a record reaches: harmonic mean distance (1.14), least distance (1.15), or from the second "
                 "derivative of irradiance");
    cache.choice(
        "--weight", s.weight, weight_names(),
        "Weight of a record over its distance: Ward's (1.8), Tabellion's (1.11), or a bell, which averages more "
        "records and shows none as a spot");
    cache.off("--no-neighbour-clamp", s.neighbour_clamp,
              "Let a record reach further than its neighbours' radii and distances allow");
    cache.off("--no-gradient-limit", s.gradient_limit, "Let a record reach further than E / |gradient|");
    cache.off("--no-reach-limit", s.reach_limit,
              "Let a record reach past the nearest surface that it sees: fewer records, and leaks through thin walls");
    cache.off("--no-in-front", s.in_front, "Use records that lie in front of the point (1.10)");
    cache.choice(
        "--direct-mis", s.direct_mis, direct_mis_names(),
        "Direct light by light samples alone (off), or by BSDF samples too (on): less grain where one of several "
        "lights is near; auto: on if the scene has several");
    cache.off("--no-grid", s.grid,
              "Let hemisphere rays go on as paths instead of asking the irradiance grid for their second bounce: "
              "unbiased, slower, and noisier");
    cache.value("--grid-paths", s.grid_paths, "N", "Paths that fill the irradiance grid; its noise falls as 1/sqrt(N)")
        ->check(CLI::Range(1, 1 << 28))
        ->default_str(std::to_string(s.grid_paths));
    cache
        .value("--firefly", s.firefly, "X",
               "Gradients take no direction as brighter than X times the mean of its hemisphere; 0: no limit")
        ->check(number("of at least 0", [](double x) { return x >= 0; }))
        ->default_str(text(s.firefly));
    cache.off("--no-share-lookups", s.share_lookups,
              "Look into the cache for every sample, not once for the samples of a pixel on one smooth patch");
}

void declare_radiance(CLI::App& app, RenderSettings& s) {
    Group cache(app, "Radiance caching (--method radiance)");
    cache.choice("--glossy", s.glossy, glossy_names(),
                 "What answers for the lobes of rough conductors and rough plastics: records of hemispheres' samples, "
                 "records of hemispherical harmonics, or rays that follow the lobe and end in the irradiance cache; "
                 "auto: by roughness");
    const auto roughness = number("from 0 to 1", [](double x) { return x >= 0 && x <= 1; });
    cache.value("--trace-below", s.trace_below, "ALPHA", "Lobes of less roughness are traced")
        ->check(roughness)
        ->default_str(text(s.trace_below));
    cache
        .value("--glossy-share", s.glossy_share, "X",
               "Lobes that reflect less than X of all that their surface reflects are traced: faint coats")
        ->check(number("from 0 to 1", [](double x) { return x >= 0 && x <= 1; }))
        ->default_str(text(s.glossy_share));
    cache
        .value("--harmonics-from", s.harmonics_from, "ALPHA",
               "auto: lobes of at least this roughness are answered by harmonics; above 1: none")
        ->check(number("from 0 to 2", [](double x) { return x >= 0 && x <= 2; }))
        ->default_str(text(s.harmonics_from));
    cache.value("--order", s.harmonics_order, "N", "Bands of the harmonics: N^2 coefficients a channel")
        ->check(CLI::Range(1, largest_harmonics_order))
        ->default_str(std::to_string(s.harmonics_order));
    cache.value("--lobe-table", s.lobe_table, "N", "Entries of each lobe's table over the angle of the view")
        ->check(CLI::Range(4, 1024))
        ->default_str(std::to_string(s.lobe_table));
    cache
        .value("--glossy-accuracy", s.glossy_accuracy, "A",
               "Reach of a radiance record over the mean distance of what it sees; records grow as 1/A^2")
        ->check(number("above 0", [](double x) { return x > 0; }))
        ->default_str(text(s.glossy_accuracy));
    cache
        .value("--glossy-reach", s.glossy_reach, "ALPHA",
               "Harmonics: lobes of less roughness use records less far, by the root of the ratio")
        ->check(roughness)
        ->default_str(text(s.glossy_reach));
    cache
        .value("--glossy-spread", s.glossy_spread, "X",
               "Radiance records whose answers differ by more than X of their mean get another between them; 0: never")
        ->check(number("of at least 0", [](double x) { return x >= 0; }))
        ->default_str(text(s.glossy_spread));
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
    declare_radiance(app, o.settings);
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
        return complain("--min-spacing " + text(s.min_spacing) + " is larger than --max-spacing " +
                        text(s.max_spacing));
    if (std::find(s.aovs.begin(), s.aovs.end(), "all") != s.aovs.end()) s.aovs = aov_names();
    o.device.traversal = traversal == "auto" ? "" : traversal;
    return -1;
}

}  // namespace irradia::app
