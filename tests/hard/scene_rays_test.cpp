// Rays that start on surfaces: whether they find their own surface again, or miss the next one, from scale 1e-4 to 1e6,
// and at 100 sizes of the scene from the origin, where float32 positions have lost two digits.
#include <random>

#include "render/run.h"
#include "scene_double.h"
#include "scene_fixture.h"

namespace irradia::test {
namespace {

constexpr std::size_t kRays = 1u << 13;

struct Start {
    float t, primitive, p[3], n[3], error, start[3], next_t, next_primitive, pad[2];
};
struct Outcome {
    std::vector<Start> starts;
    std::vector<float> ways;
};

Outcome leave(const Scene& scene, const std::vector<float>& rays, std::uint32_t mode, const std::string& traversal) {
    Device& d = device(traversal);
    const RenderSettings settings;
    const ProgressCallback none;
    Run run(scene, d, settings, none);
    const std::size_t count = rays.size() / 8;
    Outcome o{std::vector<Start>(count), std::vector<float>(3 * count)};
    const Buffer in = d.upload(rays), out = d.allocate(count * sizeof(Start)), ways = d.allocate(count * 12);
    run.scene_kernel(IRRADIA_SOURCE_DIR "/tests/hard/leave_surface.cl", "leave_and_trace", {})
        .arg(in)
        .arg(static_cast<std::uint32_t>(count))
        .arg(mode)
        .arg(out)
        .arg(ways)
        .run((count + 63) / 64, 64);
    d.read(out, o.starts.data(), count * sizeof(Start));
    d.read(ways, o.ways.data(), count * 12);
    return o;
}

// What double precision says of them.
struct Verdict {
    double depth = 0;                 // largest distance of a computed hit from its surface, in offsets
    std::size_t self = 0, wrong = 0;  // starts on the wrong side, or own surface found; other answers than double's
    std::size_t compared = 0;
};

Verdict judge(const DoubleScene& exact, const Outcome& o, double scale, double offset) {
    const auto place = [&](const float* p) {
        return real3{(static_cast<double>(p[0]) - offset) / scale, (static_cast<double>(p[1]) - offset) / scale,
                     (static_cast<double>(p[2]) - offset) / scale};
    };
    Verdict v;
    for (std::size_t i = 0; i < o.starts.size(); ++i) {
        const Start& s = o.starts[i];
        if (s.primitive < 0) {
            ++v.wrong;  // the room is closed
            continue;
        }
        const int own = static_cast<int>(s.primitive), next = static_cast<int>(s.next_primitive);
        const double error = static_cast<double>(s.error) / scale;
        const real3 n{static_cast<double>(s.n[0]), static_cast<double>(s.n[1]), static_cast<double>(s.n[2])};
        const real3 way{static_cast<double>(o.ways[3 * i]), static_cast<double>(o.ways[3 * i + 1]),
                        static_cast<double>(o.ways[3 * i + 2])};
        const real3 p = place(s.p), start = place(s.start);
        v.depth = std::max(v.depth, std::abs(exact.distance(own, p, n)) / error);
        const bool found = next == own && exact.left_for_good(own, p, n);
        v.self += exact.distance(own, start, n) <= 0 || found;
        const ExactHit want = exact.closest(start, way);
        // Where an edge passes nearer than the rounding of the start, either answer is right.
        if (want.margin < 0.1 * error + 1e-6 * want.t || want.t < 0.1 * error) continue;
        ++v.compared;
        // Surfaces in one place (the block stands on the floor) may be found in either order.
        const double t = static_cast<double>(s.next_t) / scale;
        v.wrong += next != want.primitive && !(next >= 0 && std::abs(t - want.t) < 2 * error + 1e-5 * want.t);
    }
    return v;
}

struct Sweep {
    Verdict all;
    std::size_t rays = 0;
    double self_without_offset = 0, wrong_small = 0, self_large = 0;  // shares, the naive ways
};

std::vector<float> random_rays(double scale, double offset, std::mt19937& random) {
    std::uniform_real_distribution<float> u(0, 1);
    std::normal_distribution<double> g;
    std::vector<float> rays;
    while (rays.size() < 8 * kRays) {
        const double x = g(random), y = g(random), z = g(random), l = std::sqrt(x * x + y * y + z * z);
        for (const double half : {1.9, 1.15, 1.9})
            rays.push_back(static_cast<float>((2 * static_cast<double>(u(random)) - 1) * half * scale + offset));
        for (const double c : {x, y, z}) rays.push_back(static_cast<float>(c / l));
        rays.push_back(u(random)), rays.push_back(u(random));
    }
    return rays;
}

// Bumpy spheres and tori of triangles, and analytic spheres, in a closed room with a block.
Sweep sweep() {
    std::mt19937 random(3);
    Sweep s;
    for (const std::string traversal : {"cpu", "gpu"})
        for (const double scale : {1e-4, 1e-2, 1.0, 1e3, 1e6})
            for (const double away : {0.0, 100.0}) {
                const double offset = away * scale;
                Scene scene = shapes::mesh_room(1200);
                for (int i = 0; i < 6; ++i)
                    shapes::add_sphere(scene, {0.6f * static_cast<float>(i) - 1.5f, 0.4f, 0.7f},
                                       0.05f + 0.05f * static_cast<float>(i));
                place_scene(scene, scale, offset);
                build_accel(scene);
                const DoubleScene exact(scene, scale, offset);
                const std::vector<float> rays = random_rays(scale, offset, random);
                const auto judged = [&](std::uint32_t mode) {
                    return judge(exact, leave(scene, rays, mode, traversal), scale, offset);
                };
                const Verdict v = judged(0);
                s.all.depth = std::max(s.all.depth, v.depth);
                s.all.self += v.self, s.all.wrong += v.wrong, s.all.compared += v.compared;
                s.rays += kRays;
                EXPECT_EQ(v.self, 0u) << traversal << " scale " << scale << " offset " << away;
                EXPECT_EQ(v.wrong, 0u) << traversal << " scale " << scale << " offset " << away;
                // The naive ways, once: without an offset at scale 1, with a fixed one at the ends of the range.
                if (traversal == "gpu" || away != 0) continue;
                const double share = 1 / static_cast<double>(kRays);
                if (scale == 1) s.self_without_offset = share * static_cast<double>(judged(1).self);
                if (scale == 1e-4) s.wrong_small = share * static_cast<double>(judged(2).wrong);
                if (scale == 1e6) s.self_large = share * static_cast<double>(judged(2).self);
            }
    return s;
}
const Sweep& swept() {
    static const Sweep s = sweep();
    return s;
}
const std::string kWhere = ", scale 1e-4 to 1e6, at 0 and 100 sizes from the origin, both traversals";

TEST(SelfIntersection, OffsetsFollowPositionAndScale) {
    const Sweep& s = swept();
    const std::size_t bad = s.all.self + s.all.wrong;
    EXPECT_EQ(bad, 0u);
    EXPECT_GT(s.all.compared, s.rays * 95 / 100);
    hard_case("rays from surfaces" + kWhere + " (" + std::to_string(s.rays) + " rays)", "double on the host",
              "self-hits and wrong second hits", static_cast<double>(bad), 0,
              "no offset: " + figure(100 * s.self_without_offset) +
                  " % start on or behind their surface; fixed 1e-4: " + figure(100 * s.wrong_small) +
                  " % wrong at scale 1e-4, " + figure(100 * s.self_large) + " % start on or behind at 1e6");
}

// Why: computed hits lie well within the offset of their surfaces, so that no start is behind its own.
TEST(SelfIntersection, HitsLieWithinTheOffset) {
    const Sweep& s = swept();
    EXPECT_LT(s.all.depth, 0.5);
    EXPECT_GT(s.all.depth, 0);
    hard_case("computed hits" + kWhere, "double on the host", "distance from their surface over the offset",
              s.all.depth, 0.5);
}

// A ground of 100 to 10000 times what is looked at, tilted in any way. The rounding of a hit on it is that of its own
// coordinates, not that of the point's.
TEST(SelfIntersection, OnALargeGround) {
    std::mt19937 random(11);
    std::normal_distribution<double> g;
    std::uniform_real_distribution<float> u(0, 1);
    std::size_t self = 0, naive = 0, rays_traced = 0;
    double depth = 0;
    for (const std::string traversal : {"cpu", "gpu"})
        for (const double size : {1e2, 1e3, 1e4})
            for (int tilt = 0; tilt < 4; ++tilt) {
                const real3 n = tilt == 0 ? real3{0, 1, 0} : normalize(real3{g(random), g(random), g(random)});
                const host::Frame frame = host::make_frame(n);
                Scene scene;
                const auto corner = [&](double x, double y) {
                    const real3 p = (x * size) * frame.t + (y * size) * frame.b;
                    return shapes::Point{static_cast<float>(p.x), static_cast<float>(p.y), static_cast<float>(p.z)};
                };
                shapes::add_triangle(scene, corner(-1, -0.9), corner(1.1, -1), corner(1, 1));
                shapes::add_triangle(scene, corner(-1, -0.9), corner(1, 1), corner(-0.8, 1));
                place_scene(scene, 1, 0);
                build_accel(scene);
                std::vector<float> rays;
                for (std::size_t i = 0; i < kRays; ++i) {
                    const auto near = [&] { return 2 * static_cast<double>(u(random)) - 1; };
                    const real3 from = 3 * near() * frame.t + 3 * near() * frame.b + n,
                                d = normalize(3 * near() * frame.t + 3 * near() * frame.b - from);
                    for (const double x : {from.x, from.y, from.z, d.x, d.y, d.z})
                        rays.push_back(static_cast<float>(x));
                    rays.push_back(u(random)), rays.push_back(u(random));
                }
                const DoubleScene exact(scene, 1, 0);
                const Outcome o = leave(scene, rays, 0, traversal);
                for (const Start& s : o.starts) {
                    ASSERT_GE(s.primitive, 0);
                    const real3 up{static_cast<double>(s.n[0]), static_cast<double>(s.n[1]),
                                   static_cast<double>(s.n[2])};
                    const real3 p{static_cast<double>(s.p[0]), static_cast<double>(s.p[1]),
                                  static_cast<double>(s.p[2])};
                    depth = std::max(depth, std::abs(exact.distance(static_cast<int>(s.primitive), p, up)) /
                                                static_cast<double>(s.error));
                    self += s.next_primitive >= 0;
                }
                for (shared::Triangle& t : scene.triangles) t.reach = 0;
                for (const Start& s : leave(scene, rays, 0, traversal).starts) naive += s.next_primitive >= 0;
                rays_traced += kRays;
            }
    EXPECT_EQ(self, 0u);
    EXPECT_LT(depth, 1);
    hard_case("ground of 100 to 10000 times what is looked at, tilted in any way, both traversals (" +
                  std::to_string(rays_traced) + " rays; hits within " + figure(depth) + " offsets of it)",
              "closed form: a plane is not met again", "self-hits", static_cast<double>(self), 0,
              "offset by the point's coordinates alone: " +
                  figure(100 * static_cast<double>(naive) / static_cast<double>(rays_traced)) + " %");
}

}  // namespace
}  // namespace irradia::test
