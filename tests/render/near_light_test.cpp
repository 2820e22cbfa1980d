// Direct light next to lights, where sampling their area fails: every pixel against Lambert's exact formula for
// polygons (tests/cl/polygon.h), in double.
//
// Noise. A light sample adds x = solid angle * cos / pi per unit of radiance and reflectance, between 0 and the solid
// angle W over pi, with the mean E / pi. Of all such distributions the variance is at most E (W - E) / pi^2 (Bhatia and
// Davis); of `lights` equal ones, one chosen at random, the largest value is lights * max W. A BSDF sample beside it
// adds at most E^2 / 2 (Veach 1997, theorem 9.2: (1/min n - 1/sum n) E^2 above the better of both). Stratification only
// makes that smaller. Pixels are within 5 such standard deviations (2000 pixels: 1 failure in 1000 runs, were it
// normal; seeds are fixed), their mean within 4 of its own.
#include <sstream>

#include "../cl/solid_angle.h"
#include "render_fixture.h"

namespace irradia::test {
namespace {

constexpr int kSize = 16, kSamples = 64;

struct NearLight {
    std::string name, shapes;                // of the scene: a receiver (reflectance 1), a light (radiance 1)
    std::string camera;                      // lookat, by attributes
    double fov;                              // degrees
    real3 on_receiver, normal;               // the receiver's plane
    std::vector<std::vector<real3>> lights;  // the light's faces, counter-clockwise seen from where they shine
    real3 centre{};                          // or a sphere, all of it over the receiver
    double radius = 0;
};

std::string text(double x) {
    std::ostringstream s;
    s.precision(12);
    s << x;
    return s.str();
}

const std::string kWhite =
    R"(<bsdf type="twosided"><bsdf type="diffuse"><rgb name="reflectance" value="1"/></bsdf></bsdf>)";
const std::string kBlackLight = R"(<bsdf type="diffuse"><rgb name="reflectance" value="0"/></bsdf>
    <emitter type="area"><rgb name="radiance" value="1"/></emitter>)";

std::string shape(const std::string& type, const std::string& transform, const std::string& rest) {
    return "<shape type=\"" + type + "\"><transform name=\"to_world\">" + transform + "</transform>" + rest +
           "</shape>";
}
const std::string kFloor = shape("rectangle", R"(<rotate x="1" angle="-90"/>)", kWhite);  // y = 0

// A camera that looks down on the floor from a height.
std::string looks_down(double x, double z, double height) {
    return "origin=\"" + text(x) + ", " + text(height) + ", " + text(z) + "\" target=\"" + text(x) + ", 0, " + text(z) +
           R"(" up="0, 0, 1")";
}

// A light of edge 1 that looks down from height `gap`, the camera between it and the floor, below one of its edges.
NearLight quad_over_floor(double gap) {
    return {"quad, " + text(gap) + " over a floor",
            kFloor + shape("rectangle",
                           R"(<scale value="0.5"/><rotate x="1" angle="90"/><translate y=")" + text(gap) + "\"/>",
                           kBlackLight),
            looks_down(0.5, 0.1, gap / 2),
            90,
            {0, 0, 0},
            {0, 1, 0},
            {{{-0.5, gap, -0.5}, {0.5, gap, -0.5}, {0.5, gap, 0.5}, {-0.5, gap, 0.5}}}};
}

/// A triangle as a scene's shape; its file lives as long as this.
class TriangleFile {
public:
    explicit TriangleFile(const std::vector<real3>& v)
        : path_(std::filesystem::temp_directory_path() / ("irradia-near-" + std::to_string(::getpid()) + ".obj")) {
        std::ofstream file(path_);
        for (const real3 p : v) file << "v " << text(p.x) << ' ' << text(p.y) << ' ' << text(p.z) << '\n';
        file << "f 1 2 3\n";
    }
    TriangleFile(const TriangleFile&) = delete;
    TriangleFile& operator=(const TriangleFile&) = delete;
    ~TriangleFile() { std::filesystem::remove(path_); }
    [[nodiscard]] std::string shape() const {
        return R"(<shape type="obj"><string name="filename" value=")" + path_.string() +
               R"("/><boolean name="face_normals" value="true"/>)" + kBlackLight + "</shape>";
    }

private:
    std::filesystem::path path_;
};

// A cube of edge 0.4 that shines all around, `gap` over the floor; the camera sees the floor beside and a little below
// it.
NearLight cube_over_floor(double gap, bool below) {
    const double h = 0.2, lo = gap, hi = gap + 2 * h;
    return {std::string(below ? "below" : "beside") + " a cube, " + text(gap) + " over a floor",
            kFloor + shape("cube", "<scale value=\"0.2\"/><translate y=\"" + text(gap + h) + "\"/>", kBlackLight),
            below ? looks_down(0.15, 0.05, gap / 2) : looks_down(0.25, 0.1, 0.0499),
            90,
            {0, 0, 0},
            {0, 1, 0},
            {{{-h, lo, -h}, {h, lo, -h}, {h, lo, h}, {-h, lo, h}},
             {{-h, hi, -h}, {-h, hi, h}, {h, hi, h}, {h, hi, -h}},
             {{h, lo, -h}, {h, hi, -h}, {h, hi, h}, {h, lo, h}},
             {{-h, lo, -h}, {-h, lo, h}, {-h, hi, h}, {-h, hi, -h}},
             {{-h, lo, h}, {h, lo, h}, {h, hi, h}, {-h, hi, h}},
             {{-h, lo, -h}, {-h, hi, -h}, {h, hi, -h}, {h, lo, -h}}}};
}

