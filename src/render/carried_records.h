// Records that come from a file, or go to one, as a render sees them.
#pragma once
#include <vector>

#include "irradia/RecordFile.h"
#include "render/run.h"

namespace irradia {

/// The view that `run` renders now. `radiance`: with radiance records.
RecordView view_of(const Run& run, bool radiance);

/// Does a view of the same picture, with the same kinds of records at least, stand among `views`?
bool contains(const std::vector<RecordView>& views, const RecordView& view);

/// The pictures whose records are all in `set`, if they are as `run` makes them; otherwise none.
std::vector<RecordView> known_views(const RecordSet& set, const Run& run, bool radiance);

/// The set becomes one of `run`, which its records are of.
void conclude(RecordSet& set, const Run& run, bool radiance);

}  // namespace irradia
