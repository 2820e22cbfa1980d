// What one command line, or one job of a list, asks for: a picture, frames, irradiance at points, a packed scene.
#pragma once
#include <memory>
#include <optional>
#include <vector>

#include "app/carried_records.h"
#include "app/checkpoints.h"
#include "app/options.h"
#include "app/session.h"
#include "irradia/CameraPath.h"
#include "irradia/Image.h"
#include "irradia/Points.h"

namespace irradia::app {

class RenderJob {
public:
    /// `context`: of the log, which frames add their number to.
    RenderJob(Options o, Session& session, Fields context = Fields::object());
    ~RenderJob();

    /// Returns the exit status: 0, or kSomeFailed if frames failed, which the log tells. Throws Error, or Stopped after
    /// a signal, once a checkpoint is written.
    int run();

private:
    /// One frame's options: its files, its scene.
    [[nodiscard]] Options of_frame(int frame) const;
    std::vector<int> frames_to_do();

    void answer_points();
    void render_all();
    void render_frame(const Options& o, int frame, std::optional<Checkpoint>& resumed);
    void open_scene(const Options& o, std::optional<Checkpoint>& resumed);
    void make_renderer(bool resumed);
    void drop_renderer();  // keeps its records
    void at_rest(bool whole);
    bool write_checkpoint(Level level);  // `level`: how it is said if it fails
    void state(Checkpoint& checkpoint);

    Options o_;
    Session& session_;
    Fields context_;
    double began_;
    std::unique_ptr<CarriedRecords> records_;
    std::unique_ptr<Checkpoints> checkpoints_;
    std::optional<Image> reference_;
    std::vector<int> frames_, failed_;  // to do, the one in work first; failed
    int state_frame_ = 0;               // whose state the renderer has: the one in work, or done last
    std::string state_scene_;           // scene_identity() of that frame's scene: the next one's may be open already
    bool many_;
    std::size_t done_ = 0;
    std::optional<CameraPath> path_;
    RenderSettings settings_;
    std::unique_ptr<StageLog> stages_;
    std::unique_ptr<Renderer> renderer_;
    std::optional<RecordSet> kept_;  // of a renderer that was dropped
    bool whole_ = false;             // the renderer's state may be saved
    bool started_ = false;           // it has one
};

}  // namespace irradia::app
