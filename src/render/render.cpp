// render(): checks the settings, runs a method, makes the picture.
#include <algorithm>
#include <cmath>
#include <memory>
#include <utility>

#include "irradia/Error.h"
#include "irradia/RecordFile.h"
#include "render/error_probes.h"
#include "render/lamps.h"
#include "render/methods.h"
#include "render/sky_view.h"
#include "render/target.h"

namespace irradia {

void check_settings(const Scene& scene, const RenderSettings& s) {
    const auto fail = [](const std::string& what) { throw Error(what); };
    if (!(s.accuracy > 0) || !std::isfinite(s.accuracy))
        fail("accuracy " + std::to_string(s.accuracy) + ": expected a positive number");
    if (!(s.min_spacing > 0) || !(s.max_spacing >= s.min_spacing))
        fail("spacing " + std::to_string(s.min_spacing) + " to " + std::to_string(s.max_spacing) +
             " pixels: expected 0 < min <= max");
    if (!(s.gap_spacing > 0)) fail("gap spacing " + std::to_string(s.gap_spacing) + ": expected a positive number");
    if (!(s.firefly >= 0))
        fail("firefly limit " + std::to_string(s.firefly) + ": expected 0 (off) or a positive number");
    if (!(s.overlap >= 1)) fail("overlap " + std::to_string(s.overlap) + ": expected at least 1");
    const auto in = [&](const char* what, float x, float lo, float hi) {
        if (!(x >= lo && x <= hi))
            fail(std::string(what) + " " + std::to_string(x) + ": expected " + std::to_string(lo) + " to " +
                 std::to_string(hi));
    };
    in("roughness below which lobes are traced", s.trace_below, 0, 1);
    in("share below which lobes are traced", s.glossy_share, 0, 1);
    in("roughness from which harmonics answer", s.harmonics_from, 0, 2);
    in("roughness from which records reach in full", s.glossy_reach, 0, 1);
    in("order of harmonics", static_cast<float>(s.harmonics_order), 1, largest_harmonics_order);
    in("entries of a lobe's table", static_cast<float>(s.lobe_table), 4, 1024);
    if (!(s.glossy_accuracy > 0) || !std::isfinite(s.glossy_accuracy))
        fail("accuracy " + std::to_string(s.glossy_accuracy) + " of radiance records: expected a positive number");
    if (!(s.glossy_spread >= 0))
        fail("spread " + std::to_string(s.glossy_spread) +
             " of radiance records: expected 0 (off) or a positive number");
    if (!(s.pixel_error >= 0) || !std::isfinite(s.pixel_error))
        fail("error of a pixel " + std::to_string(s.pixel_error) + ": expected 0 (off) or a positive number");
    if (!(s.error_share > 0) || !std::isfinite(s.error_share))
        fail("share " + std::to_string(s.error_share) + " of the time for the error: expected a positive number");
    for (const auto& [name, value] : {std::pair{"target error", s.target_error}, {"time limit", s.time_limit}})
        if (!(value >= 0) || !std::isfinite(value))
            fail(std::string(name) + " " + std::to_string(value) + ": expected 0 (off) or a positive number");
    if (s.spp < 0) fail("spp " + std::to_string(s.spp) + ": expected 0 (the scene's) or a positive number");
    for (const std::string& a : s.aovs)
        if (std::find(aov_names().begin(), aov_names().end(), a) == aov_names().end()) {
            std::string known;
            for (const std::string& name : aov_names()) known += (known.empty() ? "" : ", ") + name;
            fail("AOV '" + a + "': expected one of " + known);
        }
    if (scene.info.width == 0 || scene.info.height == 0) fail("film size is zero");
}

namespace {

Layer records_layer(const Film& film, const std::vector<std::uint32_t>& pixels) {
    Layer layer{"records", 1, UntouchedVector<float>(film.pixels(), 0.0f)};
    for (const std::uint32_t p : pixels) layer.data[p] += 1.0f;
    return layer;
}

}  // namespace

const std::vector<std::string>& aov_names() {
    static const std::vector<std::string> names{"direct", "indirect", "albedo", "normal",
                                                "depth",  "records",  "counted"};
    return names;
}

namespace {

bool searches(const RenderSettings& s) { return s.target_error > 0 || s.time_limit > 0; }

}  // namespace

struct Renderer::Impl {
    Impl(const Scene& scene, Device& device, const RenderSettings& asked, ProgressCallback callback)
        : settings((check_settings(scene, asked), asked)),
          given(asked),
          progress(std::move(callback)),
          run(scene, device, settings, progress),
          film(static_cast<int>(scene.info.width), static_cast<int>(scene.info.height), run.aovs(),
               device.host_threads()) {
        const bool caches = asked.method == Method::irradiance || asked.method == Method::radiance;
        if (caches && !searches(asked)) caching = std::make_unique<CachingRenderer>(run);
    }

