// Stages of loading and rendering as the log shows them.
#pragma once
#include <string>

#include "app/log.h"
#include "irradia/Renderer.h"

namespace irradia::app {

/// Listens to progress and tells it at a bearable rate, by Progress::elapsed. On a terminal a bar, ten times a second;
/// in a log a line a stage when it ends, if it took a tenth of a second, and in long stages one every five seconds
/// (later of 5 % of the time so far); in the stream five objects a second, and one at each change of stage. One clock,
/// one StageLog: a new one for every render and for loading. One thread at a time.
class StageLog {
public:
    explicit StageLog(Log& log) : log_(log) {}
    void operator()(const Progress& progress);
    /// Ends the last stage, at `elapsed` seconds of the same clock; negative: when progress was last heard. Clears the
    /// bar.
    void finish(double elapsed = -1);

private:
    void end_stage(double elapsed, std::uint64_t rays_then);

    Log& log_;
    Progress now_, begin_;  // as last heard, and at the stage's begin
    double shown_ = 0, streamed_ = 0;
};

}  // namespace irradia::app
