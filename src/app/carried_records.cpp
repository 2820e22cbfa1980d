#include "app/carried_records.h"

#include <filesystem>

#include "app/output.h"
#include "app/progress.h"
#include "irradia/Error.h"

namespace irradia::app {

CarriedRecords::CarriedRecords(const Options& o, std::function<void(const std::string&)> warn)
    : options_(o),
      warn_(std::move(warn)),
      wanted_(!o.load_records.empty() || !o.save_records.empty() || !o.report.empty()) {
    if (!o.save_records.empty()) check_writable(o.save_records);
    if (o.load_records.empty()) return;
    std::string warning;
    set_ = read_records(o.load_records, &warning);
    whole_ = warning.empty();
    if (!whole_) warn_(warning);
    loaded_.origin = set_.origin;
    loaded_.irradiance = set_.irradiance;
    static_cast<Records&>(loaded_.radiance) = set_.radiance;
    loaded_.radiance.stride = set_.radiance.stride;
    loaded_.radiance.order = set_.radiance.order;
    loaded_.views = set_.views;
}

void CarriedRecords::check(const Scene& scene) {
    if (options_.load_records.empty()) return;
    const bool radiance = options_.settings.method == Method::radiance && set_.radiance.size() > 0;
    const std::string what = record_mismatch(set_.origin, record_origin(scene, options_.settings), radiance);
    if (what.empty()) return;
    if (!options_.force_records)
        throw Error(options_.load_records + ": made for another render: " + what +
                    " (--force-records uses them nevertheless)");
    warn_(options_.load_records + ": used although made for another render: " + what);
}

std::string CarriedRecords::save() {
    const std::string& path = options_.save_records;
    if (path.empty()) return "";
    std::error_code ignored;
    if (!options_.force_records && !options_.load_records.empty() && set_.origin != loaded_.origin &&
        std::filesystem::equivalent(path, options_.load_records, ignored))
        throw Error(path +
                    ": left as it is: the last frame's scene is not that of its records, expected another file for "
                    "--save-records");
    const bool append =
        whole_ && set_.origin == loaded_.origin && std::filesystem::equivalent(path, options_.load_records, ignored) &&
        (loaded_.radiance.size() == 0 ||
         (loaded_.radiance.stride == set_.radiance.stride && loaded_.radiance.order == set_.radiance.order));
    if (append)
        append_records(path, loaded_, set_);
    else
        write_records(path, set_);
    std::string text = (append ? "appended to " : "wrote ") + path + ": ";
    const auto count = [](std::size_t n) { return count_text(static_cast<double>(n)); };
    if (append) text += count(set_.irradiance.size() - loaded_.irradiance.size()) + " new of ";
    text += count(set_.irradiance.size()) + " records";
    if (set_.radiance.size() > 0) text += ", " + count(set_.radiance.size()) + " radiance records";
    return text;
}

}  // namespace irradia::app
