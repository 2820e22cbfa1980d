// --width and --height on a scene that is loaded already.
#pragma once
#include "irradia/Scene.h"

namespace irradia::app {

/// Gives the film `width` x `height` pixels; a 0 follows the scene's shape, two zeros change nothing. Shape (to a
/// pixel's rounding) and field of view stay. Throws Error, naming scene.source, if the shape would change.
void set_film_size(Scene& scene, int width, int height);

}  // namespace irradia::app
