#include "render/carried_records.h"

#include <algorithm>
#include <cstring>

namespace irradia {
namespace {

RecordView view_of(const Run& run, bool radiance) {
    const shared::SceneInfo& info = run.scene.info;
    return {info.camera, info.width, info.height, RecordView::irradiance | (radiance ? RecordView::radiance : 0u), 0};
}

}  // namespace

bool knows_view(const RecordSet& set, const Run& run, bool radiance) {
    // Records used by force were placed for other surfaces, or farther apart.
    if (!record_mismatch(set.origin, record_origin(run.scene, run.settings), radiance).empty()) return false;
    const RecordView view = view_of(run, radiance);
    return std::any_of(set.views.begin(), set.views.end(), [&](const RecordView& known) {
        return (known.kinds & view.kinds) == view.kinds && known.width == view.width && known.height == view.height &&
               std::memcmp(&known.camera, &view.camera, sizeof view.camera) == 0;
    });
}

void conclude(RecordSet& set, const Run& run, bool radiance, bool picture) {
    if (picture && !knows_view(set, run, radiance)) set.views.push_back(view_of(run, radiance));
    const RecordOrigin before = std::move(set.origin);
    set.origin = record_origin(run.scene, run.settings);
    if (!radiance && set.radiance.size() > 0) keep_radiance_settings(before, set.origin);
}

}  // namespace irradia
