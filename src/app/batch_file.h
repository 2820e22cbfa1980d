// Job lists: `render --batch jobs.json`.
#pragma once
#include <string>
#include <utility>
#include <vector>

namespace irradia::app {

/// Options as they were given: long name without dashes, values ("true" of a flag).
using GivenOptions = std::vector<std::pair<std::string, std::vector<std::string>>>;

struct BatchJob {
    std::string name;                    ///< unique; "1", "2", ... where the file gives none
    std::vector<std::string> arguments;  ///< as on a command line, without the program's name
};

/// Reads a job list:
///
///     {"defaults": {OPTION: VALUE, ...},
///      "jobs": [{"name": TEXT, "scene": FILE, "output": FILE or [FILE, ...], "options": {OPTION: VALUE, ...}}, ...]}
///
/// OPTION: a long option's name without dashes; VALUE: text, a number, true (a flag), false (not given) or a list.
/// Options of a job win over "defaults", those over `given`, the command line's. Paths are as on a command line. Throws
/// Error "file: jobs[2].scene: what was found, what was expected"; whether options exist is not looked at here.
std::vector<BatchJob> read_batch(const std::string& path, const GivenOptions& given);

}  // namespace irradia::app
