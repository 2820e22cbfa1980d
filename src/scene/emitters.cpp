#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "scene/build.h"

namespace irradia::loader {
namespace {

constexpr double pi = std::numbers::pi;

const char* const supported_emitters = "point, spot, directional, constant, envmap";

/// An emitter's colour: finite and nowhere negative. `textures`: what may stand there, for the message.
glm::dvec3 emission(const Context& context, const Document& document, Properties& p, const std::string& name,
                    double fallback, const char* textures = "a constant colour") {
    const Node* node = p.property(name);
    if (!node) return glm::dvec3(fallback);
    glm::dvec3 colour;
    if (node->tag == "texture") {
        context.unsupported(*node, textures, "the picture's mean colour, or 1");
        Properties t(context, document, *node);
        colour = glm::dvec3(1.0);
        if (is_bitmap(*node))
            colour = mean_colour(context, *node, document.resolve(*node, t.text("filename")), t.boolean("raw", false),
                                 [](double) { return 1.0; });
    } else {
        colour = parse_colour(context, *node);
        // A flat spectrum is equal-energy white, which is not white in Rec. 709: XYZ = (1, 1, 1) in linear RGB.
        if (node->tag == "spectrum") colour *= glm::dvec3(1.20478, 0.94830, 0.90884);
    }
    if (colour.x < 0.0 || colour.y < 0.0 || colour.z < 0.0)
        fail(*node,
             fmt::format("{}: {} is negative ({}, {}, {})", describe(p.node()), name, colour.x, colour.y, colour.z));
    return colour;
}

glm::dvec3 direction_of(Properties& p) {
    const auto direction = p.vector("direction");
    const auto to_world = p.transform("to_world");
    if (direction && to_world)
        fail(p.node(), fmt::format("{}: give either direction or to_world, not both", describe(p.node())));
    const glm::dvec3 d = direction ? *direction : glm::dvec3(to_world.value_or(glm::dmat4(1.0))[2]);
    if (!(glm::length(d) > 0.0)) fail(p.node(), fmt::format("{}: direction is zero", describe(p.node())));
    return glm::normalize(d);
}

glm::dvec3 position_of(Properties& p) {
    const auto position = p.vector("position");
    const auto to_world = p.transform("to_world");
    if (position && to_world)
        fail(p.node(), fmt::format("{}: give either position or to_world, not both", describe(p.node())));
    return position ? *position : glm::dvec3(to_world.value_or(glm::dmat4(1.0))[3]);
}

/// to_world of what has a direction but no size: rotates, moves, may mirror.
glm::dmat4 rigid_transform(const Context& context, Properties& p) {
    glm::dmat4 m = p.transform("to_world").value_or(glm::dmat4(1.0));
    bool rigid = true;
    for (int i = 0; i < 3; ++i)
        for (int k = 0; k < 3; ++k)
            rigid = rigid && std::abs(glm::dot(glm::dvec3(m[i]), glm::dvec3(m[k])) - (i == k ? 1.0 : 0.0)) <= 1e-3;
    if (!rigid)
        context.problem(p.node(),
                        fmt::format("{}: to_world scales or shears; a rotation was expected", describe(p.node())),
                        "its axes are made perpendicular and of unit length");
    const glm::dvec3 z = glm::dvec3(m[2]), y = glm::dvec3(m[1]), x = glm::dvec3(m[0]);
    if (!(std::abs(glm::dot(glm::cross(x, y), z)) > 1e-12 * glm::length(x) * glm::length(y) * glm::length(z)))
        fail(p.node(), fmt::format("{}: to_world is singular, a rotation was expected", describe(p.node())));
    const glm::dvec3 unit_z = glm::normalize(z), unit_y = glm::normalize(y - unit_z * glm::dot(y, unit_z));
    const glm::dvec3 unit_x = glm::cross(unit_y, unit_z) * (glm::dot(glm::cross(y, z), x) < 0.0 ? -1.0 : 1.0);
    m[0] = glm::dvec4(unit_x, 0.0);
    m[1] = glm::dvec4(unit_y, 0.0);
    m[2] = glm::dvec4(unit_z, 0.0);
    return m;
}

FreeLight read_spot(const Context& context, const Document& document, Properties& p) {
    FreeLight light;
    light.kind = IR_LIGHT_SPOT;
    light.colour = emission(context, document, p, "intensity", 1.0);
    if (const Node* texture = p.property("texture"))
        context.problem(*texture, fmt::format("{}: a projected texture is not supported", describe(p.node())),
                        "the spot is left without it");
    const glm::dmat4 m = rigid_transform(context, p);
    light.position = glm::dvec3(m[3]);
    light.direction = glm::dvec3(m[2]);
    const double cutoff = p.number("cutoff_angle", 20.0);
    if (!(cutoff > 0.0 && cutoff < 180.0))
        fail(p.node(), fmt::format("{}: cutoff_angle is {} degrees; above 0 and below 180 was expected",
                                   describe(p.node()), cutoff));
    const double beam = p.number("beam_width", 0.75 * cutoff);
    if (!(beam > 0.0 && beam <= cutoff))
        fail(p.node(), fmt::format("{}: beam_width is {} degrees; above 0 and up to the cutoff_angle, {}, was expected",
                                   describe(p.node()), beam, cutoff));
    light.cutoff = cutoff * pi / 180.0;
    light.beam = beam * pi / 180.0;
    return light;
}

/// Power of a spot over its intensity: the integral of its falloff, 1 up to the angle `beam` and from there falling
/// linearly to 0 at `cutoff`.
double spot_solid_angle(double cutoff, double beam) {
    const double edge = cutoff - beam;
    const double slope = edge > 1e-6 ? (std::sin(cutoff) - std::sin(beam)) / edge : std::cos(cutoff);
    return 2.0 * pi * (1.0 - slope);
}

FreeLight read_envmap(const Context& context, const Document& document, Properties& p) {
    FreeLight light;
    light.kind = IR_LIGHT_ENVMAP;
    const double scale = p.number("scale", 1.0);
    if (scale < 0.0) fail(p.node(), fmt::format("{}: scale is {}; 0 or more was expected", describe(p.node()), scale));
    light.map = read_environment(context, p.node(), document.resolve(p.node(), p.text("filename")), scale);
    light.axes = glm::dmat3(rigid_transform(context, p));
    light.colour = light.map->mean;
    p.ignore({"mis_compensation"});  // a matter of noise
    return light;
}

}  // namespace

std::optional<glm::dvec3> read_area_emitter(const Context& context, const Document& document, const Node& emitter) {
    if (emitter.get("type") != "area") {
        context.unsupported(emitter, std::string("area on shapes; ") + supported_emitters + " at the top level",
                            "no emission");
        return std::nullopt;
    }
    Properties p(context, document, emitter);
    const Node* texture = p.property("radiance");
    const glm::dvec3 radiance = texture && is_bitmap(*texture)
                                    ? glm::dvec3(1.0)
                                    : emission(context, document, p, "radiance", 1.0, "a constant colour, bitmap");
    p.ignore({"sampling_weight"});
    p.finish();
    return radiance;
}

std::vector<FreeLight> read_free_lights(const Context& context, const Document& document) {
    std::vector<FreeLight> lights;
    const Node* sky = nullptr;
    for (const auto& node : document.root.children) {
        if (node.tag != "emitter") continue;
        const std::string type = node.get("type");
        Properties p(context, document, node);
        FreeLight light;
        if (type == "point") {
            light.kind = IR_LIGHT_POINT;
            light.colour = emission(context, document, p, "intensity", 1.0);
            light.position = position_of(p);
        } else if (type == "directional") {
            light.kind = IR_LIGHT_DIRECTIONAL;
            light.colour = emission(context, document, p, "irradiance", 1.0);
            light.direction = direction_of(p);
        } else if (type == "constant") {
            light.kind = IR_LIGHT_CONSTANT;
            light.colour = emission(context, document, p, "radiance", 1.0);
            p.ignore({"to_world"});
        } else if (type == "area") {
            fail(node, "<emitter type=\"area\"> has to stand inside a <shape>");
        } else if (type == "envmap") {
            light = read_envmap(context, document, p);
        } else if (type == "spot") {
            light = read_spot(context, document, p);
        } else {
            context.unsupported(node, supported_emitters, "nothing, it is left out");
            continue;
        }
        light.node = &node;
        p.ignore({"sampling_weight"});
        p.finish();
        if (light.kind == IR_LIGHT_CONSTANT || light.kind == IR_LIGHT_ENVMAP) {
            if (sky) fail(node, fmt::format("more than one environment emitter, the other one is at {}", where(*sky)));
            sky = &node;
        }
        lights.push_back(std::move(light));
    }
    return lights;
}

void set_selection_probabilities(std::vector<shared::Light>& lights, double radius) {
    std::vector<double> power;
    double sum = 0.0;
    for (const auto& l : lights) {
        const double colour = luminance({l.r, l.g, l.b});
        double p = colour * l.area * pi;
        if (l.kind == IR_LIGHT_POINT) p = colour * 4.0 * pi;
        if (l.kind == IR_LIGHT_SPOT) p = colour * spot_solid_angle(double{l.e2x}, double{l.e2y});
        if (l.kind == IR_LIGHT_DIRECTIONAL) p = colour * pi * radius * radius;
        if (l.kind == IR_LIGHT_CONSTANT || l.kind == IR_LIGHT_ENVMAP) p = colour * pi * 4.0 * pi * radius * radius;
        power.push_back(p);
        sum += p;
    }
    double running = 0.0;
    for (std::size_t i = 0; i < lights.size(); ++i) {
        const double p = power[i] / sum;
        running += p;
        lights[i].probability = static_cast<float>(p);
        lights[i].cdf = static_cast<float>(std::min(running, 1.0));
    }
    if (!lights.empty()) lights.back().cdf = 1.0f;
}

}  // namespace irradia::loader
