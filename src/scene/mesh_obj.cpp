// OBJ through tinyobjloader: all groups of a file as one mesh, materials ignored (the scene file says what they are).
#include <fmt/format.h>
#include <tiny_obj_loader.h>

#include <fstream>
#include <map>
#include <sstream>
#include <tuple>

#include "scene/build.h"

namespace irradia::loader {
namespace {

/// tinyobjloader reads what is not a number as 0; such files are refused here, with the line.
void check_numbers(const std::string& path, const std::string& text) {
    std::size_t line_number = 0;
    for (std::size_t begin = 0; begin < text.size();) {
        std::size_t end = text.find('\n', begin);
        if (end == std::string::npos) end = text.size();
        ++line_number;
        std::size_t i = begin;
        while (i < end && (text[i] == ' ' || text[i] == '\t')) ++i;
        if (i + 1 < end && text[i] == 'v' &&
            (text[i + 1] == ' ' || text[i + 1] == '\t' || text[i + 1] == 'n' || text[i + 1] == 't')) {
            const std::size_t bad =
                text.find_first_not_of("0123456789+-.eE \t\r", i + (text[i + 1] == 'n' || text[i + 1] == 't' ? 2 : 1));
            if (bad < end && text[bad] != '#')
                throw Error(fmt::format("mesh '{}' line {}: '{}' has something that is not a finite number", path,
                                        line_number, text.substr(i, std::min<std::size_t>(end - i, 60))));
        }
        begin = end + 1;
    }
}

}  // namespace

Mesh read_obj(const std::string& path) {
    std::ifstream stream(path, std::ios::binary);
    if (!stream) throw Error(fmt::format("mesh '{}' cannot be read", path));
    std::stringstream buffer;
    buffer << stream.rdbuf();
    const std::string text = buffer.str();
    if (text.empty()) throw Error(fmt::format("mesh '{}' is empty", path));
    check_numbers(path, text);

    tinyobj::ObjReaderConfig config;
    config.triangulate = false;  // fans, as Mitsuba cuts polygons
    config.vertex_color = false;
    tinyobj::ObjReader reader;
    if (!reader.ParseFromString(text, "", config)) {
        std::string reason = reader.Error().empty() ? "malformed OBJ" : reader.Error();
        for (char& c : reason)
            if (c == '\n') c = ' ';
        throw Error(fmt::format("mesh '{}' cannot be read: {}", path, reason));
    }
    const auto& attributes = reader.GetAttrib();
    const auto count = [](const std::vector<tinyobj::real_t>& v, std::size_t n) {
        return static_cast<int>(v.size() / n);
    };
    const int positions = count(attributes.vertices, 3), normals = count(attributes.normals, 3),
              uvs = count(attributes.texcoords, 2);

    Mesh mesh;
    bool any_normal = false, any_uv = false;
    std::map<std::tuple<int, int, int>, std::uint32_t> unique;
    const auto vertex = [&](const tinyobj::index_t& index) {
        if (index.vertex_index < 0 || index.vertex_index >= positions || index.normal_index >= normals ||
            index.texcoord_index >= uvs)
            throw Error(fmt::format(
                "mesh '{}': a face refers to {}, there are {} v, {} vt, {} vn", path,
                index.vertex_index >= positions || index.vertex_index < 0
                    ? fmt::format("vertex {}", index.vertex_index + 1)
                    : (index.normal_index >= normals ? fmt::format("normal {}", index.normal_index + 1)
                                                     : fmt::format("texture coordinate {}", index.texcoord_index + 1)),
                positions, uvs, normals));
        const auto key = std::make_tuple(index.vertex_index, index.texcoord_index, index.normal_index);
        const auto [it, inserted] = unique.emplace(key, static_cast<std::uint32_t>(mesh.positions.size()));
        if (inserted) {
            const auto at = [](const std::vector<tinyobj::real_t>& v, int i) {
                return static_cast<double>(v[static_cast<std::size_t>(i)]);
            };
            const int p = 3 * index.vertex_index, n = 3 * index.normal_index, t = 2 * index.texcoord_index;
            mesh.positions.emplace_back(at(attributes.vertices, p), at(attributes.vertices, p + 1),
                                        at(attributes.vertices, p + 2));
            mesh.normals.emplace_back(0.0);
            mesh.uvs.emplace_back(0.0);
            if (index.normal_index >= 0) {
                any_normal = true;
                mesh.normals.back() = {at(attributes.normals, n), at(attributes.normals, n + 1),
                                       at(attributes.normals, n + 2)};
            }
            if (index.texcoord_index >= 0) {
                any_uv = true;
                mesh.uvs.back() = {at(attributes.texcoords, t), at(attributes.texcoords, t + 1)};
            }
        }
        return it->second;
    };
    for (const auto& shape : reader.GetShapes()) {
        std::size_t first = 0;
        for (const auto corners : shape.mesh.num_face_vertices) {
            const std::size_t n = corners;
            if (n >= 3) {
                const std::uint32_t a = vertex(shape.mesh.indices[first]);
                std::uint32_t b = vertex(shape.mesh.indices[first + 1]);
                for (std::size_t c = 2; c < n; ++c) {
                    const std::uint32_t d = vertex(shape.mesh.indices[first + c]);
                    mesh.triangles.push_back({a, b, d});
                    b = d;
                }
            }
            first += n;
        }
    }
    if (mesh.triangles.empty() && positions > 0) throw Error(fmt::format("mesh '{}' has no faces", path));
    if (!any_normal) mesh.normals.clear();
    if (!any_uv) mesh.uvs.clear();
    return mesh;
}

}  // namespace irradia::loader
