// --checkpoint: when it is written, and what it belongs to.
#pragma once
#include <functional>
#include <string>

#include "app/options.h"
#include "irradia/Checkpoint.h"
#include "irradia/RecordFile.h"
#include "irradia/Scene.h"

namespace irradia::app {

/// Everything of a command line, and of the device, that the picture's bytes depend on.
CheckpointIdentity checkpoint_identity(const Options& o, const Device& device);

/// The scene, as text: hashes of what is in it (`origin`), of its camera and film.
std::string scene_identity(const Scene& scene, const RecordOrigin& origin);

class Checkpoints {
public:
    Checkpoints(const Options& o, CheckpointIdentity identity);

    [[nodiscard]] bool wanted() const { return !path_.empty(); }
    [[nodiscard]] const std::string& path() const { return path_; }
    /// Is there one to go on from?
    [[nodiscard]] bool there() const;
    [[nodiscard]] Checkpoint read() const { return Checkpoint::read(path_, identity_); }

    /// Has the time since the last one come to --checkpoint-every?
    [[nodiscard]] bool due() const;
    /// `state` exchanges everything.
    void write(const std::function<void(Checkpoint&)>& state);
    /// All is done: the file is of no more use.
    void remove() const;

private:
    std::string path_;
    double every_;
    CheckpointIdentity identity_;
    double last_;
};

}  // namespace irradia::app
