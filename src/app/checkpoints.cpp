#include "app/checkpoints.h"

#include <filesystem>
#include <iomanip>
#include <sstream>

#include "app/clock.h"
#include "app/frames.h"
#include "app/output.h"
#include "app/stats.h"
#include "core/checksum.h"
#include "core/input_file.h"

namespace irradia::app {

namespace {

/// Of a file's bytes: frames that are done were rendered by what it said then. "": no file.
std::string bytes_text(const std::string& path) {
    if (path.empty()) return "";
    InputFile in(path);
    std::vector<char> bytes(static_cast<std::size_t>(in.size()));
    in.read(bytes.data(), bytes.size());
    std::ostringstream out;
    out << "checksum " << std::hex << checksum(bytes.data(), bytes.size());
    return out.str();
}

}  // namespace

CheckpointIdentity checkpoint_identity(const Options& o, const Device& device) {
    CheckpointIdentity identity = {{"version", IRRADIA_VERSION},
                                   {"scene", o.scene},
                                   {"device", device.description().name + ", " + device.description().driver},
                                   {"traversal", device.cpu_traversal() ? "cpu" : "gpu"},
                                   {"camera-path", o.camera_path},
                                   {"camera-path's bytes", bytes_text(o.camera_path)},
                                   {"load-records", o.load_records},
                                   {"rfilter", o.rfilter},
                                   {"exposure", std::to_string(o.exposure)},
                                   {"width", std::to_string(o.width)},
                                   {"height", std::to_string(o.height)},
                                   {"report", o.report.empty() ? "no" : "yes"},
                                   {"frames", frames_text(o.frames)},
                                   {"shard", std::to_string(o.shard) + "/" + std::to_string(o.shards)}};
    for (const auto& [name, value] : o.defines) identity.emplace_back("define " + name, value);
    for (std::size_t i = 0; i < o.outputs.size(); ++i)
        identity.emplace_back("output " + std::to_string(i + 1), o.outputs[i]);
    for (auto& [name, value] : settings_texts(o)) identity.emplace_back(name, value);
    return identity;
}

std::string scene_identity(const Scene& scene, const RecordOrigin& origin) {
    std::ostringstream out;
    out << std::hex << "geometry " << origin.geometry << ", materials " << origin.materials << ", emitters "
        << origin.emitters << ", camera and film " << checksum(&scene.info, sizeof scene.info) << std::dec << ", "
        << scene.info.width << " x " << scene.info.height << " pixels, " << scene.sample_count << " samples";
    return out.str();
}

Checkpoints::Checkpoints(const Options& o, CheckpointIdentity identity)
    : path_(o.checkpoint), every_(o.checkpoint_every), identity_(std::move(identity)), last_(now()) {
    if (wanted()) check_writable(path_);
}

bool Checkpoints::there() const {
    std::error_code ignored;
    return wanted() && std::filesystem::exists(path_, ignored);
}

bool Checkpoints::due() const { return wanted() && now() - last_ >= every_; }

void Checkpoints::write(const std::function<void(Checkpoint&)>& state) {
    last_ = now();  // one that fails is tried again then
    Checkpoint out = Checkpoint::write(path_, identity_);
    state(out);
    out.finish();
    last_ = now();
}

void Checkpoints::remove() const {
    std::error_code ignored;
    if (wanted()) std::filesystem::remove(path_, ignored);
}

}  // namespace irradia::app
