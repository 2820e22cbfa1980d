// Radiance records made of hemispheres on the host, and the questions that cl/radiance_test.cl asks them.
#pragma once
#include "radiance_kernels.h"

namespace irradia::test {

constexpr double kFar = 1e5;  ///< where records keep what misses everything: 1e4 times a scene's diagonal of 10

struct PlacedRecord {
    real3 p;
    Hemisphere h;
    double support = 1;
    std::uint32_t coat = 0;
};

/// A hemisphere of cell centres that light comes into from infinitely far away; radiance(w), local frame, is RGB.
template <class F>
Hemisphere environment(real3 normal, unsigned m, unsigned n, const F& radiance) {
    Hemisphere h{m, n, host::make_frame(normal), {}};
    for (unsigned i = 0; i < m * n; ++i) {
        const real3 d = host::stratum_direction(i / n, i % n, m, n, .5, .5);
        h.samples.push_back({d, {0, 0, 1}, radiance(d), kMiss});
    }
    return h;
}

/// Irradiance of a record's samples, pi / (m n) times their sum.
inline real3 record_irradiance(const Hemisphere& h) {
    real3 sum{0, 0, 0};
    for (const HemisphereSample& s : h.samples) sum += s.radiance;
    return sum * (kPi / (h.m * h.n));
}

/// Records in device memory as RadianceCache has them: samples (entries as in shared/radiance_types.h), harmonics if
/// the tables' order is not 0. All of one number of strata.
class RadianceRecords {
public:
    RadianceRecords(Device& device, const LobeTables& tables, const std::vector<PlacedRecord>& records)
        : parameters(tables.parameters), device_(device), tables_(tables), cache_(device, settings()) {
        const Hemisphere& first = records.at(0).h;
        parameters.stride = (first.m * first.n + 7) / 8 * 8;
        for (const PlacedRecord& r : records) keep(r);
        samples_ = device.upload(kept_);
        offsets_ = device.upload(tables.offsets);
        cache_.reserve(records.size());
        device.write(const_cast<Buffer&>(cache_.keys()), keys_.data(), keys_.size() * sizeof keys_[0]);
        device.write(const_cast<Buffer&>(cache_.values()), values_.data(), values_.size() * sizeof values_[0]);
        cache_.insert(records.size(), cache_.keys(), cache_.keys());  // no neighbour clamp: points are not read
        project(first.m, first.n);
    }

    struct Question {
        std::uint32_t material;
        double alpha;
        real3 p, n, view;
    };
    struct Answer {
        bool cached, found;
        real3 radiance;
        bool covered;
        double spread, least;
    };
    std::vector<Answer> look_up(const std::vector<Question>& questions) {
        const auto out = ask("test_radiance_lookup", questions, nullptr, 8);
        std::vector<Answer> all;
        for (std::size_t i = 0; i < out.size(); i += 8)
            all.push_back(
                {out[i] != 0, out[i + 1] != 0, vector_at(out, i + 2), out[i + 5] != 0, out[i + 6], out[i + 7]});
        return all;
    }

    struct Sums {
        real3 weighted, total, irradiance;
        [[nodiscard]] real3 ratio() const { return {weighted.x / total.x, weighted.y / total.y, weighted.z / total.z}; }
    };
    struct BothSums {
        Sums samples, harmonics;
    };
    /// Of record records[i] at question i.
    std::vector<BothSums> sums(const std::vector<Question>& questions, const std::vector<std::uint32_t>& records) {
        const Buffer list = device_.upload(records);
        const auto out = ask("test_record_sums", questions, &list, 18);
        std::vector<BothSums> all;
        const auto at = [&](std::size_t i) {
            return Sums{vector_at(out, i), vector_at(out, i + 3), vector_at(out, i + 6)};
        };
        for (std::size_t i = 0; i < out.size(); i += 18) all.push_back({at(i), at(i + 9)});
        return all;
    }

    /// IR_HARMONIC_SETS times order^2 numbers a record.
    [[nodiscard]] std::vector<double> harmonics() const {
        std::vector<float> out(keys_.size() * floats());
        device_.read(harmonics_, out.data(), out.size() * sizeof(float));
        return {out.begin(), out.end()};
    }
    /// Harmonics and irradiances as if all light were `factor` times as bright, which the samples are not.
    void brighten_harmonics(float factor) {
        std::vector<float> all(keys_.size() * floats());
        device_.read(harmonics_, all.data(), all.size() * sizeof(float));
        for (float& x : all) x *= factor;
        harmonics_ = device_.upload(all);
        for (shared::RecordValue& v : values_)
            for (float& e : v.e) e *= factor;
        device_.write(const_cast<Buffer&>(cache_.values()), values_.data(), values_.size() * sizeof values_[0]);
    }
    void forbid(std::uint32_t material) {
        std::vector<std::uint32_t> offsets = tables_.offsets;
        offsets.at(material) = IR_NO_LOBE;
        offsets_ = device_.upload(offsets);
    }

    shared::RadianceParameters parameters;

private:
    static CacheSettings settings() {
        CacheSettings s;
        s.lower = {-5, -5, -5};
        s.upper = {5, 5, 5};
        s.clamp_slope = 0;
        return s;
    }
    [[nodiscard]] std::size_t floats() const {
        return std::size_t{IR_HARMONIC_SETS} * parameters.order * parameters.order;
    }