// A wall x = 0 below a ceiling light y = 1 that touches it. The picture's upper edge is 1e-4 below the light.
const std::string kWall = shape("rectangle", R"(<rotate y="1" angle="90"/>)", kWhite);
const std::string kSeesWall = R"(origin="0.5, 0.9, 0" target="0, 0.9, 0" up="0, 1, 0")";
const double kWallFov = 2 * std::atan(0.0999 / 0.5) * 180 / kPi;

NearLight wall_below_quad() {
    return {"wall that touches a quad",
            kWall + shape("rectangle", R"(<scale value="0.5"/><rotate x="1" angle="90"/><translate x="0.5" y="1"/>)",
                          kBlackLight),
            kSeesWall,
            kWallFov,
            {0, 0, 0},
            {1, 0, 0},
            {{{0, 1, -0.5}, {1, 1, -0.5}, {1, 1, 0.5}, {0, 1, 0.5}}}};
}

Scene scene_of(const NearLight& c) {
    return load_text(R"(<scene version="3.0.0"><sensor type="perspective"><float name="fov" value=")" + text(c.fov) +
                     R"("/><float name="near_clip" value="1e-6"/><transform name="to_world"><lookat )" + c.camera +
                     R"(/></transform><film type="hdrfilm"><integer name="width" value="16"/><integer name="height"
        value="16"/><rfilter type="box"/></film></sensor>)" +
                     c.shapes + "</scene>");
}

// What a pixel's samples are distributed by: mean, and a bound of the variance.
struct Exact {
    double mean = 0, variance = 0;
};

// At film position (x, y) in [0,1]².
Exact exact_at(const Scene& scene, const NearLight& c, double x, double y, bool mis) {
    const shared::Camera& k = scene.info.camera;
    const auto vector = [](float a, float b, float d) {
        return real3{static_cast<double>(a), static_cast<double>(b), static_cast<double>(d)};
    };
    const real3 origin = vector(k.ox, k.oy, k.oz) + real3{scene.centre[0], scene.centre[1], scene.centre[2]};
    const real3 w =
        vector(k.cornerx, k.cornery, k.cornerz) + x * vector(k.dxx, k.dxy, k.dxz) + y * vector(k.dyx, k.dyy, k.dyz);
    const real3 p = origin + w * (dot(c.on_receiver - origin, c.normal) / dot(w, c.normal));
    double e = 0, largest = 0;
    for (const std::vector<real3>& face : c.lights) {
        if (dot(p - face[0], host::cross(face[1] - face[0], face[2] - face[0])) <= 0) continue;
        e += polygon_irradiance(clip_to_horizon(face, p, c.normal), p, c.normal).value;
        largest = std::max(largest, girard(face, p));
    }
    if (c.radius > 0) {  // pi cos r^2/d^2, and the solid angle of its cone
        const double d = length(c.centre - p), sine2 = c.radius * c.radius / (d * d);
        e = kPi * sine2 * dot(c.centre - p, c.normal) / d;
        largest = 2 * kPi * (1 - std::sqrt(1 - sine2));
    }
    const double most = largest * static_cast<double>(std::max<std::size_t>(c.lights.size(), 1));
    return {e / kPi, (e * std::max(most - e, 0.0) + (mis ? e * e / 2 : 0)) / (kPi * kPi)};
}

// Over a pixel: 16x16 midpoints.
Exact exact_pixel(const Scene& scene, const NearLight& c, int pixel, bool mis) {
    constexpr int n = 16;
    double mean = 0, square = 0, variance = 0;
    for (int i = 0; i < n * n; ++i) {
        const double x = (pixel % kSize + (i % n + 0.5) / n) / kSize, y = (pixel / kSize + (i / n + 0.5) / n) / kSize;
        const Exact e = exact_at(scene, c, x, y, mis);
        mean += e.mean / (n * n);
        square += e.mean * e.mean / (n * n);
        variance += e.variance / (n * n);
    }
    return {mean, variance + square - mean * mean};
}

