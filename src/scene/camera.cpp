#include <fmt/format.h>

#include <cmath>

#include "scene/build.h"

namespace irradia::loader {
namespace {

void read_rfilter(const Context& context, const Document& document, const Node* node, shared::SceneInfo& info) {
    // A film without a filter: gaussian of standard deviation .5, Mitsuba 3's default.
    std::string type = node ? node->get("type") : "gaussian";
    double stddev = 0.5, radius = 1.0;
    if (node) {
        Properties p(context, document, *node);
        if (type == "gaussian") {
            stddev = p.number("stddev", 0.5);
            if (!(stddev > 0.0))
                fail(*node, fmt::format("rfilter: stddev is {}, a positive number was expected", stddev));
            p.finish();
        } else if (type == "tent") {
            radius = p.number("radius", 1.0);
            if (!(radius > 0.0))
                fail(*node, fmt::format("rfilter: radius is {}, a positive number was expected", radius));
            p.finish();
        } else if (type == "box") {
            p.finish();
        } else {
            context.unsupported(*node, "box, tent, gaussian", "gaussian with stddev 0.5");
            type = "gaussian";
        }
    }
    info.rfilter_stddev = 0.0f;
    if (type == "box") {
        info.rfilter = IR_RFILTER_BOX;
        info.rfilter_radius = 0.5f;
    } else if (type == "tent") {
        info.rfilter = IR_RFILTER_TENT;
        info.rfilter_radius = static_cast<float>(radius);
    } else {
        info.rfilter = IR_RFILTER_GAUSSIAN;
        info.rfilter_stddev = static_cast<float>(stddev);
        info.rfilter_radius = static_cast<float>(4.0 * stddev);
    }
}

std::uint32_t film_size(const Node& film, const char* name, long long value) {
    if (value < 1 || value > 1 << 16)
        fail(film, fmt::format("film: {} is {}, a number of pixels in [1, 65536] was expected", name, value));
    return static_cast<std::uint32_t>(value);
}

void read_film(const Context& context, const Document& document, const Node* film, shared::SceneInfo& info) {
    const auto& options = context.options;
    long long width = 768, height = 576;  // Mitsuba's defaults
    const Node* rfilter = nullptr;
    if (film) {
        if (film->get("type") != "hdrfilm") context.unsupported(*film, "hdrfilm", "hdrfilm of the same size");
        Properties p(context, document, *film);
        width = p.integer("width", width);
        height = p.integer("height", height);
        film_size(*film, "width", width);
        film_size(*film, "height", height);
        p.ignore({"file_format", "pixel_format", "component_format", "sample_border", "compensate"});
        if (p.integer("crop_offset_x", 0) != 0 || p.integer("crop_offset_y", 0) != 0 ||
            p.integer("crop_width", width) != width || p.integer("crop_height", height) != height)
            context.problem(*film, "film: a crop window is not supported", "the whole film is rendered");
        const auto filters = p.objects("rfilter");
        if (filters.size() > 1) fail(*filters[1], "film: more than one rfilter");
        if (!filters.empty()) rfilter = filters[0];
        p.finish();
    }
    if (options.width < 0)
        throw Error(fmt::format("width: {} was given, a positive number of pixels was expected", options.width));
    if (options.height < 0)
        throw Error(fmt::format("height: {} was given, a positive number of pixels was expected", options.height));
    if (options.width) width = options.width;
    if (options.height) height = options.height;
    const Node& at = film ? *film : document.root;
    info.width = film_size(at, "width", width);
    info.height = film_size(at, "height", height);
    if (width * height >= 1LL << 31)
        fail(at,
             fmt::format("film: {} x {} are {} pixels, fewer than 2^31 were expected", width, height, width * height));
    read_rfilter(context, document, rfilter, info);
}

/// tan of half the horizontal field of view. `aspect` = width / height.
double read_fov(Properties& p, double aspect, shared::SceneInfo& info) {
    const Node* fov_node = p.property("fov");
    const Node* focal_node = p.property("focal_length");
    const std::string given_axis = p.text("fov_axis", "x");
    if (fov_node && focal_node) fail(*focal_node, "sensor: give either fov or focal_length, not both");
    const auto axis = fov_axis_of(given_axis);
    info.fov_axis = axis.value_or(IR_FOV_AXIS_X);
    if (!fov_node) {
        // Without a field of view: 50 mm on 35 mm film (24 x 36 mm), along the diagonal.
        std::string focal = p.text("focal_length", "50mm");
        if (focal.size() > 2 && focal.substr(focal.size() - 2) == "mm") focal.resize(focal.size() - 2);
        const double millimetres = parse_number(focal_node ? *focal_node : p.node(), focal);
        if (!(millimetres > 0.0))
            fail(*focal_node,
                 fmt::format("sensor: focal_length is {} mm, a positive number was expected", millimetres));
        const double t = std::sqrt(36.0 * 36.0 + 24.0 * 24.0) / (2.0 * millimetres);
        return tan_half_fov_x(t, IR_FOV_AXIS_DIAGONAL, aspect);
    }
    const double fov = p.number("fov");
    if (!(fov > 0.0 && fov < 180.0))
        fail(*fov_node, fmt::format("sensor: fov is {} degrees, a number in (0, 180) was expected", fov));
    if (!axis)
        fail(*p.property("fov_axis"),
             fmt::format("sensor: fov_axis is '{}'; x, y, diagonal, smaller or larger was expected", given_axis));
    return tan_half_fov_x(std::tan(0.5 * glm::radians(fov)), *axis, aspect);
}

}  // namespace

Sensor read_sensor(const Context& context, const Document& document, Scene& scene) {
    const Node* sensor = nullptr;
    for (const auto& child : document.root.children) {
        if (child.tag != "sensor") continue;
        if (sensor)
            context.warn(child, fmt::format("more than one sensor; the first one ({}) is used", where(*sensor)));
        else
            sensor = &child;
    }
    if (!sensor) throw Error(fmt::format("{}: the scene has no sensor", document.files.front()));
    const std::string type = sensor->get("type");
    const bool lens = type == "thinlens", known = type == "perspective" || lens;
    if (!known) context.unsupported(*sensor, "perspective, thinlens", "perspective with the same parameters");

    Properties p(context, document, *sensor);
    const auto films = p.objects("film");
    if (films.size() > 1) fail(*films[1], "sensor: more than one film");
    read_film(context, document, films.empty() ? nullptr : films[0], scene.info);

    for (const Node* sampler : p.objects("sampler")) {
        Properties s(context, document, *sampler);
        const long long count = s.integer("sample_count", 4);
        if (count < 1 || count > 0xffffffffLL)
            fail(*sampler, fmt::format("sampler: sample_count is {}, a positive number was expected", count));
        scene.sample_count = static_cast<std::uint32_t>(count);
        s.ignore({"seed", "jitter", "reuse_samples"});
        s.finish();
    }

    const double aspect = static_cast<double>(scene.info.width) / scene.info.height;
    const double tx = read_fov(p, aspect, scene.info), ty = tx / aspect;
    Sensor camera;
    camera.node = sensor;
    camera.near_clip = p.number("near_clip", 0.01);
    camera.far_clip = p.number("far_clip", 10000.0);
    if (!(camera.near_clip >= 0.0 && camera.far_clip > camera.near_clip))
        fail(*sensor, fmt::format("sensor: near_clip {} and far_clip {}: 0 <= near_clip < far_clip was expected",
                                  camera.near_clip, camera.far_clip));
    const double offset_x = p.number("principal_point_offset_x", 0.0),
                 offset_y = p.number("principal_point_offset_y", 0.0);
    const glm::dmat4 to_world = p.transform("to_world").value_or(glm::dmat4(1.0));
    p.ignore({"shutter_open", "shutter_close"});
    if (lens) {
        camera.aperture_radius = p.number("aperture_radius");
        camera.focus_distance = p.number("focus_distance", camera.far_clip);
        if (!(camera.aperture_radius >= 0.0))
            fail(*p.property("aperture_radius"),
                 fmt::format("sensor: aperture_radius is {}, a number of at least 0 was expected (0: a pinhole)",
                             camera.aperture_radius));
        if (!(camera.focus_distance > 0.0))
            fail(*p.property("focus_distance"),
                 fmt::format("sensor: focus_distance is {}, a positive number was expected", camera.focus_distance));
    }
    if (!known) p.ignore({"aperture_radius", "focus_distance"});
    p.finish();

    const glm::dmat3 linear(to_world);
    if (!(std::abs(glm::determinant(linear)) > 0.0)) fail(*sensor, "sensor: to_world is singular");
    set_view(camera, to_world, tx, ty, offset_x, offset_y);
    return camera;
}

}  // namespace irradia::loader
