#include <fmt/format.h>
#include <tbb/parallel_for.h>
#include <tbb/parallel_reduce.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <optional>
#include <set>

#include "scene/build.h"
#include "scene/in_parallel.h"
#include "scene/parts.h"

namespace irradia {
namespace loader {
namespace {

struct Extent {
    glm::dvec3 lo{std::numeric_limits<double>::infinity()}, hi{-std::numeric_limits<double>::infinity()};
    void grow(const glm::dvec3& p, const glm::dvec3& reach) {
        lo = glm::min(lo, p - reach);
        hi = glm::max(hi, p + reach);
    }
};

/// The parts of a scene, put together and rounded.
class Assembler {
public:
    Assembler(const Context& context, const Document& document, Scene& scene)
        : context_(context), document_(document), scene_(scene) {}

    void bounds(const std::vector<Shape>& shapes) {
        for (const auto& shape : shapes) {
            const Extent extent = tbb::parallel_reduce(
                tbb::blocked_range<std::size_t>(0, shape.mesh.triangles.size(), 1 << 14), Extent{},
                [&](const auto& range, Extent e) {
                    for (std::size_t i = range.begin(); i != range.end(); ++i)
                        for (const auto v : shape.mesh.triangles[i]) e.grow(shape.mesh.positions[v], glm::dvec3(0.0));
                    return e;
                },
                [](Extent a, const Extent& b) {
                    a.lo = glm::min(a.lo, b.lo);
                    a.hi = glm::max(a.hi, b.hi);
                    return a;
                });
            if (!shape.mesh.triangles.empty()) {
                grow(extent.lo, glm::dvec3(0.0));
                grow(extent.hi, glm::dvec3(0.0));
            }
            if (shape.kind == ShapeKind::sphere) grow(shape.centre, glm::dvec3(shape.radius));
            if (shape.kind == ShapeKind::disk)  // extent of an ellipse along each axis
                grow(shape.centre, glm::sqrt(shape.axis_u * shape.axis_u + shape.axis_v * shape.axis_v));
            if (shape.kind == ShapeKind::cylinder) {  // extent of the circles at both ends
                const glm::dvec3 reach =
                    shape.radius * glm::sqrt(glm::max(1.0 - shape.normal * shape.normal, glm::dvec3(0.0)));
                grow(shape.centre, reach);
                grow(shape.centre + shape.length * shape.normal, reach);
            }
        }
        centre_ = 0.5 * (lo_ + hi_);
        const double diagonal = glm::length(hi_ - lo_);
        if (!std::isfinite(diagonal) || diagonal > 1e18)
            throw Error(fmt::format("{}: the scene is {} units across, too large for single precision",
                                    document_.files.front(), diagonal));
        scene_.centre = {centre_.x, centre_.y, centre_.z};
        auto& info = scene_.info;
        info.diagonal = static_cast<float>(diagonal);
        const glm::vec3 lo(lo_ - centre_), hi(hi_ - centre_);
        info.min_x = lo.x;
        info.min_y = lo.y;
        info.min_z = lo.z;
        info.max_x = hi.x;
        info.max_y = hi.y;
        info.max_z = hi.z;
    }

    void reserve(const std::vector<Shape>& shapes) {
        std::size_t vertices = 0, triangles = 0;
        for (const auto& shape : shapes) {
            vertices += shape.mesh.positions.size();
            triangles += shape.mesh.triangles.size();
        }
        context_.need(vertices * sizeof(shared::Vertex) + triangles * sizeof(shared::Triangle),
                      "the scene's triangles");
        scene_.vertices.reserve(vertices);
        scene_.triangles.reserve(triangles);
    }

    void add(const Shape& shape) {
        const bool emits = shape.radiance && luminance(*shape.radiance) > 0.0;
        if (shape.radiance && !emits)
            context_.warn(*shape.node,
                          fmt::format("{}: its emitter is black, it is treated as no emitter", describe(*shape.node)));
        if (is_analytic(shape.kind))
            add_analytic(shape, emits);
        else
            add_mesh(shape, emits);
    }

