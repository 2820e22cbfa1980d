// The true error of a picture, by long path tracing.
#pragma once
#include <cmath>
#include <vector>

#include "render/lamps.h"
#include "render/methods.h"
#include "room.h"

namespace irradia::test {

inline const ProgressCallback no_progress;  // a Run refers to it

inline RenderSettings path_settings(int spp, std::uint64_t seed) {
    RenderSettings s;
    s.method = Method::path;
    s.spp = spp;
    s.seed = seed;
    return s;
}

/// A reference in two independent halves, and the error of a picture against it where it counts.
struct Truth {
    UntouchedVector<float> a, b;
    std::vector<std::uint8_t> counted;

    Truth(const Scene& scene, Device& device, int spp)
        : a(render(scene, device, path_settings(spp, 501)).image.layers[0].data),
          b(render(scene, device, path_settings(spp, 502)).image.layers[0].data) {
        const RenderSettings settings = path_settings(1, 1);
        irradia::Run run(scene, device, settings, no_progress);
        counted = pixels_without_lamps(run);
    }
    [[nodiscard]] double error(const Image& image) const {
        const auto& x = image.layers[0].data;
        double square = 0, mean = 0, n = 0;
        for (std::size_t i = 0; i < x.size(); ++i) {
            if (counted[i / 3] == 0) continue;
            square += static_cast<double>(x[i] - a[i]) * static_cast<double>(x[i] - b[i]);
            mean += .5 * static_cast<double>(a[i] + b[i]);
            n += 1;
        }
        return std::sqrt(std::max(square / n, 0.0)) / (mean / n);
    }
};

}  // namespace irradia::test
