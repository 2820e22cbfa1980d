#include <fmt/format.h>

#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>

#include <bit>
#include <cmath>
#include <fstream>

#include "scene/build.h"

namespace irradia::loader {

std::string read_file(const std::string& path) {
    std::ifstream stream(path, std::ios::binary | std::ios::ate);
    const std::streamoff size = stream ? static_cast<std::streamoff>(stream.tellg()) : -1;
    if (size < 0) throw Error(fmt::format("mesh '{}' cannot be read", path));
    if (size == 0) throw Error(fmt::format("mesh '{}' is empty", path));
    std::string data(static_cast<std::size_t>(size), '\0');
    if (!stream.seekg(0) || !stream.read(data.data(), size)) throw Error(fmt::format("mesh '{}' cannot be read", path));
    return data;
}

Mesh read_mesh(const MeshFile& file, bool colours) {
    Mesh mesh = file.type == "ply"   ? read_ply(file.path, colours)
                : file.type == "obj" ? read_obj(file.path, colours)
                                     : read_serialized(file.path, file.index, colours);
    check_mesh(file.path, mesh);
    return mesh;
}

glm::dvec3 Shape::face_normal(std::size_t triangle) const {
    const auto& t = mesh.triangles[triangle];
    const glm::dvec3& p = mesh.positions[t[0]];
    const glm::dvec3 n = sign * glm::normalize(glm::cross(mesh.positions[t[1]] - p, mesh.positions[t[2]] - p));
    if (mesh.normals.empty()) return n;
    return glm::dot(n, mesh.normals[t[0]] + mesh.normals[t[1]] + mesh.normals[t[2]]) < 0.0 ? -n : n;
}

void check_mesh(const std::string& path, const Mesh& mesh) {
    const auto finite = [](const glm::dvec3& v) {
        return std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z);
    };
    if (mesh.positions.empty()) throw Error(fmt::format("mesh '{}' has no vertices", path));
    if (mesh.triangles.empty()) throw Error(fmt::format("mesh '{}' has no faces", path));
    for (std::size_t i = 0; i < mesh.positions.size(); ++i) {
        const auto& p = mesh.positions[i];
        if (!finite(p))
            throw Error(fmt::format("mesh '{}': vertex {} is not finite ({}, {}, {})", path, i, p.x, p.y, p.z));
    }
    for (std::size_t i = 0; i < mesh.normals.size(); ++i)
        if (!finite(mesh.normals[i]))
            throw Error(fmt::format("mesh '{}': the normal of vertex {} is not finite", path, i));
    for (std::size_t i = 0; i < mesh.uvs.size(); ++i)
        if (!std::isfinite(mesh.uvs[i].x) || !std::isfinite(mesh.uvs[i].y))
            throw Error(fmt::format("mesh '{}': the texture coordinate of vertex {} is not finite", path, i));
    for (std::size_t i = 0; i < mesh.colours.size(); ++i)
        for (int k = 0; k < 3; ++k)
            if (!(mesh.colours[i][k] >= 0.0f && std::isfinite(mesh.colours[i][k])))
                throw Error(fmt::format("mesh '{}': the colour of vertex {} is negative or not finite", path, i));
    for (std::size_t i = 0; i < mesh.triangles.size(); ++i)
        for (const auto v : mesh.triangles[i])
            if (v >= mesh.positions.size())
                throw Error(fmt::format("mesh '{}': triangle {} refers to vertex {}, there are {}", path, i, v,
                                        mesh.positions.size()));
}

