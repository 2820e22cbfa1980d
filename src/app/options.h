// The command line of `render`.
#pragma once
#include <iosfwd>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "app/batch_file.h"
#include "irradia/Device.h"
#include "irradia/Renderer.h"

namespace irradia::app {

struct Options {
    std::string scene;                               ///< Mitsuba XML or packed scene
    std::vector<std::string> outputs;                ///< kind by extension
    std::string pack, stats;                         ///< files to write besides; "" = none
    std::string load_records, save_records, points;  ///< files; "" = none
    std::string report, reference;                   ///< files; "" = none
    std::string batch, camera_path, checkpoint;      ///< files; "" = none
    double checkpoint_every = 60;                    ///< seconds
    std::vector<int> frames;                         ///< empty: one picture, without a number
    int shard = 1, shards = 1;                       ///< of the frames
    bool overwrite = false;                          ///< frames and jobs that are there are rendered again
    GivenOptions given;                              ///< all that stand on the command line
    bool force_records = false;                      ///< use records of another scene or other settings
    RenderSettings settings;
    DeviceOptions device;
    std::map<std::string, std::string> defines;  ///< -D name=value
    std::string rfilter;                         ///< box, tent or gaussian; "" = the scene's
    int width = 0, height = 0;                   ///< pixels; 0 = the scene's
    double exposure = 0;                         ///< stops, PNG only
    bool lenient = false, quiet = false, verbose = false, list_devices = false;
    bool log_json = false;  ///< messages as JSON
    bool progress = false;  ///< a stream of JSON on stdout
};

/// A value of an enumeration and what it is called on the command line and in files.
template <class E>
using Names = std::vector<std::pair<E, std::string>>;

const Names<Method>& method_names();
const Names<GradientRule>& gradient_names();
const Names<RadiusRule>& radius_names();
const Names<WeightRule>& weight_names();
const Names<GlossyRule>& glossy_names();
const Names<DirectMis>& direct_mis_names();
const Names<Quality>& quality_names();

template <class E>
const std::string& name_of(const Names<E>& names, E value) {
    for (const auto& [v, name] : names)
        if (v == value) return name;
    return names.front().second;
}

/// Reads the command line. Returns -1 to go on, or the status to exit with at once (0 after --help, 2 after one line to
/// `err` that says what is wrong).
int parse_options(int argc, const char* const* argv, Options& options, std::ostream& err);

}  // namespace irradia::app
