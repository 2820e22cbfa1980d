// Settings by how good the picture is to be, also between the qualities and beyond the finest.
#pragma once
#include "irradia/Renderer.h"

namespace irradia {

/// `level`: 0 = draft, 1 = medium, 2 = fine, 3 = finest, up to highest_level; between them all but the hemisphere,
/// which is that of the nearest quality, changes gradually. An error is about halved from one to the next.
void apply_level(RenderSettings& settings, double level);
constexpr double highest_level = 5;

}  // namespace irradia
