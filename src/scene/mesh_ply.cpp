// PLY: ascii, binary little and big endian; vertex x y z, nx ny nz, u v (or s t), r g b (or red green blue); faces of
// any number of corners.
#include <fmt/format.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <atomic>
#include <bit>
#include <charconv>
#include <cstring>
#include <sstream>

#include "scene/build.h"

namespace irradia::loader {
namespace {

enum class Type { i8, u8, i16, u16, i32, u32, f32, f64 };
struct Property {
    std::string name;
    Type type = Type::f32, count_type = Type::u8;
    bool list = false;
};
struct Element {
    std::string name;
    std::size_t count = 0;
    std::vector<Property> properties;
};
enum class Format { ascii, little, big };

std::size_t size_of(Type type) {
    switch (type) {
        case Type::i8:
        case Type::u8:
            return 1;
        case Type::i16:
        case Type::u16:
            return 2;
        case Type::i32:
        case Type::u32:
        case Type::f32:
            return 4;
        case Type::f64:
            return 8;
    }
    return 0;
}

class PlyReader {
public:
    PlyReader(const std::string& path, bool colours) : path_(path), data_(read_file(path)), colours_(colours) {}

    Mesh read() {
        read_header();
        Mesh mesh;
        bool vertices = false, faces = false;
        for (const auto& element : elements_) {
            if (element.name == "vertex") {
                read_vertices(element, mesh);
                vertices = true;
            } else if (element.name == "face") {
                read_faces(element, mesh);
                faces = true;
            } else {
                skip(element);
            }
        }
        if (!vertices || !faces) bad(fmt::format("has no element '{}'", vertices ? "face" : "vertex"));
        return mesh;
    }

private:
    std::string path_, data_;
    std::size_t at_ = 0;
    bool colours_;
    Format format_ = Format::ascii;
    std::vector<Element> elements_;
    const char* element_ = "";  // where the reader is, for messages
    std::size_t index_ = 0;

    [[nodiscard]] std::string place() const { return fmt::format("{} {}", element_, index_); }
    [[noreturn]] void bad(const std::string& message) const {
        throw Error(fmt::format("mesh '{}' {}", path_, message));
    }

    static bool parse_type(const std::string& name, Type& type) {
        static const std::pair<const char*, Type> table[] = {
            {"char", Type::i8},   {"int8", Type::i8},     {"uchar", Type::u8},   {"uint8", Type::u8},
            {"short", Type::i16}, {"int16", Type::i16},   {"ushort", Type::u16}, {"uint16", Type::u16},
            {"int", Type::i32},   {"int32", Type::i32},   {"uint", Type::u32},   {"uint32", Type::u32},
            {"float", Type::f32}, {"float32", Type::f32}, {"double", Type::f64}, {"float64", Type::f64}};
        for (const auto& [key, value] : table)
            if (name == key) {
                type = value;
                return true;
            }
        return false;
    }

    void read_header() {
        int line_number = 0;
        bool format = false, end = false;
        while (!end) {
            const std::size_t newline = data_.find('\n', at_);
            if (newline == std::string::npos) bad(line_number == 0 ? "is not a PLY file" : "ends inside its header");
            std::istringstream line(data_.substr(at_, newline - at_));
            at_ = newline + 1;
            ++line_number;
            std::string word;
            line >> word;
            if (line_number == 1) {
                if (word != "ply") bad("is not a PLY file");
            } else if (word == "format") {
                std::string kind;
                line >> kind;
                if (kind == "ascii")
                    format_ = Format::ascii;
                else if (kind == "binary_little_endian")
                    format_ = Format::little;
                else if (kind == "binary_big_endian")
                    format_ = Format::big;
                else
                    bad(fmt::format("has the unknown format '{}'", kind));
                format = true;
            } else if (word == "element") {
                Element element;
                long long count = -1;
                line >> element.name >> count;
                if (!line || count < 0) bad(fmt::format("line {}: bad element", line_number));
                element.count = static_cast<std::size_t>(count);
                elements_.push_back(element);
            } else if (word == "property") {
                Property property;
                std::string type;
                line >> type;
                if (type == "list") {
                    property.list = true;
                    std::string count_type;
                    line >> count_type >> type;
                    if (!parse_type(count_type, property.count_type))
                        bad(fmt::format("line {}: unknown type '{}'", line_number, count_type));
                }
                line >> property.name;
                if (!line || elements_.empty()) bad(fmt::format("line {}: bad property", line_number));
                if (!parse_type(type, property.type)) bad(fmt::format("line {}: unknown type '{}'", line_number, type));
                elements_.back().properties.push_back(property);
            } else if (word == "end_header") {
                end = true;
            } else if (word != "comment" && word != "obj_info" && !word.empty()) {
                bad(fmt::format("line {}: unknown word '{}' in the header", line_number, word));
            }
        }
        if (!format) bad("has no format line");
    }