void check(const NearLight& c, const std::string& traversal = "") {
    const Scene scene = scene_of(c);
    DeviceOptions options;
    options.traversal = traversal;
    Device device(options);
    for (const bool mis : {false, true}) {
        std::vector<Exact> exact;
        for (int i = 0; i < kSize * kSize; ++i) exact.push_back(exact_pixel(scene, c, i, mis));
        for (const Method method : {Method::irradiance, Method::path}) {
            if (method == Method::path && !mis) continue;  // path samples both ways whatever the setting
            RenderSettings s;
            s.method = method;
            s.max_depth = 2;
            s.spp = kSamples;
            s.direct_mis = mis ? DirectMis::on : DirectMis::off;
            const Image image = render(scene, device, s).image;
            double difference = 0, variance = 0, mean = 0;
            for (std::size_t i = 0; i < exact.size(); ++i) {
                const double found = static_cast<double>(image.layers[0].data[3 * i]),
                             bound = exact[i].variance / kSamples;
                EXPECT_LE(std::abs(found - exact[i].mean), 5 * std::sqrt(bound) + 1e-4 * exact[i].mean)
                    << c.name << ", "
                    << (method == Method::path ? "path"
                        : mis                  ? "both"
                                               : "light samples")
                    << ", pixel " << i << ": " << found << " for " << exact[i].mean;
                difference += found - exact[i].mean;
                variance += bound;
                mean += exact[i].mean;
            }
            EXPECT_LE(std::abs(difference), 4 * std::sqrt(variance) + 1e-4 * mean) << c.name << ", mean";
            // What the bound promises of a pixel, and of the picture: nothing hides behind noise.
            EXPECT_LE(std::sqrt(variance / static_cast<double>(exact.size())),
                      0.5 * mean / static_cast<double>(exact.size()))
                << c.name;
        }
    }
}

TEST(NearLight, QuadOverAFloor) {
    for (const double gap : {0.1, 0.01, 1e-3, 1e-4}) check(quad_over_floor(gap));
    check(quad_over_floor(1e-3), "gpu");
}

TEST(NearLight, TriangleOverAFloor) {
    for (const double gap : {0.1, 0.01, 1e-3, 1e-4}) {
        const std::vector<real3> v{{-0.5, gap, -0.5}, {0.5, gap, -0.5}, {0.2, gap, 0.5}};
        const TriangleFile file(v);
        check({"triangle, " + text(gap) + " over a floor",
               kFloor + file.shape(),
               looks_down(0.1, -0.1, gap / 2),
               90,
               {0, 0, 0},
               {0, 1, 0},
               {v}});
        check({"triangle, " + text(gap) + " over a floor, edge",
               kFloor + file.shape(),
               looks_down(0.1, -0.5, gap / 2),
               90,
               {0, 0, 0},
               {0, 1, 0},
               {v}});
    }
}

TEST(NearLight, CubeOverAFloor) {
    for (const double gap : {0.01, 1e-3}) {
        check(cube_over_floor(gap, false));
        check(cube_over_floor(gap, true));
    }
}

TEST(NearLight, SphereOverAFloor) {
    for (const double gap : {0.1, 0.01, 1e-3}) {
        const std::string y = text(0.3 + gap);
        check({"sphere, " + text(gap) + " over a floor",
               kFloor + R"(<shape type="sphere"><point name="center" x="0" y=")" + y +
                   R"(" z="0"/><float name="radius" value="0.3"/>)" + kBlackLight + "</shape>",
               looks_down(0.01, 0.01, gap / 2),
               90,
               {0, 0, 0},
               {0, 1, 0},
               {},
               {0, 0.3 + gap, 0},
               0.3});
    }
}

TEST(NearLight, WallThatTouchesALight) {
    check(wall_below_quad());
    const std::vector<real3> v{{0, 1, -0.5}, {1, 1, 0}, {0, 1, 0.5}};
    const TriangleFile file(v);
    check({"wall that touches a triangle", kWall + file.shape(), kSeesWall, kWallFov, {0, 0, 0}, {1, 0, 0}, {v}});
}

// A light does not shine on its own back: that side is seen at points of the light's plane, on one side of it or the
// other by rounding.
TEST(NearLight, LeavesItsOwnBackDark) {
    const Scene scene = load_text(R"(<scene version="3.0.0"><sensor type="perspective"><float name="fov" value="30"/>
        <transform name="to_world"><lookat origin="2.3,0.2,1.7" target="1.3,1.5,0.7" up="0,0,1"/></transform>
        <film type="hdrfilm"><integer name="width" value="24"/><integer name="height" value="24"/></film></sensor>
        <shape type="rectangle"><transform name="to_world"><scale value="0.4"/><rotate x="1" angle="-73"/>
        <translate x="1.3" y="1.5" z="0.7"/></transform>
        <bsdf type="twosided"><bsdf type="diffuse"><rgb name="reflectance" value="0.5"/></bsdf></bsdf>
        <emitter type="area"><rgb name="radiance" value="5"/></emitter></shape>
        <shape type="sphere"><point name="center" value="9,9,9"/><float name="radius" value="0.1"/></shape></scene>)");
    RenderSettings s;
    s.method = Method::path;
    s.spp = 16;
    EXPECT_LT(channel_mean(run(scene, s).image, 1).highest, 1e-4);
}

}  // namespace
}  // namespace irradia::test
