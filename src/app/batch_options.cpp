#include "app/batch_options.h"

#include <cmath>
#include <cstdlib>

#include "app/frames.h"

namespace irradia::app {
namespace {

// "90", "60s", "5m", "1.5h": seconds.
std::string read_duration(const std::string& given, double& seconds) {
    char* end = nullptr;
    const double value = std::strtod(given.c_str(), &end);
    const std::string unit = end;
    const double factor = unit.empty() || unit == "s" ? 1 : unit == "m" ? 60 : unit == "h" ? 3600 : 0;
    if (end == given.c_str() || factor == 0 || !std::isfinite(value) || !(value > 0))
        return "'" + given + "' is not a time above 0, for example 60s, 5m or 1h";
    seconds = factor * value;
    return "";
}

}  // namespace

void declare_batch(CLI::App& app, Options& o) {
    constexpr const char* group = "Batch";
    app.add_option_function<std::string>(
           "--frames", [&o](const std::string& given) { read_frames(given, o.frames); },
           "Render many frames with one cache: numbers like 1-240, 1-240x4 (every fourth) or 1-9,20. Files of a frame "
           "have a place for its number, a.####.exr, and so may SCENE, one scene file a frame, of which only what "
           "changes is loaded again. Frames that are there are left alone")
        ->check([](const std::string& given) {
            std::vector<int> frames;
            return read_frames(given, frames);
        })
        ->type_name("LIST")
        ->group(group);
    app.add_option("--camera-path", o.camera_path,
                   "How the camera moves from frame to frame: keyframes of origin, target, up and fov (docs/batch.md)")
        ->type_name("FILE.json")
        ->group(group);
    app.add_flag("--overwrite", o.overwrite, "Render frames and jobs again whose files are there")->group(group);
    app.add_option_function<std::string>(
           "--shard", [&o](const std::string& given) { read_shard(given, o.shard, o.shards); },
           "Only the I-th of N parts of the frames, I from 1: one call a task of a job array")
        ->check([](const std::string& given) {
            int shard = 0, shards = 0;
            return read_shard(given, shard, shards);
        })
        ->type_name("I/N")
        ->group(group);
    app.add_option(
           "--batch", o.batch,
           "Render a list of jobs, in place of SCENE and -o: scene, output and options of each (docs/batch.md); "
           "other options given here are every job's. A job that fails stops no other")
        ->type_name("FILE.json")
        ->group(group);
    app.add_option("--checkpoint", o.checkpoint,
                   "Write the state of the render there now and then, and on SIGTERM and SIGINT; if the file is there, "
                   "go on from it, to the same bytes. Removed when all is done")
        ->type_name("FILE")
        ->group(group);
    app.add_option_function<std::string>(
           "--checkpoint-every", [&o](const std::string& given) { read_duration(given, o.checkpoint_every); },
           "Time between checkpoints")
        ->check([](const std::string& given) {
            double seconds = 0;
            return read_duration(given, seconds);
        })
        ->type_name("TIME")
        ->default_str("60s")
        ->group(group);
}

std::string wrong_batch_options(const Options& o) {
    if (!o.batch.empty()) {
        if (!o.scene.empty()) return "--batch: its jobs have scenes of their own, found SCENE " + o.scene;
        if (!o.outputs.empty()) return "--batch: its jobs have outputs of their own, found -o " + o.outputs.front();
        return "";
    }
    const bool many = !o.frames.empty();
    if (!many) {
        if (!o.camera_path.empty()) return "--camera-path: expected --frames too";
        if (o.shards > 1) return "--shard: expected --frames too";
        if (has_frame_place(o.scene)) return "SCENE " + o.scene + ": has a place for a frame, expected --frames too";
    } else {
        if (o.outputs.empty()) return "--frames: nothing is rendered, expected -o FILE too";
        if (!o.points.empty()) return "--frames: --points makes no pictures";
        if (!o.pack.empty()) return "--frames: --pack is for one scene";
        std::vector<std::pair<std::string, std::string>> files = {{"--stats", o.stats}, {"--report", o.report}};
        for (const std::string& path : o.outputs) files.emplace_back("-o", path);
        for (const auto& [option, path] : files)
            if (!path.empty() && !has_frame_place(path))
                return option + " " + path +
                       ": expected one place for the frame's number in its name, as in a.####.exr";
    }
    if (!o.checkpoint.empty() && o.outputs.empty()) return "--checkpoint: nothing is rendered, expected -o FILE too";
    if (!o.checkpoint.empty()) {
        std::vector<std::string> others = {o.scene,        o.stats,        o.report,      o.pack,
                                           o.save_records, o.load_records, o.camera_path, o.reference};
        others.insert(others.end(), o.outputs.begin(), o.outputs.end());
        for (const std::string& path : others) {
            bool same = path == o.checkpoint;
            for (const int frame : o.frames) same = same || frame_path(path, frame) == o.checkpoint;
            if (same) return "--checkpoint " + o.checkpoint + ": is another option's file, too";
        }
    }
    if (!o.checkpoint.empty() && !o.points.empty()) return "--checkpoint: is for pictures, not for --points";
    return "";
}

}  // namespace irradia::app
