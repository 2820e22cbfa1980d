#include "irradia/CameraPath.h"

#include <algorithm>
#include <charconv>
#include <cmath>

#include "camera/lens.h"
#include "irradia/Error.h"

namespace irradia {
namespace {

constexpr double kLeastSine = 1e-6;  // between view and up: beyond, rounding would roll the picture

std::string text_of(double v) {
    char text[32];
    return std::string(text, std::to_chars(text, text + sizeof text, v).ptr);
}
std::string text_of(const glm::dvec3& v) {
    return "(" + text_of(v.x) + ", " + text_of(v.y) + ", " + text_of(v.z) + ")";
}

glm::dvec3 vector_of(const std::array<double, 3>& v) { return {v[0], v[1], v[2]}; }

/// A point that moves through `at` at the given times.
class Motion {
public:
    Motion(const CameraPath& path, std::vector<glm::dvec3> at) : path_(path), at_(std::move(at)) {}

    [[nodiscard]] glm::dvec3 operator()(double frame) const {
        const auto& keys = path_.keyframes;
        const auto after = static_cast<std::size_t>(
            std::upper_bound(keys.begin(), keys.end(), frame,
                             [](double f, const CameraKeyframe& key) { return f < key.frame; }) -
            keys.begin());
        if (after == 0) return at_.front();
        if (after == keys.size()) return at_.back();
        const std::size_t i = after - 1;
        const double h = step(i), u = (frame - keys[i].frame) / h;
        const glm::dvec3 way = at_[after] - at_[i];
        if (!path_.smooth) return at_[i] + way * u;
        const double left = 1.0 - u;  // Hermite's cubic
        return at_[i] + way * (u * u * (3.0 - 2.0 * u)) + (velocity(i) * left - velocity(after) * u) * (h * u * left);
    }

private:
    const CameraPath& path_;
    std::vector<glm::dvec3> at_;

    [[nodiscard]] double step(std::size_t i) const { return path_.keyframes[i + 1].frame - path_.keyframes[i].frame; }
    [[nodiscard]] glm::dvec3 mean_velocity(std::size_t i) const { return (at_[i + 1] - at_[i]) / step(i); }

    /// At keyframe i: of the parabola through it and its neighbours (at the ends through the next two), held back so
    /// that its part along either neighbouring way is within 0 and 3 mean velocities. Along each way the motion then
    /// never turns back (Fritsch and Carlson, SIAM J. Numer. Anal. 17(2), 1980).
    [[nodiscard]] glm::dvec3 velocity(std::size_t i) const {
        const std::size_t ways = at_.size() - 1;
        if (ways == 1) return mean_velocity(0);
        if (i == 0) return held(ahead(0, 1), {mean_velocity(0)});
        if (i == ways) return held(ahead(ways - 1, ways - 2), {mean_velocity(ways - 1)});
        const double before = step(i - 1), after = step(i);
        const glm::dvec3 in = mean_velocity(i - 1), out = mean_velocity(i);
        return held((in * after + out * before) / (before + after), {in, out});
    }
    /// The parabola's velocity at the outer end of way `first`, whose neighbour is `second`.
    [[nodiscard]] glm::dvec3 ahead(std::size_t first, std::size_t second) const {
        const glm::dvec3 change = mean_velocity(first) - mean_velocity(second);
        return mean_velocity(first) + change * (step(first) / (step(first) + step(second)));
    }
    static glm::dvec3 held(glm::dvec3 v, std::initializer_list<glm::dvec3> means) {
        for (const glm::dvec3& mean : means) {
            const double along = glm::dot(v, mean), most = 3.0 * glm::dot(mean, mean);
            if (!(along > 0.0)) return glm::dvec3(0.0);
            if (along > most) v *= most / along;
        }
        return v;
    }
};

/// What a path leaves as the scene's camera has it.
struct Film {
    glm::dvec3 dx, dy, forward;
    double aspect, tx, ty;
    double offset_x, offset_y;
    bool mirrored;
    glm::dvec3 upright{0.0};