    void add(const FreeLight& light) {
        if (!(luminance(light.colour) > 0.0)) return;
        shared::Light l = blank(light.colour);
        l.kind = light.kind;
        if (light.kind == IR_LIGHT_POINT || light.kind == IR_LIGHT_SPOT)
            set3(l.px, l.py, l.pz, light.position - centre_);
        if (light.kind == IR_LIGHT_DIRECTIONAL || light.kind == IR_LIGHT_SPOT) set3(l.nx, l.ny, l.nz, light.direction);
        if (light.kind == IR_LIGHT_SPOT) {
            l.e1x = static_cast<float>(std::cos(light.cutoff));
            l.e1y = static_cast<float>(std::cos(light.beam));
            l.e2x = static_cast<float>(light.cutoff);
            l.e2y = static_cast<float>(light.beam);
        }
        if (light.kind == IR_LIGHT_ENVMAP) {
            if (scene_.texels.size() + environment_words(*light.map) > 0xffffffffu)
                fail(*light.node, "the scene's textures exceed 16 GiB");
            set3(l.e1x, l.e1y, l.e1z, light.axes[0]);
            set3(l.e2x, l.e2y, l.e2z, light.axes[1]);
            set3(l.nx, l.ny, l.nz, light.axes[2]);
            append_environment(*light.map, scene_, l);
        }
        scene_.lights.push_back(l);
    }

    /// When all shapes are there: analytic primitives are numbered after the triangles.
    void finish_textured_lights() {
        for (std::size_t i = 0; i < scene_.analytics.size(); ++i)
            if (scene_.analytics[i].light != IR_NO_LIGHT)
                scene_.lights[static_cast<std::size_t>(scene_.analytics[i].light)].primitive =
                    static_cast<std::uint32_t>(scene_.triangles.size() + i);
        set_mean_of_textured_lights(scene_);
    }

    void camera(const CameraFrame& frame) { scene_.info.camera = rounded(frame, centre_, scene_.info); }

private:
    const Context& context_;
    const Document& document_;
    Scene& scene_;
    glm::dvec3 lo_{std::numeric_limits<double>::infinity()}, hi_{-std::numeric_limits<double>::infinity()},
        centre_{0.0};

    void grow(const glm::dvec3& p, const glm::dvec3& extent) {
        lo_ = glm::min(lo_, p - extent);
        hi_ = glm::max(hi_, p + extent);
    }
    static void set3(float& x, float& y, float& z, const glm::dvec3& v) {
        x = static_cast<float>(v.x);
        y = static_cast<float>(v.y);
        z = static_cast<float>(v.z);
    }
    static shared::Light blank(const glm::dvec3& colour) {
        shared::Light light{};
        light.texture = IR_NO_TEXTURE;
        set3(light.r, light.g, light.b, colour);
        return light;
    }
    int light(const Shape& shape, std::uint32_t kind, const glm::dvec3& p, const glm::dvec3& e1, const glm::dvec3& e2,
              const glm::dvec3& n, double area) {
        if (!(static_cast<float>(area) > 0.0f))
            fail(*shape.node, fmt::format("{}: the emitter has no area", describe(*shape.node)));
        shared::Light l = blank(*shape.radiance);
        l.kind = kind;
        set3(l.px, l.py, l.pz, p - centre_);
        set3(l.e1x, l.e1y, l.e1z, e1);
        set3(l.e2x, l.e2y, l.e2z, e2);
        set3(l.nx, l.ny, l.nz, n);
        l.area = static_cast<float>(area);
        l.texture = shape.radiance_texture;
        l.primitive = static_cast<std::uint32_t>(scene_.triangles.size());  // the next one; analytic ones: at the end
        scene_.lights.push_back(l);
        return static_cast<int>(scene_.lights.size() - 1);
    }

