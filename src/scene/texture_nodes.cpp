// <texture> elements: Mitsuba 3's bitmap, checkerboard and mesh_attribute.
#include <fmt/format.h>

#include "scene/build.h"

namespace irradia::loader {
namespace {

const std::vector<std::string> texture_names = {"bitmap", "checkerboard", "mesh_attribute"};

void read_bitmap(const Document& document, const Node& node, Properties& p, TextureSpec& spec) {
    spec.path = document.resolve(node, p.text("filename"));
    spec.raw = p.boolean("raw", false);
    const std::string filter = p.text("filter_type", "bilinear"), wrap = p.text("wrap_mode", "repeat");
    if (filter == "nearest")
        spec.filter = IR_FILTER_NEAREST;
    else if (filter != "bilinear")
        fail(node, fmt::format("{}: filter_type is '{}'; bilinear or nearest was expected", describe(node), filter));
    if (wrap == "mirror")
        spec.wrap = IR_WRAP_MIRROR;
    else if (wrap == "clamp")
        spec.wrap = IR_WRAP_CLAMP;
    else if (wrap != "repeat")
        fail(node, fmt::format("{}: wrap_mode is '{}'; repeat, mirror or clamp was expected", describe(node), wrap));
    p.ignore({"format", "accel"});
}

void read_checkerboard(const Node& node, Properties& p, TextureSpec& spec) {
    spec.checkerboard = true;
    const char* const names[2] = {"color0", "color1"};
    const double defaults[2] = {0.4, 0.2};
    for (std::size_t i = 0; i < 2; ++i) {
        spec.colours[i] = p.colour(names[i]).value_or(glm::dvec3(defaults[i]));
        if (!glm::all(glm::greaterThanEqual(spec.colours[i], glm::dvec3(0.0))) ||
            !glm::all(glm::lessThanEqual(spec.colours[i], glm::dvec3(1.0))))
            fail(*p.property(names[i]), fmt::format("{}: {} ({}, {}, {}) is outside [0, 1]", describe(node), names[i],
                                                    spec.colours[i].x, spec.colours[i].y, spec.colours[i].z));
    }
}

}  // namespace

TextureSpec read_texture(const Context& context, const Document& document, const Node& node) {
    Properties p(context, document, node);
    TextureSpec spec;
    spec.node = &node;
    const std::string type = node.get("type");
    if (type == "bitmap") {
        read_bitmap(document, node, p, spec);
    } else if (type == "checkerboard") {
        read_checkerboard(node, p, spec);
    } else if (type == "mesh_attribute") {
        spec.vertex_colours = true;
        const std::string name = p.text("name");
        if (name != "vertex_color")
            fail(*p.property("name"),
                 fmt::format("{}: attribute '{}' is not supported, vertex_color is", describe(node), name));
        if (p.number("scale", 1.0) != 1.0)
            fail(*p.property("scale"), fmt::format("{}: scale is not supported, 1 was expected", describe(node)));
        p.finish();
        return spec;
    } else {
        context.unsupported(node, "bitmap, checkerboard, mesh_attribute" + did_you_mean(type, texture_names),
                            "constant 0.5");
        spec.checkerboard = true;
        spec.colours = {glm::dvec3(0.5), glm::dvec3(0.5)};
        return spec;
    }
    spec.to_uv = p.transform("to_uv").value_or(glm::dmat4(1.0));
    p.finish();
    return spec;
}

}  // namespace irradia::loader
