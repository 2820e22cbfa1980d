// Runs the kernels of cl/bsdf_test.cl on the default device: triangles in the plane z = 0, a material each.
#pragma once
#include <array>
#include <bit>
#include <random>

#include "device.h"
#include "irradia/Scene.h"
#include "scene/build.h"

namespace irradia::test {

using Vec = std::array<double, 3>;
inline double dot(const Vec& a, const Vec& b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }
inline double largest(const Vec& a) { return std::max({a[0], a[1], a[2]}); }
/// Of polar angle and azimuth.
inline Vec direction_at(double cosine, double phi) {
    const double sine = std::sqrt(std::max(1 - cosine * cosine, 0.0));
    return {sine * std::cos(phi), sine * std::sin(phi), cosine};
}

struct BsdfValue {
    Vec diffuse, glossy;
    double density;
    [[nodiscard]] Vec sum() const { return {diffuse[0] + glossy[0], diffuse[1] + glossy[1], diffuse[2] + glossy[2]}; }
};
struct BsdfSample {
    bool valid;
    Vec direction, diffuse, glossy;
    double density, eta;
    [[nodiscard]] Vec weight() const {
        return {diffuse[0] + glossy[0], diffuse[1] + glossy[1], diffuse[2] + glossy[2]};
    }
};

// ---- materials, as the loader fills them in
// --------------------------------------------------------------------------
inline shared::Material of_kind(std::uint32_t kind, double alpha = 0.1, bool beckmann = false) {
    shared::Material m = blank_material();
    m.kind = kind;
    m.alpha_u = m.alpha_v = static_cast<float>(alpha);
    if (beckmann) m.flags |= IR_MATERIAL_BECKMANN;
    return m;
}
inline shared::Material of_colour(shared::Material m, double r, double g, double b) {
    m.r = static_cast<float>(r), m.g = static_cast<float>(g), m.b = static_cast<float>(b);
    return m;
}
/// Of index eta + i k in all channels. k = 1e4: reflects everything.
inline shared::Material conductor(std::uint32_t kind, double eta, double k, double alpha = 0.1, bool beckmann = false) {
    shared::Material m = of_kind(kind, alpha, beckmann);
    m.eta_r = m.eta_g = m.eta_b = static_cast<float>(eta);
    m.k_r = m.k_g = m.k_b = static_cast<float>(k);
    return m;
}
inline shared::Material dielectric(std::uint32_t kind, double eta, double alpha = 0.1, bool beckmann = false) {
    shared::Material m = of_kind(kind, alpha, beckmann);
    m.eta = static_cast<float>(eta);
    return m;
}
/// Its coat is added by BsdfKernels.
inline shared::Material plastic(std::uint32_t kind, double eta, double albedo, bool nonlinear, double alpha = 0.1,
                                bool beckmann = false) {
    shared::Material m = of_colour(of_kind(kind, alpha, beckmann), albedo, albedo, albedo);
    m.eta = static_cast<float>(eta);
    if (nonlinear) m.flags |= IR_MATERIAL_NONLINEAR;
    m.specular_weight = static_cast<float>(1 / (1 + albedo));
    return m;
}

class BsdfKernels {
public:
    BsdfKernels() {
        scene_.vertices = {{0, 0, 0, 0, 0, 1, 0, 0}, {1, 0, 0, 0, 0, 1, 1, 0},  {0, 1, 0, 0, 0, 1, 0, 1},
                           {0, 0, 0, 0, 0, 1, 0, 0}, {1, 0, 0, 0, 0, 1, 0, -1}, {0, 1, 0, 0, 0, 1, 1, 0}};
    }

    /// A triangle of this material; its number. Turned: u runs along y, v against x; otherwise along x and y.
    std::uint32_t add(shared::Material m, bool both_sides = false, bool turned = false) {
        const auto index = static_cast<std::uint32_t>(scene_.materials.size());
        if (both_sides || m.kind == IR_MATERIAL_DIELECTRIC || m.kind == IR_MATERIAL_THIN_DIELECTRIC ||
            m.kind == IR_MATERIAL_ROUGH_DIELECTRIC)
            m.back = static_cast<int>(index);
        add_coat(m);
        scene_.materials.push_back(m);
        shared::Triangle t{};
        t.nz = 1;
        t.flags = IR_TRIANGLE_FLAT | IR_TRIANGLE_HAS_UV;
        t.v0 = turned ? 3 : 0, t.v1 = t.v0 + 1, t.v2 = t.v0 + 2;
        t.material = index;
        t.light = IR_NO_LIGHT;
        scene_.triangles.push_back(t);
        buffers_.clear();
        return index;
    }
    /// A texture of one colour; its number.
    int add_texture(const Vec& colour) {
        shared::Texture t{};
        t.offset = static_cast<std::uint32_t>(scene_.texels.size());
        t.width = t.height = 1;
        t.format = IR_TEXTURE_RGB32F;
        t.m00 = t.m11 = 1;
        for (const double c : colour) scene_.texels.push_back(std::bit_cast<std::uint32_t>(static_cast<float>(c)));
        scene_.textures.push_back(t);
        return static_cast<int>(scene_.textures.size()) - 1;
    }
    /// With a triangle's number: of its BSDF the density, or samples, of the glossy part alone.
    static constexpr std::uint32_t lobe = 0x80000000u;
    [[nodiscard]] const shared::Material& material(std::uint32_t triangle) const {
        return scene_.materials.at(triangle & ~lobe);
    }

