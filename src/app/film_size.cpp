#include "app/film_size.h"

#include <algorithm>
#include <cmath>
#include <string>

#include "irradia/Error.h"

namespace irradia::app {

void set_film_size(Scene& scene, int width, int height) {
    if (width == 0 && height == 0) return;
    shared::SceneInfo& info = scene.info;
    const double old_width = info.width, old_height = info.height;
    const double width_for_height = std::max(1.0, std::round(height * old_width / old_height));
    const double height_for_width = std::max(1.0, std::round(width * old_height / old_width));
    if (width == 0) width = static_cast<int>(width_for_height);
    if (height == 0) height = static_cast<int>(height_for_width);
    if (width != static_cast<int>(std::max(1.0, std::round(height * old_width / old_height))) &&
        height != static_cast<int>(std::max(1.0, std::round(width * old_height / old_width))))
        throw Error(scene.source + ": is packed for " + std::to_string(info.width) + " x " +
                    std::to_string(info.height) + " pixels, expected a picture of that shape, not " +
                    std::to_string(width) + " x " + std::to_string(height) + "; pack the scene again at that size");
    if (static_cast<long long>(width) * height >= 1LL << 31)
        throw Error(scene.source + ": " + std::to_string(width) + " x " + std::to_string(height) +
                    " pixels were asked for, fewer than 2^31 were expected");
    info.width = static_cast<shared::uint>(width);
    info.height = static_cast<shared::uint>(height);
    // The view is given over the unit square, so only a pixel's edge changes (geometric mean of both edges).
    info.camera.pixel_size *=
        static_cast<float>(std::sqrt(old_width * old_height / (static_cast<double>(width) * height)));
}

void set_rfilter(Scene& scene, const std::string& name) {
    if (name.empty()) return;
    shared::SceneInfo& info = scene.info;
    info.rfilter_stddev = 0.0f;
    if (name == "box") {
        info.rfilter = IR_RFILTER_BOX;
        info.rfilter_radius = 0.5f;
    } else if (name == "tent") {
        info.rfilter = IR_RFILTER_TENT;
        info.rfilter_radius = 1.0f;
    } else if (name == "gaussian") {
        info.rfilter = IR_RFILTER_GAUSSIAN;
        info.rfilter_stddev = 0.5f;
        info.rfilter_radius = 2.0f;  // four standard deviations, as the loader has it
    } else {
        throw Error("--rfilter: '" + name + "' was found, box, tent or gaussian was expected");
    }
}

std::string rfilter_name(const Scene& scene) {
    switch (scene.info.rfilter) {
        case IR_RFILTER_BOX:
            return "box";
        case IR_RFILTER_TENT:
            return "tent";
        default:
            return "gaussian";
    }
}

}  // namespace irradia::app
