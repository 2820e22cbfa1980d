#include "app/report.h"
#include "app/progress.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <optional>

#include "app/output.h"
#include "app/report_chart.h"
#include "app/report_facts.h"
#include "app/report_html.h"
#include "app/report_pictures.h"
#include "app/report_records.h"
#include "app/report_style.h"
#include "image/image_check.h"
#include "irradia/Error.h"
#include "irradia/Metrics.h"
#include "pictures/oiio.h"

namespace irradia::app {
namespace {

using html::escape;

std::string open_section(const std::string& id, const std::string& title) {
    return fmt::format("<section id=\"{0}\" aria-labelledby=\"{0}-title\"><h2 id=\"{0}-title\">{1}</h2>\n", id, title);
}

/// A picture that the script can take into the viewer.
std::string figure(const std::string& id, const std::string& title, const Picture& picture, const std::string& alt,
                   const std::string& caption) {
    return fmt::format(
        "<figure id=\"{}\"><img class=\"{}\" data-title=\"{}\" width=\"{}\" height=\"{}\" alt=\"{}\" src=\"{}\" />\n"
        "<figcaption>{}</figcaption></figure>\n",
        id, picture.width < 500 ? "shown small" : "shown", escape(title), picture.width, picture.height, escape(alt),
        png_address(picture), caption);
}

std::string picture_section(const ReportInput& in, const std::string& name) {
    const Image& image = in.image;
    const double exposure = in.run.options.exposure;
    const Picture picture = tone_mapped(image.layers.front(), image.width, image.height, exposure);
    std::string out = open_section("picture", "Picture");
    out += fmt::format(
        "<div id=\"viewer\" class=\"viewer\" style=\"aspect-ratio: {0} / {1}; max-width: calc(75vh * {0} / {1})\">"
        "<img id=\"viewed\" class=\"{2}\" width=\"{0}\" height=\"{1}\" alt=\"{3}\" src=\"{4}\" /></div>\n",
        image.width, image.height, image.width < 500 ? "small" : "plain", escape("The rendered picture of " + name),
        png_address(picture));
    out += fmt::format("<p class=\"note\">{} x {} pixels, sRGB{}.</p>\n", image.width, image.height,
                       exposure == 0 ? "" : ", times 2^" + html::number(exposure));
    return out + "</section>\n";
}

std::string layers_section(const ReportInput& in) {
    std::string out = open_section("layers", "Layers") + "<div class=\"grid\">\n";
    for (const std::string& name : aov_names()) {
        const Layer* layer = find_layer(in.image, name);
        if (layer == nullptr) continue;
        const LayerView view = layer_view(*layer, in.image.width, in.image.height, in.run.options.exposure);
        std::string caption = "<strong>" + escape(view.title) + "</strong> " + escape(view.text);
        if (!view.scale.colours.empty()) caption += "\n" + legend("legend-" + name, view.scale);
        out += figure("layer-" + name, view.title, view.picture, view.title + ": " + view.text, caption);
    }
    return out + "</div></section>\n";
}

std::string records_figure(const ReportInput& in, const std::string& id, const std::string& title,
                           const Records& records) {
    const shared::Camera& camera = in.run.camera != nullptr ? *in.run.camera : in.run.scene.info.camera;
    const RecordsPlot plot = plot_records(in.image, camera, records, in.run.options.exposure);
    const auto count = [](std::size_t n) { return count_text(static_cast<double>(n)); };
    std::string text = fmt::format("{} of {} records are in sight", count(plot.shown), count(records.size()));
    if (plot.hidden > 0) text += fmt::format(", {} lie behind surfaces", count(plot.hidden));
    if (plot.outside > 0) text += fmt::format(", {} outside of the picture", count(plot.outside));
    text += ".";
    if (plot.shown > 0)
        text += fmt::format(" Radii from {} to {}, median {} world units, or {} pixels where they lie.",
                            html::number(plot.least), html::number(plot.most), html::number(plot.median),
                            html::number(plot.median_pixels));
    std::string caption = "<strong>" + escape(title) + "</strong> " + escape(text);
    if (plot.shown > 0)
        caption += "\n<span class=\"scale-name\">Radius of the support</span>\n" + legend("legend-" + id, plot.scale);
    return figure(id, title, plot.picture, title + ", each a dot coloured by its radius. " + text, caption);
}

std::string records_section(const ReportInput& in) {
    if (in.records == nullptr || in.records->irradiance.size() + in.records->radiance.size() == 0) return "";
    std::string out = open_section("records", "Where the records lie");
    out +=
        "<p>Each dot is a record: there a hemisphere was traced, and within its radius it answers for others. The "
        "radius is that of a disk as large as the ellipse of its support.</p>\n";
    if (in.records->irradiance.size() > 0)
        out += records_figure(in, "irradiance-records", "Irradiance records", in.records->irradiance);
    if (in.records->radiance.size() > 0)
        out += records_figure(in, "radiance-records", "Radiance records", in.records->radiance);
    return out + "</section>\n";
}

struct Comparison {
    Metrics all;
    std::optional<Metrics> without_lamps;
};

Comparison compared(const ReportInput& in) {
    Comparison c{compare_images(in.image, *in.reference), {}};
    const Layer* counted = find_layer(in.image, "counted");
    if (counted == nullptr) return c;
    const auto lamps = std::count_if(counted->data.begin(), counted->data.end(), [](float x) { return !(x > 0.5f); });
    if (lamps == 0 || lamps == static_cast<std::ptrdiff_t>(counted->data.size())) return c;
    Image mask{in.image.width, in.image.height, {{"", 3, {}}}, {}};
    for (const float x : counted->data) mask.layers.front().data.insert(mask.layers.front().data.end(), 3, x);
    MetricsOptions options;
    options.mask = &mask;
    c.without_lamps = compare_images(in.image, *in.reference, options);
    return c;
}

std::vector<html::Row> metrics_rows(const Metrics& m) {
    std::string bias = fmt::format("{:+.4f} %", 100 * m.mean_bias);
    if (std::isfinite(m.mean_bias_interval)) bias += " +- " + exact_percent(m.mean_bias_interval);
    return {{"relative RMSE", exact_percent(m.rel_rmse)},
            {"mean bias", bias},
            {"relMSE", fmt::format("{:.4e}", m.rel_mse)},
            {"maximum", fmt::format("{:.4f} at ({}, {})", m.max_error, m.max_x, m.max_y)},
            {"SSIM", fmt::format("{:.5f}", m.ssim)},
            {"mean, reference's mean", fmt::format("{:.5f}, {:.5f}", m.mean, m.mean_reference)},
            {"pixels", count_text(static_cast<double>(m.pixels))}};
}

std::string reference_section(const ReportInput& in, const std::optional<Comparison>& c) {
    if (!c) return "";
    const ErrorPicture error = error_picture(in.image, *in.reference);
    const Picture map = tone_mapped(error.image.layers.front(), in.image.width, in.image.height, 0);
    const Picture reference =
        tone_mapped(in.reference->layers.front(), in.image.width, in.image.height, in.run.options.exposure);
    const Scale scale{0, 100 * error.scale, false, "% of the reference's mean", scale_colours("inferno")};
    std::string out = open_section("reference", "Against the reference");
    out += "<p>The reference is " + escape(in.run.options.reference) + ".</p>\n<div class=\"grid wide\">\n";
    const std::string text =
        "Root mean square over a pixel's channels, relative to the reference's mean; the last "
        "colour also stands for the hundredth part of pixels beyond it.";
    out += figure("error-map", "Error map", map, "Map of the error: " + text,
                  "<strong>Error map</strong> " + text + "\n" + legend("legend-error", scale));
    out += figure("reference-picture", "Reference", reference, "The reference, shown as the picture is",
                  "<strong>Reference</strong> Shown as the picture is.");
    out += "</div>\n<div class=\"columns\"><div>\n" + html::table("All pixels", metrics_rows(c->all)) + "</div>";
    if (c->without_lamps)
        out += "<div>\n" + html::table("Pixels that show no lamp", metrics_rows(*c->without_lamps)) + "</div>";
    return out + "</div></section>\n";
}

nlohmann::ordered_json metrics_json(const Metrics& m) {
    return {{"rel_rmse", m.rel_rmse}, {"mean_bias", m.mean_bias}, {"mean_bias_interval_95", m.mean_bias_interval},
            {"relmse", m.rel_mse},    {"max_error", m.max_error}, {"max_pixel", {m.max_x, m.max_y}},
            {"ssim", m.ssim},         {"pixels", m.pixels}};
}

/// For programs: what --stats writes, and the comparison.
std::string data_script(const ReportInput& in, const std::optional<Comparison>& c) {
    nlohmann::ordered_json j = {{"stats", nlohmann::ordered_json::parse(stats_json(in.run))}};
    if (c) j["comparison"] = metrics_json(c->all);
    if (c && c->without_lamps) j["comparison_without_lamps"] = metrics_json(*c->without_lamps);
    const std::string plain = j.dump(1);
    std::string text;
    for (const char ch : plain)  // nothing in it can end the element, in HTML or XML
        text += ch == '<' ? "\\u003c" : ch == '>' ? "\\u003e" : ch == '&' ? "\\u0026" : std::string(1, ch);
    return "<script type=\"application/json\" id=\"data\">" + text + "</script>\n";
}

}  // namespace

void write_report(const std::string& path, const ReportInput& in) {
    check_image(path, in.image);
    const Run& run = in.run;
    const std::filesystem::path source(run.scene.source);  // files are often all called scene.xml
    const std::string name = (source.parent_path().filename() / source.filename()).string();
    const std::string method = name_of(method_names(), run.options.settings.method);
    const std::optional<Comparison> comparison = in.reference != nullptr ? std::optional(compared(in)) : std::nullopt;
    std::string page = page_begin("Render of " + name);
    page += "<header><h1>" + escape(name) + "</h1>\n<p>" +
            fmt::format("{} x {} pixels, method {}, on {}", in.image.width, in.image.height, method,
                        escape(run.device.name)) +
            "</p>\n" + key_figures(in);
    page += "</header>\n<main>\n" + picture_section(in, name);
    page += error_section(run) + reference_section(in, comparison);
    page += layers_section(in) + records_section(in);
    page += times_section(run) + rays_section(run) + settings_section(run);
    page += "</main>\n" + data_script(in, comparison) + page_end();
    save_text(path, page);
}

void check_report(const std::string& path) {
    oiio::library();  // loaded now rather than later: it may be missing
    check_writable(path);
}

void check_reference(const std::string& path, const Image& reference, int width, int height) {
    if (reference.width != width || reference.height != height)
        throw Error(fmt::format("{}: the reference has {} x {} pixels, expected {} x {}, the picture's", path,
                                reference.width, reference.height, width, height));
    try {
        compare_images(reference, reference);
    } catch (const Error& error) {
        throw Error(fmt::format("{}: cannot serve as a reference: {}", path, error.what()));
    }
}

Image with_layers(const Image& image, const std::vector<std::string>& names) {
    Image out{image.width, image.height, {}, image.metadata};
    for (const Layer& layer : image.layers)
        if (layer.name.empty() || std::find(names.begin(), names.end(), layer.name) != names.end())
            out.layers.push_back(layer);
    return out;
}

}  // namespace irradia::app
