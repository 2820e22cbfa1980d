// The methods: irradiance caching, plain gathering, and the unbiased path tracer that judges both.
#pragma once
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "irradia/Device.h"
#include "irradia/ErrorReport.h"
#include "irradia/Image.h"
#include "irradia/Scene.h"

namespace irradia {

enum class Method {
    irradiance,  ///< irradiance caching: hemispheres at few points, interpolation elsewhere (known, chosen error)
    radiance,    ///< irradiance caching, and radiance caching for what rough glossy surfaces reflect
    gather,      ///< a hemisphere at every pixel sample, no cache: what the cache's time is compared with
    path         ///< the etalon: unbiased path tracing with next-event estimation and MIS
};
enum class GradientRule { none, ward, crease };        ///< theory 3.2, 3.3
enum class RadiusRule { harmonic, minimum, hessian };  ///< (1.14), (1.15), theory 6
enum class WeightRule { ward, tabellion, cubic };      ///< (1.8), (1.11)-(1.13), a bell: IR_WEIGHT_* in this order
enum class GlossyRule {
    automatic,  ///< by roughness: traced, from samples, from harmonics
    samples,    ///< radiance records keep their hemisphere's samples (theory 7)
    harmonics,  ///< radiance records keep coefficients in hemispherical harmonics
    traced      ///< no radiance records: rays follow the lobe and end in the irradiance cache
};
enum class DirectMis {
    automatic,  ///< on, unless the scene's only light is one that can be sampled in solid angle
    on,         ///< direct light by light and BSDF samples, weighed against each other
    off         ///< light samples alone
};

class Checkpoint;
struct RecordSet;

/// Sets of settings, each measured to be quick for its error: about 3 %, 2 %, 1 % and .5 % relative RMSE on a Cornell box
/// (docs/measurements.md; other scenes differ).
enum class Quality { draft, medium, fine, finest };

constexpr int largest_harmonics_order = 12;  ///< IR_HARMONICS_MAX of cl/harmonics.h

/// What is asked of a render. Defaults are stated here and nowhere else.
struct RenderSettings {
    Method method = Method::irradiance;
    float accuracy = 0.2f;  ///< `a` of (1.8): allowed error; smaller = more records. Records grow as 1/a².
    int hemisphere_m = 16;  ///< rings of a hemisphere (1.3)
    int hemisphere_n = 32;  ///< sectors of a hemisphere
    int spp = 0;            ///< samples a pixel; 0 = the scene file's
    float pixel_error = 0;  ///< caching: a pixel takes samples (at least 16) until its standard error is below this
                            ///< part of the picture's mean, or it has spp of them; 0 = every pixel takes all
    std::uint64_t seed = 0;
    int max_depth = -1;  ///< path edges: 1 = emitters only, 2 = + direct light, ...; -1 = unlimited
    GradientRule gradients = GradientRule::crease;
    RadiusRule radius = RadiusRule::hessian;
    WeightRule weight = WeightRule::cubic;
    bool neighbour_clamp = true;                  ///< theory 4.4
    bool gradient_limit = true;                   ///< R <= E / |grad_t E|, theory 4.4
    bool in_front = true;                         ///< (1.10), theory 4.3
    bool reach_limit = true;                      ///< no record reaches past the nearest surface that it sees: no
                                                  ///< leaks through thin walls, more records in corners
    DirectMis direct_mis = DirectMis::automatic;  ///< where direct light and a look-up meet; path always uses both
    bool share_lookups = true;  ///< one look-up for the samples of a pixel that lie on one smooth patch
    float firefly = 100;        ///< gradients take a direction as at most this many times the mean of its
                                ///< hemisphere (theory 4.6), E does not; 0 = as it is
    float overlap = 1.75f;      ///< supports reach this much farther than the spacing at which records are placed:
                                ///< more records are averaged, at no more records
    bool grid = true;           ///< irradiance: hemisphere rays end in the irradiance grid (cl/irradiance_grid.h);
                                ///< false: they go on as paths, unbiased and slower
    int grid_paths = 1 << 18;   ///< paths that fill the grid
    bool learn_sky = true;      ///< but for path: light samples of an environment picture by what is seen of it from
                                ///< where they are taken (cl/sky_view.h); unbiased either way
    GlossyRule glossy = GlossyRule::automatic;  ///< radiance: how lobes of rough surfaces are answered
    float trace_below = 0.15f;                  ///< lobes of less roughness are traced, [0, 1]
    float glossy_share = 0.2f;  ///< lobes that reflect less than this share of what their surface reflects are traced
    float harmonics_from = 2.0f;     ///< automatic: lobes of at least this roughness are answered by harmonics
    int harmonics_order = 5;        ///< bands of the harmonics, 1 to 12: order² coefficients a channel
    int lobe_table = 64;            ///< entries over the view's angle of each lobe's table, 4 to 1024
    float glossy_accuracy = 0.2f;   ///< radiance records reach this much of the harmonic mean distance
    float glossy_reach = 0.3f;      ///< harmonics: lobes of less roughness use records less far, by the root of the ratio
    float glossy_spread = 0.1f;     ///< records that disagree by more than this want another between them; 0 = off
    float min_spacing = 1.5f;       ///< least support of a record, pixels
    float max_spacing = 30.0f;      ///< largest support of a record, pixels
    float gap_spacing = 0.3f;       ///< least support in narrow places, where it is below min_spacing, pixels
    bool specialise = true;         ///< kernels know only what the scene contains; false: everything, to measure it
    bool report_error = false;      ///< estimate the picture's error in the end, by paths of its own (theory 8)
    float error_share = 0.2f;       ///< of the picture's rays (GPUs: of its time): what the estimate may take
    float target_error = 0;         ///< render until rel_rmse's 95 % interval ends below this: chooses what a quality
                                    ///< sets, by what probes find; 0 = off
    float time_limit = 0;           ///< seconds, of a search for less error; without target_error as little as can be had
                                    ///< until then; 0 = none
    std::vector<std::string> aovs;  ///< of aov_names()
};

/// Sets accuracy, hemisphere, spacing, paths of the grid, samples a pixel and their error to those of a quality.
void apply_quality(RenderSettings& settings, Quality quality);

/// Layers that --aov can ask for: direct, indirect, albedo, normal, depth, records, counted (1 where the estimate of the
/// error counts a pixel).
const std::vector<std::string>& aov_names();

struct Progress {
    std::string stage;    ///< "grid", "records", "shade", "gather", "path", "probes"
    double fraction = 0;  ///< of the whole render, 0..1
    std::uint64_t records = 0;
    std::uint64_t rays = 0;
    double elapsed = 0;  ///< seconds since render() began
};
using ProgressCallback = std::function<void(const Progress&)>;

struct RenderStatistics {
    std::map<std::string, StageTime> stages;    ///< device time by kernel and transfer
    std::map<std::string, std::uint64_t> rays;  ///< "camera", "hemisphere", "bounce", "shadow"
    std::map<std::string, double> phases;       ///< wall seconds by phase: upload, records, fill, shade, ...
    std::uint64_t records = 0, octree_nodes = 0, octree_entries = 0, octree_depth = 0, octree_growths = 0;
    std::uint64_t radiance_records = 0;       ///< beside `records`; each takes radiance_record_bytes
    std::uint64_t radiance_record_bytes = 0;  ///< key, value, samples and harmonics
    std::uint64_t iterations = 0;  ///< rounds in which records were looked for and made
    int spp = 0;
    double mean_spp = 0;  ///< samples that pixels took on average
    double seconds = 0;   ///< wall time of render()