    template <class T>
    [[nodiscard]] T binary(std::size_t at) const {
        unsigned char bytes[sizeof(T)];
        std::memcpy(bytes, data_.data() + at, sizeof(T));
        if ((format_ == Format::big) == (std::endian::native == std::endian::little))
            std::reverse(bytes, bytes + sizeof(T));
        T value;
        std::memcpy(&value, bytes, sizeof(T));
        return value;
    }

    double number(Type type) {
        if (format_ == Format::ascii) {
            while (at_ < data_.size() && std::isspace(static_cast<unsigned char>(data_[at_]))) ++at_;
            if (at_ == data_.size()) bad("is truncated in " + place());
            std::size_t end = at_;
            while (end < data_.size() && !std::isspace(static_cast<unsigned char>(data_[end]))) ++end;
            if (data_[at_] == '+') ++at_;
            double value = 0.0;
            const auto [stop, error] = std::from_chars(data_.data() + at_, data_.data() + end, value);
            if (error == std::errc::invalid_argument || stop != data_.data() + end)
                bad(fmt::format("{}: '{}' is not a number", place(),
                                data_.substr(at_, std::min<std::size_t>(end - at_, 40))));
            if (error == std::errc::result_out_of_range)
                value = std::strtod(data_.substr(at_, end - at_).c_str(), nullptr);
            at_ = end;
            return value;
        }
        if (data_.size() - at_ < size_of(type)) bad("is truncated in " + place());
        const double value = binary_number(type, at_);
        at_ += size_of(type);
        return value;
    }

    [[nodiscard]] double binary_number(Type type, std::size_t at) const {
        switch (type) {
            case Type::i8:
                return binary<std::int8_t>(at);
            case Type::u8:
                return binary<std::uint8_t>(at);
            case Type::i16:
                return binary<std::int16_t>(at);
            case Type::u16:
                return binary<std::uint16_t>(at);
            case Type::i32:
                return binary<std::int32_t>(at);
            case Type::u32:
                return binary<std::uint32_t>(at);
            case Type::f32:
                return static_cast<double>(binary<float>(at));
            case Type::f64:
                return binary<double>(at);
        }
        return 0.0;
    }

    std::size_t list_length(const Property& property) {
        const double count = number(property.count_type);
        if (!(count >= 0.0 && count <= 1e9) || count != static_cast<double>(static_cast<std::size_t>(count)))
            bad(fmt::format("{}: {} is not the length of a list", place(), count));
        return static_cast<std::size_t>(count);
    }

    void skip_property(const Property& property) {
        const std::size_t count = property.list ? list_length(property) : 1;
        for (std::size_t i = 0; i < count; ++i) number(property.type);
    }

    void skip(const Element& element) {
        check_count(element);
        element_ = element.name.c_str();
        for (std::size_t i = 0; i < element.count; ++i) {
            index_ = i;
            for (const auto& property : element.properties) skip_property(property);
        }
    }

    /// An element cannot have more instances than what is left of the file has bytes: stops absurd counts early.
    void check_count(const Element& element) const {
        std::size_t bytes = 0;
        for (const auto& property : element.properties)
            bytes += format_ == Format::ascii ? 2 : size_of(property.list ? property.count_type : property.type);
        if (element.count > 0 && (bytes == 0 || element.count > (data_.size() - at_ + 1) / bytes))
            bad(fmt::format("is truncated: {} of '{}' announced, {} bytes left", element.count, element.name,
                            data_.size() - at_));
    }

    void read_vertices(const Element& element, Mesh& mesh) {
        check_count(element);
        element_ = "vertex";
        static const std::pair<const char*, int> slots[] = {
            {"x", 0}, {"y", 1}, {"z", 2}, {"nx", 3}, {"ny", 4}, {"nz", 5},  {"u", 6},     {"v", 7},
            {"s", 6}, {"t", 7}, {"r", 8}, {"g", 9},  {"b", 10}, {"red", 8}, {"green", 9}, {"blue", 10}};
        std::vector<int> slot(element.properties.size(), -1);
        double scale[11];  // colours in whole numbers: [0, 255], [0, 65535]
        std::fill(std::begin(scale), std::end(scale), 1.0);
        unsigned int present = 0;
        for (std::size_t i = 0; i < slot.size(); ++i)
            for (const auto& [name, index] : slots)
                if (!element.properties[i].list && element.properties[i].name == name &&
                    (present & (1u << index)) == 0) {
                    slot[i] = index;
                    present |= 1u << index;
                    if (index >= 8 && element.properties[i].type == Type::u8) scale[index] = 1.0 / 255.0;
                    if (index >= 8 && element.properties[i].type == Type::u16) scale[index] = 1.0 / 65535.0;
                }
        if ((present & 7u) != 7u) bad("has vertices without x, y, z");
        const bool normals = (present & 0x38u) == 0x38u, uvs = (present & 0xc0u) == 0xc0u;
        const bool colours = colours_ && (present & 0x700u) == 0x700u;
        if (mesh.positions.size() > 0) bad("has vertices twice");
        mesh.positions.resize(element.count);
        if (normals) mesh.normals.resize(element.count);
        if (uvs) mesh.uvs.resize(element.count);
        if (colours) mesh.colours.resize(element.count);
        const auto store = [&](std::size_t i, const double(&value)[11]) {
            mesh.positions[i] = {value[0], value[1], value[2]};
            if (normals) mesh.normals[i] = {value[3], value[4], value[5]};
            if (uvs) mesh.uvs[i] = {value[6], value[7]};
            if (colours) mesh.colours[i] = {value[8] * scale[8], value[9] * scale[9], value[10] * scale[10]};
        };
        if (const std::size_t stride = stride_of(element); stride > 0) {  // all threads at once
            tbb::parallel_for(tbb::blocked_range<std::size_t>(0, element.count, 1 << 13), [&](const auto& range) {
                for (std::size_t i = range.begin(); i != range.end(); ++i) {
                    double value[11] = {};
                    std::size_t at = at_ + i * stride;
                    for (std::size_t k = 0; k < slot.size(); ++k) {
                        const Type type = element.properties[k].type;
                        if (slot[k] >= 0) value[slot[k]] = binary_number(type, at);
                        at += size_of(type);
                    }
                    store(i, value);
                }
            });
            at_ += element.count * stride;
            return;
        }
        for (std::size_t i = 0; i < element.count; ++i) {
            index_ = i;
            double value[11] = {};
            for (std::size_t k = 0; k < slot.size(); ++k) {
                if (slot[k] < 0)
                    skip_property(element.properties[k]);
                else
                    value[slot[k]] = number(element.properties[k].type);
            }
            store(i, value);
        }
    }

