// Environment pictures: reading them, their mean, and the tables that kernels sample them by (cl/environment.h).
#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <numbers>

#include "pictures/oiio.h"
#include "scene/build.h"
#include "scene/parts.h"

namespace irradia::loader {
namespace {

constexpr double pi = std::numbers::pi;
constexpr std::uint32_t steps = 1u << 24;  // running sums are multiples of 1 / steps, which float32 holds exactly

/// Polar angle of row i of texels.
double polar_angle(std::uint32_t i, std::uint32_t height) { return pi * i / (height - 1.0); }

/// Integrals of (1 - t) sin and t sin over polar angles a to b, where t runs from 0 to 1: what a cell's upper and lower
/// texels weigh, per radian of azimuth.
std::array<double, 2> row_weights(double a, double b) {
    const double h = b - a;
    const double all = 2.0 * std::sin(0.5 * (a + b)) * std::sin(0.5 * h);
    // sin b - sin a - h cos b, over h; by its series where that cancels
    const double lower = h > 1e-3 ? (std::sin(b) - std::sin(a)) / h - std::cos(b)
                                  : h * (std::sin(a) / 2.0 + h * std::cos(a) / 3.0 - h * h * std::sin(a) / 8.0);
    return {all - lower, lower};
}

/// Integral of the bilinear picture over each cell's solid angle.
class CellFlux {
public:
    explicit CellFlux(const EnvironmentMap& map) : map_(map) {
        for (std::uint32_t row = 0; row + 1 < map.height; ++row)
            weights_.push_back(row_weights(polar_angle(row, map.height), polar_angle(row + 1, map.height)));
    }
    [[nodiscard]] glm::dvec3 operator()(std::uint32_t column, std::uint32_t row) const {
        const auto [upper, lower] = weights_[row];
        const std::uint32_t next = (column + 1) % map_.width;
        const glm::dvec3 above = 0.5 * (texel(column, row) + texel(next, row)),
                         below = 0.5 * (texel(column, row + 1) + texel(next, row + 1));
        return (above * upper + below * lower) * (2.0 * pi / map_.width);
    }

private:
    const EnvironmentMap& map_;
    std::vector<std::array<double, 2>> weights_;  // of every row of cells
    [[nodiscard]] glm::dvec3 texel(std::uint32_t column, std::uint32_t row) const {
        const float* t = map_.texels.data() + 3 * (std::size_t{row} * map_.width + column);
        return {t[0], t[1], t[2]};
    }
};

/// Appends the inclusive running sums of the probabilities that are proportional to `weights`. Whatever has a weight
/// has a probability: one step at least. All weights zero: uniform, which nothing will ask for.
void append_sums(std::vector<std::uint32_t>& texels, const std::vector<double>& weights) {
    double total = 0.0;
    for (const double w : weights) total += w;
    const auto weight = [&](std::size_t i) { return total > 0.0 ? weights[i] : 1.0; };
    const double scale = steps / (total > 0.0 ? total : static_cast<double>(weights.size()));
    std::vector<std::uint32_t> sums(weights.size());
    double running = 0.0;
    std::uint32_t before = 0;
    for (std::size_t i = 0; i < weights.size(); ++i) {
        running += weight(i) * scale;
        if (weight(i) > 0.0) before = std::max(static_cast<std::uint32_t>(std::llround(running)), before + 1);
        sums[i] = before;
    }
    std::uint32_t limit = steps;  // for what steps of their own have pushed beyond the end
    bool last = true;
    for (std::size_t i = weights.size(); i-- > 0;) {
        sums[i] = last ? steps : std::min(sums[i], limit);
        if (weight(i) > 0.0) {
            limit = sums[i] - 1;
            last = false;
        } else {
            limit = sums[i];
        }
    }
    for (const std::uint32_t sum : sums)
        texels.push_back(std::bit_cast<std::uint32_t>(static_cast<float>(sum) / static_cast<float>(steps)));
}

/// All that cl/environment.h reads besides the texels.
std::vector<std::uint32_t> sampling_tables(const EnvironmentMap& map, const CellFlux& flux) {
    const std::uint32_t rows = map.height - 1;
    std::vector<std::uint32_t> of_cells, tables;
    of_cells.reserve(std::size_t{rows} * map.width);
    std::vector<double> of_rows(rows), cells(map.width);
    for (std::uint32_t row = 0; row < rows; ++row) {
        for (std::uint32_t column = 0; column < map.width; ++column) {
            cells[column] = luminance(flux(column, row));
            of_rows[row] += cells[column];
        }
        append_sums(of_cells, cells);
    }
    const auto append = [&](double x) { tables.push_back(std::bit_cast<std::uint32_t>(static_cast<float>(x))); };
    tables.reserve(3 * std::size_t{rows} + 1 + of_cells.size());
    append_sums(tables, of_rows);
    for (std::uint32_t row = 0; row < map.height; ++row) {
        const double angle = polar_angle(row, map.height), half = std::sin(0.5 * std::min(angle, pi - angle));
        append(2.0 * half * half);
    }
    for (std::uint32_t row = 0; row < rows; ++row) {
        const auto [upper, lower] = row_weights(polar_angle(row, map.height), polar_angle(row + 1, map.height));
        append(map.width / (2.0 * pi * (upper + lower)));
    }
    tables.insert(tables.end(), of_cells.begin(), of_cells.end());
    return tables;
}

glm::dvec3 mean_radiance(const EnvironmentMap& map, const CellFlux& flux) {
    glm::dvec3 sum(0.0);
    for (std::uint32_t row = 0; row + 1 < map.height; ++row)
        for (std::uint32_t column = 0; column < map.width; ++column) sum += flux(column, row);
    return sum / (4.0 * pi);
}

EnvironmentMap read_map(const Node& node, const std::string& path, double scale) {
    const auto unreadable = [&](const std::string& why) {
        fail(node, fmt::format("environment picture '{}' cannot be read: {}", path, why));
    };
    std::string why;
    const std::unique_ptr<oiio::Input> input = oiio::library().open(path, true, why);
    if (!input) unreadable(why);
    const std::size_t channels = input->channels.size();
    if (input->width < 1 || input->height < 1 || channels < 1 || input->width > 1 << 20 || input->height > 1 << 20)
        fail(node,
             fmt::format("environment picture '{}' is {} x {} pixels of {} channels; 1 to 1048576 pixels each way "
                         "and at least one channel were expected",
                         path, input->width, input->height, channels));
    EnvironmentMap map;
    map.width = static_cast<std::uint32_t>(input->width);
    map.height = static_cast<std::uint32_t>(input->height);
    std::vector<float> data(std::size_t{map.width} * map.height * channels);
    why = input->read(data.data());
    if (!why.empty()) unreadable(why);
    const bool encoded = input->values != oiio::Values::floats;  // integer formats carry sRGB-encoded values
    map.texels.resize(std::size_t{map.width} * map.height * 3);
    for (std::size_t i = 0; i < map.texels.size(); ++i) {
        const std::size_t pixel = i / 3, channel = channels < 3 ? 0 : i % 3;
        double v = static_cast<double>(data[pixel * channels + channel]);
        if (encoded) v = srgb_to_linear(v);
        if (v < 0.0) {
            ++map.negative;
            v = 0.0;
        }
        map.texels[i] = static_cast<float>(v * scale);
        if (!std::isfinite(map.texels[i]))
            fail(node, fmt::format("environment picture '{}' has the value {} (times scale {}) at pixel ({}, {}); a "
                                   "finite number was expected",
                                   path, v, scale, pixel % map.width, pixel / map.width));
    }
    if (map.height == 1) {  // both poles: the same row
        map.height = 2;
        map.texels.insert(map.texels.end(), map.texels.begin(), map.texels.begin() + 3 * std::ptrdiff_t{map.width});
    }
    const CellFlux flux(map);
    map.tables = sampling_tables(map, flux);
    map.mean = mean_radiance(map, flux);
    return map;
}

}  // namespace

std::shared_ptr<const EnvironmentMap> read_environment(const Context& context, const Node& node,
                                                       const std::string& path, double scale) {
    const auto map = from_parts(context.options.parts, &SceneParts::Impl::environments, path,
                                fmt::format("times {}", scale), [&] { return read_map(node, path, scale); });
    if (map->negative > 0)
        context.warn(node,
                     fmt::format("environment picture '{}': {} negative values are taken as 0", path, map->negative));
    return map;
}

void append_environment(const EnvironmentMap& map, Scene& scene, shared::Light& light) {
    std::vector<std::uint32_t>& texels = scene.texels;
    light.texture = static_cast<int>(scene.textures.size());
    shared::Texture picture{};
    picture.offset = static_cast<std::uint32_t>(texels.size());
    picture.width = map.width;
    picture.height = map.height;
    picture.format = IR_TEXTURE_RGB32F;
    picture.m00 = picture.m11 = 1.0f;
    scene.textures.push_back(picture);
    texels.reserve(texels.size() + environment_words(map));
    for (const float t : map.texels) texels.push_back(std::bit_cast<std::uint32_t>(t));
    light.table = static_cast<std::uint32_t>(texels.size());
    texels.insert(texels.end(), map.tables.begin(), map.tables.end());
}

std::size_t environment_words(const EnvironmentMap& map) { return map.texels.size() + map.tables.size(); }

}  // namespace irradia::loader