    [[nodiscard]] std::uint64_t total_rays() const;  ///< of all kinds
};

struct RenderResult {
    Image image;
    RenderStatistics statistics;
    std::optional<ErrorReport> error;  ///< if report_error, target_error or time_limit ask for it
};

/// Renders `scene` on `device`. The picture is linear radiance (W·m⁻²·sr⁻¹ in Rec. 709 RGB); layers follow
/// settings.aovs. Same seed, device and settings give the same bytes, whatever the number of threads. Throws Error for
/// settings the device cannot run (M x N too large for its local memory, unknown AOV, ...).
/// `records` (RecordFile.h): what caching methods know beforehand; afterwards all that they know then, which a later
/// render of the scene can be given, by whatever camera.
RenderResult render(const Scene& scene, Device& device, const RenderSettings& settings,
                    const ProgressCallback& progress = {}, RecordSet* records = nullptr);

/// About how many rays render() is going to trace of one view, known before it begins: right within a factor of four.
/// Infinity where a target error or a time limit decide, which mostly go on for long. Which hierarchy to build depends on it.
double expected_rays(const Scene& scene, const RenderSettings& settings);

/// Renders `scene` seen by one camera after the other (which replaces scene.info.camera; the film's size stays). The caches
/// serve all of them: a view costs what it shows anew. Only with a target error or a time limit each has caches of its
/// own. What it has been given must outlive it.
class Renderer {
public:
    Renderer(const Scene& scene, Device& device, const RenderSettings& settings, ProgressCallback progress = {});
    ~Renderer();
    Renderer(const Renderer&) = delete;
    Renderer& operator=(const Renderer&) = delete;

    /// Records known beforehand, as render() takes them. Before the first view.
    void load(const RecordSet& records);
    /// Hands out all records; radiance records of `records` stay if this method knows none.
    void store(RecordSet& records) const;

    /// A view. Statistics are its own (but stages: of the device since it was opened; records: of all views so far).
    RenderResult render(const shared::Camera& camera);

    /// `at_rest` is called wherever a render may be left, between launches. It may throw, which ends render(). `whole`:
    /// it may call save() too; during a search for a target error that is so only between its steps.
    void on_rest(std::function<void(bool whole)> at_rest);
    /// Writes the state of the view being rendered and of the caches. From `at_rest`, or after render().
    void save(Checkpoint& checkpoint);
    /// Goes on where save() was called, in a renderer of the same scene, device and settings: what render() would have
    /// returned, to the byte (seconds apart; a search for a target error goes by them). Before the first view.
    RenderResult resume(Checkpoint& checkpoint);

private:
    struct Impl;
    std::unique_ptr<Impl> impl_;
};

/// Renders each of `cameras`; `done` is given each picture as it is finished.
void render_views(const Scene& scene, Device& device, const RenderSettings& settings,
                  const std::vector<shared::Camera>& cameras,
                  const std::function<void(std::size_t, RenderResult)>& done, const ProgressCallback& progress = {});

}  // namespace irradia
