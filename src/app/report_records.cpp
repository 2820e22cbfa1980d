#include "app/report_records.h"

#include <algorithm>
#include <cmath>
#include <glm/glm.hpp>

#include "irradia/Error.h"

namespace irradia::app {
namespace {

// The dots' part of the map: its dark end is not seen on a dark picture.
const char* const kMap = "viridis";
constexpr float kMapBegins = 0.3f;
constexpr int kPlotWidth = 1000;  // pixels that smaller pictures are enlarged to, by whole factors

struct Dot {
    double x, y;  // pixels of the picture
    double support, pixels;
};

// Is it the nearest surface, or one seen through the same pixels? Depth is a pixel's mean, which lies between the
// depths of surfaces that meet in it: the farthest of the neighbours decides.
bool in_sight(const Layer& depth, int width, int height, const Projected& p) {
    constexpr double allowance = 0.01;  // of the distance: slanted surfaces
    const int px = static_cast<int>(p.x), py = static_cast<int>(p.y);
    double farthest = 0;
    for (int y = std::max(py - 1, 0); y <= std::min(py + 1, height - 1); ++y)
        for (int x = std::max(px - 1, 0); x <= std::min(px + 1, width - 1); ++x)
            farthest = std::max(farthest, static_cast<double>(depth.data[static_cast<std::size_t>(y) * width + x]));
    return p.distance <= farthest * (1 + allowance);
}

// A dot with a dark rim, its edges smoothed.
void draw(Picture& picture, double cx, double cy, double radius, const std::uint8_t* colour) {
    const double rim = radius + 1;
    const int left = std::max(0, static_cast<int>(cx - rim - 1)), top = std::max(0, static_cast<int>(cy - rim - 1));
    const int right = std::min(picture.width - 1, static_cast<int>(cx + rim + 1));
    const int bottom = std::min(picture.height - 1, static_cast<int>(cy + rim + 1));
    for (int y = top; y <= bottom; ++y)
        for (int x = left; x <= right; ++x) {
            const double distance = std::hypot(x + 0.5 - cx, y + 0.5 - cy);
            const double inside = std::clamp(radius + 0.5 - distance, 0.0, 1.0);
            const double dark = 0.6 * std::clamp(rim + 0.5 - distance, 0.0, 1.0);
            std::uint8_t* pixel = &picture.rgb[3 * (static_cast<std::size_t>(y) * picture.width + x)];
            for (int c = 0; c < 3; ++c)
                pixel[c] =
                    static_cast<std::uint8_t>(std::lround((1 - dark) * (1 - inside) * pixel[c] + inside * colour[c]));
        }
}

Picture backdrop(const Image& image, double exposure, int factor) {
    const Picture small = tone_mapped(image.layers.front(), image.width, image.height, exposure);
    Picture out{small.width * factor, small.height * factor, {}};
    out.rgb.reserve(3 * static_cast<std::size_t>(out.width) * out.height);
    for (int y = 0; y < out.height; ++y)
        for (int x = 0; x < out.width; ++x) {
            const std::uint8_t* p = &small.rgb[3 * (static_cast<std::size_t>(y / factor) * small.width + x / factor)];
            const double grey = 0.2126 * p[0] + 0.7152 * p[1] + 0.0722 * p[2];
            out.rgb.insert(out.rgb.end(), 3, static_cast<std::uint8_t>(12 + 0.3 * grey));
        }
    return out;
}

double share_of(const Scale& s, double support) {
    return s.high > s.low ? std::clamp(std::log(support / s.low) / std::log(s.high / s.low), 0.0, 1.0) : 0.5;
}

}  // namespace

std::optional<Projected> project(const shared::Camera& c, int width, int height, const std::array<float, 3>& point) {
    const glm::dvec3 way = glm::dvec3(point[0], point[1], point[2]) - glm::dvec3(c.ox, c.oy, c.oz);
    // camera_ray_at() of cl/camera.h: way = s (corner + x dx + y dy), with s > 0.
    const glm::dmat3 film(glm::dvec3(c.dxx, c.dxy, c.dxz), glm::dvec3(c.dyx, c.dyy, c.dyz),
                          glm::dvec3(c.cornerx, c.cornery, c.cornerz));
    const glm::dvec3 at = glm::inverse(film) * way;
    if (!(at.z > 0)) return std::nullopt;
    return Projected{at.x / at.z * width, at.y / at.z * height, glm::length(way)};
}

RecordsPlot plot_records(const Image& image, const shared::Camera& camera, const Records& records, double exposure) {
    const Layer* depth = find_layer(image, "depth");
    if (depth == nullptr) throw Error("records cannot be drawn: the picture has no layer depth");
    RecordsPlot plot;
    std::vector<Dot> dots;
    for (const shared::RecordKey& key : records.keys) {
        const auto p = project(camera, image.width, image.height, {key.px, key.py, key.pz});
        if (!p || !(p->x >= 0 && p->y >= 0 && p->x < image.width && p->y < image.height)) {
            ++plot.outside;
        } else if (!in_sight(*depth, image.width, image.height, *p)) {
            ++plot.hidden;
        } else {
            // The radius of a disk as large as the support's ellipse.
            const double support = std::sqrt(static_cast<double>(key.support1) * static_cast<double>(key.support2));
            dots.push_back({p->x, p->y, support, support / (p->distance * static_cast<double>(camera.pixel_size))});
        }
    }
    plot.shown = dots.size();
    plot.enlarged = std::clamp(kPlotWidth / image.width, 1, 16);
    plot.picture = backdrop(image, exposure, plot.enlarged);
    if (dots.empty()) return plot;

    const auto median = [&](auto by) {
        const auto at = dots.begin() + static_cast<std::ptrdiff_t>(dots.size() / 2);
        std::nth_element(dots.begin(), at, dots.end(), [&](const Dot& a, const Dot& b) { return by(a) < by(b); });
        return by(*at);
    };
    plot.median_pixels = median([](const Dot& d) { return d.pixels; });
    plot.median = median([](const Dot& d) { return d.support; });
    // Large ones first: small ones lie close together and are to be seen.
    std::stable_sort(dots.begin(), dots.end(), [](const Dot& a, const Dot& b) { return a.support > b.support; });
    plot.most = dots.front().support;
    plot.least = dots.back().support;
    plot.scale = {plot.least, plot.most, true, "world units", scale_colours(kMap, kMapBegins)};

    std::vector<float> shares;
    for (const Dot& d : dots)
        shares.push_back(kMapBegins + (1 - kMapBegins) * static_cast<float>(share_of(plot.scale, d.support)));
    const std::vector<std::uint8_t> colours = map_colours(kMap, shares);
    const double area = static_cast<double>(plot.picture.width) * plot.picture.height / static_cast<double>(plot.shown);
    const double radius = std::clamp(0.2 * std::sqrt(area), 0.8, 4.0);
    for (std::size_t i = 0; i < dots.size(); ++i)
        draw(plot.picture, plot.enlarged * dots[i].x, plot.enlarged * dots[i].y, radius, &colours[3 * i]);
    return plot;
}

}  // namespace irradia::app
