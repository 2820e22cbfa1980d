// render(): checks the settings, runs a method, makes the picture.
#include <algorithm>
#include <cmath>
#include <memory>

#include "irradia/Error.h"
#include "irradia/RecordFile.h"
#include "render/methods.h"

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
    static const std::vector<std::string> names{"direct", "indirect", "albedo", "normal", "depth", "records"};
    return names;
}

namespace {

RenderResult render_view(Run& run, CachingRenderer* caching) {
    const RenderSettings& settings = run.settings;
    Film film(static_cast<int>(run.scene.info.width), static_cast<int>(run.scene.info.height), run.aovs());
    std::vector<std::uint32_t> record_pixels;
    if (caching != nullptr)
        record_pixels = caching->render(film);
    else if (settings.method == Method::path)
        render_path(run, film);
    else
        render_gather(run, film);
    RenderResult result;
    result.image = film.image(settings);
    if (std::find(settings.aovs.begin(), settings.aovs.end(), "records") != settings.aovs.end())
        result.image.layers.push_back(records_layer(film, record_pixels));
    run.statistics.mean_spp = static_cast<double>(film.samples()) / static_cast<double>(film.pixels());
    run.statistics.stages = run.device.stage_times();
    run.statistics.seconds = run.elapsed();
    result.statistics = std::move(run.statistics);
    return result;
}

std::unique_ptr<CachingRenderer> caching_renderer(Run& run) {
    const Method m = run.settings.method;
    return m == Method::irradiance || m == Method::radiance ? std::make_unique<CachingRenderer>(run) : nullptr;
}

}  // namespace

RenderResult render(const Scene& scene, Device& device, const RenderSettings& settings,
                    const ProgressCallback& progress, RecordSet* records) {
    check_settings(scene, settings);
    Run run(scene, device, settings, progress);
    const std::unique_ptr<CachingRenderer> caching = caching_renderer(run);
    const bool carries = caching && records != nullptr;
    if (carries) caching->load(*records);
    RenderResult result = render_view(run, caching.get());
    if (carries) caching->store(*records, true);
    return result;
}

void render_views(const Scene& scene, Device& device, const RenderSettings& settings,
                  const std::vector<shared::Camera>& cameras,
                  const std::function<void(std::size_t, RenderResult)>& done, const ProgressCallback& progress) {
    check_settings(scene, settings);
    Run run(scene, device, settings, progress);
    const std::unique_ptr<CachingRenderer> caching = caching_renderer(run);
    for (std::size_t i = 0; i < cameras.size(); ++i) {
        run.set_camera(cameras[i]);
        done(i, render_view(run, caching.get()));
    }
}

}  // namespace irradia
