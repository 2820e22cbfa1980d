// Records that come from a file, or go to one, as a render sees them.
#pragma once
#include "irradia/RecordFile.h"
#include "render/run.h"

namespace irradia {

/// Was the picture that `run` is to render rendered before, by the same settings, so that all its records are in `set`?
/// `radiance`: radiance records too.
bool knows_view(const RecordSet& set, const Run& run, bool radiance);

/// What the set is after `run`: `picture`: with its view.
void conclude(RecordSet& set, const Run& run, bool radiance, bool picture);

}  // namespace irradia
