// Reading a scene: Mitsuba 3 XML in, flat arrays out.
#pragma once
#include <cstddef>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <string>

#include "irradia/Scene.h"

namespace irradia {

/// What one load_scene() has read and the next may use again: meshes as their files have them (before any transform),
/// pictures of textures and environments. A file is read again if it is another one or has changed: by its canonical
/// path, device, inode, size and times, and by what is asked of it (shape index, vertex colours, raw, scale).
/// After a load it keeps what that load used, nothing else; after one that failed also what the last good one used.
/// Meshes that a scene doesn't use are dropped before others are read, so that two big ones are not held at once.
/// Scenes are the same, byte for byte, with it and without. For one load at a time.
class SceneParts {
public:
    SceneParts();
    ~SceneParts();
    SceneParts(const SceneParts&) = delete;
    SceneParts& operator=(const SceneParts&) = delete;

    [[nodiscard]] std::size_t files_read() const;  ///< mesh and picture files since construction; failed ones too
    [[nodiscard]] std::size_t files_kept() const;  ///< that it holds now
    [[nodiscard]] std::size_t bytes() const;       ///< of memory that they take

    struct Impl;
    [[nodiscard]] Impl& impl() const { return *impl_; }  ///< of the loader

private:
    std::unique_ptr<Impl> impl_;
};

/// How to read a scene file.
struct LoadOptions {
    std::map<std::string, std::string> defines;  ///< $name -> value (-D name=value); win over the file's <default>
    bool lenient = false;       ///< substitute what is not supported, with a warning, instead of failing
    int width = 0, height = 0;  ///< film size in pixels; 0: the file's
    int threads = 0;            ///< at most; 0: as many as there are
    SceneParts* parts = nullptr;  ///< files read before, and for the next load; null: everything is read
    std::function<void(const std::string&)> warn;  ///< receives one line a warning; may be empty
    /// Hears the stage ("parsing", "meshes", "textures", "assembly") and the fraction of it that is done, from any
    /// thread, two at once too; may be empty.
    std::function<void(const std::string&, double)> progress;
    /// Hears how many more bytes of memory are about to be taken, at least, and what for; may throw to refuse them;
    /// may be empty.
    std::function<void(std::uint64_t, const std::string&)> need;
};

/// Loads `path` and everything it refers to (includes, meshes, textures), centred and rounded to float32.
/// All of Scene is filled but `accel`. The result does not depend on the number of threads.
/// Throws Error with one line "file:line: what was found, what was expected" on bad input.
Scene load_scene(const std::string& path, const LoadOptions& options = {});

/// Loads what the first load_scene() of a process otherwise does: the libraries that its threads need, which would have to
/// wait for a driver that another thread is loading.
void prepare_loading();

}  // namespace irradia
