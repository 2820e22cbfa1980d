// Weights, radii, harmonics, re-projection and the error probe in float32 on the device, against the vectors and
// against the same headers in double from the same (rounded) inputs. kEps = 2^-24 is one rounding.
#include <random>

#include "device.h"

namespace irradia::test {
namespace {
using namespace irradia::host;

std::mt19937 generator(29);
double uniform(double lo, double hi) { return std::uniform_real_distribution<double>(lo, hi)(generator); }
real3 random_direction() {
    std::normal_distribution<double> g;
    const double x = g(generator), y = g(generator), z = g(generator);
    return normalize(make_real3(x, y, z));
}

// ---- weights
// ---------------------------------------------------------------------------------------------------------

struct WeightCase {
    real3 p, n, pi, ni;
    double radius, a;
};

std::vector<double> run_weights(const std::vector<WeightCase>& cases, Inputs& in) {
    for (const WeightCase& c : cases) {
        const Frame f = make_frame(c.ni);
        in.add(c.p).add(c.n).add(c.pi).add(c.ni).add(c.radius).add(c.a).add(f.b);
    }
    return run_formula("formula_weight", in, 17, 6);
}

// e is a sum of two lengths of differences of rounded numbers, each good to some roundings (theory 4.1: 5e-8 for the
// angle's); w = (1/x - 1)/a has slope 1/x^2 in x = e/a, which is capped where x < .01.
void expect_weights(const std::vector<double>& out, const Inputs& in) {
    for (std::size_t i = 0; i < out.size() / 6; ++i) {
        const real3 p = in.vector(i, 17, 0), n = in.vector(i, 17, 3), pi = in.vector(i, 17, 6),
                    ni = in.vector(i, 17, 9);
        const double radius = in.scalar(i, 17, 12), a = in.scalar(i, 17, 13);
        const double e = ward_error(p, n, pi, ni, radius), x = std::max(e / a, .01);
        const double e_error = 1e-7 + 8 * kEps * e;
        EXPECT_NEAR(out[6 * i], e, e_error);
        EXPECT_NEAR(out[6 * i + 1], ward_weight(e, a), (e_error / (a * x * x) + 8 * kEps / x) / a);
        EXPECT_NEAR(out[6 * i + 2], tabellion_weight(length(p - pi), radius, normal_error(n, ni), .5 / a),
                    10 * e_error / a + kEps);
        const double elliptic = elliptic_weight(
            elliptic_error(p - pi, in.vector(i, 17, 14), a * radius, 2 * a * radius), normal_error(n, ni), a);
        EXPECT_NEAR(out[6 * i + 3], elliptic, 4 * e_error / a + kEps);
        for (std::size_t k = 0; k < 6; ++k) EXPECT_TRUE(std::isfinite(out[6 * i + k]));
        EXPECT_GE(out[6 * i + 1], 0);
        EXPECT_LE(out[6 * i + 1], 100.001 / a);
    }
}

TEST(DeviceWeight, MatchesVectors) {
    const json cases = load_vectors("weights", "cases");
    std::vector<WeightCase> list;
    for (const json& c : cases)
        list.push_back({vec3(c["p"]), vec3(c["n"]), vec3(c["pi"]), vec3(c["ni"]), c["R"], c["a"]});
    Inputs in;
    const std::vector<double> out = run_weights(list, in);
    expect_weights(out, in);
    for (std::size_t i = 0; i < cases.size(); ++i) {
        // Rounding the inputs moves |p - p_i|/R by 2 kEps |p|/R and |n - n_i| by 2 kEps, at most.
        const WeightCase& c = list[i];
        const double moved = 4 * kEps * (1 + length(c.p) / c.radius) + 8 * kEps * cases[i]["e"].get<double>();
        EXPECT_NEAR(out[6 * i], cases[i]["e"].get<double>(), moved);
        const double x = std::max(c.a > 0 ? cases[i]["e"].get<double>() / c.a : 0, .01);
        EXPECT_NEAR(out[6 * i + 1], cases[i]["w_safe"].get<double>(), (moved / (c.a * x * x) + 8 * kEps / x) / c.a);
        EXPECT_NEAR(out[6 * i + 2], cases[i]["w_tabellion"].get<double>(), 10 * moved / c.a + kEps);
    }
}

// Equal normals of float32: the printed form's root is of a negative number for some of them; this one is exact.
TEST(DeviceWeight, IsNeverNaN) {
    std::vector<WeightCase> list;
    int negative = 0;
    for (int i = 0; i < 4000; ++i) {
        const real3 n = random_direction();
        const float x = static_cast<float>(n.x), y = static_cast<float>(n.y), z = static_cast<float>(n.z);
        const float square = x * x + y * y + z * z;
        if (1.0f - square < 0) ++negative;
        const real3 p = make_real3(uniform(-5, 5), uniform(-5, 5), uniform(-5, 5));
        if (i % 2)
            list.push_back({p, n, p, n, .3, .2});
        else
            list.push_back({p, normalize(n + 1e-4 * random_direction()), p + 1e-3 * random_direction(), n, .3, .2});
    }
    EXPECT_GT(negative, 100) << "no case here would have been a NaN";
    Inputs in;
    const std::vector<double> out = run_weights(list, in);
    expect_weights(out, in);
    for (std::size_t i = 1; i < list.size(); i += 2) EXPECT_NEAR(out[6 * i + 1], 500, 500 * 4 * kEps);
}

TEST(DeviceInFront, MatchesVectors) {
    const json cases = load_vectors("in_front", "cases");
    std::vector<WeightCase> list;
    for (const json& c : cases) list.push_back({vec3(c["p"]), vec3(c["n"]), vec3(c["pi"]), vec3(c["ni"]), 1, .2});
    Inputs in;
    const std::vector<double> out = run_weights(list, in);
    for (std::size_t i = 0; i < cases.size(); ++i) {
        const double coordinate = std::max(largest_coordinate(list[i].p), largest_coordinate(list[i].pi));
        EXPECT_NEAR(out[6 * i + 4], cases[i]["d"].get<double>(), 8 * kEps * coordinate) << cases[i]["name"];
        EXPECT_EQ(out[6 * i + 5] != 0, cases[i]["reject"].get<bool>()) << cases[i]["name"];
    }
}

TEST(DeviceInFront, SpheresAndPlanesAreNeverRejected) {
    std::vector<WeightCase> list;
    for (int i = 0; i < 4000; ++i) {
        const double scale = std::pow(10, uniform(-4, 5)), side = i % 2 ? 1 : -1;
        const real3 centre = (scale * 10) * random_direction(), ni = random_direction();
        const real3 n = normalize(ni + uniform(0, .3) * random_direction());
        if (i % 4 < 2)
            list.push_back({centre + scale * n, side * n, centre + scale * ni, side * ni, scale, .2});
        else
            list.push_back({centre + (scale * uniform(0, .1)) * make_frame(ni).t, ni, centre, ni, scale, .2});
    }
    Inputs in;
    const std::vector<double> out = run_weights(list, in);
    for (std::size_t i = 0; i < list.size(); ++i) EXPECT_EQ(out[6 * i + 5], 0) << i;
}

// ---- radii
// -----------------------------------------------------------------------------------------------------------

TEST(DeviceRadius,
     EllipsesAtAnyScale) {  // eigenvalues to roundings of |l1|, radii to a fourth of the eigenvalue's error
    Inputs in;
    for (const double s : {1e-4, 1.0, 1e6})
        for (int i = 0; i < 1000; ++i) {
            const double E = std::pow(10, uniform(-6, 6)), h = E / (s * s);
            in.add(uniform(-1, 1) * h).add(i % 7 == 0 ? 0 : uniform(-1, 1) * h).add(uniform(-1, 1) * h);
            in.add(E).add(8 * s).add(.02).add(1e-5 * s * s).add(1e-3 * s).add(3 * s).add(3);
        }
    for (int i = 0; i < 3; ++i) in.add(0).add(0).add(0).add(1).add(1).add(.01).add(1e-4).add(1e-3).add(1).add(3);
    const std::vector<double> out = run_formula("formula_ellipse", in, 10, 6);
    for (std::size_t i = 0; i < out.size() / 6; ++i) {
        const auto u = [&](std::size_t k) { return in.scalar(i, 10, k); };
        const Eigen2 h = eigen_symmetric(u(0), u(1), u(2));
        const EllipseRadii e = hessian_ellipse(h, u(3), u(4), u(5), u(6), u(7), u(8), u(9));
        const double size = std::abs(h.l1), l1 = out[6 * i], l2 = out[6 * i + 1], x = out[6 * i + 2],
                     y = out[6 * i + 3];
        EXPECT_NEAR(l1, h.l1, 8 * kEps * size);
        EXPECT_NEAR(l2, h.l2, 8 * kEps * size);
        EXPECT_NEAR(l1 * x * x + l2 * y * y, u(0), 24 * kEps * size);  // the matrix, whatever the axis of equal values
        EXPECT_NEAR((l1 - l2) * x * y, u(1), 24 * kEps * size);
        EXPECT_NEAR(l1 * y * y + l2 * x * x, u(2), 24 * kEps * size);
        expect_relative(out[6 * i + 4], e.r1, 8 * kEps, "r1");
        const double l_error = 8 * kEps * size / std::max(std::abs(h.l2), hessian_floor(u(3), u(4)));
        expect_relative(out[6 * i + 5], e.r2, 8 * kEps + .25 * l_error, "r2");
    }
}

TEST(DeviceRadius, Limits) {
    Inputs in;
    in.add(2).add(0).add(1e30).add(.1);  // black
    for (int i = 0; i < 1000; ++i)
        in.add(std::pow(10, uniform(-5, 5)))
            .add(std::pow(10, uniform(-8, 8)))
            .add(std::pow(10, uniform(-8, 8)))
            .add(std::pow(10, uniform(-5, 5)));
    const std::vector<double> out = run_formula("formula_limits", in, 4, 4);
    for (std::size_t i = 0; i < out.size() / 4; ++i) {
        const double r = in.scalar(i, 4, 0), E = in.scalar(i, 4, 1), g = in.scalar(i, 4, 2), d = in.scalar(i, 4, 3);
        expect_relative(out[4 * i], gradient_limited_radius(r, E, g), 4 * kEps, "gradient limit");
        expect_relative(out[4 * i + 1], gradient_scale(r, E, g), 6 * kEps, "gradient scale");
        expect_relative(out[4 * i + 2], neighbour_clamped_radius(r, E, d), 2 * kEps, "neighbour clamp");
        EXPECT_NEAR(out[4 * i + 3], extrapolate(E, g * d), 6 * kEps * E);
    }
}

// ---- radiance
// --------------------------------------------------------------------------------------------------------

// Values up to 3 by recurrences of 5 steps whose coefficients are at most 3: some 60 roundings.
TEST(DeviceHarmonics, MatchVectors) {
    const json v = load_vectors("harmonics");
    Inputs in;
    for (const json& d : v["dirs"]) in.add(vec3(d));
    const std::vector<double> out = run_formula("formula_harmonics", in, 3, 72);
    for (std::size_t i = 0; i < v["dirs"].size(); ++i)
        for (std::size_t q = 0; q < 36; ++q) {
            EXPECT_NEAR(out[72 * i + q], v["sh6"][i][q].get<double>(), 60 * kEps) << "SH " << i << " " << q;
            // On the horizon HSH has a slope of infinite size in sqrt(cos): only z = 0 itself is asked there.
            EXPECT_NEAR(out[72 * i + 36 + q], v["hsh6"][i][q].get<double>(), 60 * kEps) << "HSH " << i << " " << q;
        }
}

// t = h.x^2 + h.y^2 + alpha^2 h.z^2 >= alpha^2 feels the rounding of h.x by at most kEps/alpha, relative; D = 1/t^2.
TEST(DeviceGgx, AgreesWithDouble) {
    Inputs in;
    for (int i = 0; i < 4000; ++i) {
        real3 wi = random_direction(), wo = i % 2 ? random_direction() : make_real3(-wi.x, -wi.y, wi.z);
        wi.z = std::abs(wi.z), wo.z = std::abs(wo.z);
        in.add(wi).add(wo).add(uniform(.05, 1));
    }
    const std::vector<double> out = run_formula("formula_ggx", in, 7, 1);
    for (std::size_t i = 0; i < out.size(); ++i) {
        const double alpha = in.scalar(i, 7, 6);
        // The half vector of nearly opposite directions loses 1/|wi + wo|.
        const real3 wi = in.vector(i, 7, 0), wo = in.vector(i, 7, 3);
        const double tolerance = 16 * kEps + 8 * kEps / (alpha * std::min(1.0, length(wi + wo)));
        expect_relative(out[i], ggx_brdf(wi, wo, alpha), tolerance, "GGX, alpha " + std::to_string(alpha));
    }
}

// J's cosines are good to a few roundings over their size; the vectors' are above .05. Sums of positive terms keep
// that.
TEST(DeviceReproject, MatchesVectors) {
    for (const json& c : load_vectors("reproject", "cases")) {
        const real3 pi = vec3(c["record_p"]), ni = vec3(c["record_n"]), p = vec3(c["p"]);
        const Frame frame = frame_of(c);
        const double alpha = .3;
        Inputs in, lobes;
        for (std::size_t s = 0; s < c["dirs"].size(); ++s) {
            const real3 w = vec3(c["dirs"][s]);
            in.add(pi - p).add(w).add(c["r"][s]).add(vec3(c["hit_normal"][s])).add(dot(ni, w)).add(frame.n);
        }
        in.add(pi - p).add(ni).add(kMiss).add(ni).add(1).add(frame.n);  // and a miss
        const std::vector<double> out = run_formula("formula_reproject", in, 14, 5);
        const std::size_t count = c["dirs"].size();
        for (std::size_t s = 0; s < count; ++s)
            lobes.add(to_local(frame, vector_at(out, 5 * s))).add(vec3(c["wo_local"])).add(alpha);
        const std::vector<double> f = run_formula("formula_ggx", lobes, 7, 1);
        ReprojectedSum flat = reprojected_sum_zero(), lobe = flat;
        for (std::size_t s = 0; s < count; ++s) {
            expect_relative(out[5 * s + 3], c["W"][s], 5e-6, "W of sample " + std::to_string(s));
            const ReprojectedSample t = {vector_at(out, 5 * s), out[5 * s + 3], out[5 * s + 4]};
            const double L = c["L"][s];
            flat = reprojected_add(flat, t, 1, make_real3(L, L, L));
            lobe = reprojected_add(lobe, t, f[s], make_real3(L, L, L));
        }
        expect_relative(reprojected_radiance(flat, kPi).x, c["E"], 5e-6, "E");
        expect_relative(reprojected_radiance(lobe, 1).x, c["Lo_over_albedo"]["0.3"], 5e-6, "Lo/albedo");
        EXPECT_EQ(out[5 * count + 3], 1) << "a miss stays where it is";
        EXPECT_LE(distance(vector_at(out, 5 * count), ni), 1e-7);
    }
}

TEST(DeviceProbe, MatchesVectors) {  // a difference of two numbers each good to a few roundings of I^2 + s^2
    const json cases = load_vectors("probe", "cases");
    Inputs in;
    for (const json& c : cases) {
        ASSERT_EQ(c["samples"].size(), 8u);
        in.add(c["I"]);
        for (const json& x : c["samples"]) in.add(x);
    }
    const std::vector<double> out = run_formula("formula_probe", in, 9, 1);
    for (std::size_t i = 0; i < cases.size(); ++i) {
        double size = cases[i]["I"].get<double>() * cases[i]["I"].get<double>();
        for (const json& x : cases[i]["samples"]) size += x.get<double>() * x.get<double>();
        EXPECT_NEAR(out[i], cases[i]["q"].get<double>(), 16 * kEps * size);
    }
}

}  // namespace
}  // namespace irradia::test
