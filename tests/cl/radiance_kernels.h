// Runs the kernels of cl/radiance_test.cl: lobes, their tables, radiance records made of hemispheres on the host.
#pragma once
#include "bsdf_kernels.h"
#include "cache/RecordCache.h"
#include "hemisphere.h"
#include "irradia/shared/radiance_types.h"

namespace irradia::host {
#define R(x) x
#include "cl/fresnel.h"
#include "cl/microfacet.h"
#undef R
}  // namespace irradia::host

namespace irradia::test {

/// Every test in both dialects of the kernels: "cpu" has lanes of eight floats, "gpu" of one.
class RadianceTest : public ::testing::TestWithParam<const char*> {
protected:
    static Device& device() { return test::device(GetParam()); }
};
inline std::string traversal_name(const ::testing::TestParamInfo<const char*>& info) { return info.param; }

/// The conductors of src/scene/indices.cpp that the tests use: "none", or eta and k of R, G, B there.
inline shared::Material metal(const std::string& name, double alpha, bool beckmann = false) {
    static const std::map<std::string, std::array<double, 6>> indices{
        {"none", {0, 0, 0, 1, 1, 1}},
        {"Cu", {0.2010055, 0.9237495, 1.102215, 3.913262, 2.453045, 2.14209}},
        {"Al", {1.657501, 0.8804047, 0.5212445, 9.223811, 6.269502, 4.837004}},
        {"Au", {0.143036, 0.3753071, 1.442045, 3.982997, 2.385556, 1.603359}}};
    shared::Material m = of_kind(IR_MATERIAL_ROUGH_CONDUCTOR, alpha, beckmann);
    const auto f = [&](std::size_t i) { return static_cast<float>(indices.at(name)[i]); };
    m.eta_r = f(0), m.eta_g = f(1), m.eta_b = f(2), m.k_r = f(3), m.k_g = f(4), m.k_b = f(5);
    return m;
}
inline shared::Material coated(double eta, double alpha, bool beckmann = false) {
    return plastic(IR_MATERIAL_ROUGH_PLASTIC, eta, 0.5, false, alpha, beckmann);
}

inline real3 to_real3(const Vec& v) { return {v[0], v[1], v[2]}; }

// ---- lobes in double
// -------------------------------------------------------------------------------------------------

/// Reflectance of a material's facets at cosine c.
inline Vec facet_fresnel(const shared::Material& m, double c) {
    if (m.kind == IR_MATERIAL_ROUGH_PLASTIC) {
        double unused;
        const double f = host::fresnel_dielectric(c, static_cast<double>(m.eta), &unused);
        return {f, f, f};
    }
    const auto one = [c](float eta, float k) {
        return host::fresnel_conductor(c, static_cast<double>(eta), static_cast<double>(k));
    };
    return {one(m.eta_r, m.k_r), one(m.eta_g, m.k_g), one(m.eta_b, m.k_b)};
}
/// The same, but conductors' as Schlick has it: what lobe.h weighs samples by.
inline Vec schlick_fresnel(const shared::Material& m, double c) {
    if (m.kind == IR_MATERIAL_ROUGH_PLASTIC) return facet_fresnel(m, c);
    const Vec f0 = facet_fresnel(m, 1);
    const double s = std::pow(1 - c, 5);
    return {f0[0] + (1 - f0[0]) * s, f0[1] + (1 - f0[1]) * s, f0[2] + (1 - f0[2]) * s};
}

/// BSDF times cosine of facets that reflect everything, local frame; *c: between the view and the facet.
inline double facet_lobe(const host::Microfacets& f, real3 wi, real3 wo, double* c) {
    const real3 h = host::normalize(wi + wo);
    *c = host::dot(wi, h);
    return host::microfacet_density(&f, h) * host::smith_g1(&f, wi, h) * host::smith_g1(&f, wo, h) / (4 * wi.z);
}
inline host::Microfacets facets_of(const shared::Material& m, double alpha) {
    return {alpha, alpha, (m.flags & IR_MATERIAL_BECKMANN) != 0};
}

/// The BSDF times cosine itself over the hemisphere, local frame: visit(direction, its share of each channel). By
/// midpoints over facets whose slope is roughness x / (1 - x), and azimuth; 512 steps are good to 1e-4 of the sum
/// (against 2000), most lobes far better.
template <class F>
void integrate_lobe(const shared::Material& m, double alpha, real3 wi, const F& visit) {
    constexpr int steps = 512;
    const host::Microfacets facets = facets_of(m, alpha);
    for (int i = 0; i < steps; ++i)
        for (int j = 0; j < steps; ++j) {
            const double x = (i + .5) / steps, tangent = alpha * x / (1 - x), z = 1 / std::sqrt(1 + tangent * tangent);
            const real3 h = to_real3(direction_at(z, 2 * kPi * (j + .5) / steps));
            const double h_view = host::dot(wi, h);
            const real3 wo = h * (2 * h_view) - wi;
            if (!(h_view > 0 && wo.z > 0)) continue;
            // dw = 4 (h.v) dh, dh = sin dtheta dphi, dtheta = cos^2 dtan
            const double dh = tangent * z * z * z * alpha / ((1 - x) * (1 - x)) * 2 * kPi / (steps * steps);
            double c;
            const double share = facet_lobe(facets, wi, wo, &c) * 4 * h_view * dh;
            const Vec f = facet_fresnel(m, c);
            visit(wo, Vec{share * f[0], share * f[1], share * f[2]});
        }
}

// ---- tables
// ----------------------------------------------------------------------------------------------------------

/// The materials and their tables, as RadianceCache makes them.
class LobeTables {
public:
    LobeTables(Device& device, std::vector<shared::Material> materials, std::uint32_t order, std::uint32_t angles = 64,
               std::uint32_t alphas = 24)
        : materials_(std::move(materials)), list_(device.upload(materials_)), device_(device) {
        parameters.order = order;
        parameters.angles = angles;
        parameters.alphas = alphas;
        parameters.harmonics_from = 1e30f;
        parameters.full_reach = 1e-4f;
        std::uint32_t floats = 0;
        for (const shared::Material& m : materials_) {
            offsets.push_back(floats);
            floats += angles * rows(m) * entry();
        }
        buffer_ = device.allocate(floats * sizeof(float));
        for (std::uint32_t i = 0; i < materials_.size(); ++i) {
            const std::uint32_t count = angles * rows(materials_[i]);
            device
                .kernel("tabulate_lobes.cl", "tabulate_lobes",
                        {{"IR_FEATURES", "33u"}, {"IR_ORDER", std::to_string(order)}})
                .arg(list_)
                .arg(buffer_)
                .arg(parameters)
                .arg(i)
                .arg(offsets[i])
                .arg(rows(materials_[i]))
                .run((count + 15) / 16, 16);
        }
    }
    /// Floats of an entry of the table.
    [[nodiscard]] std::uint32_t entry() const { return IR_LOBE_FLOATS(parameters.order); }
    [[nodiscard]] const Buffer& buffer() const { return buffer_; }
    [[nodiscard]] const Buffer& list() const { return list_; }
    [[nodiscard]] const shared::Material& material(std::size_t i) const { return materials_.at(i); }

