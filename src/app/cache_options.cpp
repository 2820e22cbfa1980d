// The options of the caches.
#include "app/cache_options.h"

#include <charconv>

#include "app/option_group.h"

namespace irradia::app {
namespace {

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

void declare_irradiance(CLI::App& app, RenderSettings& s) {
    Group cache(app, "Irradiance caching");
    cache
        .value("--accuracy", s.accuracy, "A",
               "Error allowed in interpolation, `a` of (1.8); records, and time, grow as 1/A^2")
        ->check(number("above 0", [](double x) { return x > 0; }))
        ->default_str(option_text(s.accuracy));
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
        ->default_str(option_text(s.overlap));
    cache.value("--min-spacing", s.min_spacing, "PIXELS", "Least radius of a record on the screen")
        ->check(number("of at least 0", [](double x) { return x >= 0; }))
        ->default_str(option_text(s.min_spacing));
    cache.value("--max-spacing", s.max_spacing, "PIXELS", "Largest radius of a record on the screen")
        ->check(number("above 0", [](double x) { return x > 0; }))
        ->default_str(option_text(s.max_spacing));
    cache
        .value("--gap-spacing", s.gap_spacing, "PIXELS",
               "Least radius of a record in a narrow place, under or beside something near, if less than --min-spacing")
        ->check(number("above 0", [](double x) { return x > 0; }))
        ->default_str(option_text(s.gap_spacing));
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
    cache.off("--no-learn-sky", s.learn_sky,
              "Take light samples of an environment picture from all of it alike, not by what paths have found is seen "
              "of it from there: as unbiased, and noisier indoors");
    cache
        .value("--firefly", s.firefly, "X",
               "Gradients take no direction as brighter than X times the mean of its hemisphere; 0: no limit")
        ->check(number("of at least 0", [](double x) { return x >= 0; }))
        ->default_str(option_text(s.firefly));
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
        ->default_str(option_text(s.trace_below));
    cache
        .value("--glossy-share", s.glossy_share, "X",
               "Lobes that reflect less than X of all that their surface reflects are traced: faint coats")
        ->check(number("from 0 to 1", [](double x) { return x >= 0 && x <= 1; }))
        ->default_str(option_text(s.glossy_share));
    cache
        .value("--harmonics-from", s.harmonics_from, "ALPHA",
               "auto: lobes of at least this roughness are answered by harmonics; above 1: none")
        ->check(number("from 0 to 2", [](double x) { return x >= 0 && x <= 2; }))
        ->default_str(option_text(s.harmonics_from));
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
        ->default_str(option_text(s.glossy_accuracy));
    cache
        .value("--glossy-reach", s.glossy_reach, "ALPHA",
               "Harmonics: lobes of less roughness use records less far, by the root of the ratio")
        ->check(roughness)
        ->default_str(option_text(s.glossy_reach));
    cache
        .value("--glossy-spread", s.glossy_spread, "X",
               "Radiance records whose answers differ by more than X of their mean get another between them; 0: never")
        ->check(number("of at least 0", [](double x) { return x >= 0; }))
        ->default_str(option_text(s.glossy_spread));
}

}  // namespace

void declare_caches(CLI::App& app, RenderSettings& s) {
    declare_irradiance(app, s);
    declare_radiance(app, s);
}

}  // namespace irradia::app
