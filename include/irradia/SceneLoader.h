// Reading a scene: Mitsuba 3 XML in, flat arrays out.
#pragma once
#include <cstdint>
#include <functional>
#include <map>
#include <string>

#include "irradia/Scene.h"

namespace irradia {

/// How to read a scene file.
struct LoadOptions {
    std::map<std::string, std::string> defines;  ///< $name -> value (-D name=value); win over the file's <default>
    bool lenient = false;       ///< substitute what is not supported, with a warning, instead of failing
    int width = 0, height = 0;  ///< film size in pixels; 0: the file's
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

}  // namespace irradia