    struct Corner {
        glm::dvec3 p, e1, e2;
    };
    /// Vertex k of a triangle and the edges from there to the two others.
    static Corner corner(const Mesh& mesh, const std::array<std::uint32_t, 3>& t, std::size_t k) {
        const glm::dvec3& p = mesh.positions[t[k]];
        return {p, mesh.positions[t[(k + 1) % 3]] - p, mesh.positions[t[(k + 2) % 3]] - p};
    }
    /// The rectangle that two triangles make up, by a corner next to `a`'s right angle. A rectangle is one light
    /// (halves would each be chosen with half its probability) and has a solid angle that can be sampled at once.
    static std::optional<Corner> rectangle_of(const Mesh& mesh, const std::array<std::uint32_t, 3>& a,
                                              const std::array<std::uint32_t, 3>& b) {
        for (std::size_t k = 0; k < 3; ++k) {
            const Corner c = corner(mesh, a, k);
            const double size = glm::length(c.e1) + glm::length(c.e2), tolerance = 1e-6 * size;
            if (std::abs(glm::dot(c.e1, c.e2)) > 1e-6 * glm::length(c.e1) * glm::length(c.e2)) continue;
            for (std::size_t m = 0; m < 3; ++m) {  // b's right angle lies opposite; its edges run back, in a's order
                const Corner d = corner(mesh, b, m);
                if (glm::length(d.p - (c.p + c.e1 + c.e2)) <= tolerance && glm::length(d.e1 + c.e1) <= tolerance &&
                    glm::length(d.e2 + c.e2) <= tolerance)
                    return Corner{c.p + c.e2, -c.e2, c.e1};
            }
        }
        return std::nullopt;
    }

    /// Does the affine map from position to texture coordinates that `a` has hold for `b` too?
    static bool same_mapping(const Mesh& mesh, const std::array<std::uint32_t, 3>& a,
                             const std::array<std::uint32_t, 3>& b) {
        if (mesh.uvs.empty()) return false;  // barycentrics: each triangle its own
        const Corner c = corner(mesh, a, 0);
        const glm::dvec2 uv = mesh.uvs[a[0]], uv1 = mesh.uvs[a[1]] - uv, uv2 = mesh.uvs[a[2]] - uv;
        const double e11 = glm::dot(c.e1, c.e1), e12 = glm::dot(c.e1, c.e2), e22 = glm::dot(c.e2, c.e2);
        const double det = e11 * e22 - e12 * e12;
        const double tolerance = 1e-5 * (std::abs(uv1.x) + std::abs(uv1.y) + std::abs(uv2.x) + std::abs(uv2.y));
        return std::all_of(b.begin(), b.end(), [&](std::uint32_t v) {
            const glm::dvec3 d = mesh.positions[v] - c.p;
            const double d1 = glm::dot(d, c.e1), d2 = glm::dot(d, c.e2);
            const glm::dvec2 expected = uv + uv1 * ((d1 * e22 - d2 * e12) / det) + uv2 * ((d2 * e11 - d1 * e12) / det);
            return glm::length(mesh.uvs[v] - expected) <= tolerance;
        });
    }

