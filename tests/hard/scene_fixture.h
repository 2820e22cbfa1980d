// Scenes and pictures of the hard cases. Pictures of one scene at two scales use the same random numbers, so that they
// differ by rounding alone.
#pragma once
#include <array>
#include <cmath>
#include <regex>
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
    const std::vector<float>&x = a.layers.at(0).data, &y = b.layers.at(0).data;
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

/// The scene of an XML text with everything in it, the camera too, times `scale`, then moved by `offset`. Its camera
/// has to be a lookat with `origin` and `target`, and no clipping planes of its own.
inline std::string transformed(const std::string& xml, double scale, const std::array<double, 3>& offset = {0, 0, 0}) {
    const std::size_t sensor = xml.find("<sensor"), end = xml.find("</sensor>");
    std::string camera = xml.substr(sensor, end - sensor);
    for (const std::string point : {"origin", "target"}) {
        const std::regex numbers(point + R"(="\s*([-+.0-9e]+)\s*,\s*([-+.0-9e]+)\s*,\s*([-+.0-9e]+)\s*")");
        std::smatch found;
        if (!std::regex_search(camera, found, numbers)) throw std::logic_error("no lookat in the camera");
        std::string moved = point + "=\"";
        for (std::size_t k = 0; k < 3; ++k)
            moved += text(std::stod(found[k + 1]) * scale + offset[k]) + (k < 2 ? ", " : "\"");
        camera = found.prefix().str() + moved + found.suffix().str();
    }
    const std::size_t head = camera.find('>') + 1;
    camera.insert(head, "<float name=\"near_clip\" value=\"" + text(1e-2 * scale) +
                            "\"/><float name=\"far_clip\" value=\"" + text(1e4 * scale) + "\"/>");
    const std::string move = "<scale value=\"" + text(scale) + "\"/><translate x=\"" + text(offset[0]) + "\" y=\"" +
                             text(offset[1]) + "\" z=\"" + text(offset[2]) + "\"/></transform>";
    const auto shapes = [&](const std::string& part) {
        return std::regex_replace(part, std::regex("</transform>"), move);
    };
    return shapes(xml.substr(0, sensor)) + camera + shapes(xml.substr(end));
}

/// scenes/cornell-box.xml of that many pixels a side, scaled and moved.
inline Scene cornell(int size, double scale = 1, const std::array<double, 3>& offset = {0, 0, 0}) {
    std::string xml = read_file(project_scene("cornell-box.xml"));
    xml = std::regex_replace(xml, std::regex(R"(<default name="size" value="256" />)"),
                             "<default name=\"size\" value=\"" + std::to_string(size) + "\" />");
    return load_text(transformed(xml, scale, offset));
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
