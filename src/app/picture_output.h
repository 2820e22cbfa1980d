// What a finished picture becomes: files, and a line about them.
#pragma once
#include <optional>

#include "app/options.h"
#include "app/session.h"
#include "app/stats.h"
#include "irradia/Image.h"
#include "irradia/RecordFile.h"

namespace irradia::app {

/// Throws Error for files of `o` that could not be written: found now, not after an hour of rendering.
void check_outputs(const Options& o, Log& log);
/// Are all files there that write_results() makes?
bool results_there(const Options& o);
/// What --reference names, if anything. Throws Error: unreadable.
std::optional<Image> open_reference(const Options& o);
/// Throws Error if there is a reference and it is not of the scene's size.
void check_reference_size(const Options& o, const std::optional<Image>& reference, const Scene& scene);

/// The settings that a render is given: for a report with all layers.
RenderSettings render_settings(const Options& o);

/// Writes pictures, statistics, report; says so. `records`: of all caches, for the report; may be null. `began`: when
/// the picture's turn came (see now()).
void write_results(const Options& o, Session& session, const shared::Camera& camera, RenderResult& result,
                   const RecordSet* records, const std::optional<Image>& reference, double began);

}  // namespace irradia::app
