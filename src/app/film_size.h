// --width, --height and --rfilter on a scene that is loaded already.
#pragma once
#include <string>

#include "irradia/Scene.h"

namespace irradia::app {

/// Gives the film `width` x `height` pixels; a 0 follows the scene's shape, two zeros change nothing. Shape (to a
/// pixel's rounding) and field of view stay. Throws Error, naming scene.source, if the shape would change.
void set_film_size(Scene& scene, int width, int height);

/// Replaces the film's reconstruction filter by "box", "tent" or "gaussian" of Mitsuba's default width; "" changes
/// nothing. Two pictures can be compared pixel by pixel only if they were filtered alike.
void set_rfilter(Scene& scene, const std::string& name);

/// What set_rfilter() calls the scene's filter.
std::string rfilter_name(const Scene& scene);

}  // namespace irradia::app
