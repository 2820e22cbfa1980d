#include "camera/lens.h"

#include <cmath>

namespace irradia {
namespace {

/// Smaller and larger resolved: x, y or diagonal.
std::uint32_t plain_axis(std::uint32_t axis, double aspect) {
    if (axis == IR_FOV_AXIS_SMALLER) return aspect > 1.0 ? IR_FOV_AXIS_Y : IR_FOV_AXIS_X;
    if (axis == IR_FOV_AXIS_LARGER) return aspect > 1.0 ? IR_FOV_AXIS_X : IR_FOV_AXIS_Y;
    return axis;
}

void set3(float& x, float& y, float& z, const glm::dvec3& v) {
    x = static_cast<float>(v.x);
    y = static_cast<float>(v.y);
    z = static_cast<float>(v.z);
}

}  // namespace

std::optional<std::uint32_t> fov_axis_of(const std::string& name) {
    if (name == "x") return IR_FOV_AXIS_X;
    if (name == "y") return IR_FOV_AXIS_Y;
    if (name == "diagonal") return IR_FOV_AXIS_DIAGONAL;
    if (name == "smaller") return IR_FOV_AXIS_SMALLER;
    if (name == "larger") return IR_FOV_AXIS_LARGER;
    return std::nullopt;
}

double tan_half_fov_x(double t, std::uint32_t axis, double aspect) {
    axis = plain_axis(axis, aspect);
    if (axis == IR_FOV_AXIS_Y) return t * aspect;
    if (axis == IR_FOV_AXIS_DIAGONAL) return t / std::sqrt(1.0 + 1.0 / (aspect * aspect));
    return t;
}

double tan_half_fov_along(std::uint32_t axis, double tx, double aspect) {
    axis = plain_axis(axis, aspect);
    if (axis == IR_FOV_AXIS_Y) return tx / aspect;
    if (axis == IR_FOV_AXIS_DIAGONAL) return tx * std::sqrt(1.0 + 1.0 / (aspect * aspect));
    return tx;
}

std::optional<glm::dmat4> look_along(const glm::dvec3& origin, const glm::dvec3& z, const glm::dvec3& up,
                                     double least_sine) {
    const glm::dvec3 left = glm::cross(up, z);
    if (glm::length(left) <= least_sine * glm::length(up) || glm::length(up) == 0.0) return std::nullopt;
    const glm::dvec3 x = glm::normalize(left), y = glm::cross(z, x);
    return glm::dmat4(glm::dvec4(x, 0.0), glm::dvec4(y, 0.0), glm::dvec4(z, 0.0), glm::dvec4(origin, 1.0));
}

void set_view(CameraFrame& camera, const glm::dmat4& to_world, double tx, double ty, double offset_x, double offset_y) {
    // Mitsuba's camera looks along +z; +x is to the left of the picture, +y up.
    const glm::dmat3 linear(to_world);
    const double scale = 1.0 / glm::length(linear[2]);
    camera.origin = glm::dvec3(to_world[3]);
    camera.forward = linear[2] * scale;
    camera.dx = linear[0] * (-2.0 * tx * scale);
    camera.dy = linear[1] * (-2.0 * ty * scale);
    camera.corner = camera.forward + (offset_x - 0.5) * camera.dx + (offset_y - 0.5) * camera.dy;
}

shared::Camera rounded(const CameraFrame& camera, const glm::dvec3& centre, const shared::SceneInfo& film) {
    shared::Camera c{};
    set3(c.ox, c.oy, c.oz, camera.origin - centre);
    set3(c.cornerx, c.cornery, c.cornerz, camera.corner);
    set3(c.dxx, c.dxy, c.dxz, camera.dx);
    set3(c.dyx, c.dyy, c.dyz, camera.dy);
    set3(c.forwardx, c.forwardy, c.forwardz, camera.forward);
    c.near_clip = static_cast<float>(camera.near_clip);
    c.far_clip = static_cast<float>(camera.far_clip);
    c.aperture_radius = static_cast<float>(camera.aperture_radius);
    c.focus_distance = static_cast<float>(camera.focus_distance);
    c.pixel_size =
        static_cast<float>(std::sqrt(glm::length(camera.dx) / film.width * glm::length(camera.dy) / film.height));
    return c;
}

}  // namespace irradia