    /// Bytes of an instance, if that is the same for all and all are there; otherwise 0.
    [[nodiscard]] std::size_t stride_of(const Element& element) const {
        std::size_t bytes = 0;
        for (const auto& property : element.properties) {
            if (property.list) return 0;
            bytes += size_of(property.type);
        }
        return format_ != Format::ascii && element.count <= (data_.size() - at_) / bytes ? bytes : 0;
    }

    /// The usual: nothing but triangles, their indices of four bytes behind a count of one. False: it is not so.
    bool read_triangles(const Element& element, Mesh& mesh) {
        const Property& p = element.properties[0];
        if (format_ == Format::ascii || element.properties.size() != 1 || size_of(p.count_type) != 1 ||
            (p.type != Type::i32 && p.type != Type::u32))
            return false;
        constexpr std::size_t kStride = 13;
        if (element.count > (data_.size() - at_) / kStride) return false;
        // As long as all counts before were three, the next one lies here.
        for (std::size_t i = 0; i < element.count; ++i)
            if (data_[at_ + i * kStride] != 3) return false;
        mesh.triangles.resize(element.count);
        const std::size_t begin = at_;
        std::atomic<bool> negative = false;
        tbb::parallel_for(tbb::blocked_range<std::size_t>(0, element.count, 1 << 13), [&](const auto& range) {
            for (std::size_t i = range.begin(); i != range.end(); ++i)
                for (std::size_t c = 0; c < 3; ++c) {
                    const auto index = binary<std::uint32_t>(begin + i * kStride + 1 + 4 * c);
                    if (p.type == Type::i32 && index > 0x7fffffffu) negative = true;
                    mesh.triangles[i][c] = index;
                }
        });
        if (negative) {  // the slow way says where
            mesh.triangles.clear();
            return false;
        }
        at_ += element.count * kStride;
        return true;
    }

    void read_faces(const Element& element, Mesh& mesh) {
        check_count(element);
        element_ = "face";
        std::size_t indices = element.properties.size();
        for (std::size_t k = 0; k < element.properties.size(); ++k) {
            const auto& p = element.properties[k];
            if (p.list && (p.name == "vertex_indices" || p.name == "vertex_index")) indices = k;
        }
        if (indices == element.properties.size()) bad("has faces without vertex_indices");
        if (mesh.triangles.size() > 0) bad("has faces twice");
        if (read_triangles(element, mesh)) return;
        mesh.triangles.reserve(element.count);
        std::vector<std::uint32_t> corners;
        for (std::size_t i = 0; i < element.count; ++i) {
            index_ = i;
            for (std::size_t k = 0; k < element.properties.size(); ++k) {
                const auto& property = element.properties[k];
                if (k != indices) {
                    skip_property(property);
                    continue;
                }
                const std::size_t count = list_length(property);
                if (count < 3) bad(fmt::format("face {} has {} corners", i, count));
                corners.clear();
                for (std::size_t c = 0; c < count; ++c) {
                    const double index = number(property.type);
                    if (!(index >= 0.0 && index < 4294967295.0))
                        bad(fmt::format("face {}: vertex index {} is out of range", i, index));
                    corners.push_back(static_cast<std::uint32_t>(index));
                }
                for (std::size_t c = 2; c < count; ++c)
                    mesh.triangles.push_back({corners[0], corners[c - 1], corners[c]});
            }
        }
    }
};

}  // namespace

Mesh read_ply(const std::string& path, bool colours) { return PlyReader(path, colours).read(); }

}  // namespace irradia::loader
