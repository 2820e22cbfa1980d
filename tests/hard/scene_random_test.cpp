// Random scenes: irradiance of records made by the device against the same expectation by a ray tracer in double.
//
// A closed room with boxes, turned by any angle, and spheres in it, all of random reflectance, under a point light and,
// in half of the scenes, a lamp. A record's irradiance E is that of light which was reflected once: with no more than
// three path edges its expectation is the integral over the hemisphere of cos / pi x reflectance x direct irradiance,
// of which the host takes independent samples, stratified alike. Both are unbiased, so z = (E_device - E_host) /
// standard error has mean 0 and variance 1, as far as means of 32 hemispheres are normal: |z| > 5 comes once in 10^5
// (Student's t of 31 degrees of freedom on either side), and the root mean square of n of them is 1.03 (that t's)
// within 4 / sqrt(2n). Both have hemispheres of one size: E is skewed where a light is near, and of two alike the skews
// cancel in z.
#include <random>

#include "../cl/formulas.h"
#include "render/hemispheres.h"
#include "render/run.h"
#include "scene_fixture.h"

namespace irradia::test {
namespace {
using host::real3;

constexpr double kPi = 3.14159265358979323846;
constexpr int kScenes = 200, kPoints = 3, kHemispheres = 32, kRings = 8, kSectors = 32;

struct Box {  // turned by `angle` degrees about y
    real3 centre, half;
    double angle, reflectance;
    double c = 1, s = 0;  // of the angle
};
struct Sphere {
    real3 centre;
    double radius, reflectance;
};
struct RandomScene {
    std::vector<Box> boxes;  // the first is the room
    std::vector<Sphere> spheres;
    real3 light;
    double intensity = 1;
    bool lamp =
        false;  // a square of edge 2 lamp_half below the ceiling, radiance lamp_radiance, which reflects nothing
    real3 lamp_centre{};
    double lamp_half = 0, lamp_radiance = 0;
};

struct Found {
    double t = 1e30, reflectance = 0;
    real3 normal{};
};

real3 into(const Box& b, const real3& v) { return {b.c * v.x - b.s * v.z, v.y, b.s * v.x + b.c * v.z}; }
real3 out_of(const Box& b, const real3& v) { return {b.c * v.x + b.s * v.z, v.y, -b.s * v.x + b.c * v.z}; }

// The first surface at t > 1e-9.
Found trace(const RandomScene& scene, const real3& o, const real3& d) {
    Found best;
    for (const Box& b : scene.boxes) {
        const real3 p = into(b, o - b.centre), w = into(b, d);
        const double origin[3] = {p.x, p.y, p.z}, direction[3] = {w.x, w.y, w.z},
                     half[3] = {b.half.x, b.half.y, b.half.z};
        double enter = -1e30, leave = 1e30;
        int enter_axis = 0, leave_axis = 0;
        for (int k = 0; k < 3; ++k) {
            const double r = 1 / direction[k], near = (-std::copysign(half[k], direction[k]) - origin[k]) * r,
                         far = (std::copysign(half[k], direction[k]) - origin[k]) * r;
            if (near > enter) enter = near, enter_axis = k;
            if (far < leave) leave = far, leave_axis = k;
        }
        if (enter > leave) continue;
        const bool outside = enter > 1e-9;
        const double t = outside ? enter : leave;
        if (t <= 1e-9 || t >= best.t) continue;
        const int axis = outside ? enter_axis : leave_axis;
        const double sign = -std::copysign(1, direction[axis]);  // both sides are walls: towards the ray
        best.t = t;
        best.reflectance = b.reflectance;
        best.normal = out_of(b, {axis == 0 ? sign : 0, axis == 1 ? sign : 0, axis == 2 ? sign : 0});
    }
    for (const Sphere& s : scene.spheres) {
        const real3 f = o - s.centre;
        const double b = -dot(f, d);
        const real3 l = f + b * d;
        const double root = s.radius * s.radius - dot(l, l);
        if (root < 0) continue;
        for (const double t : {b - std::sqrt(root), b + std::sqrt(root)}) {
            if (t <= 1e-9 || t >= best.t) continue;
            best.t = t;
            best.reflectance = s.reflectance;
            const real3 n = (o + t * d - s.centre) * (1 / s.radius);
            best.normal = dot(n, d) < 0 ? n : -n;
        }
    }
    if (scene.lamp) {
        const double t = (scene.lamp_centre.y - o.y) / d.y;
        const real3 p = o + t * d - scene.lamp_centre;
        if (t > 1e-9 && t < best.t && std::abs(p.x) <= scene.lamp_half && std::abs(p.z) <= scene.lamp_half) {
            best.t = t;
            best.reflectance = 0;
            best.normal = {0, d.y > 0 ? -1.0 : 1.0, 0};
        }
    }
    return best;
}

// One sample of the irradiance by both lights at p.
template <class Uniform>
double direct(const RandomScene& scene, const real3& p, const real3& n, Uniform& u) {
    const auto sees = [&](const real3& to) {
        const double l = length(to);
        return trace(scene, p + 1e-7 * n, to * (1 / l)).t > l * (1 - 1e-6);
    };
    double sum = 0;
    const real3 to = scene.light - p;
    if (dot(to, n) > 0 && sees(to)) sum += scene.intensity * dot(to, n) / std::pow(dot(to, to), 1.5);
    if (scene.lamp) {
        const real3 w =
            scene.lamp_centre + real3{scene.lamp_half * (2 * u() - 1), -1e-9, scene.lamp_half * (2 * u() - 1)} - p;
        const double area = 4 * scene.lamp_half * scene.lamp_half, square = dot(w, w);
        if (dot(w, n) > 0 && w.y > 0 && sees(w))
            sum += scene.lamp_radiance * area * dot(w, n) * w.y / (square * square);
    }
    return sum;
}

// One stratified hemisphere's estimate.
template <class Uniform>
double irradiance(const RandomScene& scene, const real3& p, const real3& n, Uniform& u) {
    constexpr int m = kRings, k = kSectors;
    const host::Frame frame = host::make_frame(n);
    double sum = 0;
    for (int i = 0; i < m * k; ++i) {
        const double s2 = (i / k + u()) / m, phi = 2 * kPi * (i % k + u()) / k, s = std::sqrt(s2);
        const real3 d = (s * std::cos(phi)) * frame.t + (s * std::sin(phi)) * frame.b + std::sqrt(1 - s2) * n;
        const Found f = trace(scene, p + 1e-7 * n, d);
        if (f.reflectance > 0) sum += f.reflectance / kPi * direct(scene, p + f.t * d, f.normal, u);
    }
    return kPi * sum / (m * k);
}

RandomScene random_scene(std::mt19937& random) {
    std::uniform_real_distribution<double> unit(0, 1);
    const auto in = [&](double lo, double hi) { return lo + (hi - lo) * unit(random); };
    RandomScene s;
    const real3 room{in(1, 3), in(1, 2), in(1, 3)};
    s.boxes.push_back({{0, 0, 0}, room, 0, in(0.2, 0.9)});
    const auto place = [&] { return real3{room.x * in(-0.7, 0.7), room.y * in(-0.9, 0.4), room.z * in(-0.7, 0.7)}; };
    for (int i = static_cast<int>(in(1, 5)); i-- > 0;) {
        Box b{place(), {in(0.05, 0.5), in(0.05, 0.5), in(0.05, 0.5)}, in(0, 90), in(0.05, 0.95)};
        b.c = std::cos(b.angle * kPi / 180), b.s = std::sin(b.angle * kPi / 180);
        s.boxes.push_back(b);
    }
    for (int i = static_cast<int>(in(1, 5)); i-- > 0;) s.spheres.push_back({place(), in(0.05, 0.5), in(0.05, 0.95)});
    s.light = {room.x * in(-0.5, 0.5), room.y * 0.6, room.z * in(-0.5, 0.5)};
    s.intensity = in(0.5, 5);
    s.lamp = unit(random) < 0.5;
    s.lamp_half = in(0.1, 0.4);
    s.lamp_centre = {room.x * in(-0.5, 0.5), room.y * 0.97, room.z * in(-0.5, 0.5)};
    s.lamp_radiance = in(1, 10);
    return s;
}

std::string xml_of(const RandomScene& s) {
    const auto triple = [](const real3& v) {
        return "x=\"" + text(v.x) + "\" y=\"" + text(v.y) + "\" z=\"" + text(v.z) + "\"/>";
    };
    std::string xml = camera(16, 16, "0.1, 0.2, 0.3", "0, 0, -1", 60);
    for (const Box& b : s.boxes)
        xml += shape("cube",
                     "<scale " + triple(b.half) + "<rotate y=\"1\" angle=\"" + text(b.angle) + "\"/><translate " +
                         triple(b.centre),
                     grey(b.reflectance));
    for (const Sphere& b : s.spheres)
        xml += shape("sphere", "<scale value=\"" + text(b.radius) + "\"/><translate " + triple(b.centre),
                     grey(b.reflectance));
    xml += "<emitter type=\"point\"><point name=\"position\" " + triple(s.light) + "<rgb name=\"intensity\" value=\"" +
           text(s.intensity) + "\"/></emitter>";
    if (s.lamp)
        xml += shape("rectangle",
                     "<scale value=\"" + text(s.lamp_half) + R"("/><rotate x="1" angle="90"/><translate )" +
                         triple(s.lamp_centre),
                     R"(<bsdf type="diffuse"><rgb name="reflectance" value="0"/></bsdf>
                        <emitter type="area"><rgb name="radiance" value=")" +
                         text(s.lamp_radiance) + R"("/></emitter>)");
    return scene_text(xml);
}

struct Place {
    real3 p, n;
    double t;
};

// Irradiance of kHemispheres records at each place, by the device.
std::vector<float> records_at(const Scene& scene, const std::vector<Place>& places, const std::string& traversal) {
    Device& d = device(traversal);
    RenderSettings settings;
    settings.max_depth = 3;
    settings.hemisphere_m = kRings;
    settings.hemisphere_n = kSectors;
    const ProgressCallback none;
    Run run(scene, d, settings, none);
    HemisphereSampler sampler(run, Hemispheres::irradiance_records);
    const IrradianceGrid grid(run);
    std::vector<shared::ShadingPoint> points;
    std::vector<std::uint32_t> stack;
    for (const Place& place : places)
        for (int i = 0; i < kHemispheres; ++i) {
            shared::ShadingPoint q{};
            q.px = static_cast<float>(place.p.x - scene.centre[0]);
            q.py = static_cast<float>(place.p.y - scene.centre[1]);
            q.pz = static_cast<float>(place.p.z - scene.centre[2]);
            q.nx = q.gx = static_cast<float>(place.n.x);
            q.ny = q.gy = static_cast<float>(place.n.y);
            q.nz = q.gz = static_cast<float>(place.n.z);
            q.state = IR_POINT_MISS;
            q.footprint = 0.01f;
            q.offset = 4e-6f * static_cast<float>(
                                   std::max({place.t, std::abs(place.p.x), std::abs(place.p.y), std::abs(place.p.z)}));
            q.pixel = static_cast<std::uint32_t>(points.size());
            stack.push_back(q.pixel);
            points.push_back(q);
        }
    const Buffer on_device = d.upload(points), indices = d.upload(stack);
    const Buffer keys = d.allocate(points.size() * sizeof(shared::RecordKey)),
                 values = d.allocate(points.size() * sizeof(shared::RecordValue));
    sampler.sample(on_device, indices, points.size(), grid, keys, values, 0, 0);
    std::vector<shared::RecordValue> records(points.size());
    std::vector<shared::RecordKey> record_keys(points.size());
    d.read(values, records.data(), records.size() * sizeof records[0]);
    d.read(keys, record_keys.data(), record_keys.size() * sizeof record_keys[0]);
    std::vector<float> e;
    for (std::size_t i = 0; i < records.size(); ++i) {
        for (const float x : records[i].translation) EXPECT_TRUE(std::isfinite(x));
        for (const float x : records[i].rotation) EXPECT_TRUE(std::isfinite(x));
        EXPECT_TRUE(record_keys[i].support1 > 0 && record_keys[i].support2 >= record_keys[i].support1 &&
                    std::isfinite(record_keys[i].support2));
        e.push_back(records[i].e[1]);
    }
    return e;
}

struct Estimate {
    double mean = 0, square = 0;  // square: of the mean's standard error
};
template <class Values>
Estimate estimate(const Values& values) {
    Estimate e;
    const double n = static_cast<double>(values.size());
    for (const auto x : values) e.mean += static_cast<double>(x) / n;
    for (const auto x : values) e.square += std::pow(static_cast<double>(x) - e.mean, 2) / (n * (n - 1));
    return e;
}

TEST(RandomScenes, IrradianceIsThatOfDoublePrecision) {
    std::mt19937 random(2026);
    std::uniform_real_distribution<double> unit(0, 1);
    const auto u = [&] { return unit(random); };
    double worst = 0, squares = 0, sum = 0;
    int compared = 0, dark = 0;
    std::size_t bad = 0;
    for (int number = 0; number < kScenes; ++number) {
        const RandomScene r = random_scene(random);
        const Scene scene = load_text(xml_of(r));
        std::vector<Place> places;
        while (places.size() < kPoints) {
            std::normal_distribution<double> g;
            const real3 o{r.boxes[0].half.x * (2 * u() - 1), r.boxes[0].half.y * (2 * u() - 1),
                          r.boxes[0].half.z * (2 * u() - 1)};
            const real3 d = normalize(real3{g(random), g(random), g(random)});
            const Found f = trace(r, o, d);
            if (f.reflectance > 0) places.push_back({o + f.t * d, f.normal, f.t});
        }
        const std::vector<float> e = records_at(scene, places, number % 2 ? "gpu" : "cpu");
        for (std::size_t i = 0; i < kPoints; ++i) {
            const std::vector<float> own(e.begin() + static_cast<std::ptrdiff_t>(i * kHemispheres),
                                         e.begin() + static_cast<std::ptrdiff_t>((i + 1) * kHemispheres));
            for (const float x : own) bad += !std::isfinite(x) || x < 0;
            std::vector<double> theirs;
            for (int k = 0; k < kHemispheres; ++k) theirs.push_back(irradiance(r, places[i].p, places[i].n, u));
            const Estimate a = estimate(own), b = estimate(theirs);
            if (b.mean == 0) {  // within a box or a sphere, where no light comes
                ++dark;
                EXPECT_EQ(a.mean, 0) << "scene " << number << " point " << i;
                continue;
            }
            const double z = (a.mean - b.mean) / std::sqrt(a.square + b.square + std::pow(1e-6 * b.mean, 2));
            EXPECT_LE(std::abs(z), 5) << "scene " << number << " point " << i << ": " << a.mean << " +- "
                                      << std::sqrt(a.square) << ", in double " << b.mean << " +- "
                                      << std::sqrt(b.square);
            worst = std::max(worst, std::abs(z));
            squares += z * z;
            sum += z;
            ++compared;
        }
    }
    const double rms = std::sqrt(squares / compared), mean = sum / compared;
    EXPECT_EQ(bad, 0u);
    EXPECT_GT(compared, kScenes * kPoints * 8 / 10);
    EXPECT_NEAR(rms, 1.03, 4 / std::sqrt(2.0 * compared));
    EXPECT_LE(std::abs(mean), 4 / std::sqrt(static_cast<double>(compared)));
    hard_case(std::to_string(kScenes) + " random scenes of boxes and spheres, " + std::to_string(compared) +
                  " records, both traversals (root mean square of z " + figure(rms) + ", mean " + figure(mean) + ", " +
                  std::to_string(dark) + " more in the dark: exactly 0)",
              "double on the host", "largest |error| of E in standard errors", worst, 5);
}

}  // namespace
}  // namespace irradia::test
