#include "scene/properties.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <glm/gtc/matrix_transform.hpp>

#include "camera/lens.h"

namespace irradia::loader {

double parse_number(const Node& node, std::string_view text) {
    const auto trimmed = [&] {
        auto t = text;
        while (!t.empty() && std::isspace(static_cast<unsigned char>(t.front()))) t.remove_prefix(1);
        while (!t.empty() && std::isspace(static_cast<unsigned char>(t.back()))) t.remove_suffix(1);
        if (t.size() > 1 && t.front() == '+' && t[1] != '-') t.remove_prefix(1);
        return t;
    }();
    double value = 0.0;
    const auto [end, error] = std::from_chars(trimmed.data(), trimmed.data() + trimmed.size(), value);
    if (trimmed.empty() || error == std::errc::invalid_argument || end != trimmed.data() + trimmed.size())
        fail(node, fmt::format("{}: '{}' is not a number", describe(node), text));
    if (error == std::errc::result_out_of_range) {
        // from_chars leaves the value alone: 1e-400 is zero as far as a scene is concerned, 1e400 is not a number.
        const bool tiny = std::strtod(std::string(trimmed).c_str(), nullptr) < 1.0;
        if (tiny) return 0.0;
        fail(node, fmt::format("{}: '{}' is not a finite number", describe(node), text));
    }
    if (!std::isfinite(value)) fail(node, fmt::format("{}: '{}' is not a finite number", describe(node), text));
    if (!std::isfinite(static_cast<float>(value)))
        fail(node, fmt::format("{}: '{}' is too large for single precision", describe(node), text));
    return value;
}

std::vector<double> parse_numbers(const Node& node, std::string_view text, std::size_t count) {
    std::vector<double> numbers;
    const auto separator = [](char c) { return c == ',' || std::isspace(static_cast<unsigned char>(c)); };
    for (std::size_t i = 0; i < text.size();) {
        if (separator(text[i])) {
            ++i;
            continue;
        }
        std::size_t end = i;
        while (end < text.size() && !separator(text[end])) ++end;
        numbers.push_back(parse_number(node, text.substr(i, end - i)));
        i = end;
    }
    if (count != 0 && numbers.size() != count)
        fail(node, fmt::format("{}: '{}' has {} numbers, {} expected", describe(node), text, numbers.size(), count));
    return numbers;
}

double srgb_to_linear(double v) { return v <= 0.04045 ? v / 12.92 : std::pow((v + 0.055) / 1.055, 2.4); }

glm::dvec3 parse_colour(const Context& context, const Node& property) {
    const std::string text = property.get("value");
    if (property.tag == "float" || property.tag == "integer") return glm::dvec3(parse_number(property, text));
    if (property.tag == "spectrum") {
        if (property.find("filename")) {
            context.unsupported(property, "one value", "1");
            return glm::dvec3(1.0);
        }
        if (text.find(':') == std::string::npos) {
            const auto numbers = parse_numbers(property, text);
            if (numbers.size() == 1) return glm::dvec3(numbers[0]);
            fail(property,
                 fmt::format("{}: '{}' has {} numbers, 1 expected", describe(property), text, numbers.size()));
        }
        context.unsupported(property, "one value", "the mean of its values");
        std::string plain = text;  // wavelength:value, ...: keep the values
        std::replace(plain.begin(), plain.end(), ':', ' ');
        const auto numbers = parse_numbers(property, plain);
        double sum = 0.0;
        for (std::size_t i = 1; i < numbers.size(); i += 2) sum += numbers[i];
        return glm::dvec3(numbers.size() < 2 ? 0.0 : sum / static_cast<double>(numbers.size() / 2));
    }
    if (property.tag != "rgb")
        fail(property, fmt::format("{}: a colour was expected (<rgb>, <float> or <spectrum>)", describe(property)));
    if (!text.empty() && text.front() == '#') {
        unsigned int packed = 0;
        const auto [end, error] = std::from_chars(text.data() + 1, text.data() + text.size(), packed, 16);
        if (text.size() != 7 || error != std::errc() || end != text.data() + text.size())
            fail(property, fmt::format("{}: '{}' is not a colour, #rrggbb was expected", describe(property), text));
        const auto channel = [&](unsigned int shift) { return srgb_to_linear(((packed >> shift) & 0xffu) / 255.0); };
        return {channel(16), channel(8), channel(0)};
    }
    const auto numbers = parse_numbers(property, text);
    if (numbers.size() == 1) return glm::dvec3(numbers[0]);
    if (numbers.size() != 3)
        fail(property,
             fmt::format("{}: '{}' has {} numbers, 1 or 3 expected", describe(property), text, numbers.size()));
    return {numbers[0], numbers[1], numbers[2]};
}

namespace {

glm::dvec3 xyz(const Node& node, double fallback) {
    if (const auto* value = node.find("value")) {
        for (const char* axis : {"x", "y", "z"})
            if (node.find(axis)) fail(node, fmt::format("<{}>: give either 'value' or x, y, z, not both", node.tag));
        const auto numbers = parse_numbers(node, *value);
        if (numbers.size() == 1 && node.tag == "scale") return glm::dvec3(numbers[0]);
        if (numbers.size() != 3)
            fail(node, fmt::format("{}: '{}' has {} numbers, 3 expected", describe(node), *value, numbers.size()));
        return {numbers[0], numbers[1], numbers[2]};
    }
    const auto axis = [&](const char* name) {
        const auto* value = node.find(name);
        return value ? parse_number(node, *value) : fallback;
    };
    return {axis("x"), axis("y"), axis("z")};
}

const std::string& required(const Node& node, const char* attribute) {
    const auto* value = node.find(attribute);
    if (!value) fail(node, fmt::format("<{}> needs the attribute '{}'", node.tag, attribute));
    return *value;
}

glm::dmat4 matrix(const Node& node) {
    const auto m = parse_numbers(node, required(node, "value"));
    if (m.size() != 16 && m.size() != 9) fail(node, fmt::format("<matrix> has {} numbers, 16 or 9 expected", m.size()));
    const std::size_t n = m.size() == 16 ? 4 : 3;
    glm::dmat4 result(1.0);
    for (std::size_t row = 0; row < n; ++row)
        for (std::size_t column = 0; column < n; ++column)
            result[static_cast<int>(column)][static_cast<int>(row)] = m[row * n + column];
    if (result[0][3] != 0.0 || result[1][3] != 0.0 || result[2][3] != 0.0 || result[3][3] != 1.0)
        fail(node, "<matrix>: the last row has to be 0 0 0 1");
    return result;
}

glm::dmat4 look_at(const Node& node) {
    const auto triple = [&](const std::string& text) {
        const auto n = parse_numbers(node, text, 3);
        return glm::dvec3(n[0], n[1], n[2]);
    };
    const glm::dvec3 origin = triple(required(node, "origin")), target = triple(required(node, "target"));
    if (origin == target) fail(node, "<lookat>: origin and target are the same point");
    const glm::dvec3 z = glm::normalize(target - origin);
    glm::dvec3 up;
    if (const auto* given = node.find("up")) {
        up = triple(*given);
    } else {  // any; Mitsuba takes the first axis of Duff et al.'s basis
        const double sign = z.z >= 0.0 ? 1.0 : -1.0, a = -1.0 / (sign + z.z), b = z.x * z.y * a;
        up = {1.0 + sign * z.x * z.x * a, sign * b, -sign * z.x};
    }
    const auto to_world = look_along(origin, z, up);
    if (!to_world) fail(node, "<lookat>: up is zero or parallel to the view direction");
    return *to_world;
}

glm::dmat4 operation(const Context& context, const Node& node) {
    if (node.tag == "translate") return glm::translate(glm::dmat4(1.0), xyz(node, 0.0));
    if (node.tag == "scale") return glm::scale(glm::dmat4(1.0), xyz(node, 1.0));
    if (node.tag == "matrix") return matrix(node);
    if (node.tag == "lookat") return look_at(node);
    if (node.tag == "rotate") {
        const glm::dvec3 axis = xyz(node, 0.0);
        if (glm::length(axis) == 0.0) fail(node, "<rotate> needs an axis: x, y, z or value");
        if (std::abs(glm::length(axis) - 1.0) > 1e-3)
            context.warn(node,
                         "<rotate>: the axis is not of unit length; it is normalised here, Mitsuba 3 scales by it");
        return glm::rotate(glm::dmat4(1.0), glm::radians(parse_number(node, required(node, "angle"))), axis);
    }
    fail(node,
         fmt::format("<{}> inside <transform>; translate, scale, rotate, lookat or matrix was expected", node.tag));
}

}  // namespace

glm::dmat4 parse_transform(const Context& context, const Node& transform) {
    if (transform.tag != "transform")
        fail(transform, fmt::format("{}: a <transform> was expected", describe(transform)));
    glm::dmat4 result(1.0);
    for (const auto& child : transform.children) result = operation(context, child) * result;
    return result;
}

Properties::Properties(const Context& context, const Document& document, const Node& node)
    : context_(context), node_(node) {
    std::set<std::string> names;
    for (const auto& child : node.children) {
        entries_.push_back({&child, child.tag == "ref" ? &document.follow(child) : &child});
        const auto* name = child.find("name");
        if (name && !names.insert(*name).second)
            fail(child, fmt::format("{}: parameter '{}' is given twice", describe(node), *name));
    }
}

const Node* Properties::property(const std::string& name) {
    known_.insert(name);
    for (auto& entry : entries_)
        if (entry.node->get("name") == name && entry.node->find("name")) {
            entry.taken = true;
            return entry.target;
        }
    return nullptr;
}

const Node* Properties::take(const std::string& name, std::initializer_list<const char*> tags, const char* kind) {
    const Node* found = property(name);
    if (!found) return nullptr;
    for (const char* tag : tags)
        if (found->tag == tag) return found;
    fail(*found, fmt::format("{}: '{}' has to be {}, found <{}>", describe(node_), name, kind, found->tag));
}

const std::string& Properties::value(const Node& property) const { return required(property, "value"); }

double Properties::number(const std::string& name, double fallback) {
    const Node* p = take(name, {"float", "integer"}, "a <float>");
    return p ? parse_number(*p, value(*p)) : fallback;
}

double Properties::number(const std::string& name) {
    if (!property(name)) fail(node_, fmt::format("{} needs <float name=\"{}\">", describe(node_), name));
    return number(name, 0.0);
}

long long Properties::integer(const std::string& name, long long fallback) {
    const Node* p = take(name, {"integer"}, "an <integer>");
    if (!p) return fallback;
    const double v = parse_number(*p, value(*p));
    if (v != std::floor(v) || std::abs(v) > 1e15)
        fail(*p, fmt::format("{}: '{}' is not an integer", describe(*p), value(*p)));
    return static_cast<long long>(v);
}

bool Properties::boolean(const std::string& name, bool fallback) {
    const Node* p = take(name, {"boolean"}, "a <boolean>");
    if (!p) return fallback;
    std::string v = value(*p);
    std::transform(v.begin(), v.end(), v.begin(), [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
    if (v == "true") return true;
    if (v != "false") fail(*p, fmt::format("{}: '{}' is not true or false", describe(*p), value(*p)));
    return false;
}

std::string Properties::text(const std::string& name, const std::string& fallback) {
    const Node* p = take(name, {"string"}, "a <string>");
    return p ? value(*p) : fallback;
}

std::string Properties::text(const std::string& name) {
    if (!property(name)) fail(node_, fmt::format("{} needs <string name=\"{}\">", describe(node_), name));
    return text(name, "");
}

std::optional<glm::dvec3> Properties::vector(const std::string& name) {
    const Node* p = take(name, {"vector", "point"}, "a <point> or <vector>");
    if (!p) return std::nullopt;
    if (!p->find("value") && !p->find("x") && !p->find("y") && !p->find("z")) value(*p);
    return xyz(*p, 0.0);
}

std::optional<glm::dmat4> Properties::transform(const std::string& name) {
    const Node* p = take(name, {"transform"}, "a <transform>");
    if (!p) return std::nullopt;
    return parse_transform(context_, *p);
}

std::optional<glm::dvec3> Properties::colour(const std::string& name) {
    const Node* p = take(name, {"rgb", "float", "integer", "spectrum"}, "a colour");
    if (!p) return std::nullopt;
    return parse_colour(context_, *p);
}

void Properties::ignore(std::initializer_list<const char*> names) {
    for (const char* name : names) property(name);
}

std::vector<const Node*> Properties::objects(const std::string& tag) {
    std::vector<const Node*> found;
    for (auto& entry : entries_)
        if (entry.target->tag == tag && !entry.taken) {
            entry.taken = true;
            found.push_back(entry.target);
        }
    return found;
}

void Properties::finish() {
    const std::vector<std::string> names(known_.begin(), known_.end());
    for (const auto& entry : entries_) {
        if (entry.taken) continue;
        if (const auto* name = entry.node->find("name"))
            context_.problem(
                *entry.node,
                fmt::format("{} has no parameter '{}'{}", describe(node_), *name, did_you_mean(*name, names)),
                "ignored");
        else
            context_.problem(*entry.node,
                             fmt::format("{} cannot stand inside {}", describe(*entry.target), describe(node_)),
                             "ignored");
    }
}

}  // namespace irradia::loader
