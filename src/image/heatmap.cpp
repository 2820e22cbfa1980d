#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "image/metrics_detail.h"
#include "irradia/Error.h"
#include "pictures/oiio.h"

namespace irradia {

ErrorPicture error_picture(const Image& picture, const Image& reference, const MetricsOptions& options, double scale) {
    const detail::Comparison c = detail::make_comparison(picture, reference, options);
    std::vector<float> error(c.pixels), counted;
    for (std::size_t p = 0; p < c.pixels; ++p) {
        if (!c.counted[p]) continue;
        double sum = 0;
        for (std::size_t i = 3 * p; i < 3 * p + 3; ++i) sum += (c.x[i] - c.reference(i)) * (c.x[i] - c.reference(i));
        error[p] = static_cast<float>(std::sqrt(sum / 3) / c.mean_reference);
        counted.push_back(error[p]);
    }
    if (scale <= 0) {
        const auto at = counted.begin() + static_cast<std::ptrdiff_t>(0.99 * static_cast<double>(counted.size() - 1));
        std::nth_element(counted.begin(), at, counted.end());
        scale = *at > 0 ? *at : 1;  // equal pictures: any scale shows them black
    }
    for (float& e : error) e = static_cast<float>(std::min(e / scale, 1.0));

    ErrorPicture result;
    result.scale = scale;
    result.image = {picture.width, picture.height, {{"", 3, UntouchedVector<float>(c.pixels * 3)}}, {}};
    UntouchedVector<float>& out = result.image.layers[0].data;
    const std::string why =
        oiio::library().colour_map("inferno", picture.width, picture.height, error.data(), out.data());
    if (!why.empty()) throw Error(fmt::format("the error picture cannot be made: {}", why));
    for (std::size_t i = 0; i < out.size(); ++i)  // OpenImageIO's colours of the map are linear
        if (!c.counted[i / 3]) out[i] = 0.2f;
    result.image.metadata["irradia.quantity"] = "rms over channels of (x - ref) / mean(ref)";
    result.image.metadata["irradia.colour map"] = fmt::format("inferno, 0 to {:.4g}, grey: not counted", scale);
    return result;
}

}  // namespace irradia
