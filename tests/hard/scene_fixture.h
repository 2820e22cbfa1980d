// Scenes and pictures of the hard cases. Pictures of one scene at two scales use the same random numbers, so that they
// differ by rounding alone.
#pragma once
#include <algorithm>
#include <array>
#include <cmath>
#include <sstream>
#include <string>
#include <utility>

#include "../cl/device.h"
#include "../render/render_fixture.h"
#include "hard_case.h"

namespace irradia::test {

inline std::string text(double x) {
    std::ostringstream s;
    s.precision(17);
    s << x;
    return s.str();
}

/// A picture on the device that all tests share, so that its kernels are compiled once.
inline RenderResult picture(const Scene& scene, const RenderSettings& settings, const std::string& traversal = "") {
    return render(scene, device(traversal), settings);
}

/// Values of any layer that are no radiance: not finite, or negative.
inline std::size_t unsound(const Image& image) {
    std::size_t count = 0;
    for (const Layer& l : image.layers)
        for (const float x : l.data) count += !std::isfinite(x) || x < 0;
    return count;
}

/// How two pictures of the same numbers differ.
struct Difference {
    double bias = 0;        ///< of the mean, relative
    double rmse = 0;        ///< relative to the mean
    double differing = 0;   ///< share of values that differ by more than 1e-3 of themselves
    std::size_t bytes = 0;  ///< values that are not the same number
};
/// `scale`: what `b` is multiplied by first.
inline Difference difference(const Image& a, const Image& b, double scale = 1) {
    const auto &x = a.layers.at(0).data, &y = b.layers.at(0).data;
    Difference d;
    if (x.size() != y.size()) throw std::logic_error("pictures of different sizes");
    double sum = 0, square = 0, mean = 0;
    for (std::size_t i = 0; i < x.size(); ++i) {
        const double p = static_cast<double>(x[i]), q = scale * static_cast<double>(y[i]);
        sum += p - q;
        square += (p - q) * (p - q);
        mean += q;
        d.differing += std::abs(p - q) > 1e-3 * std::abs(q);
        d.bytes += p != q;
    }
    if (!(mean > 0)) throw std::logic_error("a black picture to compare with");
    const double n = static_cast<double>(x.size());
    d.bias = std::abs(sum) / mean;
    d.rmse = std::sqrt(square / n) / (mean / n);
    d.differing /= n;
    return d;
}

inline std::string read_file(const std::string& path) {
    std::ifstream file(path);
    std::stringstream s;
    s << file.rdbuf();
    return s.str();
}

/// `in` with every `what` replaced.
inline std::string replaced(std::string in, const std::string& what, const std::string& by) {
    std::size_t at = in.find(what);
    if (at == std::string::npos) throw std::logic_error("nothing to replace: " + what);
    for (; at != std::string::npos; at = in.find(what, at + by.size())) in.replace(at, what.size(), by);
    return in;
}

/// The scene of an XML text with everything in it, the camera too, times `scale`, then moved by `offset`. Its camera
/// has to be a lookat with `origin` and `target`, without clipping planes of its own, and to come before the shapes.
inline std::string transformed(const std::string& xml, double scale, const std::array<double, 3>& offset = {0, 0, 0}) {
    const std::size_t sensor = xml.find("<sensor"), end = xml.find("</sensor>");
    std::string camera = xml.substr(sensor, end - sensor);
    for (const std::string point : {"origin=\"", "target=\""}) {
        const std::size_t first = camera.find(point) + point.size(), last = camera.find('"', first);
        std::string numbers = camera.substr(first, last - first), moved;
        std::replace(numbers.begin(), numbers.end(), ',', ' ');
        std::istringstream in(numbers);
        for (std::size_t k = 0; k < 3; ++k) {
            double x = 0;
            if (!(in >> x)) throw std::logic_error("no lookat in the camera");
            moved += text(x * scale + offset[k]) + (k < 2 ? ", " : "");
        }
        camera.replace(first, last - first, moved);
    }
    const std::size_t head = camera.find('>') + 1;
    camera.insert(head, "<float name=\"near_clip\" value=\"" + text(1e-2 * scale) +
                            "\"/><float name=\"far_clip\" value=\"" + text(1e4 * scale) + "\"/>");
    const std::string move = "<scale value=\"" + text(scale) + "\"/><translate x=\"" + text(offset[0]) + "\" y=\"" +
                             text(offset[1]) + "\" z=\"" + text(offset[2]) + "\"/></transform>";
    return xml.substr(0, sensor) + camera + replaced(xml.substr(end), "</transform>", move);
}

/// scenes/cornell-box.xml of that many pixels a side.
inline std::string cornell_text(int size) {
    return replaced(read_file(project_scene("cornell-box.xml")), R"(name="size" value="256")",
                    "name=\"size\" value=\"" + std::to_string(size) + "\"");
}
/// The same, scaled and moved.
inline Scene cornell(int size, double scale = 1, const std::array<double, 3>& offset = {0, 0, 0}) {
    return load_text(transformed(cornell_text(size), scale, offset));
}

/// `lookat` and the rest of a camera of width x height pixels with a box filter.
inline std::string camera(int width, int height, const std::string& origin, const std::string& target, double fov,
                          const std::string& rest = "") {
    return R"(<sensor type="perspective"><float name="fov" value=")" + text(fov) +
           R"("/><string name="fov_axis" value="larger"/>)" + rest + R"(<transform name="to_world"><lookat origin=")" +
           origin + R"(" target=")" + target +
           R"(" up="0, 1, 0"/></transform><film type="hdrfilm"><integer name="width" value=")" + std::to_string(width) +
           R"("/><integer name="height" value=")" + std::to_string(height) +
           R"("/><rfilter type="box"/></film></sensor>)";
}
inline std::string grey(double reflectance) {
    return R"(<bsdf type="twosided"><bsdf type="diffuse"><rgb name="reflectance" value=")" + text(reflectance) +
           R"("/></bsdf></bsdf>)";
}
inline std::string shape(const std::string& type, const std::string& transform, const std::string& rest) {
    return "<shape type=\"" + type + "\"><transform name=\"to_world\">" + transform + "</transform>" + rest +
           "</shape>";
}
inline std::string scene_text(const std::string& inside) { return "<scene version=\"3.0.0\">" + inside + "</scene>"; }

inline std::string name_of(Method method) {
    switch (method) {
        case Method::irradiance:
            return "irradiance";
        case Method::radiance:
            return "radiance";
        case Method::gather:
            return "gather";
        default:
            return "path";
    }
}

}  // namespace irradia::test
