// Whole hemispheres in float32 on the device: hemisphere_cells.json end to end, the same in double, other scales, and
// receivers close to a wall.
#include "device.h"
#include "hemisphere.h"

namespace irradia::test {
namespace {

/// Samples as the device gets them; `scale` multiplies distances.
std::vector<float> flatten(const Hemisphere& h, double scale = 1) {
    Inputs in;
    for (const HemisphereSample& s : h.samples)
        in.add(s.direction).add(s.normal).add(s.radiance).add(s.distance >= kMiss ? kMiss : s.distance * scale);
    return in.values();
}

/// The same hemisphere from the rounded numbers.
Hemisphere rounded(const Hemisphere& h) {
    Hemisphere out = h;
    const std::vector<float> v = flatten(h);
    for (std::size_t i = 0; i < h.samples.size(); ++i) {
        const float* f = &v[10 * i];
        out.samples[i] = {{f[0], f[1], f[2]}, {f[3], f[4], f[5]}, {f[6], f[7], f[8]}, f[9]};
        if (h.samples[i].distance >= kMiss) out.samples[i].distance = kMiss;
    }
    return out;
}

/// Work-items' sums (23 floats each, `stride` apart) as a record; Ward's gradient is left out.
Record record_of_sums(const Hemisphere& h, const std::vector<float>& out, std::size_t stride) {
    std::vector<double> sum(stride);
    double minimum = kMiss;
    for (std::size_t at = 0; at < out.size(); at += stride) {
        for (std::size_t q = 0; q < stride; ++q) sum[q] += static_cast<double>(out[at + q]);
        minimum = std::min(minimum, static_cast<double>(out[at + 22]));
    }
    const double factor = kPi / (h.m * h.n);
    const auto world = [&](double x, double y) { return h.frame.t * x + h.frame.b * y; };
    return {factor * sum[0],
            h.m * h.n / sum[21],
            minimum,
            factor * world(sum[3], sum[6]),
            stride > 24 ? world(sum[23], sum[24]) : real3{0, 0, 0},
            real3{0, 0, 0},
            world(sum[9], sum[12]),
            sum[18],
            sum[19],
            sum[20]};
}

/// The same by sum_cells, as sample_hemispheres has it: eight cells at once on CPU devices. (Its cells have no z.)
Record run_sum_cells(const Hemisphere& h, bool cpu_traversal, float limit) {
    constexpr unsigned items = 8, arrays = 9;
    const std::size_t count = h.samples.size();
    std::vector<float> cells(arrays * count), weights, out(items * 23);
    for (std::size_t i = 0; i < count; ++i) {
        const HemisphereSample& s = h.samples[i];
        const double values[arrays] = {s.direction.x, s.direction.y, s.distance,   s.normal.x,  s.normal.y,
                                       s.normal.z,    s.radiance.x,  s.radiance.y, s.radiance.z};
        for (unsigned a = 0; a < arrays; ++a) cells[a * count + i] = static_cast<float>(values[a]);
    }
    for (unsigned j = 0; j < h.m; ++j) weights.push_back(static_cast<float>(host::ring_rotation_weight(j, h.m)));
    DeviceOptions options;
    options.traversal = cpu_traversal ? "cpu" : "gpu";
    Device d(options);
    const Buffer from = d.upload(cells), table = d.upload(weights);
    Buffer to = d.upload(out);
    d.kernel("sum_cells_test.cl", "test_sum_cells",
             {{"IR_M", std::to_string(h.m)},
              {"IR_N", std::to_string(h.n)},
              {"IR_GROUP", std::to_string(items)},
              {"IR_GRADIENT", "2"},
              {"IR_RADIUS", "2"}})
        .arg(from)
        .arg(table)
        .arg(to)
        .arg(limit)
        .run(1, items);
    d.read(to, out.data(), out.size() * sizeof(float));
    return record_of_sums(h, out, 23);
}

Record run_record(const Hemisphere& h, double scale = 1) {
    std::vector<float> weights, out(h.m * 25);
    for (unsigned j = 0; j < h.m; ++j) weights.push_back(static_cast<float>(host::ring_rotation_weight(j, h.m)));
    Device& d = device();
    const Buffer samples = d.upload(flatten(h, scale)), table = d.upload(weights);
    Buffer to = d.upload(out);
    Kernel kernel = d.kernel("formulas_test.cl", "formula_hemisphere", {});
    kernel.arg(samples).arg(table).arg(to).arg(h.m).arg(h.n).run((h.m + 15) / 16, 16);
    d.read(to, out.data(), out.size() * sizeof(float));
    return record_of_sums(h, out, 25);
}

/// Sums of the sizes of a hemisphere's terms: what rounding errors are relative to.
struct Sizes {
    double rotation = 0, ward = 0, gradient = 0, hessian = 0;
};

Sizes sizes_of(const Hemisphere& h) {
    Sizes s;
    for (unsigned j = 0; j < h.m; ++j)
        for (unsigned k = 0; k < h.n; ++k) {
            HemisphereSums t = host::hemisphere_sums_zero(), w = t;
            const HemisphereSample &own = h.samples[j * h.n + k], &ring = ring_neighbour(h, j, k);
            cell_edges(&t, j, k, h.m, h.n, own, ring, azimuth_neighbour(h, j, k));
            cell_edges_ward(&w, j, k, h.m, h.n, own, ring, azimuth_neighbour(h, j, k), 0, false);
            s.gradient += std::hypot(t.gx.x, t.gy.x);
            s.hessian += std::hypot(t.hxx, t.hxy, t.hyy);
            s.ward += std::hypot(w.gx.x, w.gy.x);
            s.rotation += kPi / (h.m * h.n) * host::ring_rotation_weight(j, h.m) * own.radiance.x;
        }
    return s;
}

// An edge's g is good to 2e-5 and its H to 7e-5 (theory 5, and device_geometry_test), in the worst case; rotational and
// Ward's terms to the fast sine's and some roundings, 1e-6. A crease decided within rounding changes one edge in a
// thousand by at most its size. E, R: sums of 64 terms a ring, 64 roundings.
void expect_record(const Record& found, const Record& want, const Sizes& size, const std::string& name) {
    expect_relative(found.E, want.E, 64 * kEps, name + " E");
    expect_relative(found.harmonic, want.harmonic, 64 * kEps, name + " R_HMD");
    expect_relative(found.minimum, want.minimum, 2 * kEps, name + " R_min");
    EXPECT_LE(distance(found.rotation, want.rotation), 1e-6 * size.rotation) << name;
    EXPECT_LE(distance(found.ward, want.ward), 1e-6 * size.ward) << name;
    EXPECT_LE(distance(found.crease, want.crease), 2e-5 * size.gradient) << name;
    EXPECT_NEAR(found.hxx, want.hxx, 7e-5 * size.hessian) << name;
    EXPECT_NEAR(found.hxy, want.hxy, 7e-5 * size.hessian) << name;
    EXPECT_NEAR(found.hyy, want.hyy, 7e-5 * size.hessian) << name;
}

TEST(DeviceHemisphere, MatchesVectorsAndDouble) {
    for (const json& c : load_vectors("hemisphere_cells", "cases")) {
        const std::string name = c["name"];
        const Hemisphere h = hemisphere_of(c);
        const Record found = run_record(h);
        const Sizes size = sizes_of(h);
        expect_record(found, record_of(rounded(h)), size, name);
        const json& hess = c["hess_crease_TB"];
        const Record file = {c["E"],
                             c["R_HMD"],
                             c["R_min"],
                             vec3(c["grad_rot_exactweight"]),
                             vec3(c["grad_t_ward"]),
                             {0, 0, 0},
                             vec3(c["grad_t_crease"]),
                             hess[0][0],
                             hess[0][1],
                             hess[1][1]};
        expect_record(found, file, size, name + " (file)");
    }
}

TEST(DeviceHemisphere, AnyScale) {  // gradients ~ 1/length, Hessian ~ 1/length^2 (theory 4.8)
    for (const json& c : load_vectors("hemisphere_cells", "cases")) {
        if (c["name"] != "occ_jit" && c["name"] != "room_corner_jit") continue;
        const Hemisphere h = hemisphere_of(c);
        const Record one = record_of(h);
        for (const double s : {1e-4, 1e3, 1e6}) {
            Record r = run_record(h, s);
            r.harmonic /= s, r.minimum /= s;
            r.ward *= s, r.crease *= s;
            r.hxx *= s * s, r.hxy *= s * s, r.hyy *= s * s;
            expect_record(r, one, sizes_of(h), c["name"].get<std::string>() + " scaled by " + std::to_string(s));
        }
    }
}

TEST(DeviceHemisphere, FewStrata) {  // one ring, whose neighbour is itself; no multiples of anything
    std::vector<Rectangle> scene;
    for (const json& c : load_vectors("hemisphere_cells", "cases"))
        if (c["name"] == "room_corner_mid") scene = rectangles_of(c);
    ASSERT_EQ(scene.size(), 6u);
    std::mt19937 random(37);
    for (const auto& [m, n] : {std::pair{1u, 3u}, {3u, 5u}}) {
        const Hemisphere h = sample_scene(scene, {.5, 1.4, .3}, {0, 0, 1}, m, n, random);
        expect_record(run_record(h), record_of(rounded(h)), sizes_of(h), std::to_string(m) + "x" + std::to_string(n));
    }
}

// Eight cells at once (on CPU devices) against the cells one by one in double: where a hemisphere's sectors are a
// multiple of eight, also of one group of lanes, and where they are none.
TEST(DeviceHemisphere, CellsOfARingAreSummedTogether) {
    std::vector<Rectangle> scene;
    for (const json& c : load_vectors("hemisphere_cells", "cases"))
        if (c["name"] == "room_corner_mid") scene = rectangles_of(c);
    ASSERT_EQ(scene.size(), 6u);
    scene.pop_back();  // and some rays miss
    std::mt19937 random(53);
    for (const auto& [m, n] : {std::pair{16u, 64u}, {8u, 8u}, {5u, 24u}, {7u, 12u}})
        for (const real3 p : {real3{.5, 1.4, .3}, real3{-.97, 1.4, .9}}) {
            Hemisphere h = rounded(sample_scene(scene, p, {0, 0, 1}, m, n, random));
            double least = kMiss;
            for (HemisphereSample& s : h.samples) {  // the device has x and y of a direction only
                const double x = s.direction.x, y = s.direction.y;
                s.direction.z = std::sqrt(std::max(1 - x * x - y * y, 6e-8));
                if (s.direction.z >= .17) least = std::min(least, s.distance);
            }
            Record want = record_of(h);
            want.minimum = least;  // sum_cells leaves grazing rays out
            want.ward = {0, 0, 0};
            for (const bool cpu : {true, false}) {
                Record found = run_sum_cells(h, cpu, 1e30f);
                expect_record(found, want, sizes_of(h),
                              std::to_string(m) + "x" + std::to_string(n) + (cpu ? " cpu" : " gpu"));
            }
        }
}

// A limit takes gradients and Hessian as if brighter cells were that bright, and leaves E as it is.
TEST(DeviceHemisphere, LimitsBrightCellsInGradientsAlone) {
    std::vector<Rectangle> scene;
    for (const json& c : load_vectors("hemisphere_cells", "cases"))
        if (c["name"] == "room_corner_mid") scene = rectangles_of(c);
    std::mt19937 random(59);
    Hemisphere h = rounded(sample_scene(scene, {.5, 1.4, .3}, {0, 0, 1}, 16, 64, random));
    double mean = 0;
    for (const HemisphereSample& s : h.samples) mean += s.radiance.x / static_cast<double>(h.samples.size());
    const auto limit = static_cast<float>(1.5 * mean);
    Hemisphere limited = h;
    for (HemisphereSample& s : limited.samples)
        if (s.radiance.x > static_cast<double>(limit))
            s.radiance.x = s.radiance.y = s.radiance.z = static_cast<double>(limit);
    for (Hemisphere* each : {&h, &limited})
        for (HemisphereSample& s : each->samples)
            s.direction.z =
                std::sqrt(std::max(1 - s.direction.x * s.direction.x - s.direction.y * s.direction.y, 6e-8));
    ASSERT_NE(record_of(limited).E, record_of(h).E);
    Record want = record_of(limited);
    want.E = record_of(h).E;
    want.minimum = run_sum_cells(h, true, limit).minimum;  // tested above
    want.ward = {0, 0, 0};
    for (const bool cpu : {true, false})
        expect_record(run_sum_cells(h, cpu, limit), want, sizes_of(h), cpu ? "cpu" : "gpu");
}

// Theory 3.3's table in float32: jittered 16x64 in the room, at distance h from a wall of radiance 1.
TEST(DeviceHemisphere, CreaseGradientHoldsCloseToAWall) {
    std::vector<Rectangle> scene;
    for (const json& c : load_vectors("hemisphere_cells", "cases"))
        if (c["name"] == "room_corner_mid") scene = rectangles_of(c);
    ASSERT_EQ(scene.size(), 6u);
    const double table[][2] = {{.5, .009}, {.1, .009}, {.02, .008}, {4e-3, .005}, {1e-3, .004}, {1e-4, .004}};
    for (const auto& [h, error] : table) {
        const real3 p{h, 1.4, 0}, n{0, 0, 1};
        const Irradiance exact = room_irradiance(scene, p, n);
        const real3 g = exact.gradient - dot(n, exact.gradient) * n;
        std::mt19937 random(31);
        double square = 0;
        for (int s = 0; s < 40; ++s) {
            const Record r = run_record(sample_scene(scene, p, n, 16, 64, random));
            square += std::pow(distance(r.crease, g) / length(g), 2) / 40;
        }
        EXPECT_LE(std::sqrt(square), 1.35 * error) << "h = " << h;  // 1.35: an rms over 40 seeds scatters by 11 %
    }
}

}  // namespace
}  // namespace irradia::test
