#include "render/carried_records.h"

#include <algorithm>
#include <cstring>

namespace irradia {

RecordView view_of(const Run& run, bool radiance) {
    const shared::SceneInfo& info = run.scene.info;
    return {run.camera(), info.width, info.height, RecordView::irradiance | (radiance ? RecordView::radiance : 0u), 0};
}

bool contains(const std::vector<RecordView>& views, const RecordView& view) {
    return std::any_of(views.begin(), views.end(), [&](const RecordView& known) {
        return (known.kinds & view.kinds) == view.kinds && known.width == view.width && known.height == view.height &&
               std::memcmp(&known.camera, &view.camera, sizeof view.camera) == 0;
    });
}

std::vector<RecordView> known_views(const RecordSet& set, const Run& run, bool radiance) {
    // Records used by force were placed for other surfaces, or farther apart.
    const bool fits = record_mismatch(set.origin, record_origin(run.scene, run.settings), radiance).empty();
    return fits ? set.views : std::vector<RecordView>{};
}

void conclude(RecordSet& set, const Run& run, bool radiance) {
    const RecordOrigin before = std::move(set.origin);
    set.origin = record_origin(run.scene, run.settings);
    if (!radiance && set.radiance.size() > 0) keep_radiance_settings(before, set.origin);
}

}  // namespace irradia