void fill_normals(Mesh& mesh) {
    const std::size_t vertices = mesh.positions.size();
    if (mesh.normals.empty()) mesh.normals.assign(vertices, glm::dvec3(0.0));
    std::vector<char> wanted(vertices);
    bool any = false;
    for (std::size_t i = 0; i < vertices; ++i) {
        wanted[i] = mesh.normals[i] == glm::dvec3(0.0);
        any = any || wanted[i];
    }
    if (!any) return;
    // Each task goes through all triangles and sums up for a range of the vertices: no two write to the same sum, and
    // every sum is made in the triangles' order, however many tasks there are.
    const std::size_t tasks =
        mesh.triangles.size() < 10000 ? 1 : static_cast<std::size_t>(tbb::this_task_arena::max_concurrency());
    tbb::parallel_for(std::size_t{0}, tasks, [&](std::size_t task) {
        const std::size_t begin = vertices * task / tasks, end = vertices * (task + 1) / tasks;
        const auto ours = [&](std::uint32_t v) { return v >= begin && v < end && wanted[v]; };
        for (const auto& t : mesh.triangles) {
            if (!ours(t[0]) && !ours(t[1]) && !ours(t[2])) continue;
            const glm::dvec3 p[3] = {mesh.positions[t[0]], mesh.positions[t[1]], mesh.positions[t[2]]};
            const glm::dvec3 normal = glm::cross(p[1] - p[0], p[2] - p[0]);
            const double length = glm::length(normal);
            if (!(length > 0.0)) continue;
            for (int k = 0; k < 3; ++k) {
                const std::uint32_t v = t[static_cast<std::size_t>(k)];
                if (!ours(v)) continue;
                const glm::dvec3 a = p[(k + 1) % 3] - p[k], b = p[(k + 2) % 3] - p[k];
                mesh.normals[v] += normal * (std::atan2(length, glm::dot(a, b)) / length);
            }
        }
        for (std::size_t i = begin; i < end; ++i) {
            if (!wanted[i]) continue;
            const double length = glm::length(mesh.normals[i]);
            // Sums of unit normals: below this they cancel.
            mesh.normals[i] = length > 1e-9 ? mesh.normals[i] / length : glm::dvec3(0.0);
        }
    });
}

void add_vertex_colours(const std::vector<Shape>& shapes, const std::vector<shared::Material>& materials,
                        const TextureTable& textures, Scene& scene) {
    const auto reads = [&](int texture) {
        return texture >= 0 && scene.textures[static_cast<std::size_t>(texture)].format == IR_TEXTURE_VERTEX_COLOUR;
    };
    const auto asks = [&](const shared::Material& m) {
        return reads(m.texture) || reads(m.specular_texture) || reads(m.opacity_texture) || reads(m.alpha_texture) ||
               reads(m.map);
    };
    std::size_t vertices = 0;
    for (const Shape& shape : shapes) {
        vertices += shape.mesh.positions.size();
        const shared::Material& front = materials[shape.material];
        const bool asked = reads(shape.radiance_texture) || asks(front) ||
                           (front.back >= 0 && asks(materials[static_cast<std::size_t>(front.back)]));
        if (asked && shape.mesh.colours.empty())
            fail(*shape.node,
                 fmt::format("{} has no vertex colours, which its bsdf or emitter reads", describe(*shape.node)));
    }
    // One copy of values in [0, 1], one of values as they are, if asked for.
    std::optional<std::uint32_t> offsets[2];
    for (std::size_t i = 0; i < scene.textures.size(); ++i) {
        if (!reads(static_cast<int>(i))) continue;
        const TextureSpec& spec = textures.spec(static_cast<int>(i));
        std::optional<std::uint32_t>& offset = offsets[spec.unbounded];
        if (!offset) {
            if (scene.texels.size() + 3 * vertices > 0xffffffffu)
                fail(*spec.node, "the scene's textures exceed 16 GiB");
            offset = static_cast<std::uint32_t>(scene.texels.size());
            scene.texels.reserve(scene.texels.size() + 3 * vertices);
            for (const Shape& shape : shapes) {
                for (const glm::vec3& c : shape.mesh.colours)
                    for (int k = 0; k < 3; ++k)
                        scene.texels.push_back(
                            std::bit_cast<std::uint32_t>(spec.unbounded ? c[k] : std::min(c[k], 1.0f)));
                if (shape.mesh.colours.empty())  // nobody looks here
                    scene.texels.resize(scene.texels.size() + 3 * shape.mesh.positions.size(), 0u);
            }
        }
        scene.textures[i].offset = *offset;
    }
}

}  // namespace irradia::loader
