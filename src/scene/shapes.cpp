#include <fmt/format.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <exception>
#include <filesystem>
#include <glm/gtc/matrix_inverse.hpp>

#include "scene/build.h"
#include "scene/in_parallel.h"
#include "scene/parts.h"

namespace irradia::loader {
namespace {

const std::vector<std::string> supported_shapes = {"rectangle", "cube", "sphere",     "disk",       "cylinder",
                                                   "obj",       "ply",  "serialized", "shapegroup", "instance"};

/// What the file says about a shape, before any mesh is read.
struct Request {
    Shape shape;
    MeshFile file;  // path: empty if the shape is none
    glm::dmat4 to_world{1.0};
    bool flip_normals = false, flip_v = false;
    std::size_t dropped = 0;  // degenerate triangles
};

Mesh cube_mesh() {
    // Four corners a face, (u, v) = (0,1), (1,1), (1,0), (0,0): the order and coordinates of Mitsuba's cube.
    static const int corners[24][3] = {{1, -1, -1}, {1, -1, 1},   {-1, -1, 1}, {-1, -1, -1}, {1, 1, -1},   {-1, 1, -1},
                                       {-1, 1, 1},  {1, 1, 1},    {1, -1, -1}, {1, 1, -1},   {1, 1, 1},    {1, -1, 1},
                                       {1, -1, 1},  {1, 1, 1},    {-1, 1, 1},  {-1, -1, 1},  {-1, -1, 1},  {-1, 1, 1},
                                       {-1, 1, -1}, {-1, -1, -1}, {1, 1, -1},  {1, -1, -1},  {-1, -1, -1}, {-1, 1, -1}};
    static const int uv[4][2] = {{0, 1}, {1, 1}, {1, 0}, {0, 0}};
    Mesh mesh;
    for (std::uint32_t face = 0; face < 6; ++face) {
        for (std::uint32_t k = 0; k < 4; ++k) {
            const auto& c = corners[4 * face + k];
            mesh.positions.emplace_back(c[0], c[1], c[2]);
            mesh.uvs.emplace_back(uv[k][0], uv[k][1]);
        }
        const std::uint32_t i = 4 * face;
        mesh.triangles.push_back({i, i + 1, i + 2});
        mesh.triangles.push_back({i + 3, i, i + 2});
        const glm::dvec3 normal = glm::normalize(
            glm::cross(mesh.positions[i + 1] - mesh.positions[i], mesh.positions[i + 2] - mesh.positions[i]));
        mesh.normals.insert(mesh.normals.end(), 4, normal);
    }
    return mesh;
}

Mesh rectangle_mesh() {
    Mesh mesh;
    mesh.positions = {{-1, -1, 0}, {1, -1, 0}, {1, 1, 0}, {-1, 1, 0}};
    mesh.uvs = {{0, 0}, {1, 0}, {1, 1}, {0, 1}};
    mesh.normals.assign(4, glm::dvec3(0, 0, 1));
    mesh.triangles = {{0, 1, 2}, {0, 2, 3}};
    return mesh;
}

/// Moves a mesh to world space, drops degenerate triangles, decides which way its faces look.
void place_mesh(Request& request) {
    Shape& shape = request.shape;
    Mesh& mesh = shape.mesh;
    const glm::dmat3 normal_matrix = glm::inverseTranspose(glm::dmat3(request.to_world));
    in_parallel(mesh.positions.size(), [&](std::size_t i) {
        mesh.positions[i] = glm::dvec3(request.to_world * glm::dvec4(mesh.positions[i], 1.0));
    });
    if (request.flip_v)
        for (auto& uv : mesh.uvs) uv.y = 1.0 - uv.y;
    in_parallel(mesh.normals.size(), [&](std::size_t i) {
        const glm::dvec3 m = normal_matrix * mesh.normals[i];
        const double length = glm::length(m);
        mesh.normals[i] = length > 0.0 ? m / length : glm::dvec3(0.0);
    });
    // Degenerate: collinear or coincident corners, as good as exactly.
    const auto degenerate = [&](const std::array<std::uint32_t, 3>& t) {
        const glm::dvec3 a = mesh.positions[t[1]] - mesh.positions[t[0]],
                         b = mesh.positions[t[2]] - mesh.positions[t[0]];
        const double longest = std::max({glm::dot(a, a), glm::dot(b, b), glm::dot(b - a, b - a)});
        return !(glm::length(glm::cross(a, b)) > 1e-12 * longest);
    };
    std::atomic<bool> any = false;  // hardly ever
    in_parallel(mesh.triangles.size(), [&](std::size_t i) {
        if (degenerate(mesh.triangles[i])) any = true;
    });
    if (any) request.dropped = std::erase_if(mesh.triangles, degenerate);

    if (!shape.flat) fill_normals(mesh);
    shape.sign = request.flip_normals ? -1.0 : 1.0;
    if (request.flip_normals)
        for (auto& n : mesh.normals) n = -n;
}

void place_sphere(const Context& context, Request& request, Properties& p) {
    Shape& shape = request.shape;
    const Node& node = p.node();
    const glm::dvec3 centre = p.vector("center").value_or(glm::dvec3(0.0));
    const double radius = p.number("radius", 1.0);
    if (!(radius > 0.0))
        fail(node, fmt::format("{}: radius is {}, a positive number was expected", describe(node), radius));
    const glm::dmat3 linear(request.to_world);
    const double s = glm::length(linear[0]);
    for (int i = 0; i < 3; ++i)
        for (int j = 0; j < 3; ++j)
            if (std::abs(glm::dot(linear[i], linear[j]) - (i == j ? s * s : 0.0)) > 1e-5 * s * s)
                fail(node, fmt::format("{}: to_world scales unevenly or shears; a sphere allows rotation, translation "
                                       "and uniform scale",
                                       describe(node)));
    shape.centre = glm::dvec3(request.to_world * glm::dvec4(centre, 1.0));
    shape.radius = radius * s;
    shape.axis_u = linear[0] / s;
    shape.axis_v = linear[2] / s;
    const bool mirrored = glm::determinant(linear) < 0.0;  // turns the normals inward, as in Mitsuba
    if (mirrored) context.warn(node, fmt::format("{}: to_world mirrors: its normals point inward", describe(node)));
    shape.sign = request.flip_normals != mirrored ? -1.0 : 1.0;
}

void place_disk(Request& request, const Node& node) {
    Shape& shape = request.shape;
    const glm::dmat3 linear(request.to_world);
    shape.centre = glm::dvec3(request.to_world[3]);
    shape.axis_u = linear[0];
    shape.axis_v = linear[1];
    if (std::abs(glm::dot(linear[0], linear[1])) > 1e-5 * glm::length(linear[0]) * glm::length(linear[1]))
        fail(node, fmt::format("{}: to_world shears; a disk's half axes have to stay perpendicular", describe(node)));
    shape.normal = glm::normalize(glm::inverseTranspose(linear)[2]) * (request.flip_normals ? -1.0 : 1.0);
}

/// Right-handed axes x, y, z for a unit z: Duff et al., "Building an orthonormal basis, revisited", JCGT 6(1), 2017,
/// which Mitsuba turns its cylinders by.
glm::dmat3 frame_around(const glm::dvec3& z) {
    const double sign = std::copysign(1.0, z.z), a = -1.0 / (sign + z.z), b = z.x * z.y * a;
    return {{1.0 + sign * z.x * z.x * a, sign * b, -sign * z.x}, {b, sign + z.y * z.y * a, -z.y}, z};
}

void place_cylinder(Request& request, Properties& p) {
    Shape& shape = request.shape;
    const Node& node = p.node();
    const glm::dvec3 p0 = p.vector("p0").value_or(glm::dvec3(0.0)), p1 = p.vector("p1").value_or(glm::dvec3(0, 0, 1));
    const double radius = p.number("radius", 1.0), length = glm::length(p1 - p0);
    if (!(radius > 0.0))
        fail(node, fmt::format("{}: radius is {}, a positive number was expected", describe(node), radius));
    if (!(length > 0.0)) fail(node, fmt::format("{}: p0 and p1 are the same point", describe(node)));
    const glm::dmat3 frame = glm::dmat3(request.to_world) * frame_around((p1 - p0) / length);
    const double x = glm::length(frame[0]), y = glm::length(frame[1]), z = glm::length(frame[2]);
    if (std::abs(x - y) > 1e-5 * x || std::abs(glm::dot(frame[0], frame[1])) > 1e-5 * x * y ||
        std::abs(glm::dot(frame[0], frame[2])) > 1e-5 * x * z || std::abs(glm::dot(frame[1], frame[2])) > 1e-5 * y * z)
        fail(node, fmt::format("{}: to_world shears the cylinder or makes it elliptical; a cylinder allows rotation, "
                               "translation and scale, which across its axis has to be uniform",
                               describe(node)));
    shape.centre = glm::dvec3(request.to_world * glm::dvec4(p0, 1.0));
    shape.radius = radius * x;
    shape.length = length * z;
    shape.axis_u = frame[0] / x;
    shape.axis_v = frame[1] / y;
    shape.normal = frame[2] / z;
    shape.sign = request.flip_normals ? -1.0 : 1.0;  // a mirrored to_world changes nothing, as in Mitsuba
}

/// Reads one <shape>; no value if it is left out. `outer`: the transform of the instance it belongs to.
std::optional<Request> read_shape(const Context& context, const Document& document, MaterialTable& materials,
                                  const Node& node, const glm::dmat4& outer) {
    const std::string type = node.get("type");
    const bool file = type == "obj" || type == "ply" || type == "serialized";
    if (type == "shapegroup" || type == "instance" ||
        std::find(supported_shapes.begin(), supported_shapes.end(), type) == supported_shapes.end()) {
        context.problem(node,
                        fmt::format("{} is not supported{} (supported: {})", describe(node),
                                    did_you_mean(type, supported_shapes), fmt::join(supported_shapes, ", ")),
                        "the shape is left out");
        return std::nullopt;
    }
    Properties p(context, document, node);
    Request request;
    Shape& shape = request.shape;
    shape.node = &node;
    request.to_world = outer * p.transform("to_world").value_or(glm::dmat4(1.0));
    request.flip_normals = p.boolean("flip_normals", false);
    const glm::dmat3 linear(request.to_world);
    const double volume = glm::length(linear[0]) * glm::length(linear[1]) * glm::length(linear[2]);
    if (!(std::abs(glm::determinant(linear)) > 1e-12 * volume)) {
        // A rectangle or disk may be flattened along z, its area stays; anything else has none left.
        const bool planar = type == "rectangle" || type == "disk";
        const glm::dvec3 z = glm::cross(linear[0], linear[1]);
        if (!planar || !(glm::length(z) > 1e-12 * glm::length(linear[0]) * glm::length(linear[1])))
            fail(node, fmt::format("{}: to_world is singular, the shape has no area", describe(node)));
        request.to_world[2] = glm::dvec4(glm::normalize(z) * std::sqrt(glm::length(z)), 0.0);
    }

    if (file) {
        request.file.type = type;
        request.file.path = document.resolve(node, p.text("filename"));
        shape.flat = p.boolean("face_normals", false);
        if (type == "serialized")
            request.file.index = p.integer("shape_index", 0);
        else
            request.flip_v = p.boolean("flip_tex_coords", type == "obj");
    } else if (type == "rectangle") {
        shape.kind = ShapeKind::rectangle;
        shape.flat = true;
        shape.mesh = rectangle_mesh();
    } else if (type == "cube") {
        shape.flat = true;
        shape.mesh = cube_mesh();
    } else if (type == "sphere") {
        shape.kind = ShapeKind::sphere;
        place_sphere(context, request, p);
    } else if (type == "cylinder") {
        shape.kind = ShapeKind::cylinder;
        place_cylinder(request, p);
    } else {
        shape.kind = ShapeKind::disk;
        place_disk(request, node);
    }

    const auto bsdfs = p.objects("bsdf");
    if (bsdfs.size() > 1) fail(*bsdfs[1], fmt::format("{} has more than one bsdf", describe(node)));
    const auto emitters = p.objects("emitter");
    if (emitters.size() > 1) fail(*emitters[1], fmt::format("{} has more than one emitter", describe(node)));
    if (!emitters.empty()) shape.radiance = read_area_emitter(context, document, *emitters[0]);
    p.ignore({"silhouette_sampling_weight"});
    p.finish();
    shape.material = materials.material(bsdfs.empty() ? nullptr : bsdfs[0], !emitters.empty());
    return request;
}

/// <shape type="instance">: the shapes of its group, moved. They are copied; there is one acceleration structure.
void read_instance(const Context& context, const Document& document, MaterialTable& materials, const Node& node,
                   std::vector<Request>& requests) {
    Properties p(context, document, node);
    const glm::dmat4 to_world = p.transform("to_world").value_or(glm::dmat4(1.0));
    const auto groups = p.objects("shape");
    if (groups.size() != 1 || groups[0]->get("type") != "shapegroup")
        fail(node, fmt::format("{} needs a reference to one <shape type=\"shapegroup\">", describe(node)));
    p.finish();
    Properties group(context, document, *groups[0]);
    for (const Node* shape : group.objects("shape")) {
        auto request = read_shape(context, document, materials, *shape, to_world);
        if (!request) continue;
        if (request->shape.radiance)
            fail(*shape, fmt::format("{}: a shape of a shapegroup cannot emit", describe(*shape)));
        requests.push_back(std::move(*request));
    }
    group.finish();
}

void load_mesh(Request& request, bool colours, MeshFiles& files) {
    Mesh& mesh = request.shape.mesh;
    if (!request.file.path.empty()) {
        mesh = files.mesh(request.file, colours);
        if (request.shape.flat) mesh.normals.clear();
    }
    place_mesh(request);
}

// Measured: meshes take 1.4 times their binary files' sizes and more (text and compressed ones several times), and a
// file is in memory while it is read.
std::uint64_t least_memory(const std::vector<Request>& requests) {
    double all = 0, largest = 0;
    for (const Request& request : requests) {
        if (request.file.path.empty()) continue;
        std::error_code unreadable;  // which is said when it is read
        const auto bytes = static_cast<double>(std::filesystem::file_size(request.file.path, unreadable));
        if (unreadable) continue;
        all += bytes;
        largest = std::max(largest, bytes);
    }
    return static_cast<std::uint64_t>(1.4 * all + largest);
}

}  // namespace

std::vector<Shape> read_shapes(const Context& context, const Document& document, MaterialTable& materials,
                               const TextureTable& textures) {
    std::vector<Request> requests;
    for (const auto& node : document.root.children) {
        if (node.tag != "shape" || node.get("type") == "shapegroup") continue;
        if (node.get("type") == "instance") {
            read_instance(context, document, materials, node, requests);
        } else if (auto request = read_shape(context, document, materials, node, glm::dmat4(1.0))) {
            requests.push_back(std::move(*request));
        }
    }

    const bool colours = textures.vertex_colours();
    std::vector<std::exception_ptr> errors(requests.size());
    std::atomic<std::size_t> done = 0;
    context.progress("meshes", 0.0);
    context.need(least_memory(requests), "the scene's meshes");
    MeshFiles files(context.options.parts);
    for (const Request& request : requests)
        if (!request.file.path.empty()) files.add(request.file, colours);
    files.read();
    tbb::parallel_for(std::size_t{0}, requests.size(), [&](std::size_t i) {
        if (is_analytic(requests[i].shape.kind)) return;
        try {
            load_mesh(requests[i], colours, files);
        } catch (...) {
            errors[i] = std::current_exception();
        }
        context.progress("meshes", static_cast<double>(++done) / static_cast<double>(requests.size()));
    });
    std::vector<Shape> shapes;
    for (std::size_t i = 0; i < requests.size(); ++i) {
        const Node& node = *requests[i].shape.node;
        if (errors[i]) {  // the first in file order, whatever thread met it
            try {
                std::rethrow_exception(errors[i]);
            } catch (const Error& error) {
                fail(node, error.what());
            }
        }
        if (requests[i].dropped && requests[i].shape.mesh.triangles.empty()) {
            context.warn(node,
                         fmt::format("mesh '{}': all of its {} triangles are degenerate (zero area), the shape is "
                                     "left out",
                                     requests[i].file.path, requests[i].dropped));
            continue;
        }
        if (requests[i].dropped)
            context.warn(node, fmt::format("mesh '{}': {} degenerate triangle{} dropped", requests[i].file.path,
                                           requests[i].dropped, requests[i].dropped == 1 ? "" : "s"));
        shapes.push_back(std::move(requests[i].shape));
    }
    return shapes;
}

}  // namespace irradia::loader
