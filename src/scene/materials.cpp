// <bsdf> elements into materials: Mitsuba 3's plugins, parameters and defaults.
#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cmath>

#include "scene/build.h"
#include "scene/parts.h"

namespace irradia::loader {
namespace {

constexpr int max_nesting = 16;
constexpr int both_sides = -2;  // Material::back while a material has no index yet: its own

const std::vector<std::string> bsdf_names = {
    "diffuse",      "conductor", "roughconductor", "dielectric", "roughdielectric", "thindielectric", "plastic",
    "roughplastic", "twosided",  "mask",           "null",       "bumpmap",         "normalmap"};

std::string supported_bsdfs() {
    std::string list;
    for (const auto& name : bsdf_names) list += (list.empty() ? "" : ", ") + name;
    return list;
}

glm::vec3 rounded(const glm::dvec3& v) { return {v.x, v.y, v.z}; }

/// A colour where one number is asked for, as Mitsuba takes it (of a picture it takes the luminance).
glm::dvec3 mean_of_channels(const glm::dvec3& c) { return glm::dvec3((c.x + c.y + c.z) / 3.0); }

bool transmits(const shared::Material& m) {
    return m.kind == IR_MATERIAL_DIELECTRIC || m.kind == IR_MATERIAL_ROUGH_DIELECTRIC ||
           m.kind == IR_MATERIAL_THIN_DIELECTRIC || m.opacity < 1.0f || m.opacity_texture != IR_NO_TEXTURE;
}

}  // namespace

std::uint32_t MaterialTable::material(const Node* bsdf, bool emitter) {
    if (!bsdf) {
        std::optional<std::uint32_t>& index = emitter ? default_of_emitters_ : default_;
        if (!index) {
            shared::Material m = blank_material();
            if (!emitter) m.r = m.g = m.b = 0.5f;
            index = append(m);
        }
        return *index;
    }
    const auto it = known_.find(bsdf);
    if (it != known_.end()) return it->second;
    const std::uint32_t index = append(read(*bsdf, 0));
    known_.emplace(bsdf, index);
    return index;
}

std::uint32_t MaterialTable::append(shared::Material m) {
    const auto index = static_cast<std::uint32_t>(materials.size());
    if (m.back == both_sides) m.back = static_cast<int>(index);
    materials.push_back(m);
    return index;
}

shared::Material MaterialTable::read(const Node& bsdf, int depth) {
    if (depth > max_nesting) fail(bsdf, fmt::format("{}: bsdfs are nested too deep, or in a circle", describe(bsdf)));
    const std::string type = bsdf.get("type");
    Properties p(context_, document_, bsdf);
    shared::Material m = blank_material();
    if (type == "twosided") return twosided(p, depth);
    if (type == "mask") return mask(p, depth);
    if (type == "bumpmap" || type == "normalmap") return perturbed(p, depth);
    if (type == "null") {
        m.opacity = 0.0f;
        m.back = both_sides;
    } else if (type == "diffuse") {
        set_diffuse(p, "reflectance", m);
    } else if (type == "conductor" || type == "roughconductor") {
        conductor(p, m);
    } else if (type == "plastic" || type == "roughplastic") {
        plastic(p, m);
    } else if (type == "dielectric" || type == "roughdielectric" || type == "thindielectric") {
        dielectric(p, m);
    } else {
        return substitute(bsdf, depth);
    }
    p.finish();
    return m;
}

// ---- bsdfs around others -------------------------------------------------------------------------------------------

const Node& MaterialTable::only_nested(Properties& p) {
    const auto nested = p.objects("bsdf");
    if (nested.empty()) fail(p.node(), fmt::format("{} needs a nested bsdf", describe(p.node())));
    if (nested.size() > 1)
        context_.problem(p.node(),
                         fmt::format("{} has {} nested bsdfs, one was expected", describe(p.node()), nested.size()),
                         "the first one is used");
    return *nested[0];
}

shared::Material MaterialTable::twosided(Properties& p, int depth) {
    const auto nested = p.objects("bsdf");
    if (nested.empty()) fail(p.node(), fmt::format("{} needs a nested bsdf", describe(p.node())));
    if (nested.size() > 2)
        fail(p.node(),
             fmt::format("{} has {} nested bsdfs, one or two were expected", describe(p.node()), nested.size()));
    p.finish();
    const auto side = [&](const Node& node) {
        const shared::Material m = read(node, depth + 1);
        if (transmits(m))
            fail(node, fmt::format("{} lets light through: it has both sides already and cannot stand inside twosided",
                                   describe(node)));
        return m;
    };
    shared::Material m = side(*nested[0]);
    if (m.map != IR_NO_TEXTURE) m.flags |= IR_MATERIAL_MIRRORED_MAP;
    m.back = both_sides;
    if (nested.size() == 1) return m;
    const shared::Material other = side(*nested[1]);
    // The kernels perturb the normal before they know which side it shows.
    if (other.map != m.map || other.map_scale != m.map_scale || ((other.flags ^ m.flags) & IR_MATERIAL_NORMAL_MAP) != 0)
        context_.problem(*nested[1],
                         fmt::format("{}: both sides need the same bump or normal map (write it around twosided)",
                                     describe(*nested[1])),
                         "that of the front is used");
    m.back = static_cast<int>(append(other));
    return m;
}

shared::Material MaterialTable::mask(Properties& p, int depth) {
    shared::Material m = read(only_nested(p), depth + 1);
    const Colour opacity = colour(p, "opacity", glm::dvec3(0.5), TextureUse::number);
    p.finish();
    if (m.opacity_texture != IR_NO_TEXTURE || (m.opacity != 1.0f && opacity.texture != IR_NO_TEXTURE))
        fail(p.node(),
             fmt::format("{}: a mask around another is supported for numbers, not for textures", describe(p.node())));
    m.opacity *= static_cast<float>(luminance(opacity.value));
    m.opacity_texture = opacity.texture;
    return m;
}

shared::Material MaterialTable::perturbed(Properties& p, int depth) {
    const bool normals = p.node().get("type") == "normalmap";
    shared::Material m = read(only_nested(p), depth + 1);
    const auto textures = p.objects("texture");
    if (textures.size() != 1)
        fail(p.node(), fmt::format("{} has {} nested textures, one was expected", describe(p.node()), textures.size()));
    if (m.map != IR_NO_TEXTURE)
        fail(p.node(), fmt::format("{}: a bump or normal map inside another is not supported", describe(p.node())));
    m.map = texture(*textures[0], TextureUse::map);
    if (normals)
        m.flags |= IR_MATERIAL_NORMAL_MAP;
    else
        m.map_scale = static_cast<float>(p.number("scale", 1.0));
    for (const char* name : {"flip_invalid_normals", "use_shadowing_function"})
        if (!p.boolean(name, true))
            fail(*p.property(name), fmt::format("{}: {} = false is not supported", describe(p.node()), name));
    p.finish();
    return m;
}

// ---- surfaces ------------------------------------------------------------------------------------------------------

void MaterialTable::set_diffuse(Properties& p, const std::string& name, shared::Material& m) {
    const Colour c = colour(p, name, glm::dvec3(0.5));
    const glm::vec3 v = rounded(c.value);
    m.r = v.x, m.g = v.y, m.b = v.z;
    m.texture = c.texture;
}

void MaterialTable::set_specular(Properties& p, shared::Material& m) {
    const Colour c = colour(p, "specular_reflectance", glm::dvec3(1.0));
    const glm::vec3 v = rounded(c.value);
    m.specular_r = v.x, m.specular_g = v.y, m.specular_b = v.z;
    m.specular_texture = c.texture;
}

void MaterialTable::set_roughness(Properties& p, bool anisotropic, shared::Material& m) {
    const std::string distribution = p.text("distribution", "beckmann");
    if (distribution == "beckmann")
        m.flags |= IR_MATERIAL_BECKMANN;
    else if (distribution != "ggx")
        fail(*p.property("distribution"),
             fmt::format("{}: distribution is '{}'; beckmann or ggx was expected", describe(p.node()), distribution));
    p.ignore({"sample_visible"});  // how to sample is our own business
    const Node *alpha = p.property("alpha"), *u = nullptr, *v = nullptr;
    if (anisotropic) {
        u = p.property("alpha_u");
        v = p.property("alpha_v");
    }
    if ((u != nullptr) != (v != nullptr))
        fail(p.node(), fmt::format("{}: give both alpha_u and alpha_v, or alpha", describe(p.node())));
    if (alpha && u) fail(*alpha, fmt::format("{}: give either alpha or alpha_u and alpha_v", describe(p.node())));
    const auto roughness = [&](const Node& node, const char* name) {
        const double value = p.number(name, 0.1);
        if (!(value > 0.0))
            fail(node,
                 fmt::format("{}: {} is {}, a number above 0 was expected (a smooth surface has a bsdf of its own)",
                             describe(p.node()), name, value));
        return static_cast<float>(std::max(value, 1e-4));
    };
    if (u) {
        if (u->tag == "texture" || v->tag == "texture")
            fail(u->tag == "texture" ? *u : *v,
                 fmt::format("{}: alpha_u and alpha_v as textures are not supported, alpha is", describe(p.node())));
        m.alpha_u = roughness(*u, "alpha_u");
        m.alpha_v = roughness(*v, "alpha_v");
    } else if (alpha && alpha->tag == "texture" && anisotropic) {
        m.alpha_texture = texture(*alpha, TextureUse::number);
    } else if (alpha) {
        m.alpha_u = m.alpha_v = roughness(*alpha, "alpha");
    }
}

double MaterialTable::index_of_refraction(Properties& p, const char* name, const char* fallback) {
    const Node* node = p.property(name);
    double ior = 1.0;
    if (node && node->tag != "string") {
        ior = p.number(name, 1.0);
        if (!(ior > 0.0))
            fail(*node, fmt::format("{}: {} is {}, a number above 0 was expected", describe(p.node()), name, ior));
        return ior;
    }
    const std::string medium = p.text(name, fallback);
    if (!find_dielectric(medium, ior))
        fail(*node, fmt::format("{}: {} names no known medium: '{}'{}", describe(p.node()), name, medium,
                                did_you_mean(medium, dielectric_names())));
    return ior;
}

void MaterialTable::set_index(Properties& p, const char* inside, shared::Material& m) {
    m.eta = static_cast<float>(index_of_refraction(p, "int_ior", inside) / index_of_refraction(p, "ext_ior", "air"));
}

void MaterialTable::conductor(Properties& p, shared::Material& m) {
    m.kind = IR_MATERIAL_CONDUCTOR;
    if (p.node().get("type") == "roughconductor") {
        m.kind = IR_MATERIAL_ROUGH_CONDUCTOR;
        set_roughness(p, true, m);
    }
    set_specular(p, m);
    const Node *named = p.property("material"), *eta_node = p.property("eta"), *k_node = p.property("k");
    glm::dvec3 eta(0.0), k(1.0);
    const std::string name = p.text("material", "none");
    if (!find_conductor(name, eta, k))
        fail(*named, fmt::format("{}: there is no conductor '{}'{}", describe(p.node()), name,
                                 did_you_mean(name, conductor_names())));
    if (name != "none" && (eta_node || k_node))
        fail(*named, fmt::format("{}: give either material or eta and k", describe(p.node())));
    const auto part = [&](const Node* node, const char* which, glm::dvec3& index) {
        if (!node) return;
        index = parse_colour(context_, *node);
        for (int c = 0; c < 3; ++c)
            if (!(index[c] >= 0.0))
                fail(*node, fmt::format("{}: {} is negative ({}), 0 or more was expected", describe(p.node()), which,
                                        index[c]));
    };
    part(eta_node, "eta", eta);
    part(k_node, "k", k);
    const glm::vec3 e = rounded(eta), i = rounded(k);
    m.eta_r = e.x, m.eta_g = e.y, m.eta_b = e.z;
    m.k_r = i.x, m.k_g = i.y, m.k_b = i.z;
}

void MaterialTable::dielectric(Properties& p, shared::Material& m) {
    const std::string type = p.node().get("type");
    m.back = both_sides;
    m.kind = type == "dielectric"
                 ? IR_MATERIAL_DIELECTRIC
                 : (type == "thindielectric" ? IR_MATERIAL_THIN_DIELECTRIC : IR_MATERIAL_ROUGH_DIELECTRIC);
    if (m.kind == IR_MATERIAL_ROUGH_DIELECTRIC) set_roughness(p, true, m);
    set_index(p, "bk7", m);
    if (m.kind == IR_MATERIAL_ROUGH_DIELECTRIC && m.eta == 1.0f)
        fail(p.node(),
             fmt::format("{}: int_ior and ext_ior are alike, different ones were expected", describe(p.node())));
    set_specular(p, m);
    const Colour c = colour(p, "specular_transmittance", glm::dvec3(1.0));
    if (c.texture != IR_NO_TEXTURE)
        fail(*p.property("specular_transmittance"),
             fmt::format("{}: specular_transmittance has to be a colour, textures are not supported",
                         describe(p.node())));
    const glm::vec3 v = rounded(c.value);
    m.transmittance_r = v.x, m.transmittance_g = v.y, m.transmittance_b = v.z;
}

void MaterialTable::plastic(Properties& p, shared::Material& m) {
    const bool rough = p.node().get("type") == "roughplastic";
    m.kind = rough ? IR_MATERIAL_ROUGH_PLASTIC : IR_MATERIAL_PLASTIC;
    if (rough) set_roughness(p, false, m);
    set_index(p, "polypropylene", m);
    if (!(m.eta > 1.0f))
        fail(p.node(),
             fmt::format("{}: int_ior over ext_ior is {}, more than 1 was expected", describe(p.node()), m.eta));
    set_diffuse(p, "diffuse_reflectance", m);
    set_specular(p, m);
    if (p.boolean("nonlinear", false)) m.flags |= IR_MATERIAL_NONLINEAR;
    set_coat(m);
    if (!(m.internal_reflectance < 1.0f))
        fail(p.node(),
             fmt::format("{}: int_ior over ext_ior is {}: the coat would let no light out (below 3.9 it does)",
                         describe(p.node()), m.eta));
}

void MaterialTable::set_coat(shared::Material& m) {
    const bool rough = m.kind == IR_MATERIAL_ROUGH_PLASTIC, beckmann = (m.flags & IR_MATERIAL_BECKMANN) != 0;
    const Coat wanted{m.kind, rough && beckmann, m.eta, rough ? m.alpha_u : 0.0f, {}};
    std::size_t i = 0;
    while (i < coats_.size() && !(coats_[i].kind == wanted.kind && coats_[i].beckmann == wanted.beckmann &&
                                  coats_[i].eta == wanted.eta && coats_[i].alpha == wanted.alpha))
        ++i;
    if (i == coats_.size()) {
        coats_.push_back(wanted);
        const auto eta = static_cast<double>(m.eta);
        if (rough)
            coats_[i].table = coat_from_parts(context_.options.parts, eta, static_cast<double>(m.alpha_u), beckmann);
        else
            coats_[i].table.internal_reflectance = smooth_internal_reflectance(eta);
    }
    m.coat = static_cast<std::uint32_t>(i + 1);
    m.internal_reflectance = static_cast<float>(coats_[i].table.internal_reflectance);
}

void MaterialTable::store_coats(Scene& scene) {
    std::vector<std::uint32_t> first;
    for (const Coat& coat : coats_) {
        first.push_back(static_cast<std::uint32_t>(scene.texels.size()));
        for (const float t : coat.table.transmittance) scene.texels.push_back(std::bit_cast<std::uint32_t>(t));
    }
    std::unordered_map<int, double> means;
    const auto mean = [&](int texture, float r, float g, float b) {
        if (texture == IR_NO_TEXTURE) return (double{r} + double{g} + double{b}) / 3.0;
        const auto [known, first_time] = means.try_emplace(texture, 0.0);
        if (first_time) known->second = mean_of_texture(scene, scene.textures[static_cast<std::size_t>(texture)]);
        return known->second;
    };
    for (shared::Material& m : materials) {
        if (m.coat == 0) continue;
        if (m.kind == IR_MATERIAL_ROUGH_PLASTIC) m.coat_table = first[m.coat - 1];
        // Which part of the BSDF a sample takes: by their mean reflectances.
        const double base = mean(m.texture, m.r, m.g, m.b);
        const double coat = mean(m.specular_texture, m.specular_r, m.specular_g, m.specular_b);
        m.specular_weight = base + coat > 0.0 ? static_cast<float>(coat / (base + coat)) : 0.5f;
    }
}

// ---- the rest ------------------------------------------------------------------------------------------------------

shared::Material MaterialTable::substitute(const Node& bsdf, int depth) {
    const std::string type = bsdf.get("type");
    const std::string supported = supported_bsdfs() + did_you_mean(type, bsdf_names);
    // Parameters that have no meaning for the substitute are passed over without a word each.
    Properties p(context_, document_, bsdf);
    shared::Material m = blank_material();
    m.r = m.g = m.b = 0.5f;
    if (type == "principled" || type == "principledthin") {
        context_.unsupported(bsdf, supported, "diffuse with base_color");
        set_diffuse(p, "base_color", m);
    } else if (type == "blendbsdf") {
        const auto nested = p.objects("bsdf");
        if (nested.empty()) fail(bsdf, fmt::format("{} needs a nested bsdf", describe(bsdf)));
        context_.unsupported(bsdf, supported, "its (first) nested bsdf");
        m = read(*nested[0], depth + 1);
    } else {
        context_.unsupported(bsdf, supported, "diffuse with reflectance 0.5");
    }
    return m;
}

MaterialTable::Colour MaterialTable::colour(Properties& p, const std::string& name, const glm::dvec3& fallback,
                                            TextureUse use) {
    Colour result{fallback, IR_NO_TEXTURE};
    const Node* node = p.property(name);
    if (!node) return result;
    if (node->tag == "texture") {
        result.texture = texture(*node, use);
        result.value = glm::dvec3(1.0);
        return result;
    }
    const glm::dvec3 c = parse_colour(context_, *node);
    if (!glm::all(glm::greaterThanEqual(c, glm::dvec3(0.0))) || !glm::all(glm::lessThanEqual(c, glm::dvec3(1.0))))
        context_.problem(*node, fmt::format("{} ({}, {}, {}) is outside [0, 1]", name, c.x, c.y, c.z), "clamped");
    result.value = glm::clamp(c, 0.0, 1.0);
    if (use == TextureUse::number) result.value = mean_of_channels(result.value);
    return result;
}

int MaterialTable::texture(const Node& node, TextureUse use) {
    TextureSpec spec = read_texture(context_, document_, node);
    spec.unbounded = use == TextureUse::map;
    if (use != TextureUse::colour && spec.vertex_colours)
        fail(node, fmt::format("{}: vertex colours can be reflectances only", describe(node)));
    // Asked for one number instead of a colour, Mitsuba 3.9.1's checkerboard answers the other way round.
    if (use == TextureUse::number && spec.checkerboard)
        spec.colours = {mean_of_channels(spec.colours[1]), mean_of_channels(spec.colours[0])};
    return textures_.add(spec);
}

}  // namespace irradia::loader
