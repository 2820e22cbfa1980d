// render(): checks the settings, runs a method, makes the picture.
#include <algorithm>
#include <cmath>
#include <memory>

#include "irradia/Error.h"
#include "irradia/RecordFile.h"
#include "render/error_probes.h"
#include "render/lamps.h"
#include "render/methods.h"
#include "render/target.h"

namespace irradia {

void check_settings(const Scene& scene, const RenderSettings& s) {
    const auto fail = [](const std::string& what) { throw Error(what); };
    if (!(s.accuracy > 0) || !std::isfinite(s.accuracy))
        fail("accuracy " + std::to_string(s.accuracy) + ": expected a positive number");
    if (!(s.min_spacing > 0) || !(s.max_spacing >= s.min_spacing))
        fail("spacing " + std::to_string(s.min_spacing) + " to " + std::to_string(s.max_spacing) +
             " pixels: expected 0 < min <= max");
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
    Layer layer{"records", 1, std::vector<float>(film.pixels(), 0.0f)};
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

std::vector<std::uint32_t> render_film(Run& run, Film& film, CachingRenderer* caching) {
    if (caching != nullptr) return caching->render(film);
    if (run.settings.method == Method::path)
        render_path(run, film);
    else
        render_gather(run, film);
    return {};
}

bool searches(const RenderSettings& s) { return s.target_error > 0 || s.time_limit > 0; }

/// `settings`: what run.settings refers to. `caching`: made here where the settings are only found here.
RenderResult render_view(Run& run, RenderSettings& settings, std::unique_ptr<CachingRenderer>& caching) {
    Film film(static_cast<int>(run.scene.info.width), static_cast<int>(run.scene.info.height), run.aovs());
    std::vector<std::uint32_t> record_pixels;
    RenderResult result;
    if (searches(settings)) {
        record_pixels = render_to_target(run, settings, film, caching, result.error.emplace());
    } else {
        record_pixels = render_film(run, film, caching.get());
        if (settings.report_error) {
            ErrorProbes probes(run, film);
            spend(probes, film, static_cast<double>(settings.error_share) * run.elapsed());
            result.error = probes.report(film);
            run.phase("probes");
        }
    }
    result.image = film.image(settings);
    if (std::find(settings.aovs.begin(), settings.aovs.end(), "records") != settings.aovs.end())
        result.image.layers.push_back(records_layer(film, record_pixels));
    if (std::find(settings.aovs.begin(), settings.aovs.end(), "counted") != settings.aovs.end()) {
        const std::vector<std::uint8_t> counted = pixels_without_lamps(run);
        result.image.layers.push_back({"counted", 1, std::vector<float>(counted.begin(), counted.end())});
    }
    run.statistics.mean_spp = static_cast<double>(film.samples()) / static_cast<double>(film.pixels());
    run.statistics.stages = run.device.stage_times();
    run.statistics.seconds = run.elapsed();
    result.statistics = std::move(run.statistics);
    return result;
}

std::unique_ptr<CachingRenderer> caching_renderer(Run& run) {
    const Method m = run.settings.method;
    const bool caches = m == Method::irradiance || m == Method::radiance;
    return caches && !searches(run.settings) ? std::make_unique<CachingRenderer>(run) : nullptr;
}

}  // namespace

RenderResult render(const Scene& scene, Device& device, const RenderSettings& asked, const ProgressCallback& progress,
                    RecordSet* records) {
    check_settings(scene, asked);
    RenderSettings settings = asked;
    Run run(scene, device, settings, progress);
    std::unique_ptr<CachingRenderer> caching = caching_renderer(run);
    const bool loads = records != nullptr && records->irradiance.size() + records->radiance.size() > 0;
    if (loads && searches(asked))
        throw Error(
            "records from elsewhere: expected settings as they were made with, not a target error or time limit");
    if (caching && records != nullptr) caching->load(*records);
    RenderResult result = render_view(run, settings, caching);
    if (caching && records != nullptr) caching->store(*records, true);
    return result;
}

void render_views(const Scene& scene, Device& device, const RenderSettings& asked,
                  const std::vector<shared::Camera>& cameras,
                  const std::function<void(std::size_t, RenderResult)>& done, const ProgressCallback& progress) {
    check_settings(scene, asked);
    if (searches(asked)) throw Error("target error and time limit: expected a single view");
    RenderSettings settings = asked;
    Run run(scene, device, settings, progress);
    std::unique_ptr<CachingRenderer> caching = caching_renderer(run);
    for (std::size_t i = 0; i < cameras.size(); ++i) {
        run.set_camera(cameras[i]);
        done(i, render_view(run, settings, caching));
    }
}

}  // namespace irradia
