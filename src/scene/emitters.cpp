#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "scene/build.h"

namespace irradia::loader {
namespace {

constexpr double pi = std::numbers::pi;

/// An emitter's colour: finite and nowhere negative.
glm::dvec3 emission(const Context& context, const Document& document, Properties& p, const std::string& name,
                    double fallback) {
    const Node* node = p.property(name);
    if (!node) return glm::dvec3(fallback);
    glm::dvec3 colour;
    if (node->tag == "texture") {
        context.unsupported(*node, "a constant colour", "the picture's mean colour, or 1");
        Properties t(context, document, *node);
        colour = glm::dvec3(1.0);
        if (node->get("type") == "bitmap")
            colour = mean_colour(*node, document.resolve(*node, t.text("filename")), t.boolean("raw", false),
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

double sky_weight(double y) { return std::sin(pi * y); }  // solid angle of a row of a latitude-longitude map

}  // namespace

std::optional<glm::dvec3> read_area_emitter(const Context& context, const Document& document, const Node& emitter) {
    if (emitter.get("type") != "area") {
        context.unsupported(emitter, "area on shapes; point, directional and constant at the top level", "no emission");
        return std::nullopt;
    }
    Properties p(context, document, emitter);
    const glm::dvec3 radiance = emission(context, document, p, "radiance", 1.0);
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
            light.position = direction_of(p);
        } else if (type == "constant") {
            light.kind = IR_LIGHT_CONSTANT;
            light.colour = emission(context, document, p, "radiance", 1.0);
            p.ignore({"to_world"});
        } else if (type == "area") {
            fail(node, "<emitter type=\"area\"> has to stand inside a <shape>");
        } else if (type == "envmap") {
            context.unsupported(node, "point, directional, constant", "constant with the map's mean radiance");
            light.kind = IR_LIGHT_CONSTANT;
            light.colour = p.number("scale", 1.0) *
                           mean_colour(node, document.resolve(node, p.text("filename")), false, sky_weight);
            p.ignore({"to_world"});
        } else if (type == "spot") {
            context.unsupported(node, "point, directional, constant", "point of the same intensity");
            light.colour = emission(context, document, p, "intensity", 1.0);
            light.position = position_of(p);
            p.ignore({"cutoff_angle", "beam_width", "texture"});
        } else {
            context.unsupported(node, "point, directional, constant", "nothing, it is left out");
            continue;
        }
        p.ignore({"sampling_weight"});
        p.finish();
        if (light.kind == IR_LIGHT_CONSTANT) {
            if (sky) fail(node, fmt::format("more than one environment emitter, the other one is at {}", where(*sky)));
            sky = &node;
        }
        lights.push_back(light);
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
        if (l.kind == IR_LIGHT_DIRECTIONAL) p = colour * pi * radius * radius;
        if (l.kind == IR_LIGHT_CONSTANT) p = colour * pi * 4.0 * pi * radius * radius;
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
