// A camera that moves from frame to frame: keyframes of where it stands and what it looks at.
#pragma once
#include <array>
#include <optional>
#include <string>
#include <vector>

#include "irradia/Scene.h"

namespace irradia {

/// Where the camera is at one frame, in the scene file's world.
struct CameraKeyframe {
    double frame = 0.0;
    std::array<double, 3> origin{}, target{};
    /// No value: the axis of the world, one of +-x, +-y, +-z, that stands upright in the picture of the scene's own camera.
    std::optional<std::array<double, 3>> up;
    std::optional<double> fov;             ///< degrees, in (0, 180); no value: the scene's
    std::optional<double> focus_distance;  ///< of a thin lens, world units; no value: the scene's
};

struct CameraPath {
    std::string source;  ///< file it was read from, for messages
    /// Smooth: piecewise cubic, with a continuous velocity in all that keyframes give. It passes through every keyframe,
    /// keeps a straight uniform motion as it is, and on its way between two keyframes never turns back; where the
    /// keyframes themselves turn back, or two in a row are alike, it comes to rest. Otherwise straight from one to the next.
    bool smooth = true;
    std::string fov_axis;  ///< of all fields of view: x, y, diagonal, smaller or larger; empty: the scene's
    std::vector<CameraKeyframe> keyframes;  ///< at least one; frames strictly increase
};

/// Reads a camera path, JSON:
///     {"interpolation": "smooth", "fov_axis": "x", "keyframes": [
///         {"frame": 1, "origin": [0, 1, 4], "target": [0, 1, 0], "up": [0, 1, 0], "fov": 45, "focus_distance": 4}, ...]}
/// where only keyframes, frame, origin and target must be. Throws Error with one line "file: field: what was found, what
/// was expected", or "file:line: ..." if it is no JSON.
CameraPath read_camera_path(const std::string& file);

/// The scene's camera, moved to where the path has it at `frame`, which may lie between keyframes: before the first and
/// after the last one the camera stands still. Film, principal point, clip distances, aperture, and a mirrored picture stay
/// the scene's. Throws Error if there is no view: the target at the camera's own place, or up along the view.
shared::Camera camera_at(const CameraPath& path, const Scene& scene, double frame);

/// Throws Error if the path is not as the comments above say. read_camera_path() and camera_at() have called it.
void check_camera_path(const CameraPath& path);

}  // namespace irradia
