// A camera inside a solid object, or with a surface right before its eye: found here, not in a black picture.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <numbers>

#include "scene/build.h"

namespace irradia::loader {
namespace {

constexpr int kRays = 256;  // over the film, and over the sphere of directions

/// What lies on a ray, in units of its direction.
struct Sight {
    const Shape* hidden = nullptr;  // the nearest surface before `nearest`, which the picture does not show
    const Shape* seen = nullptr;    // the first surface after it
    bool dark = false;              // it is seen from behind and reflects nothing there
};

/// Follows one ray through every shape. There are few of them, usually one: no hierarchy pays.
class Ray {
public:
    Ray(const glm::dvec3& origin, const glm::dvec3& direction, double nearest, double farthest)
        : origin_(origin), direction_(direction), nearest_(nearest), farthest_(farthest), seen_at_(farthest) {}

    Sight look(const std::vector<Shape>& shapes, const std::vector<shared::Material>& materials) {
        for (const Shape& shape : shapes) {
            back_is_dark_ = materials[shape.material].back == IR_NO_MATERIAL;
            if (shape.kind == ShapeKind::sphere)
                sphere(shape);
            else if (shape.kind == ShapeKind::disk)
                disk(shape);
            else if (shape.kind == ShapeKind::cylinder)
                cylinder(shape);
            else
                mesh(shape);
        }
        return sight_;
    }

private:
    glm::dvec3 origin_, direction_;
    double nearest_, farthest_, seen_at_, hidden_at_ = std::numeric_limits<double>::infinity();
    bool back_is_dark_ = false;
    Sight sight_;

    void hit(const Shape& shape, double t, const glm::dvec3& normal) {
        // A surface through the eye itself may come out on either side of it, by rounding.
        if (t >= nearest_ && t < seen_at_) {
            seen_at_ = t;
            sight_.seen = &shape;
            sight_.dark = back_is_dark_ && glm::dot(direction_, normal) > 0.0;
        } else if (t > -1e-3 * nearest_ && t < nearest_ && t < hidden_at_) {
            hidden_at_ = t;
            sight_.hidden = &shape;
        }
    }

    /// Möller and Trumbore, "Fast, minimum storage ray/triangle intersection", 1997.
    void mesh(const Shape& shape) {
        for (std::size_t i = 0; i < shape.mesh.triangles.size(); ++i) {
            const auto& corners = shape.mesh.triangles[i];
            const glm::dvec3& a = shape.mesh.positions[corners[0]];
            const glm::dvec3 e1 = shape.mesh.positions[corners[1]] - a, e2 = shape.mesh.positions[corners[2]] - a;
            const glm::dvec3 p = glm::cross(direction_, e2), s = origin_ - a;
            const double determinant = glm::dot(e1, p), u = glm::dot(s, p) / determinant;
            if (!(u >= 0.0 && u <= 1.0)) continue;
            const glm::dvec3 q = glm::cross(s, e1);
            const double v = glm::dot(direction_, q) / determinant;
            if (v >= 0.0 && u + v <= 1.0) hit(shape, glm::dot(e2, q) / determinant, shape.face_normal(i));
        }
    }

    void sphere(const Shape& shape) {
        const glm::dvec3 from_centre = origin_ - shape.centre;
        const double a = glm::dot(direction_, direction_), b = glm::dot(direction_, from_centre);
        const double discriminant = b * b - a * (glm::dot(from_centre, from_centre) - shape.radius * shape.radius);
        if (discriminant < 0.0) return;
        for (const double root : {-std::sqrt(discriminant), std::sqrt(discriminant)}) {
            const double t = (root - b) / a;
            hit(shape, t, shape.sign * (from_centre + t * direction_));
        }
    }

    void disk(const Shape& shape) {
        const double t = glm::dot(shape.centre - origin_, shape.normal) / glm::dot(direction_, shape.normal);
        if (!std::isfinite(t)) return;
        const glm::dvec3 from_centre = origin_ + t * direction_ - shape.centre;
        const double u = glm::dot(from_centre, shape.axis_u) / glm::dot(shape.axis_u, shape.axis_u);
        const double v = glm::dot(from_centre, shape.axis_v) / glm::dot(shape.axis_v, shape.axis_v);
        if (u * u + v * v <= 1.0) hit(shape, t, shape.normal);
    }