    void add_mesh(const Shape& shape, bool emits) {
        const Mesh& mesh = shape.mesh;
        if (scene_.vertices.size() + mesh.positions.size() > 0xffffffffu)
            fail(*shape.node, "the scene has more vertices than 32-bit indices can count");
        const auto base = static_cast<std::uint32_t>(scene_.vertices.size());
        const bool normals = !shape.flat && !mesh.normals.empty(), uvs = !mesh.uvs.empty();
        scene_.vertices.resize(base + mesh.positions.size());
        in_parallel(mesh.positions.size(), [&](std::size_t i) {
            shared::Vertex v{};
            set3(v.px, v.py, v.pz, mesh.positions[i] - centre_);
            if (normals) set3(v.nx, v.ny, v.nz, mesh.normals[i]);
            if (uvs) {
                v.u = static_cast<float>(mesh.uvs[i].x);
                v.v = static_cast<float>(mesh.uvs[i].y);
            }
            scene_.vertices[base + i] = v;
        });
        const auto without_light = [&](std::size_t i) {
            const auto& t = mesh.triangles[i];
            const glm::dvec3 n = shape.face_normal(i);
            shared::Triangle triangle{};
            set3(triangle.nx, triangle.ny, triangle.nz, n);
            bool flat = !normals;
            if (normals) {
                flat = true;
                bool cancelled = false;  // coincident faces back to back: their vertex normals add up to nothing
                for (const auto v : t) {
                    flat = flat && glm::length(mesh.normals[v] - n) <= 1e-5;
                    cancelled = cancelled || glm::length(mesh.normals[v]) < 0.5;
                }
                flat = flat || cancelled;
            }
            triangle.flags = (flat ? IR_TRIANGLE_FLAT : 0u) | (uvs ? IR_TRIANGLE_HAS_UV : 0u);
            triangle.v0 = base + t[0];
            triangle.v1 = base + t[1];
            triangle.v2 = base + t[2];
            triangle.material = shape.material;
            triangle.light = IR_NO_LIGHT;
            return triangle;
        };
        if (!emits) {
            const std::size_t first = scene_.triangles.size();
            scene_.triangles.resize(first + mesh.triangles.size());
            in_parallel(mesh.triangles.size(), [&](std::size_t i) { scene_.triangles[first + i] = without_light(i); });
            return;
        }
        bool second_half = false;  // of the rectangle that began with the previous triangle
        for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
            const auto& t = mesh.triangles[i];
            const glm::dvec3 n = shape.face_normal(i);
            shared::Triangle triangle = without_light(i);
            triangle.light = second_half ? static_cast<int>(scene_.lights.size() - 1) : IR_NO_LIGHT;
            if (emits && !second_half) {
                auto quad = i + 1 < mesh.triangles.size() ? rectangle_of(mesh, t, mesh.triangles[i + 1]) : std::nullopt;
                if (quad && shape.radiance_texture != IR_NO_TEXTURE && !same_mapping(mesh, t, mesh.triangles[i + 1]))
                    quad.reset();
                const Corner c = quad.value_or(corner(mesh, t, 0));
                triangle.light = light(shape, quad ? IR_LIGHT_QUAD : IR_LIGHT_TRIANGLE, c.p, c.e1, c.e2, n,
                                       (quad ? 1.0 : 0.5) * glm::length(glm::cross(c.e1, c.e2)));
                second_half = quad.has_value();
            } else {
                second_half = false;
            }
            scene_.triangles.push_back(triangle);
        }
    }