    struct Question {
        bool textured;
        double alpha, cosine;
    };
    /// entry() values each.
    std::vector<double> values(std::size_t material, const std::vector<Question>& questions) {
        Inputs in;
        for (const Question& q : questions) in.add(q.textured).add(q.alpha).add(q.cosine);
        std::vector<float> out(questions.size() * entry());
        const Buffer from = device_.upload(in.values()), to = device_.upload(out);
        device_.kernel("radiance_test.cl", "test_lobe_values", {{"IR_FEATURES", "33u"}})
            .arg(buffer_)
            .arg(parameters)
            .arg(offsets.at(material))
            .arg(from)
            .arg(to)
            .arg(static_cast<std::uint32_t>(questions.size()))
            .run((questions.size() + 15) / 16, 16);
        device_.read(to, out.data(), out.size() * sizeof(float));
        return {out.begin(), out.end()};
    }

    shared::RadianceParameters parameters{};
    std::vector<std::uint32_t> offsets;

private:
    [[nodiscard]] std::uint32_t rows(const shared::Material& m) const {
        return m.alpha_texture == IR_NO_TEXTURE ? 1 : parameters.alphas;
    }
    std::vector<shared::Material> materials_;
    Buffer list_, buffer_;
    Device& device_;
};

}  // namespace irradia::test