    explicit Film(const shared::SceneInfo& info) {
        const shared::Camera& c = info.camera;
        dx = {c.dxx, c.dxy, c.dxz};
        dy = {c.dyx, c.dyy, c.dyz};
        forward = {c.forwardx, c.forwardy, c.forwardz};
        tx = 0.5 * glm::length(dx);
        ty = 0.5 * glm::length(dy);
        // Of the view, not of the pixels, which may be other than square. Rounding is not taken for such a difference.
        const double pixels = static_cast<double>(info.width) / info.height;
        aspect = std::abs(tx / ty / pixels - 1.0) < 1e-6 ? pixels : tx / ty;
        const glm::dvec3 shift = glm::dvec3(c.cornerx, c.cornery, c.cornerz) - forward + 0.5 * (dx + dy);
        const auto offset = [&](const glm::dvec3& edge) {
            const double o = glm::dot(shift, edge) / glm::dot(edge, edge);
            return std::abs(o) < 1e-6 * (1.0 + 1.0 / glm::length(edge)) ? 0.0 : o;
        };
        offset_x = offset(dx);
        offset_y = offset(dy);
        mirrored = glm::dot(glm::cross(dx, dy), forward) < 0.0;
        const glm::dvec3 up = -dy / (2.0 * ty), across = dx / (2.0 * tx);
        // Of an axis that is horizontal in the picture nobody would say that it is upright: a camera that looks steeply
        // down has its own up nearer to the ground than to the sky.
        double best = 0.0;
        for (const double least : {1e-3, 2.0}) {
            for (int k = 0; k < 3; ++k)
                if (std::abs(across[k]) < least && std::abs(up[k]) > std::abs(best)) {
                    best = up[k];
                    upright = glm::dvec3(0.0);
                    upright[k] = best < 0.0 ? -1.0 : 1.0;
                }
            if (best != 0.0) break;
        }
    }
};

void check_number(const std::string& where, double v, bool positive = false) {
    if (!std::isfinite(v) || std::abs(v) > 1e18 || (positive && !(v > 0.0)))
        throw Error(where + ": found " + text_of(v) + ", expected a " + (positive ? "positive " : "") +
                    "number of at most 1e18");
}

void check_vector(const std::string& where, const std::array<double, 3>& v) {
    for (const double x : v)
        if (!std::isfinite(x) || std::abs(x) > 1e18)
            throw Error(where + ": found " + text_of(vector_of(v)) + ", expected three numbers of at most 1e18");
}

void check_keyframe(const std::string& where, const CameraKeyframe& key) {
    check_number(where + ".frame", key.frame);
    check_vector(where + ".origin", key.origin);
    check_vector(where + ".target", key.target);
    const glm::dvec3 origin = vector_of(key.origin), target = vector_of(key.target);
    if (!(glm::length(target - origin) > 1e-9 * (glm::length(origin) + glm::length(target))))
        throw Error(where + ".target: found " + text_of(target) + ", the origin, expected another point");
    if (key.up) {
        check_vector(where + ".up", *key.up);
        const glm::dvec3 up = vector_of(*key.up);
        if (!(glm::length(up) > 0.0)) throw Error(where + ".up: found " + text_of(up) + ", expected a direction");
        if (!look_along(origin, glm::normalize(target - origin), glm::normalize(up), kLeastSine))
            throw Error(where + ".up: found " + text_of(up) + ", parallel to the view, expected another direction");
    }
    if (key.fov && !(*key.fov > 0.0 && *key.fov < 180.0))
        throw Error(where + ".fov: found " + text_of(*key.fov) + ", expected degrees above 0 and below 180");
    if (key.focus_distance) check_number(where + ".focus_distance", *key.focus_distance, true);
}

}  // namespace

void check_camera_path(const CameraPath& path) {
    const std::string begin = path.source.empty() ? "camera path" : path.source;
    if (!path.fov_axis.empty() && !fov_axis_of(path.fov_axis))
        throw Error(begin + ": fov_axis: found '" + path.fov_axis + "', expected x, y, diagonal, smaller or larger");
    if (path.keyframes.empty()) throw Error(begin + ": keyframes: found none, expected at least one");
    for (std::size_t i = 0; i < path.keyframes.size(); ++i) {
        const std::string where = begin + ": keyframes[" + std::to_string(i) + "]";
        check_keyframe(where, path.keyframes[i]);
        if (i > 0 && !(path.keyframes[i].frame > path.keyframes[i - 1].frame))
            throw Error(where + ".frame: found " + text_of(path.keyframes[i].frame) + " after " +
                        text_of(path.keyframes[i - 1].frame) + ", expected a larger number: frames increase");
    }
}

shared::Camera camera_at(const CameraPath& path, const Scene& scene, double frame) {
    check_camera_path(path);
    const std::string where = (path.source.empty() ? "camera path" : path.source) + ": frame " + text_of(frame);
    if (!std::isfinite(frame)) throw Error(where + ": expected a finite number");
    const shared::Camera& own = scene.info.camera;
    const Film film(scene.info);
    const auto& keys = path.keyframes;
    const auto at = [&](const auto& value) {
        std::vector<glm::dvec3> points;
        for (const CameraKeyframe& key : keys) points.push_back(value(key));
        return Motion(path, std::move(points))(frame);
    };

    const glm::dvec3 origin = at([](const CameraKeyframe& key) { return vector_of(key.origin); });
    const glm::dvec3 target = at([](const CameraKeyframe& key) { return vector_of(key.target); });
    const glm::dvec3 up =
        at([&](const CameraKeyframe& key) { return key.up ? glm::normalize(vector_of(*key.up)) : film.upright; });
    if (!(glm::length(target - origin) > 1e-9 * (glm::length(origin) + glm::length(target))))
        throw Error(where + ": origin and target meet at " + text_of(origin) + ", expected them apart");
    auto to_world = glm::length(up) > kLeastSine ? look_along(origin, glm::normalize(target - origin), up, kLeastSine)
                                                 : std::nullopt;
    if (!to_world)
        throw Error(where + ": up is " + text_of(up) + ", zero or parallel to the view along " +
                    text_of(glm::normalize(target - origin)) + ", expected another direction: give keyframes an 'up'");
    if (film.mirrored) (*to_world)[0] = -(*to_world)[0];

    double tx = film.tx, ty = film.ty;
    if (std::any_of(keys.begin(), keys.end(), [](const CameraKeyframe& key) { return key.fov.has_value(); })) {
        const std::uint32_t axis = path.fov_axis.empty() ? scene.info.fov_axis : *fov_axis_of(path.fov_axis);
        if (axis == IR_FOV_AXIS_UNKNOWN)
            throw Error((path.source.empty() ? "camera path" : path.source) + ": fov: the scene " + scene.source +
                        " doesn't say along which axis, expected \"fov_axis\" beside \"keyframes\"");
        const double of_scene = glm::degrees(2.0 * std::atan(tan_half_fov_along(axis, film.tx, film.aspect)));
        const double fov =
            at([&](const CameraKeyframe& key) { return glm::dvec3(key.fov.value_or(of_scene), 0.0, 0.0); }).x;
        tx = tan_half_fov_x(std::tan(0.5 * glm::radians(fov)), axis, film.aspect);
        ty = tx / film.aspect;
    }
    CameraFrame camera;
    set_view(camera, *to_world, tx, ty, film.offset_x, film.offset_y);
    if (own.aperture_radius > 0.0f)
        camera.focus_distance =
            at([&](const CameraKeyframe& key) {
                return glm::dvec3(key.focus_distance.value_or(double{own.focus_distance}), 0.0, 0.0);
            }).x;
    shared::Camera result = rounded(camera, vector_of(scene.centre), scene.info);
    result.near_clip = own.near_clip;
    result.far_clip = own.far_clip;
    result.aperture_radius = own.aperture_radius;
    if (!(own.aperture_radius > 0.0f)) result.focus_distance = own.focus_distance;
    if (!(std::isfinite(result.pixel_size) && result.pixel_size > 0.0f && std::isfinite(result.ox) &&
          std::isfinite(result.oy) && std::isfinite(result.oz)))
        throw Error(where + ": the camera's place or field of view is beyond single precision");
    return result;
}

}  // namespace irradia
