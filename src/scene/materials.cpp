#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "scene/build.h"

namespace irradia::loader {
namespace {

constexpr int max_nesting = 16;
const char* const supported_bsdfs = "diffuse, twosided";

/// Normal-incidence reflectance of a named metal, from the usual measured values; for substitutes.
glm::dvec3 metal_colour(const std::string& name) {
    static const std::pair<const char*, glm::dvec3> table[] = {
        {"none", {1.0, 1.0, 1.0}}, {"Ag", {0.97, 0.96, 0.92}}, {"Al", {0.91, 0.92, 0.92}},
        {"Au", {1.0, 0.77, 0.34}}, {"Cu", {0.96, 0.64, 0.54}}, {"Cr", {0.55, 0.56, 0.56}},
    };
    for (const auto& [key, colour] : table)
        if (name == key) return colour;
    return glm::dvec3(0.7);
}

/// ((eta-1)^2 + k^2) / ((eta+1)^2 + k^2), a channel at a time.
glm::dvec3 fresnel_colour(const glm::dvec3& eta, const glm::dvec3& k) {
    const glm::dvec3 a = eta - 1.0, b = eta + 1.0;
    return (a * a + k * k) / (b * b + k * k);
}

}  // namespace

std::optional<std::uint32_t> MaterialTable::material(const Node* bsdf) {
    const auto append = [&](const Surface& s) {
        shared::Material m = blank_material();
        if (s.twosided) m.back = static_cast<int>(materials.size());
        m.texture = s.reflectance.texture;
        m.r = static_cast<float>(s.reflectance.colour.x);
        m.g = static_cast<float>(s.reflectance.colour.y);
        m.b = static_cast<float>(s.reflectance.colour.z);
        materials.push_back(m);
        return static_cast<std::uint32_t>(materials.size() - 1);
    };
    if (!bsdf) {
        if (!default_) default_ = append(Surface{});
        return default_;
    }
    const auto it = known_.find(bsdf);
    if (it != known_.end()) return it->second;
    const Surface s = surface(*bsdf, 0);
    const std::optional<std::uint32_t> index = s.left_out ? std::nullopt : std::optional(append(s));
    known_.emplace(bsdf, index);
    return index;
}

MaterialTable::Surface MaterialTable::surface(const Node& bsdf, int depth) {
    if (depth > max_nesting) fail(bsdf, fmt::format("{}: bsdfs are nested too deep, or in a circle", describe(bsdf)));
    const std::string type = bsdf.get("type");
    if (type == "diffuse") {
        Properties p(context_, document_, bsdf);
        Surface s;
        s.reflectance = reflectance(p, "reflectance", glm::dvec3(0.5));
        p.finish();
        return s;
    }
    if (type == "twosided") {
        Properties p(context_, document_, bsdf);
        const auto nested = p.objects("bsdf");
        if (nested.empty()) fail(bsdf, fmt::format("{} needs a nested bsdf", describe(bsdf)));
        if (nested.size() > 1)
            context_.problem(bsdf,
                             fmt::format("{} has {} nested bsdfs, one was expected", describe(bsdf), nested.size()),
                             "the first one is used on both sides");
        p.finish();
        Surface s = surface(*nested[0], depth + 1);
        s.twosided = true;
        return s;
    }
    return substitute(bsdf, depth);
}

MaterialTable::Surface MaterialTable::substitute(const Node& bsdf, int depth) {
    const std::string type = bsdf.get("type");
    const auto is = [&](std::initializer_list<const char*> names) {
        return std::any_of(names.begin(), names.end(), [&](const char* name) { return type == name; });
    };
    Surface s;
    // Parameters of a substituted bsdf that have no meaning for the substitute are passed over without a word each.
    Properties p(context_, document_, bsdf);
    if (is({"conductor", "roughconductor"})) {
        context_.unsupported(bsdf, supported_bsdfs,
                             "diffuse with specular_reflectance times the metal's reflectance at normal incidence");
        s.reflectance = reflectance(p, "specular_reflectance", glm::dvec3(1.0));
        glm::dvec3 metal(1.0);
        const Node *eta = p.property("eta"), *k = p.property("k");
        if (eta && k && (eta->tag == "rgb" || eta->tag == "float" || eta->tag == "spectrum"))
            metal = fresnel_colour(parse_colour(context_, *eta), parse_colour(context_, *k));
        else
            metal = metal_colour(p.text("material", "none"));
        s.reflectance.colour = glm::clamp(s.reflectance.colour * metal, 0.0, 1.0);
    } else if (is({"plastic", "roughplastic"})) {
        context_.unsupported(bsdf, supported_bsdfs, "diffuse with diffuse_reflectance");
        s.reflectance = reflectance(p, "diffuse_reflectance", glm::dvec3(0.5));
    } else if (is({"principled", "principledthin"})) {
        context_.unsupported(bsdf, supported_bsdfs, "diffuse with base_color");
        s.reflectance = reflectance(p, "base_color", glm::dvec3(0.5));
    } else if (is({"dielectric", "roughdielectric"})) {
        context_.unsupported(bsdf, supported_bsdfs, "twosided diffuse with reflectance 0.8");
        s.reflectance.colour = glm::dvec3(0.8);
        s.twosided = true;
    } else if (is({"thindielectric", "null"})) {
        context_.unsupported(bsdf, supported_bsdfs, "nothing, surfaces of this material are left out");
        s.left_out = true;
    } else if (is({"mask", "bumpmap", "normalmap", "blendbsdf"})) {
        const auto nested = p.objects("bsdf");
        if (nested.empty()) fail(bsdf, fmt::format("{} needs a nested bsdf", describe(bsdf)));
        context_.unsupported(bsdf, supported_bsdfs, "its (first) nested bsdf");
        s = surface(*nested[0], depth + 1);
    } else {
        context_.unsupported(bsdf, supported_bsdfs, "diffuse with reflectance 0.5");
    }
    return s;
}

glm::dvec3 MaterialTable::checked(const Node& node, const glm::dvec3& colour) const {
    if (glm::all(glm::greaterThanEqual(colour, glm::dvec3(0.0))) &&
        glm::all(glm::lessThanEqual(colour, glm::dvec3(1.0))))
        return colour;
    context_.problem(node, fmt::format("reflectance ({}, {}, {}) is outside [0, 1]", colour.x, colour.y, colour.z),
                     "clamped");
    return glm::clamp(colour, 0.0, 1.0);
}

MaterialTable::Reflectance MaterialTable::reflectance(Properties& p, const std::string& name,
                                                      const glm::dvec3& fallback) {
    Reflectance result;
    result.colour = fallback;
    const Node* node = p.property(name);
    if (!node) return result;
    if (node->tag == "texture") return texture(*node);
    result.colour = checked(*node, parse_colour(context_, *node));
    return result;
}

MaterialTable::Reflectance MaterialTable::texture(const Node& node) {
    Properties p(context_, document_, node);
    Reflectance result;
    const std::string type = node.get("type");
    if (type != "bitmap") {
        if (type == "checkerboard") {
            context_.unsupported(node, "bitmap", "the mean of color0 and color1");
            result.colour = checked(node, 0.5 * (p.colour("color0").value_or(glm::dvec3(0.4)) +
                                                 p.colour("color1").value_or(glm::dvec3(0.2))));
        } else {
            context_.unsupported(node, "bitmap", "constant 0.5");
        }
        return result;
    }
    TextureSpec spec;
    spec.node = &node;
    spec.path = document_.resolve(node, p.text("filename"));
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
    spec.to_uv = p.transform("to_uv").value_or(glm::dmat4(1.0));
    p.ignore({"format", "accel"});
    p.finish();
    result.texture = textures_.add(spec);
    result.colour = glm::dvec3(1.0);
    return result;
}

}  // namespace irradia::loader
