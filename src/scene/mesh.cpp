#include <fmt/format.h>

#include <cmath>

#include "scene/build.h"

namespace irradia::loader {

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
    for (std::size_t i = 0; i < mesh.triangles.size(); ++i)
        for (const auto v : mesh.triangles[i])
            if (v >= mesh.positions.size())
                throw Error(fmt::format("mesh '{}': triangle {} refers to vertex {}, there are {}", path, i, v,
                                        mesh.positions.size()));
}

void fill_normals(Mesh& mesh) {
    if (mesh.normals.empty()) mesh.normals.assign(mesh.positions.size(), glm::dvec3(0.0));
    std::vector<bool> wanted(mesh.positions.size());
    bool any = false;
    for (std::size_t i = 0; i < wanted.size(); ++i) {
        wanted[i] = mesh.normals[i] == glm::dvec3(0.0);
        any = any || wanted[i];
    }
    if (!any) return;
    std::vector<glm::dvec3> sums(mesh.positions.size(), glm::dvec3(0.0));
    for (const auto& t : mesh.triangles) {
        const glm::dvec3 p[3] = {mesh.positions[t[0]], mesh.positions[t[1]], mesh.positions[t[2]]};
        const glm::dvec3 normal = glm::cross(p[1] - p[0], p[2] - p[0]);
        const double length = glm::length(normal);
        if (!(length > 0.0)) continue;
        for (int k = 0; k < 3; ++k) {
            const glm::dvec3 a = p[(k + 1) % 3] - p[k], b = p[(k + 2) % 3] - p[k];
            const double angle = std::atan2(glm::length(glm::cross(a, b)), glm::dot(a, b));
            sums[t[static_cast<std::size_t>(k)]] += normal * (angle / length);
        }
    }
    for (std::size_t i = 0; i < wanted.size(); ++i) {
        if (!wanted[i]) continue;
        const double length = glm::length(sums[i]);
        if (length > 1e-9) mesh.normals[i] = sums[i] / length;  // sums of unit normals: below this they cancel
    }
}

}  // namespace irradia::loader