    void add_analytic(const Shape& shape, bool emits) {
        shared::Analytic a{};
        set3(a.px, a.py, a.pz, shape.centre - centre_);
        a.material = shape.material;
        a.light = IR_NO_LIGHT;
        a.sign = static_cast<float>(shape.sign);
        if (shape.kind == ShapeKind::sphere) {
            a.kind = IR_ANALYTIC_SPHERE;
            a.radius = static_cast<float>(shape.radius);
            set3(a.ux, a.uy, a.uz, shape.axis_u);
            set3(a.vx, a.vy, a.vz, shape.axis_v);
            if (emits) {
                a.light = light(shape, IR_LIGHT_SPHERE, shape.centre, {}, {}, {shape.sign, 0.0, 0.0},
                                4.0 * std::numbers::pi * shape.radius * shape.radius);
                scene_.lights.back().radius = a.radius;
            }
        } else if (shape.kind == ShapeKind::cylinder) {
            a.kind = IR_ANALYTIC_CYLINDER;
            a.radius = static_cast<float>(shape.radius);
            a.length = static_cast<float>(shape.length);
            set3(a.nx, a.ny, a.nz, shape.normal);
            set3(a.ux, a.uy, a.uz, shape.axis_u);
            set3(a.vx, a.vy, a.vz, shape.axis_v);
            if (emits) {
                a.light = light(shape, IR_LIGHT_CYLINDER, shape.centre, shape.length * shape.normal, {},
                                {shape.sign, 0.0, 0.0}, 2.0 * std::numbers::pi * shape.radius * shape.length);
                scene_.lights.back().radius = a.radius;
            }
        } else {
            a.kind = IR_ANALYTIC_DISK;
            set3(a.nx, a.ny, a.nz, shape.normal);
            set3(a.ux, a.uy, a.uz, shape.axis_u / glm::dot(shape.axis_u, shape.axis_u));
            set3(a.vx, a.vy, a.vz, shape.axis_v / glm::dot(shape.axis_v, shape.axis_v));
            if (emits)
                a.light = light(shape, IR_LIGHT_DISK, shape.centre, shape.axis_u, shape.axis_v, shape.normal,
                                std::numbers::pi * glm::length(glm::cross(shape.axis_u, shape.axis_v)));
        }
        scene_.analytics.push_back(a);
    }
};

/// Elements of the root that nobody reads: values outside an object, things of other renderers.
void check_top_level(const Context& context, const Document& document) {
    for (const auto& node : document.root.children) {
        const auto& tag = node.tag;
        if (tag == "medium" || tag == "volume" || tag == "phase")
            context.unsupported(node, "surfaces in vacuum", "nothing, it is left out");
        else if (tag == "ref")
            static_cast<void>(document.follow(node));
        else if (tag != "sensor" && tag != "shape" && tag != "emitter" && tag != "bsdf" && tag != "texture" &&
                 tag != "integrator")
            context.problem(node, fmt::format("{} cannot stand directly inside <scene>", describe(node)), "ignored");
    }
    if (const auto* version = document.root.find("version")) {
        if (parse_numbers(document.root, version->substr(0, version->find('.')))[0] < 2.0)
            context.problem(document.root,
                            fmt::format("scene version {} is not supported (supported: 2 and 3)", *version),
                            "read as version 3");
    }
}

Scene load(const std::string& path, const LoadOptions& given) {
    LoadOptions options = given;
    std::set<std::string> said;  // an element that is used twice is warned of once
    options.warn = [&](const std::string& line) {
        if (given.warn && said.insert(line).second) given.warn(line);
    };
    PartsInUse in_use(options.parts);
    const Context context{options};
    context.progress("parsing", 0.0);
    Document document;
    read_document(path, context, document);
    check_top_level(context, document);

    Scene scene;
    scene.source = path;
    const Sensor camera = read_sensor(context, document, scene);
    TextureTable textures;
    MaterialTable materials(context, document, textures);
    // Materials nobody uses are read too: a mistake in one is a mistake.
    for (const auto& node : document.root.children)
        if (node.tag == "bsdf") materials.material(&node);
    std::vector<Shape> shapes = read_shapes(context, document, materials, textures);
    read_radiance_textures(context, document, textures, shapes);
    const std::vector<FreeLight> lights = read_free_lights(context, document);
    if (shapes.empty()) throw Error(fmt::format("{}: the scene has no shapes", path));
    context.progress("textures", 0.0);
    textures.load(context, scene);
    set_mean_of_textures(scene, shapes);
    materials.store_coats(scene);
    context.progress("assembly", 0.0);
    add_vertex_colours(shapes, materials.materials, textures, scene);

    const bool environment = std::any_of(lights.begin(), lights.end(), [](const FreeLight& light) {
        return light.kind == IR_LIGHT_CONSTANT || light.kind == IR_LIGHT_ENVMAP;
    });
    check_camera(camera, shapes, materials.materials, environment);
    Assembler assembler(context, document, scene);
    assembler.bounds(shapes);
    assembler.reserve(shapes);
    for (auto& shape : shapes) {
        assembler.add(shape);
        shape.mesh = Mesh{};  // large scenes: not twice in memory
    }
    assembler.finish_textured_lights();
    for (const auto& light : lights) assembler.add(light);
    if (scene.lights.empty())
        throw Error(fmt::format("{}: nothing emits light: the scene has no emitter, or only black ones", path));
    assembler.camera(camera);
    scene.materials = std::move(materials.materials);
    set_selection_probabilities(scene.lights, 0.5 * static_cast<double>(scene.info.diagonal));
    finish_scene(scene);
    in_use.loaded();
    return scene;
}

}  // namespace
}  // namespace loader

Scene load_scene(const std::string& path, const LoadOptions& options) {
    tbb::task_arena arena(options.threads > 0 ? options.threads : tbb::task_arena::automatic);
    return arena.execute([&] { return loader::load(path, options); });
}

void prepare_loading() {
    tbb::task_arena(2).execute([] { tbb::parallel_for(0, 2, [](int) {}); });
}

}  // namespace irradia
