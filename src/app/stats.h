// What --stats writes, what goes into a picture's metadata, and the table of --verbose.
#pragma once
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "app/loading.h"
#include "app/options.h"
#include "irradia/Scene.h"

namespace irradia::app {

/// Facts of one run, gathered by render_main.
struct Run {
    const Options& options;
    const Scene& scene;
    const DeviceDescription& device;
    bool cpu_traversal = false;
    std::uint64_t device_peak_bytes = 0;
    const RenderStatistics& statistics;
    Phases load_phases{};                         ///< wall seconds: parsing, meshes, ..., hierarchy
    std::uint64_t load_peak_bytes = 0;            ///< largest resident set until the scene was there
    double write_seconds = 0, total_seconds = 0;  ///< wall
    const ErrorReport* error = nullptr;           ///< of the picture, if it was estimated
    const shared::Camera* camera = nullptr;       ///< of the picture; null: the scene's
};

/// Everything, as indented JSON.
std::string stats_json(const Run& run);

/// Method, parameters, seed, device, version, records and rays, as text by key ("irradia.method"). No times: the same
/// picture is the same file (but for what --report-error says on GPUs, which depends on the time it has).
std::map<std::string, std::string> picture_metadata(const Run& run);

/// All settings that a picture depends on, as text by the names they have in --stats.
std::vector<std::pair<std::string, std::string>> settings_texts(const Options& options);

/// Device time by stage, rays by kind, memory: several lines.
std::string stats_table(const Run& run);

}  // namespace irradia::app