    void begin(const shared::Camera& camera) {
        if (std::exchange(started, true)) {
            run.restart();  // what comes before the first view is part of it
            film.clear();
        }
        run.set_camera(camera);
        position = {};
        picture_effort = 0;
        if (!searches(given)) return;
        settings = given;
        search = std::make_unique<TargetSearch>(run, settings, film);
    }

    void state(Checkpoint& c) {
        run.state(c);
        film.state(c);
        position.state(c);
        c(picture_effort);
        if (caching) caching->state(c);
        if (search) search->state(c);
    }

    // `resumed`: of a view whose state was read.
    RenderResult view(bool resumed) {
        std::vector<std::uint32_t> record_pixels;
        RenderResult result;
        if (given.method != Method::path) learn_sky(run, asked_spp(run.scene, given), !resumed);  // the etalon does not
        if (searches(given)) {
            record_pixels = search->run(result.error.emplace());
        } else {
            if (caching)
                record_pixels = resumed ? caching->go_on(film) : caching->render(film);
            else if (settings.method == Method::path)
                render_path(run, film, position);
            else
                render_gather(run, film, position);
            if (settings.report_error) {
                if (picture_effort == 0) picture_effort = run.effort();  // else it was stopped among the probes
                ErrorProbes probes(run, film);
                spend(probes, film, static_cast<double>(settings.error_share) * picture_effort);
                result.error = probes.report(film);
                run.phase("probes");
            }
        }
        result.image = film.image(settings);
        if (std::find(settings.aovs.begin(), settings.aovs.end(), "records") != settings.aovs.end())
            result.image.layers.push_back(records_layer(film, record_pixels));
        if (std::find(settings.aovs.begin(), settings.aovs.end(), "counted") != settings.aovs.end()) {
            const std::vector<std::uint8_t> counted = pixels_without_lamps(run);
            result.image.layers.push_back({"counted", 1, UntouchedVector<float>(counted.begin(), counted.end())});
        }
        run.statistics.mean_spp = static_cast<double>(film.samples()) / static_cast<double>(film.pixels());
        run.statistics.stages = run.device.stage_times();
        run.statistics.seconds = run.elapsed();
        result.statistics = run.statistics;
        return result;
    }

    bool started = false;
    RenderSettings settings, given;  // what run refers to: a search changes it
    ProgressCallback progress;
    Run run;
    Film film;
    SamplePosition position;
    double picture_effort = 0;                 // without probes, once it is done
    std::unique_ptr<CachingRenderer> caching;  // of all views
    std::unique_ptr<TargetSearch> search;      // of the present one, which has caches of its own
};

Renderer::Renderer(const Scene& scene, Device& device, const RenderSettings& settings, ProgressCallback progress)
    : impl_(std::make_unique<Impl>(scene, device, settings, std::move(progress))) {}
Renderer::~Renderer() = default;

void Renderer::load(const RecordSet& records) {
    if (records.irradiance.size() + records.radiance.size() > 0 && searches(impl_->given))
        throw Error(
            "records from elsewhere: expected settings as they were made with, not a target error or time limit");
    if (impl_->caching) impl_->caching->load(records);
}

void Renderer::store(RecordSet& records) const {
    const CachingRenderer* const caching = impl_->search ? impl_->search->caching() : impl_->caching.get();
    if (caching != nullptr) caching->store(records);
}

RenderResult Renderer::render(const shared::Camera& camera) {
    impl_->begin(camera);
    return impl_->view(false);
}

void Renderer::on_rest(std::function<void(bool)> at_rest) { impl_->run.on_rest(std::move(at_rest)); }

void Renderer::save(Checkpoint& checkpoint) { impl_->state(checkpoint); }

RenderResult Renderer::resume(Checkpoint& checkpoint) {
    impl_->begin(impl_->run.camera());
    impl_->state(checkpoint);
    checkpoint.finish();
    return impl_->view(true);
}

RenderResult render(const Scene& scene, Device& device, const RenderSettings& settings,
                    const ProgressCallback& progress, RecordSet* records) {
    Renderer renderer(scene, device, settings, progress);
    if (records != nullptr) renderer.load(*records);
    RenderResult result = renderer.render(scene.info.camera);
    if (records != nullptr) renderer.store(*records);
    return result;
}

void render_views(const Scene& scene, Device& device, const RenderSettings& settings,
                  const std::vector<shared::Camera>& cameras,
                  const std::function<void(std::size_t, RenderResult)>& done, const ProgressCallback& progress) {
    Renderer renderer(scene, device, settings, progress);
    for (std::size_t i = 0; i < cameras.size(); ++i) done(i, renderer.render(cameras[i]));
}

}  // namespace irradia