    void keep(const PlacedRecord& r) {
        const Hemisphere& h = r.h;
        const std::size_t stride = parameters.stride, first = kept_.size();
        kept_.resize(first + IR_SAMPLE_FLOATS * stride);
        const auto put = [&](std::size_t set, std::size_t i, double x) {
            kept_[first + set * stride + i] = static_cast<float>(x);
        };
        for (std::size_t i = 0; i < stride; ++i) {
            if (i >= h.samples.size()) {
                put(2, i, 1);
                continue;
            }
            const HemisphereSample& s = h.samples[i];
            const bool miss = s.distance >= kMiss;
            const double d = miss ? kFar : s.distance;
            const real3 w = to_world(h.frame, s.direction), p = d * w, q = miss ? -w : to_world(h.frame, s.normal);
            put(0, i, p.x), put(1, i, p.y), put(2, i, p.z);
            put(3, i, q.x), put(4, i, q.y), put(5, i, q.z);
            put(6, i, d * d / (std::max(std::abs(host::dot(q, w)), 1e-4) * std::max(s.direction.z, 1e-3)));
            put(7, i, s.radiance.x), put(8, i, s.radiance.y), put(9, i, s.radiance.z);
        }
        shared::RecordKey key{};
        const auto f = [](double x) { return static_cast<float>(x); };
        key.px = f(r.p.x), key.py = f(r.p.y), key.pz = f(r.p.z);
        key.nx = f(h.frame.n.x), key.ny = f(h.frame.n.y), key.nz = f(h.frame.n.z);
        key.t2x = f(h.frame.t.x), key.t2y = f(h.frame.t.y), key.t2z = f(h.frame.t.z);
        key.support1 = key.support2 = f(r.support);
        key.coat = r.coat;
        keys_.push_back(key);
        shared::RecordValue value{};
        const real3 e = record_irradiance(h);
        value.e[0] = f(e.x), value.e[1] = f(e.y), value.e[2] = f(e.z);
        values_.push_back(value);
    }

    void project(unsigned m, unsigned n) {
        harmonics_ = device_.allocate(std::max<std::size_t>(keys_.size() * floats(), 1) * sizeof(float));
        if (parameters.order == 0) return;
        constexpr std::size_t group = 16;
        const Buffer partial = device_.allocate(keys_.size() * group * floats() * sizeof(float));
        device_
            .kernel("project_harmonics.cl", "project_harmonics",
                    {{"IR_M", std::to_string(m)},
                     {"IR_N", std::to_string(n)},
                     {"IR_GROUP", std::to_string(group)},
                     {"IR_ORDER", std::to_string(parameters.order)}})
            .arg(cache_.keys())
            .arg(cache_.values())
            .arg(samples_)
            .arg(harmonics_)
            .arg(partial)
            .arg(static_cast<float>(.5 * kFar))
            .arg(parameters.stride)
            .arg(0u)
            .arg(0u)
            .run(keys_.size(), group);
        device_.finish();
    }

    std::vector<double> ask(const char* name, const std::vector<Question>& questions, const Buffer* records,
                            std::size_t outputs) {
        Inputs in;
        for (const Question& q : questions) in.add(q.material).add(q.alpha).add(q.p).add(q.n).add(q.view);
        std::vector<float> out(questions.size() * outputs);
        const Buffer from = device_.upload(in.values()), to = device_.upload(out);
        std::map<std::string, std::string> defines = cache_.defines();
        defines["IR_FEATURES"] = "33u";
        Kernel kernel = device_.kernel("radiance_test.cl", name, defines);
        cache_.bind(kernel, false).arg(samples_).arg(harmonics_).arg(tables_.buffer()).arg(offsets_).arg(parameters);
        kernel.arg(tables_.list()).arg(from);
        if (records != nullptr) kernel.arg(*records);
        kernel.arg(to).arg(static_cast<std::uint32_t>(questions.size())).run((questions.size() + 15) / 16, 16);
        device_.read(to, out.data(), out.size() * sizeof(float));
        return {out.begin(), out.end()};
    }

    Device& device_;
    const LobeTables& tables_;
    RecordCache cache_;
    std::vector<float> kept_;
    std::vector<shared::RecordKey> keys_;
    std::vector<shared::RecordValue> values_;
    Buffer samples_, harmonics_, offsets_;
};

/// The room of hemisphere_cells.json (six walls of different grey), in colour: red as it is, green its negative, blue
/// constant.
inline const std::vector<Rectangle>& coloured_room() {
    static const std::vector<Rectangle> room = [] {
        for (const json& c : load_vectors("hemisphere_cells", "cases"))
            if (c["name"] == "room_mid") return rectangles_of(c);
        throw std::runtime_error("hemisphere_cells.json has no room_mid");
    }();
    return room;
}
inline PlacedRecord room_record(real3 p, real3 normal, unsigned m, unsigned n, std::mt19937& random,
                                double support = 1) {
    PlacedRecord r{p, sample_scene(coloured_room(), p, normal, m, n, random), support};
    for (HemisphereSample& s : r.h.samples) s.radiance = {s.radiance.x, 1.2 - s.radiance.x, .7};
    return r;
}

}  // namespace irradia::test
