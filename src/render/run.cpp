#include "render/run.h"

#include <algorithm>
#include <array>
#include <utility>

#include "irradia/Error.h"
#include "irradia/shared/counter_types.h"

namespace irradia {
namespace {
using Counters = std::array<std::uint32_t, IR_COUNTER_SETS * IR_COUNTER_STRIDE>;
static_assert(IR_COUNTERS <= IR_COUNTER_STRIDE);
}  // namespace

std::uint32_t asked_spp(const Scene& scene, const RenderSettings& settings) {
    return settings.spp > 0 ? static_cast<std::uint32_t>(settings.spp) : std::max(scene.sample_count, 1u);
}

Run::Run(const Scene& scene_in, Device& device_in, const RenderSettings& settings_in, const ProgressCallback& progress)
    : scene(scene_in),
      device(device_in),
      settings(settings_in),
      progress_(progress),
      start_(Clock::now()),
      phase_start_(start_),
      camera_(scene_in.info.camera) {
    seed_ = static_cast<std::uint32_t>(settings.seed) ^ static_cast<std::uint32_t>((settings.seed >> 32) * 0x9e3779b9u);
    if (device.cpu_traversal() ? scene.accel.bvh8_nodes.empty() : scene.accel.bvh2_nodes.empty())
        throw Error((scene.source.empty() ? std::string("scene") : scene.source) +
                    ": has no acceleration structure of the kind that the device traverses");
    if (device.cpu_traversal()) {
        nodes_ = device.share(scene.accel.bvh8_nodes);
        leaves_ = device.share(scene.accel.bvh8_triangles);
    } else {
        nodes_ = device.share(scene.accel.bvh2_nodes);
        leaves_ = device.share(scene.accel.bvh2_triangles);
    }
    analytics_ = device.upload(scene.analytics);
    triangles_ = device.share(scene.triangles);
    vertices_ = device.share(scene.vertices);
    materials_ = device.upload(scene.materials);
    textures_ = device.upload(scene.textures);
    texels_ = device.share(scene.texels);
    lights_ = device.upload(scene.lights);
    info_ = device.upload(&scene.info, sizeof scene.info);
    clear_statistics();
    ray_counters_ = device.allocate(sizeof(Counters));
    device.fill(ray_counters_, 0, sizeof(Counters));
    phase("upload");
}

void Run::clear_statistics() {
    statistics = {};
    statistics.spp = static_cast<int>(asked_spp(scene, settings));
    statistics.rays = {{"camera", 0}, {"hemisphere", 0}, {"bounce", 0}, {"shadow", 0}};
}

void Run::set_camera(const shared::Camera& camera) {
    shared::SceneInfo info = scene.info;
    info.camera = camera_ = camera;
    device.write(info_, &info, sizeof info);
}

void Run::see_sky(const std::vector<std::uint32_t>& tables) {
    std::vector<shared::Light> lights = scene.lights;
    if (!tables.empty()) {
        const std::size_t before = scene.texels.size() * sizeof tables[0];
        texels_ = device.allocate(before + tables.size() * sizeof tables[0]);
        device.write(texels_, scene.texels.data(), before);
        device.write(texels_, tables.data(), tables.size() * sizeof tables[0], before);
        lights[scene.info.environment_light].view = static_cast<std::uint32_t>(scene.texels.size());
    }
    device.write(lights_, lights.data(), lights.size() * sizeof lights[0]);
}

void Run::restart() {
    clear_statistics();
    start_ = phase_start_ = Clock::now();
}

namespace {

/// The kernels' variant that serves a scene: one of a few, so that scenes share compiled kernels. What each costs that
/// a scene does not need is in docs/measurements.md.
std::uint32_t kernel_features(const Scene& scene, bool specialise) {
    constexpr std::uint32_t diffuse = IR_FEATURE_ANALYTIC | IR_FEATURE_SMOOTH_NORMALS | IR_FEATURE_ENVIRONMENT |
                                      IR_FEATURE_DELTA_LIGHTS | IR_FEATURE_TEXTURES,
                            materials = diffuse | IR_FEATURE_BSDFS | IR_FEATURE_BUMPS | IR_FEATURE_ENVMAP |
                                        IR_FEATURE_TEXTURED_LIGHTS,
                            masks = materials | IR_FEATURE_MASKS, everything = masks | IR_FEATURE_THIN_LENS;
    if (!specialise) return everything;
    for (const std::uint32_t group : {0u, diffuse, materials, masks})
        if ((scene.features & ~group) == 0) return group;
    return everything;
}

}  // namespace

std::map<std::string, std::string> Run::scene_defines() const {
    const std::uint32_t features = kernel_features(scene, settings.specialise);
    std::map<std::string, std::string> defines{{"IR_FEATURES", std::to_string(features) + "u"}};
    if (aovs()) defines["IR_AOVS"] = "1";
    return defines;
}

KernelSource Run::scene_source(const std::string& file, std::map<std::string, std::string> defines) const {
    defines.merge(scene_defines());
    return {file, std::move(defines)};
}

Kernel Run::scene_kernel(const std::string& file, const std::string& name, std::map<std::string, std::string> defines,
                         int registers) {
    const KernelSource source = scene_source(file, std::move(defines));
    Kernel kernel = device.kernel(source.file, name, source.defines, registers);
    kernel.arg(nodes_)
        .arg(leaves_)
        .arg(analytics_)
        .arg(triangles_)
        .arg(vertices_)
        .arg(materials_)
        .arg(textures_)
        .arg(texels_)
        .arg(lights_)
        .arg(info_);
    return kernel;
}

std::uint32_t Run::collect_rays() {
    static constexpr std::pair<const char*, std::size_t> kinds[] = {{"camera", IR_RAYS_CAMERA},
                                                                    {"hemisphere", IR_RAYS_HEMISPHERE},
                                                                    {"bounce", IR_RAYS_BOUNCE},
                                                                    {"shadow", IR_RAYS_SHADOW}};
    Counters counters{};
    device.read(ray_counters_, counters.data(), sizeof counters);
    device.fill(ray_counters_, 0, sizeof counters);
    const auto total = [&](std::size_t counter) {
        std::uint64_t sum = 0;
        for (std::size_t i = counter; i < counters.size(); i += IR_COUNTER_STRIDE) sum += counters[i];
        return sum;
    };
    for (const auto& [kind, counter] : kinds) statistics.rays[kind] += total(counter);
    return static_cast<std::uint32_t>(total(IR_REQUESTS));
}

bool Run::direct_mis() const noexcept {
    if (settings.direct_mis != DirectMis::automatic) return settings.direct_mis == DirectMis::on;
    // Measured (README): one light sampled in solid angle is noisier with BSDF samples beside it. Disks, and spheres
    // seen from inside, are sampled by area only.
    if (scene.lights.size() != 1) return true;
    const shared::Light& l = scene.lights.front();
    return l.kind == IR_LIGHT_DISK || l.kind == IR_LIGHT_CYLINDER || l.kind == IR_LIGHT_ENVMAP ||
           (l.kind == IR_LIGHT_SPHERE && l.nx < 0);
}

bool Run::aovs() const noexcept {
    return std::any_of(settings.aovs.begin(), settings.aovs.end(),
                       [](const std::string& a) { return a == "albedo" || a == "normal" || a == "depth"; });
}

std::uint32_t Run::edges_beyond_camera() const noexcept {
    return settings.max_depth < 0 ? 0xffffffffu : static_cast<std::uint32_t>(std::max(settings.max_depth - 1, 0));
}

std::uint32_t Run::edges_beyond_hemisphere() const noexcept {
    return settings.max_depth < 0 ? 0xffffffffu : static_cast<std::uint32_t>(std::max(settings.max_depth - 2, 0));
}

void Run::report(const std::string& stage, double fraction, std::uint64_t records) {
    if (elapsed() > stop_) throw TimeIsUp{};
    if (!progress_) return;
    Progress p;
    p.stage = stage;
    p.fraction = std::clamp(fraction, 0.0, 1.0);
    p.records = records;
    p.rays = statistics.total_rays();
    p.elapsed = elapsed();
    progress_(p);
}

void Run::state(Checkpoint& c) {
    RenderStatistics& s = statistics;
    c(camera_)(s.rays)(s.phases)(s.iterations)(s.spp)(s.records)(s.radiance_records)(s.octree_depth)(s.octree_growths);
    const Clock::time_point now = Clock::now();
    Clock::duration elapsed = now - start_, of_phase = now - phase_start_;
    c(elapsed)(of_phase);
    if (!c.reading()) return;
    set_camera(camera_);
    start_ = now - elapsed;
    phase_start_ = now - of_phase;
}

void Run::phase(const std::string& name) {
    const Clock::time_point now = Clock::now();
    statistics.phases[name] += std::chrono::duration<double>(now - phase_start_).count();
    phase_start_ = now;
}

std::uint64_t RenderStatistics::total_rays() const {
    std::uint64_t sum = 0;
    for (const auto& [kind, count] : rays) sum += count;
    return sum;
}

double Run::effort() const {
    return device.description().is_cpu ? static_cast<double>(statistics.total_rays()) : elapsed();
}

double Run::elapsed() const { return std::chrono::duration<double>(Clock::now() - start_).count(); }

}  // namespace irradia
