#include "app/record_options.h"

namespace irradia::app {

void declare_records(CLI::App& app, Options& o) {
    const auto file = [&](const char* name, std::string& target, const char* type, const char* help) {
        app.add_option(name, target, help)->type_name(type)->group("Records");
    };
    file(
        "--save-records", o.save_records, "FILE",
        "Write the caches' records, for later renders and for other programs (docs/record-format.md, tools/records); a "
        "file that --load-records names too is appended to");
    file("--load-records", o.load_records, "FILE",
         "Begin with the records of earlier renders. Scene and settings have to be those of then; camera, size, --spp "
         "and "
         "--seed may differ: what has been seen costs nothing");
    app.add_flag("--force-records", o.force_records,
                 "Use loaded records even if scene or settings differ, with a warning: they show the light of then")
        ->group("Records");
    file("--points", o.points, "FILE.csv",
         "Irradiance at points instead of a picture: lines x,y,z,nx,ny,nz, a position and the normal of the side that "
         "is "
         "asked; -o OUT.csv gets E in W/m^2, direct light by --spp samples, indirect light from records, made where "
         "there are none");
}

std::string wrong_record_options(const Options& o) {
    const bool caching = o.settings.method == Method::irradiance || o.settings.method == Method::radiance;
    const std::string given = !o.save_records.empty()   ? "--save-records"
                              : !o.load_records.empty() ? "--load-records"
                              : !o.points.empty()       ? "--points"
                                                        : "";
    if (!given.empty() && !caching)
        return given + ": --method " + name_of(method_names(), o.settings.method) +
               " has no records, expected irradiance or radiance";
    if (!given.empty() && o.outputs.empty()) return given + ": nothing is rendered, expected -o FILE too";
    if (!o.load_records.empty() && (o.settings.target_error > 0 || o.settings.time_limit > 0))
        return "--load-records: its records are for settings as they were made with, found --target-error or "
               "--time-limit, which choose them";
    if (o.force_records && o.load_records.empty()) return "--force-records: expected --load-records FILE too";
    if (!o.points.empty() && !o.stats.empty()) return "--points: has no --stats, which are a picture's";
    for (const std::string& path : o.outputs)
        if (path.ends_with(".csv") == o.points.empty())
            return "-o " + path +
                   (o.points.empty() ? ": only --points writes .csv files" : ": --points writes a .csv file");
    return "";
}

}  // namespace irradia::app
