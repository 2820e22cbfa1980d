// A room for tests of materials, and its picture by caching against path tracing.
#pragma once
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <string>
#include <vector>

#include "render_fixture.h"

namespace irradia::test {

inline std::string sensor(int size, const std::string& origin, const std::string& target, double fov) {
    return R"(<sensor type="perspective"><float name="fov" value=")" + std::to_string(fov) +
           R"("/><transform name="to_world"><lookat origin=")" + origin + R"(" target=")" + target +
           R"(" up="0,1,0"/></transform><film type="hdrfilm"><integer name="width" value=")" + std::to_string(size) +
           R"("/><integer name="height" value=")" + std::to_string(size) +
           R"("/><rfilter type="box"/></film></sensor>)";
}

// A closed room of grey walls under a lamp, `floor` its floor, `things` in it.
inline std::string room(const std::string& floor, const std::string& things) {
    const std::string grey =
        R"(<bsdf type="twosided"><bsdf type="diffuse"><rgb name="reflectance" value=".6,.55,.5"/></bsdf></bsdf>)";
    const auto wall = [&](const std::string& transform, const std::string& bsdf) {
        return R"(<shape type="rectangle"><transform name="to_world">)" + transform + "</transform>" + bsdf +
               "</shape>";
    };
    return R"(<scene version="3.0.0">)" + sensor(64, "0,0.2,2.9", "0,-.35,0", 50) +
           wall(R"(<rotate x="1" angle="-90"/><translate y="-1"/>)", floor) +
           wall(R"(<rotate x="1" angle="90"/><translate y="1"/>)", grey) + wall(R"(<translate z="-1"/>)", grey) +
           wall(R"(<rotate y="1" angle="90"/><translate x="-1"/>)", grey) +
           wall(R"(<rotate y="1" angle="-90"/><translate x="1"/>)", grey) +
           R"(<shape type="rectangle"><transform name="to_world"><scale value=".25"/><rotate x="1" angle="90"/>
              <translate y=".98"/></transform><bsdf type="diffuse"><rgb name="reflectance" value="0"/></bsdf>
              <emitter type="area"><rgb name="radiance" value="12"/></emitter></shape>)" +
           things + "</scene>";
}

// A closed room but for a window in its right wall, a quarter of it each way, under an environment picture (a
// chessboard).
inline std::string window_room(int size) {
    const std::string grey =
        R"(<bsdf type="twosided"><bsdf type="diffuse"><rgb name="reflectance" value=".6,.55,.5"/></bsdf></bsdf>)";
    const auto wall = [&](const std::string& transform) {
        return R"(<shape type="rectangle"><transform name="to_world">)" + transform + "</transform>" + grey +
               "</shape>";
    };
    const std::string right = R"(<rotate y="1" angle="-90"/><translate x="1"/>)";
    std::string pieces;  // around the window: below, above, and its sides
    for (const char* piece :
         {R"(<scale x="1" y=".375"/><translate y="-.625"/>)", R"(<scale x="1" y=".375"/><translate y=".625"/>)",
          R"(<scale x=".375" y=".25"/><translate x="-.625"/>)", R"(<scale x=".375" y=".25"/><translate x=".625"/>)"})
        pieces += wall(piece + right);
    return R"(<scene version="3.0.0">)" + sensor(size, "-.2,0.1,.95", "0.1,-.1,-1", 80) +
           wall(R"(<rotate x="1" angle="-90"/><translate y="-1"/>)") +
           wall(R"(<rotate x="1" angle="90"/><translate y="1"/>)") + wall(R"(<translate z="-1"/>)") +
           wall(R"(<translate z="1"/>)") + wall(R"(<rotate y="1" angle="90"/><translate x="-1"/>)") + pieces +
           R"(<emitter type="envmap"><string name="filename" value=")" + project_scene("textures/tiles.png") +
           R"("/><float name="scale" value="4"/></emitter></scene>)";
}

inline const char* const grey_floor =
    R"(<bsdf type="twosided"><bsdf type="diffuse"><rgb name="reflectance" value=".5"/></bsdf></bsdf>)";

struct Comparison {
    double bias = 0, rmse = 0, noise = 0;  // relative to the mean; noise: standard error of bias
    std::uint64_t records = 0, radiance_records = 0;
};

// The picture by a caching method against the mean of path-traced ones.
inline Comparison compare(const Scene& scene, RenderSettings settings = {}) {
    constexpr int parts = 4;
    Device device({});
    std::vector<UntouchedVector<float>> paths;
    for (int i = 0; i < parts; ++i) {
        RenderSettings s;
        s.method = Method::path;
        s.spp = 256;
        s.seed = 100 + static_cast<unsigned>(i);
        paths.push_back(render(scene, device, s).image.layers[0].data);
    }
    settings.spp = 64;
    const RenderResult result = render(scene, device, settings);
    const auto& cached = result.image.layers[0].data;
    Comparison c;
    c.records = result.statistics.records;
    c.radiance_records = result.statistics.radiance_records;
    // Without the lamp and its edges, whose noise would hide everything else.
    std::vector<double> means(cached.size(), 0.0);
    for (const auto& part : paths)
        for (std::size_t i = 0; i < means.size(); ++i) means[i] += static_cast<double>(part[i]) / parts;
    std::vector<double> ordered = means;
    std::nth_element(ordered.begin(), ordered.begin() + static_cast<std::ptrdiff_t>(ordered.size() / 2), ordered.end());
    const double brightest = 4 * ordered[ordered.size() / 2];
    double reference = 0, squares = 0, difference = 0, n = 0;
    double part_means[parts] = {};
    for (std::size_t i = 0; i < cached.size(); ++i) {
        if (means[i] > brightest) continue;
        double product = 0, part[parts];
        for (int k = 0; k < parts; ++k) {
            part[k] = static_cast<double>(paths[static_cast<std::size_t>(k)][i]);
            part_means[k] += part[k];
        }
        const double x = static_cast<double>(cached[i]);
        for (int k = 0; k < parts; k += 2) product += (x - part[k]) * (x - part[k + 1]) / (parts / 2);
        reference += means[i];
        difference += x - means[i];
        squares += product;
        n += 1;
    }
    c.bias = difference / reference;
    c.rmse = std::sqrt(std::max(squares / n, 0.0)) / (reference / n);
    double spread = 0;
    for (const double m : part_means) spread += (m - reference) * (m - reference);
    c.noise = std::sqrt(spread / (parts * (parts - 1.0))) / reference;
    return c;
}

}  // namespace irradia::test