    void cylinder(const Shape& shape) {
        const glm::dvec3 from_base = origin_ - shape.centre;
        const double height = glm::dot(from_base, shape.normal), climb = glm::dot(direction_, shape.normal);
        const glm::dvec3 f = from_base - height * shape.normal, d = direction_ - climb * shape.normal;
        const double a = glm::dot(d, d), b = glm::dot(d, f);
        const double discriminant = b * b - a * (glm::dot(f, f) - shape.radius * shape.radius);
        if (!(a > 0.0) || discriminant < 0.0) return;
        for (const double root : {-std::sqrt(discriminant), std::sqrt(discriminant)}) {
            const double t = (root - b) / a, z = height + t * climb;
            if (z >= 0.0 && z <= shape.length) hit(shape, t, shape.sign * (f + t * d));
        }
    }
};

/// Point i of an even sequence over the unit square that starts at its centre (Roberts's R2: the plastic number).
glm::dvec2 even_point(int i) {
    return glm::fract(glm::dvec2(0.5) + static_cast<double>(i) * glm::dvec2(0.7548776662466927, 0.5698402909980532));
}

glm::dvec3 direction_of(const glm::dvec2& square) {
    const double z = 1.0 - 2.0 * square.x, r = std::sqrt(1.0 - z * z), phi = 2.0 * std::numbers::pi * square.y;
    return {r * std::cos(phi), r * std::sin(phi), z};
}

const Shape& most_frequent(const std::map<const Shape*, int>& counts) {
    const auto most = std::max_element(counts.begin(), counts.end(), [](const auto& a, const auto& b) {
        return a.second != b.second ? a.second < b.second : a.first > b.first;
    });
    return *most->first;
}

}  // namespace

void check_camera(const Sensor& camera, const std::vector<Shape>& shapes,
                  const std::vector<shared::Material>& materials, bool environment) {
    // Does any part of the film see something? Nearly always the first ray does.
    std::map<const Shape*, int> hidden;
    for (int i = 0; i < kRays; ++i) {
        const glm::dvec2 film = even_point(i);
        Ray ray(camera.origin, camera.corner + film.x * camera.dx + film.y * camera.dy, camera.near_clip,
                camera.far_clip);
        const Sight sight = ray.look(shapes, materials);
        const bool nothing = sight.seen == nullptr && sight.hidden != nullptr && !environment;
        if (!nothing && !sight.dark) return;
        if (sight.hidden) ++hidden[sight.hidden];
    }
    const std::string eye = fmt::format("sensor: the camera at ({:.6g}, {:.6g}, {:.6g})", camera.origin.x,
                                        camera.origin.y, camera.origin.z);
    int hidden_rays = 0;
    for (const auto& [shape, count] : hidden) hidden_rays += count;
    if (hidden_rays == kRays) {
        const Shape& shape = most_frequent(hidden);
        fail(*camera.node,
             fmt::format("{} lies within near_clip ({:.6g}) of {} ({}) and sees nothing beyond it; a free "
                         "view was expected",
                         eye, camera.near_clip, describe(*shape.node), where(*shape.node)));
    }

    // An object fills less than half of the directions around a point outside it, and all of them inside.
    std::map<const Shape*, int> around;
    int dark_rays = 0;
    for (int i = 0; i < kRays; ++i) {
        Ray ray(camera.origin, direction_of(even_point(i)), 0.0, std::numeric_limits<double>::infinity());
        const Sight sight = ray.look(shapes, materials);
        if (!sight.dark) continue;
        ++around[sight.seen];
        ++dark_rays;
    }
    if (2 * dark_rays <= kRays) return;
    const Shape& shape = most_frequent(around);
    fail(*camera.node, fmt::format("{} is inside {} ({}): it sees only back sides, which reflect nothing; a camera "
                                   "outside of it or a twosided bsdf was expected",
                                   eye, describe(*shape.node), where(*shape.node)));
}

}  // namespace irradia::loader