    struct Pair {
        std::uint32_t triangle;
        Vec view, direction;
    };
    std::vector<BsdfValue> evaluate(const std::vector<Pair>& pairs) {
        std::vector<std::uint32_t> asked;
        std::vector<float> in;
        for (const Pair& p : pairs) {
            asked.push_back(p.triangle);
            add_to(in, p.view);
            add_to(in, p.direction);
        }
        const std::vector<float> out = run("test_bsdf_evaluate", asked, in, 7);
        std::vector<BsdfValue> all(pairs.size());
        for (std::size_t i = 0; i < all.size(); ++i) {
            const float* a = out.data() + 7 * i;
            all[i] = {{a[0], a[1], a[2]}, {a[3], a[4], a[5]}, a[6]};
        }
        return all;
    }

    struct Draw {
        std::uint32_t triangle;
        Vec view, u;
    };
    std::vector<BsdfSample> sample(const std::vector<Draw>& draws) {
        std::vector<std::uint32_t> asked;
        std::vector<float> in;
        for (const Draw& d : draws) {
            asked.push_back(d.triangle);
            add_to(in, d.view);
            add_to(in, d.u);
        }
        const std::vector<float> out = run("test_bsdf_sample", asked, in, 12);
        std::vector<BsdfSample> all(draws.size());
        for (std::size_t i = 0; i < all.size(); ++i) {
            const float* a = out.data() + 12 * i;
            all[i] = {a[0] != 0, {a[1], a[2], a[3]}, {a[4], a[5], a[6]}, {a[7], a[8], a[9]}, a[10], a[11]};
        }
        return all;
    }

private:
    Scene scene_;
    std::vector<Buffer> buffers_;

    static void add_to(std::vector<float>& to, const Vec& v) {
        for (const double x : v) to.push_back(static_cast<float>(x));
    }
    void add_coat(shared::Material& m) {
        if (m.kind == IR_MATERIAL_PLASTIC) {
            m.coat = 1;
            m.internal_reflectance =
                static_cast<float>(loader::smooth_internal_reflectance(static_cast<double>(m.eta)));
        }
        if (m.kind != IR_MATERIAL_ROUGH_PLASTIC) return;
        for (const shared::Material& other : scene_.materials)
            if (other.kind == m.kind && other.eta == m.eta && other.alpha_u == m.alpha_u &&
                ((other.flags ^ m.flags) & IR_MATERIAL_BECKMANN) == 0) {
                m.coat = other.coat, m.coat_table = other.coat_table;
                m.internal_reflectance = other.internal_reflectance;
                return;
            }
        const loader::RoughCoat coat = loader::rough_coat(static_cast<double>(m.eta), static_cast<double>(m.alpha_u),
                                                          (m.flags & IR_MATERIAL_BECKMANN) != 0);
        m.coat = static_cast<std::uint32_t>(2 + scene_.materials.size());
        m.coat_table = static_cast<std::uint32_t>(scene_.texels.size());
        m.internal_reflectance = static_cast<float>(coat.internal_reflectance);
        for (const float t : coat.transmittance) scene_.texels.push_back(std::bit_cast<std::uint32_t>(t));
    }

    void upload() {
        Device& d = device();
        const auto put = [&]<class T>(const std::vector<T>& v) {
            buffers_.push_back(v.empty() ? d.upload(std::vector<std::uint32_t>{0}) : d.upload(v));
        };
        scene_.info.triangle_count = static_cast<std::uint32_t>(scene_.triangles.size());
        const std::vector<std::uint32_t> nothing;  // no rays are traced
        put(nothing), put(nothing), put(nothing), put(scene_.triangles), put(scene_.vertices);
        put(scene_.materials), put(scene_.textures), put(scene_.texels), put(nothing);
        put(std::vector<shared::SceneInfo>{scene_.info});
    }
    std::vector<float> run(const char* name, const std::vector<std::uint32_t>& asked, const std::vector<float>& in,
                           std::size_t outputs) {
        if (buffers_.empty()) upload();
        std::uint32_t features = IR_FEATURE_TEXTURES | IR_FEATURE_BSDFS;
        for (const shared::Material& m : scene_.materials)
            if (m.map != IR_NO_TEXTURE) features |= IR_FEATURE_BUMPS;
        Device& d = device();
        std::vector<float> out(asked.size() * outputs);
        const Buffer of = d.upload(asked), from = d.upload(in);
        Buffer to = d.upload(out);
        Kernel kernel = d.kernel("bsdf_test.cl", name, {{"IR_FEATURES", std::to_string(features) + "u"}});
        for (const Buffer& b : buffers_) kernel.arg(b);
        kernel.arg(of)
            .arg(from)
            .arg(to)
            .arg(static_cast<std::uint32_t>(asked.size()))
            .run((asked.size() + 63) / 64, 64);
        d.read(to, out.data(), out.size() * sizeof(float));
        return out;
    }
};

}  // namespace irradia::test
