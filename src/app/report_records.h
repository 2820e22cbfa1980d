// Where the caches' records lie in a picture.
#pragma once
#include <array>
#include <optional>
#include <vector>

#include "app/report_pictures.h"
#include "irradia/RecordFile.h"
#include "irradia/Scene.h"

namespace irradia::app {

/// A point as the camera (through the centre of its lens) sees it.
struct Projected {
    double x = 0, y = 0;  ///< pixels from the picture's top left corner
    double distance = 0;  ///< from the camera, world units
};
/// Where `point`, centred as the camera is, lies on the film; nothing if it is not in front of the camera.
std::optional<Projected> project(const shared::Camera& camera, int width, int height,
                                 const std::array<float, 3>& point);

struct RecordsPlot {
    Picture picture;  ///< the picture, dark and grey, `enlarged` times; a dot a record
    Scale scale;      ///< of the dots' colours: radius of the support, world units
    int enlarged = 1;
    std::size_t shown = 0, hidden = 0, outside = 0;  ///< records: in sight, behind surfaces, outside of the picture
    double least = 0, median = 0, most = 0;          ///< support of those shown
    double median_pixels = 0;                        ///< their median as pixels at the record's distance
};
/// `image`: with the layer "depth". `records`: their positions as the scene's.
RecordsPlot plot_records(const Image& image, const shared::Camera& camera, const Records& records, double exposure);

}  // namespace irradia::app
