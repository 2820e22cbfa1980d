#include "render/radiance_cache.h"

#include <algorithm>
#include <vector>

#include "cache/buffer_state.h"
#include "irradia/Error.h"

namespace irradia {
namespace {

constexpr std::size_t lanes = 8;  // of CPU devices (cl/lanes.h)
constexpr std::size_t first_records = 256;
constexpr std::size_t projecting = 16;      // work-items that share a record's cells: IR_GROUP of project_harmonics.cl
constexpr std::uint32_t table_alphas = 24;  // roughnesses, where they are a texture
constexpr float unlimited = 1e30f;          // a roughness that no lobe has

bool has_lobe(const shared::Material& m) {
    return (m.kind == IR_MATERIAL_ROUGH_CONDUCTOR || m.kind == IR_MATERIAL_ROUGH_PLASTIC) && m.alpha_u == m.alpha_v;
}

bool rough_by_texture(const shared::Material& m) { return m.alpha_texture != IR_NO_TEXTURE; }
float widest(const shared::Material& m) { return rough_by_texture(m) ? 1.0f : m.alpha_u; }

std::size_t stride_of(const RenderSettings& s) {
    const std::size_t cells = static_cast<std::size_t>(s.hemisphere_m) * static_cast<std::size_t>(s.hemisphere_n);
    return (cells + lanes - 1) / lanes * lanes;
}

}  // namespace

bool RadianceCache::useful(const Scene& scene) {
    return std::any_of(scene.materials.begin(), scene.materials.end(), has_lobe);
}

RadianceCache::RadianceCache(Run& run, const CacheSettings& settings) : run_(run), records_(run.device, settings) {
    hemispheres_.emplace(run, Hemispheres::radiance_records);
    const RenderSettings& s = run.settings;
    parameters_.stride = static_cast<std::uint32_t>(stride_of(s));
    parameters_.angles = static_cast<std::uint32_t>(s.lobe_table);
    parameters_.alphas = table_alphas;
    parameters_.trace_below = s.glossy == GlossyRule::traced ? unlimited : s.trace_below;
    parameters_.harmonics_from = s.glossy == GlossyRule::harmonics ? 0.0f
                                 : s.glossy == GlossyRule::samples ? unlimited
                                                                   : s.harmonics_from;
    parameters_.full_reach = s.glossy_reach;
    parameters_.spread = s.glossy_spread;
    parameters_.share = s.glossy_share;
    parameters_.least = s.min_spacing * s.overlap;
    // Which representations any lobe asks for: a record holds those alone.
    bool harmonics = false;
    keep_samples_ = false;
    for (const shared::Material& m : run.scene.materials) {
        if (!asks(m)) continue;
        const float narrowest = std::max(rough_by_texture(m) ? 0.0f : m.alpha_u, parameters_.trace_below);
        harmonics = harmonics || widest(m) >= parameters_.harmonics_from;
        keep_samples_ = keep_samples_ || narrowest < parameters_.harmonics_from;
    }
    parameters_.order = harmonics ? static_cast<std::uint32_t>(s.harmonics_order) : 0;
    grow(1);
}

bool RadianceCache::asks(const shared::Material& m) const {
    return has_lobe(m) && widest(m) >= parameters_.trace_below;
}

KernelSource RadianceCache::table_kernel() const {
    std::map<std::string, std::string> defines = run_.scene_defines();
    defines["IR_ORDER"] = std::to_string(parameters_.order);
    return {"tabulate_lobes.cl", std::move(defines)};
}

void RadianceCache::tabulate() {
    const std::vector<shared::Material>& materials = run_.scene.materials;
    const std::uint32_t order = parameters_.order, entry = IR_LOBE_FLOATS(order);
    std::vector<std::uint32_t> offsets(materials.size(), IR_NO_LOBE);
    std::uint32_t floats = 0;
    const auto alphas = [](const shared::Material& m) { return rough_by_texture(m) ? table_alphas : 1; };
    for (std::size_t i = 0; i < materials.size(); ++i) {
        if (!asks(materials[i])) continue;
        offsets[i] = floats;
        floats += parameters_.angles * alphas(materials[i]) * entry;
    }
    offsets_ = run_.device.upload(offsets);
    tables_ = run_.device.allocate(floats * sizeof(float));
    const Buffer list = run_.device.upload(materials);
    const KernelSource kernel = table_kernel();
    const std::size_t group = run_.device.pixel_group();
    for (std::uint32_t i = 0; i < materials.size(); ++i) {
        if (offsets[i] == IR_NO_LOBE) continue;
        const std::uint32_t rows = alphas(materials[i]);
        run_.device.kernel(kernel.file, "tabulate_lobes", kernel.defines)
            .arg(list)
            .arg(tables_)
            .arg(parameters_)
            .arg(i)
            .arg(offsets[i])
            .arg(rows)
            .run(group_count(static_cast<std::size_t>(parameters_.angles) * rows, group), group);
    }
    run_.device.finish();
}

void RadianceCache::grow(std::size_t records) {
    if (records <= capacity_ && capacity_ > 0) return;
    const std::size_t capacity = std::max({first_records, 2 * capacity_, records});
    const auto resize = [&](Buffer& buffer, std::size_t record) {
        Buffer fresh = run_.device.allocate(std::max<std::size_t>(capacity * record, 4));
        if (records_.size() > 0 && record > 0) run_.device.copy(buffer, fresh, records_.size() * record);
        run_.device.finish();
        buffer = std::move(fresh);
    };
    if (!keep_samples_ && capacity_ == 0) samples_ = run_.device.allocate(sizeof(float));
    if (keep_samples_) resize(samples_, IR_SAMPLE_FLOATS * sizeof(float) * parameters_.stride);
    resize(harmonics_, IR_HARMONIC_SETS * sizeof(float) * parameters_.order * parameters_.order);
    capacity_ = capacity;
}

std::size_t RadianceCache::record_bytes() const noexcept {
    return sizeof(shared::RecordKey) + sizeof(shared::RecordValue) +
           sizeof(float) * (keep_samples_ ? std::size_t{IR_SAMPLE_FLOATS} * parameters_.stride : 0) +
           sizeof(float) * std::size_t{IR_HARMONIC_SETS} * parameters_.order * parameters_.order;
}

void RadianceCache::project(std::uint32_t first_kept, std::uint32_t first, std::size_t count) {
    const std::size_t floats = projecting * IR_HARMONIC_SETS * parameters_.order * parameters_.order;
    if (partial_.bytes() < count * floats * sizeof(float))
        partial_ = run_.device.allocate(count * floats * sizeof(float));
    run_.device
        .kernel("project_harmonics.cl", "project_harmonics",
                {{"IR_M", std::to_string(run_.settings.hemisphere_m)},
                 {"IR_N", std::to_string(run_.settings.hemisphere_n)},
                 {"IR_GROUP", std::to_string(projecting)},
                 {"IR_ORDER", std::to_string(parameters_.order)}})
        .arg(records_.keys())
        .arg(records_.values())
        .arg(samples_)
        .arg(harmonics_)
        .arg(partial_)
        .arg(0.5f * IR_FAR_DIAGONALS * run_.scene.info.diagonal)
        .arg(parameters_.stride)
        .arg(first_kept)
        .arg(first)
        .run(count, projecting);
}

void RadianceCache::make(const Buffer& points, const RecordStack& stack, const IrradianceGrid& grid,
                         std::uint32_t salt) {
    if (stack.empty()) return;
    const Buffer indices = run_.device.upload(stack.indices);
    const std::uint32_t first = records_.reserve(stack.size());
    grow(first + stack.size());
    // Without samples to keep, they lie in a buffer that every batch uses anew.
    if (!keep_samples_) {
        const std::size_t bytes = stack.size() * IR_SAMPLE_FLOATS * sizeof(float) * parameters_.stride;
        if (samples_.bytes() < bytes) samples_ = run_.device.allocate(bytes);
    }
    const KeptSamples kept{&samples_, parameters_.stride, keep_samples_ ? 0 : first};
    hemispheres_->sample(points, indices, stack.size(), grid, records_.keys(), records_.values(), first, salt, &kept);
    if (parameters_.order > 0) project(kept.first, first, stack.size());
    records_.insert(stack.size(), points, indices);
}

bool RadianceCache::fits(const RenderSettings& settings) const { return parameters_.stride == stride_of(settings); }

void RadianceCache::rescale(float factor, const CacheSettings& settings) {
    hemispheres_.emplace(run_, Hemispheres::radiance_records);
    parameters_.least = run_.settings.min_spacing * run_.settings.overlap;
    records_.rescale(factor, settings);
}

void RadianceCache::load(const RadianceRecords& records) {
    if (records.size() == 0) return;
    if (records.stride != kept_stride() || records.order != parameters_.order) {
        const auto text = [](std::uint32_t stride, std::uint32_t order) {
            return std::to_string(stride) + " samples and harmonics of order " + std::to_string(order);
        };
        throw Error("radiance records hold " + text(records.stride, records.order) + ", expected " +
                    text(kept_stride(), parameters_.order) +
                    ", which --hemisphere, --glossy, --harmonics-from, --trace-below and --order decide");
    }
    const std::size_t first = records_.size();
    grow(first + records.size());
    const auto write = [&](Buffer& to, const std::vector<float>& from, std::size_t floats) {
        if (!from.empty())
            run_.device.write(to, from.data(), from.size() * sizeof(float), first * floats * sizeof(float));
    };
    write(samples_, records.samples, records.sample_floats());
    write(harmonics_, records.harmonics, records.harmonic_floats());
    records_.load(records.keys, records.values);
}

RadianceRecords RadianceCache::store() const {
    RadianceRecords out;
    out.keys = records_.download_keys();
    out.values = records_.download_values();
    if (out.size() == 0) return out;
    out.stride = kept_stride();
    out.order = parameters_.order;
    out.samples.resize(out.size() * out.sample_floats());
    out.harmonics.resize(out.size() * out.harmonic_floats());
    if (!out.samples.empty()) run_.device.read(samples_, out.samples.data(), out.samples.size() * sizeof(float));
    if (!out.harmonics.empty())
        run_.device.read(harmonics_, out.harmonics.data(), out.harmonics.size() * sizeof(float));
    return out;
}

void RadianceCache::state(Checkpoint& c) {
    records_.state(c);
    std::uint64_t capacity = capacity_;
    c(capacity)(parameters_);
    capacity_ = capacity;
    const std::size_t sample = IR_SAMPLE_FLOATS * sizeof(float) * kept_stride(),
                      harmonic = IR_HARMONIC_SETS * sizeof(float) * parameters_.order * parameters_.order;
    exchange(c, run_.device, samples_, records_.size() * sample, capacity_ * sample);
    exchange(c, run_.device, harmonics_, records_.size() * harmonic, capacity_ * harmonic);
}

Kernel& RadianceCache::bind(Kernel& kernel, bool placement) const {
    return records_.bind(kernel, placement).arg(samples_).arg(harmonics_).arg(tables_).arg(offsets_).arg(parameters_);
}

}  // namespace irradia
