// Cameras in double precision, before they are rounded for the device: for the loader and for camera paths.
#pragma once
#include <cstdint>
#include <glm/glm.hpp>
#include <optional>
#include <string>

#include "irradia/shared/scene_types.h"

namespace irradia {

/// The camera in world space: direction through film (x, y) = corner + x dx + y dy, unit depth along `forward`.
struct CameraFrame {
    glm::dvec3 origin{0.0}, corner{0.0}, dx{0.0}, dy{0.0}, forward{0.0};
    double near_clip = 0.01, far_clip = 1e4;
    double aperture_radius = 0.0, focus_distance = 0.0;  // thin lens; radius 0: pinhole
};

/// IR_FOV_AXIS_* of "x", "y", "diagonal", "smaller" or "larger".
std::optional<std::uint32_t> fov_axis_of(const std::string& name);
/// tan of half the horizontal field of view, from `t`, the one along `axis`. `aspect` = width / height.
double tan_half_fov_x(double t, std::uint32_t axis, double aspect);
/// The other way round.
double tan_half_fov_along(std::uint32_t axis, double tx, double aspect);

/// Mitsuba's lookat: x to the left of the picture, y up, z along the unit vector `z`. No value if the sine of the angle
/// between z and `up` is at most `least_sine`, or up is zero.
std::optional<glm::dmat4> look_along(const glm::dvec3& origin, const glm::dvec3& z, const glm::dvec3& up,
                                     double least_sine = 1e-12);
/// Sets origin and film from a camera-to-world transform as Mitsuba has it, tangents of half the fields of view along x
/// and y, and the principal point's offset in film widths and heights.
void set_view(CameraFrame& camera, const glm::dmat4& to_world, double tx, double ty, double offset_x, double offset_y);
/// For the device: less `centre`, in single precision; `film` gives the size in pixels.
shared::Camera rounded(const CameraFrame& camera, const glm::dvec3& centre, const shared::SceneInfo& film);

}  // namespace irradia
