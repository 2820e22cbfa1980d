#include "app/memory_option.h"

#include <algorithm>
#include <filesystem>

#include "core/memory.h"

namespace irradia::app {
namespace {

const char* const kHelp =
    "take a smaller picture (--width, --height), fewer layers (--aov), a larger --accuracy, or a smaller scene";

std::uint64_t layer_channels(const RenderSettings& s) {
    std::uint64_t channels = 3;  // the picture itself
    for (const std::string& name : s.aovs)
        channels += name == "depth" || name == "records" || name == "counted" ? 1u : 3u;
    return channels;
}

}  // namespace

void declare_memory(CLI::App& app, Options& o) {
    app.add_option_function<std::string>(
           "--memory-limit",
           [&o](const std::string& given) { o.device.memory_limit = parse_memory_size(given).value_or(0); },
           "Memory that this process may take, for example 4G, 512M or 80% (of the machine's or its control group's): "
           "what would pass it is refused, with one line that says what needs how much, instead of swapping. A GPU's "
           "own memory is not counted")
        ->check([](const std::string& given) {
            return parse_memory_size(given)
                       ? std::string()
                       : "'" + given + "' is not a size, for example 4G, 512M, 3.5GiB, 800000000 or 80%";
        })
        ->type_name("SIZE")
        ->group("Device");
}

// Of a film (film.h), its layers, and of a cache's schedule (sample_schedule.h). Measured, from 2048 to 3072 pixels
// square, with the file being written: 76 bytes a pixel of a picture by paths, where this says 64, and 110 with a
// cache, where it says 96.
std::uint64_t picture_memory(const RenderSettings& s, std::uint64_t width, std::uint64_t height) {
    const bool aovs = std::any_of(s.aovs.begin(), s.aovs.end(),
                                  [](const std::string& a) { return a == "albedo" || a == "normal" || a == "depth"; });
    const std::uint64_t film = (aovs ? 13 : 6) * sizeof(double) + sizeof(std::uint32_t);
    const bool searches = s.target_error > 0 || s.time_limit > 0;  // keeps the last film whose error is known
    const bool caches = s.method == Method::irradiance || s.method == Method::radiance;
    return width * height *
           ((searches ? 2 : 1) * film + layer_channels(s) * sizeof(float) + (caches ? std::uint64_t{32} : 0));
}

void require_records_memory(const Options& o) {
    if (o.load_records.empty()) return;
    std::error_code unreadable;  // which is said when it is read
    const std::uint64_t bytes = std::filesystem::file_size(o.load_records, unreadable);
    if (!unreadable)  // kept twice: as read, and with what is found besides
        require_memory(o.device.memory_limit, 2 * bytes, "the records of " + o.load_records, "load fewer records");
}

void require_picture_memory(const Options& o, std::uint64_t width, std::uint64_t height) {
    require_memory(o.device.memory_limit, picture_memory(o.settings, width, height),
                   "a picture of " + std::to_string(width) + " x " + std::to_string(height) + " pixels and its layers",
                   kHelp);
}

void check_memory(const Options& o, std::uint64_t pixels, const std::string& what) {
    require_memory(o.device.memory_limit, pixels * layer_channels(o.settings) * sizeof(float), what, kHelp);
}

std::string out_of_memory_text() {
    return "out of memory, having had " + memory_text(peak_resident_memory()) + " at most: " + kHelp;
}

}  // namespace irradia::app
