#include "app/render_job.h"

#include <algorithm>
#include <new>

#include "app/frames.h"
#include "app/help.h"
#include "app/memory_option.h"
#include "app/output.h"
#include "app/picture_output.h"
#include "app/point_list.h"
#include "app/progress.h"
#include "app/stop_signal.h"
#include "irradia/Error.h"
#include "irradia/PackedScene.h"

namespace irradia::app {
namespace {

bool searches(const Options& o) { return o.settings.target_error > 0 || o.settings.time_limit > 0; }

}  // namespace

RenderJob::RenderJob(Options o, Session& session, Fields context)
    : o_(std::move(o)),
      session_(session),
      context_(std::move(context)),
      began_(now()),
      many_(!o_.frames.empty()),
      settings_(render_settings(o_)) {}
RenderJob::~RenderJob() = default;

Options RenderJob::of_frame(int frame) const {
    Options o = o_;
    if (!many_) return o;
    for (std::string* path : {&o.scene, &o.stats, &o.report, &o.reference}) *path = frame_path(*path, frame);
    for (std::string& path : o.outputs) path = frame_path(path, frame);
    return o;
}

std::vector<int> RenderJob::frames_to_do() {
    if (!many_) return {0};
    const std::vector<int> all = shard_of(o_.frames, o_.shard, o_.shards);
    std::vector<int> missing, done;
    for (const int frame : all) (!o_.overwrite && results_there(of_frame(frame)) ? done : missing).push_back(frame);
    if (!done.empty())
        session_.log.info("left as they are, since their files are there (--overwrite): frames " + frames_text(done),
                          {{"skipped", done}});
    return missing;
}

int RenderJob::run() {
    Log& log = session_.log;
    log.context(context_);
    if (!many_) check_outputs(o_, log);
    if (!o_.outputs.empty()) session_.expect_device(o_);
    require_records_memory(o_);
    records_ = std::make_unique<CarriedRecords>(o_, [&log](const std::string& text) { log.warn(text); });
    if (o_.outputs.empty()) {  // --pack alone: no device is needed
        session_.open(o_, 1, true);
        write_packed_scene(o_.pack, session_.scene());
        log.info("wrote " + o_.pack + ": packed scene", {{"output", o_.pack}});
        log.done({o_.pack}, now() - began_);
        return 0;
    }
    if (!o_.points.empty()) {
        answer_points();
        return 0;
    }
    render_all();
    if (started_)  // nothing was rendered: the file, if it is there, may hold what an earlier run has found
        if (const std::string what = records_->save(); !what.empty()) log.info(what, {{"output", o_.save_records}});
    if (failed_.empty()) checkpoints_->remove();
    if (!many_) {
        log.done(o_.outputs, now() - began_);
        return 0;
    }
    std::string text = "frames: " + std::to_string(done_) + " rendered in " + time_text(now() - began_);
    if (!failed_.empty()) text += ", failed: " + frames_text(failed_);
    log.say(failed_.empty() ? Level::info : Level::error, text, {{"rendered", done_}, {"failed", failed_}});
    if (!failed_.empty()) {
        log.failed(text, kSomeFailed);
        return kSomeFailed;
    }
    log.done(o_.outputs, now() - began_);
    return 0;
}

/// --points: no picture, but irradiance.
void RenderJob::answer_points() {
    Log& log = session_.log;
    const std::vector<IrradiancePoint> points = read_points(o_.points);
    session_.open(o_, 1, !o_.pack.empty());
    Device& device = session_.device(o_.device);
    if (!o_.pack.empty()) {
        write_packed_scene(o_.pack, session_.scene());
        log.info("wrote " + o_.pack + ": packed scene", {{"output", o_.pack}});
    }
    records_->check(session_.scene());
    StageLog stages(log);
    const ProgressCallback callback = [&](const Progress& p) {
        stages(p);
        stop_if_told();
        check_memory(o_, 0, "the render (" + p.stage + ")");
    };
    RenderStatistics statistics;
    const std::vector<PointIrradiance> answers =
        irradiance_at(session_.scene(), device, o_.settings, points, callback, records_->set(), &statistics);
    stages.finish();
    for (const std::string& path : o_.outputs) write_points(path, points, answers);
    log.info("wrote " + o_.outputs.front() + ": irradiance at " + count_text(static_cast<double>(points.size())) +
             " points, " + time_text(statistics.seconds) + ", " + count_text(static_cast<double>(statistics.records)) +
             " records");
    if (const std::string what = records_->save(); !what.empty()) log.info(what);
    log.done(o_.outputs, now() - began_);
}

void RenderJob::render_all() {
    Log& log = session_.log;
    if (!o_.camera_path.empty()) path_ = read_camera_path(o_.camera_path);
    if (many_) session_.device(o_.device);  // if it is not there no frame is tried
    checkpoints_ = std::make_unique<Checkpoints>(
        o_, o_.checkpoint.empty() ? CheckpointIdentity{} : checkpoint_identity(o_, session_.device(o_.device)));
    std::optional<Checkpoint> resumed;
    if (checkpoints_->there()) {
        resumed.emplace(checkpoints_->read());
        (*resumed)(frames_)(failed_);
        for (const int frame : failed_)  // they have another chance
            if (std::find(frames_.begin(), frames_.end(), frame) == frames_.end()) frames_.push_back(frame);
        failed_.clear();
        log.info("going on from " + checkpoints_->path());
    } else {
        frames_ = frames_to_do();
    }
    try {
        while (!frames_.empty()) {
            const int frame = frames_.front();
            if (many_) {
                Fields context = context_;
                context["frame"] = frame;
                log.context(context);
            }
            try {
                render_frame(of_frame(frame), frame, resumed);
                ++done_;
            } catch (const std::exception& error) {
                if (!many_ || resumed) throw;  // a checkpoint that cannot be used is neither lost nor passed over
                const bool memory = dynamic_cast<const std::bad_alloc*>(&error) != nullptr;
                const std::string what = memory ? out_of_memory_text() : error.what();
                log.error(what);
                log.event("error", {{"message", what}, {"status", kBadInput}});
                failed_.push_back(frame);
                if (!whole_) drop_renderer();  // in the middle of it
            }
            log.context(context_);
            frames_.erase(frames_.begin());
            if (!frames_.empty()) stop_if_told();
        }
    } catch (const Stopped&) {
        if (whole_ && checkpoints_->wanted() && write_checkpoint(Level::error))
            log.info("wrote " + checkpoints_->path() + ": the same command goes on from there",
                     {{"output", checkpoints_->path()}});
        throw;
    }
    if (!failed_.empty() && whole_ && checkpoints_->wanted()) {  // from which they can be rendered later on
        frames_ = failed_;
        write_checkpoint(Level::warning);
        frames_.clear();
    }
    RecordSet* const records = records_->set();
    if (records == nullptr) return;
    if (renderer_) {
        // Of another scene than the last one's, and unknown to it.
        if (!record_mismatch(records->origin, record_origin(session_.scene(), settings_), true).empty())
            records->radiance = {};
        renderer_->store(*records);
    } else if (kept_) {  // the last frames failed
        *records = std::move(*kept_);
    }
}

void RenderJob::render_frame(const Options& o, int frame, std::optional<Checkpoint>& resumed) {
    const double began = many_ ? now() : began_;
    if (many_) check_outputs(o, session_.log);
    reference_ = open_reference(o);
    open_scene(o, resumed);
    shared::Camera camera = session_.scene().info.camera;
    if (path_) camera = camera_at(*path_, session_.scene(), frame);
    check_reference_size(o, reference_, session_.scene());
    whole_ = false;
    RenderResult result = [&] {
        try {
            stages_ = std::make_unique<StageLog>(session_.log);
            make_renderer(resumed.has_value());
            state_frame_ = frame;
            if (checkpoints_->wanted()) state_scene_ = scene_identity(session_.scene(), session_.origin());
            if (!resumed) return renderer_->render(camera);
            Checkpoint checkpoint = std::move(*resumed);
            resumed.reset();
            return renderer_->resume(checkpoint);
        } catch (const std::bad_alloc&) {
            throw Error("out of memory for a picture of " + std::to_string(session_.scene().info.width) + " x " +
                        std::to_string(session_.scene().info.height) +
                        " pixels: take a smaller one (--width, --height) or fewer layers (--aov)");
        }
    }();
    stages_->finish();
    whole_ = started_ = true;
    RecordSet* const records = records_->set();
    if (records != nullptr && !o.report.empty()) renderer_->store(*records);
    // A frame that is there and no checkpoint: a run that is killed now would go on without the frame's records.
    if (many_ && checkpoints_->wanted() && !checkpoints_->there()) write_checkpoint(Level::warning);
    write_results(o, session_, camera, result, records, reference_, began);
}

void RenderJob::open_scene(const Options& o, std::optional<Checkpoint>& resumed) {
    const bool each_frame = has_frame_place(o_.scene);
    if (!renderer_ || each_frame) {
        const std::size_t frames = shard_of(o_.frames, o_.shard, o_.shards).size(),
                          views = each_frame ? 1 : std::max<std::size_t>(frames, 1);
        session_.open(o, views, !o_.pack.empty(), [&] { drop_renderer(); });
        if (!o_.pack.empty()) {
            write_packed_scene(o_.pack, session_.scene());
            session_.log.info("wrote " + o_.pack + ": packed scene", {{"output", o_.pack}});
        }
    }
    if (!resumed) return;
    std::string then;
    (*resumed)(then);
    if (const std::string is = scene_identity(session_.scene(), session_.origin()); then != is)
        throw Error(checkpoints_->path() + ": checkpoint of another scene: found " + then + ", expected " + is);
}

// `resumed`: whatever records it is to have are in the checkpoint.
void RenderJob::make_renderer(bool resumed) {
    if (renderer_) return;
    RecordSet* const records = records_->set();
    const bool loads = !resumed && !kept_ && !started_ && records != nullptr;
    if (loads) records_->check(session_.scene());
    const shared::SceneInfo& info = session_.scene().info;
    Options rendered = o_;
    rendered.settings = settings_;
    require_picture_memory(rendered, info.width, info.height);
    const std::uint64_t pixels = std::uint64_t{info.width} * info.height;
    const ProgressCallback callback = [this, pixels, rendered](const Progress& p) {
        (*stages_)(p);
        check_memory(rendered, pixels, "the render (" + p.stage + ")");
    };
    auto renderer = std::make_unique<Renderer>(session_.scene(), session_.device(o_.device), settings_, callback);
    renderer->on_rest([this](bool whole) { at_rest(whole); });
    // Records of an earlier scene serve this one if it differs in nothing that they know.
    if (kept_ && !resumed) {
        const bool radiance = settings_.method == Method::radiance && kept_->radiance.size() > 0;
        if (record_mismatch(kept_->origin, record_origin(session_.scene(), settings_), radiance).empty())
            renderer->load(*kept_);
    } else if (loads) {
        renderer->load(*records);
    }
    kept_.reset();
    renderer_ = std::move(renderer);
}

void RenderJob::drop_renderer() {
    if (!renderer_) return;
    if (!searches(o_)) {
        try {  // records are whole at any time, unless it is the device that has failed
            const RecordSet* const records = records_->set();
            renderer_->store(records != nullptr ? kept_.emplace(*records) : kept_.emplace());
            check_records("records", *kept_);
        } catch (const std::exception&) {
            kept_.reset();
        }
    }
    renderer_.reset();
    whole_ = false;
}

void RenderJob::at_rest(bool whole) {
    if (signal_received() != 0) {
        whole_ = whole;
        throw Stopped{signal_received()};
    }
    // Between the steps of a search, which come seldom, always.
    if (whole && (checkpoints_->due() || (searches(o_) && checkpoints_->wanted()))) write_checkpoint(Level::warning);
}

bool RenderJob::write_checkpoint(Level level) {
    try {
        checkpoints_->write([this](Checkpoint& c) { state(c); });
        return true;
    } catch (const Error& error) {  // the render itself is none the worse
        session_.log.say(level, error.what());
    } catch (const std::exception& error) {
        session_.log.say(level, checkpoints_->path() + ": not written: " + error.what());
    }
    return false;
}

void RenderJob::state(Checkpoint& c) {
    std::vector<int> frames = frames_;
    // Between two frames, or while the next one is being loaded: its picture is written once more.
    if (frames.empty() || frames.front() != state_frame_) frames.insert(frames.begin(), state_frame_);
    c(frames)(failed_)(state_scene_);
    renderer_->save(c);
}

}  // namespace irradia::app
