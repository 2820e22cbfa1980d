// The values inside an element: numbers, vectors, colours, transforms, each read once; what nobody asked for is an
// error.
#pragma once
#include <glm/glm.hpp>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "scene/xml_tree.h"

namespace irradia::loader {

/// A whole, finite number. Throws Error at `node` naming what was found.
double parse_number(const Node& node, std::string_view text);
/// `count` numbers separated by blanks or commas; count 0: any number of them.
std::vector<double> parse_numbers(const Node& node, std::string_view text, std::size_t count = 0);
/// A property's colour: <rgb> (three numbers, one, or #rrggbb in sRGB), <float>, or <spectrum> with one value.
glm::dvec3 parse_colour(const Context& context, const Node& property);
/// <transform>: its operations in order, each applied after those before it (Mitsuba's order).
glm::dmat4 parse_transform(const Context& context, const Node& transform);
/// Rec. 709 luminance.
inline double luminance(const glm::dvec3& c) { return 0.2126 * c.x + 0.7152 * c.y + 0.0722 * c.z; }
/// The sRGB transfer function's inverse, v in [0, 1].
double srgb_to_linear(double v);

/// An element's children sorted into named properties and nested objects. Every query marks a name as known.
class Properties {
public:
    Properties(const Context& context, const Document& document, const Node& node);

    const Node* property(const std::string& name);  ///< any kind of child with this name, or null
    double number(const std::string& name, double fallback);
    double number(const std::string& name);  ///< required
    long long integer(const std::string& name, long long fallback);
    bool boolean(const std::string& name, bool fallback);
    std::string text(const std::string& name, const std::string& fallback);
    std::string text(const std::string& name);  ///< required
    std::optional<glm::dvec3> vector(const std::string& name);
    std::optional<glm::dmat4> transform(const std::string& name);
    std::optional<glm::dvec3> colour(const std::string& name);
    void ignore(std::initializer_list<const char*> names);  ///< accepted, of no effect here

    /// Nested objects with this tag, references followed; in file order. Marks them as known.
    std::vector<const Node*> objects(const std::string& tag);
    /// Reports properties and objects nobody asked for (lenient: warns and ignores them).
    void finish();

    [[nodiscard]] const Node& node() const { return node_; }

private:
    struct Entry {
        const Node* node;    // the child
        const Node* target;  // what it refers to, or itself
        bool taken = false;
    };
    const Node* take(const std::string& name, std::initializer_list<const char*> tags, const char* kind);
    const std::string& value(const Node& property) const;

    const Context& context_;
    const Node& node_;
    std::vector<Entry> entries_;
    std::set<std::string> known_;
};

}  // namespace irradia::loader
