// --load-records and --save-records.
#pragma once
#include <functional>
#include <string>

#include "app/options.h"
#include "irradia/RecordFile.h"
#include "irradia/Scene.h"

namespace irradia::app {

/// The records of a run: read before it, written after it.
class CarriedRecords {
public:
    /// Reads what --load-records names. Throws Error: not a record file, or --save-records cannot be written.
    CarriedRecords(const Options& options, std::function<void(const std::string&)> warn);
    /// Throws Error, which names what differs, unless the records are of this scene and these settings, or forced.
    void check(const Scene& scene);
    /// For render(); null if records are neither loaded nor saved nor shown.
    [[nodiscard]] RecordSet* set() { return wanted_ ? &set_ : nullptr; }
    /// Writes what --save-records names. Returns what was done: "" or "wrote F: 1066 records, ...".
    std::string save();

private:
    const Options& options_;
    std::function<void(const std::string&)> warn_;
    RecordSet set_, loaded_;  // loaded_: without samples and harmonics
    bool wanted_, whole_ = false;
};

}  // namespace irradia::app
