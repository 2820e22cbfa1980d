// SH, HSH and GGX against harmonics.json: 1e-9 for values, 1e-4 for projections (theory 9).
#include "gauss_legendre.h"
#include "polygon.h"

namespace irradia::test {
namespace {
using namespace irradia::host;

constexpr uint kBands = 6, kCount = kBands * kBands;
using Values = std::array<double, kCount>;

TEST(Harmonics, BasesMatchVectors) {
    const json v = load_vectors("harmonics");
    for (std::size_t i = 0; i < v["dirs"].size(); ++i) {
        Values sh, hsh;
        sh_basis(vec3(v["dirs"][i]), kBands, sh.data());
        hsh_basis(vec3(v["dirs"][i]), kBands, hsh.data());
        for (uint q = 0; q < kCount; ++q) {
            EXPECT_NEAR(sh[q], v["sh6"][i][q].get<double>(), 1e-9) << "SH, direction " << i << ", index " << q;
            EXPECT_NEAR(hsh[q], v["hsh6"][i][q].get<double>(), 1e-9) << "HSH, direction " << i << ", index " << q;
        }
    }
}

// The rule that made the file: midpoints in (cos, phi) over the upper hemisphere.
template <class F>
void integrate_hemisphere(const F& visit) {
    const int rows = 512, columns = 1024;
    const double weight = 2 * kPi / (static_cast<double>(rows) * columns);
    for (int i = 0; i < rows; ++i)
        for (int j = 0; j < columns; ++j) {
            const double z = (i + .5) / rows, s = std::sqrt(1 - z * z), phi = 2 * kPi * (j + .5) / columns;
            visit(make_real3(s * std::cos(phi), s * std::sin(phi), z), weight);
        }
}

std::vector<Rectangle> room() {  // the room of theory's preamble, and the point of the file's projection in it
    for (const json& c : load_vectors("hemisphere_cells", "cases"))
        if (c["name"] == "room_mid") return rectangles_of(c);
    throw std::runtime_error("hemisphere_cells.json has no room_mid");
}
const real3 kRoomPoint{.7, .8, 0};

void expect_coefficients(const Values& found, const json& wanted, const std::string& what) {
    double size = 0;
    for (const json& x : wanted) size = std::max(size, std::abs(x.get<double>()));
    for (uint q = 0; q < kCount; ++q)
        EXPECT_NEAR(found[q], wanted[q].get<double>(), 1e-4 * size) << what << ", index " << q;
}

TEST(Harmonics, ProjectionsMatchVectors) {
    const json v = load_vectors("harmonics");
    const std::vector<Rectangle> scene = room();
    struct Projection {
        Values sh{}, hsh{};
    } constant, cosine, lit;
    struct Lobe {
        std::string key;
        double alpha = 0, albedo = 0, reflected = 0;
        real3 wo{0, 0, 1};
        Values hsh{};
    };
    std::vector<Lobe> lobes;
    for (const auto& [key, j] : v["ggx"].items()) {
        lobes.emplace_back();
        lobes.back().key = key;
        lobes.back().alpha = std::stod(key);
        lobes.back().wo = vec3(j["wo"]);
    }
    integrate_hemisphere([&](real3 d, double weight) {
        Values sh, hsh;
        sh_basis(d, kBands, sh.data());
        hsh_basis(d, kBands, hsh.data());
        const RectangleHit hit = trace(scene, kRoomPoint, d);
        const double L = hit.index < 0 ? 0 : scene[static_cast<std::size_t>(hit.index)].radiance;
        for (uint q = 0; q < kCount; ++q) {
            constant.sh[q] += weight * sh[q], constant.hsh[q] += weight * hsh[q];
            cosine.sh[q] += weight * d.z * sh[q], cosine.hsh[q] += weight * d.z * hsh[q];
            lit.sh[q] += weight * L * sh[q], lit.hsh[q] += weight * L * hsh[q];
        }
        for (Lobe& lobe : lobes) {
            const double f = weight * ggx_brdf(d, lobe.wo, lobe.alpha) * d.z;
            lobe.albedo += f;
            lobe.reflected += f * L;
            for (uint q = 0; q < kCount; ++q) lobe.hsh[q] += f * hsh[q];
        }
    });
    const json& p = v["projections"];
    expect_coefficients(constant.sh, p["constant"]["sh"], "SH of 1");
    expect_coefficients(constant.hsh, p["constant"]["hsh"], "HSH of 1");
    expect_coefficients(cosine.sh, p["cosine"]["sh"], "SH of cos");
    expect_coefficients(cosine.hsh, p["cosine"]["hsh"], "HSH of cos");
    expect_coefficients(lit.sh, p["room_at_0p7_0p8"]["sh"], "SH of room");
    expect_coefficients(lit.hsh, p["room_at_0p7_0p8"]["hsh"], "HSH of room");
    for (const Lobe& lobe : lobes) {
        const json& j = v["ggx"][lobe.key];
        expect_coefficients(lobe.hsh, j["hsh"], "GGX " + lobe.key);
        expect_relative(lobe.albedo, j["albedo"], 1e-4, "albedo, alpha " + lobe.key);
        expect_relative(lobe.reflected, j["reflected_room_reference"], 1e-4, "reflected, alpha " + lobe.key);
        double dotted = 0;
        for (uint q = 0; q < kCount; ++q) dotted += lobe.hsh[q] * lit.hsh[q];
        expect_relative(dotted, j["reflected_room_hsh6"], 1e-4, "reflected by HSH, alpha " + lobe.key);
    }
}

// Products of two functions of up to 12 bands are integrated exactly by Gauss-Legendre in cos (24 points) and the
// trapezoid in phi (48 points).
TEST(Harmonics, BasesAreOrthonormalUpToTwelveBands) {
    const uint n = IR_HARMONICS_MAX, count = n * n;
    const auto rule = gauss_legendre(24);
    for (const bool hemisphere : {false, true}) {
        std::vector<double> gram(count * count), v(count);
        for (const auto& [x, weight] : rule)
            for (int j = 0; j < 48; ++j) {
                const double z = hemisphere ? x : 2 * x - 1;
                const double w = weight * (hemisphere ? 1 : 2) * 2 * kPi / 48, phi = 2 * kPi * j / 48;
                const double s = std::sqrt(1 - z * z);
                const real3 d = make_real3(s * std::cos(phi), s * std::sin(phi), z);
                hemisphere ? hsh_basis(d, n, v.data()) : sh_basis(d, n, v.data());
                for (uint a = 0; a < count; ++a)
                    for (uint b = 0; b < count; ++b) gram[a * count + b] += w * v[a] * v[b];
            }
        for (uint a = 0; a < count; ++a)
            for (uint b = 0; b < count; ++b) ASSERT_NEAR(gram[a * count + b], a == b ? 1 : 0, 1e-11) << a << " " << b;
    }
}

TEST(Ggx, IsReciprocalAndConservesEnergy) {
    const real3 a = normalize(make_real3(.3, -.4, .5)), b = normalize(make_real3(-.8, .1, .3));
    for (const double alpha : {.05, .2, .5, 1.0}) {
        EXPECT_NEAR(ggx_brdf(a, b, alpha), ggx_brdf(b, a, alpha), 1e-12);
        EXPECT_EQ(ggx_brdf(a, make_real3(0, .6, -.8), alpha), 0);
    }
    EXPECT_NEAR(ggx_brdf(make_real3(0, 0, 1), make_real3(0, 0, 1), .5), 1 / (4 * kPi * .25),
                1e-12);  // D/4, D=1/(pi a2)
}

}  // namespace
}  // namespace irradia::test
