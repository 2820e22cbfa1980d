// compare: how far a picture is from its reference, in the measures of include/irradia/Metrics.h.
#include <fmt/format.h>

#include <cmath>
#include <exception>
#include <iostream>
#include <nlohmann/json.hpp>
#include <optional>

#include "app/help.h"
#include "irradia/Error.h"
#include "irradia/Metrics.h"

namespace {

using irradia::Image;
using irradia::Metrics;

struct Options {
    std::string picture, reference, reference_a, reference_b, mask, heatmap;
    double reference_error = 0, heatmap_scale = 0;
    bool json = false;
};

void declare(CLI::App& app, Options& o) {
    irradia::app::set_up(app, "PICTURE REFERENCE [options]\n       compare PICTURE --ref-a A --ref-b B [options]");
    app.add_option("PICTURE", o.picture, "What is judged: .exr, .pfm, or any file OpenImageIO reads")->required();
    CLI::Option* ref = app.add_option("REFERENCE", o.reference, "What it is judged by; of the same size");

    const auto group = [&](const char* name, CLI::Option* option) { return option->group(name); };
    CLI::Option* a = group("Reference", app.add_option("--ref-a", o.reference_a,
                                                       "First half of a noisy reference, instead of REFERENCE: two "
                                                       "pictures rendered with different seeds. Their own variance is "
                                                       "taken out: mean((x-a)(x-b)) is the squared error"))
                         ->type_name("FILE");
    CLI::Option* b =
        group("Reference", app.add_option("--ref-b", o.reference_b, "Second half"))->type_name("FILE")->needs(a);
    a->needs(b)->excludes(ref);
    group("Reference", app.add_option("--ref-error", o.reference_error,
                                      "Known relative RMSE of REFERENCE itself (0.01 is 1 %); its square is "
                                      "subtracted"))
        ->type_name("X")
        ->check(CLI::NonNegativeNumber)
        ->excludes(a)
        ->capture_default_str();
    group("Reference",
          app.add_option("--mask", o.mask, "Count only pixels where this picture's first channel is > 0.5"))
        ->type_name("FILE");
    group("Output", app.add_flag("--json", o.json, "Print one JSON object instead of a table"));
    group("Output", app.add_option("--heatmap", o.heatmap,
                                   "Write a picture of the error of each pixel, relative to mean(ref), in the colour "
                                   "map inferno: black is none, yellow is --heatmap-scale, grey is masked out"))
        ->type_name("OUT.png");
    group("Output", app.add_option("--heatmap-scale", o.heatmap_scale,
                                   "Relative error shown in the map's last colour; 0: the 99th percentile"))
        ->type_name("X")
        ->check(CLI::NonNegativeNumber)
        ->capture_default_str();
    app.footer(
        "What is printed (means over counted pixels and channels)\n"
        "  relative RMSE   sqrt(mean((x-ref)^2) - the reference's own variance, if known) / mean(ref)\n"
        "  relMSE          mean((x-ref)^2 / (ref^2 + 0.01))\n"
        "  mean bias       (mean(x) - mean(ref)) / mean(ref), with its 95 % interval from 16x16-pixel tiles\n"
        "  maximum         largest |x-ref| of a channel, and where\n"
        "  SSIM            of luminances scaled to mean(ref) = 0.18 and sRGB-coded; 1 is equal\n\n"
        "Examples\n"
        "  compare cornell.exr reference.exr --mask mask.exr --heatmap error.png\n"
        "  compare picture.exr --ref-a half-a.exr --ref-b half-b.exr --json\n\n"
        "Exit status: 0 compared, 1 bad input, 2 wrong command line.");
}

void print_table(const Metrics& m) {
    fmt::print("relative RMSE   {:.4f} %", 100 * m.rel_rmse);
    if (m.reference_rel_rmse > 0)
        fmt::print("   ({:.4f} % with the reference's own {:.4f} %)", 100 * m.rel_rmse_raw, 100 * m.reference_rel_rmse);
    if (m.mse < 0) fmt::print("   (below what the reference's noise lets one see)");
    fmt::print("\nrelMSE          {:.4e}\nmean bias       {:+.4f} %", m.rel_mse, 100 * m.mean_bias);
    if (std::isfinite(m.mean_bias_interval)) fmt::print(" +- {:.4f} %", 100 * m.mean_bias_interval);
    fmt::print("\nmaximum         {:.4f} at ({}, {})\nSSIM            {:.5f}\n", m.max_error, m.max_x, m.max_y, m.ssim);
    fmt::print("mean            {:.5f}, reference {:.5f}, {} pixels\n", m.mean, m.mean_reference, m.pixels);
}

void print_json(const Metrics& m, const std::optional<irradia::ErrorPicture>& heatmap) {
    nlohmann::ordered_json j = {{"rel_rmse", m.rel_rmse},
                                {"rel_rmse_raw", m.rel_rmse_raw},
                                {"reference_rel_rmse", m.reference_rel_rmse},
                                {"mse", m.mse},
                                {"relmse", m.rel_mse},
                                {"mean_bias", m.mean_bias},
                                {"mean_bias_interval_95", m.mean_bias_interval},
                                {"max_error", m.max_error},
                                {"max_pixel", {m.max_x, m.max_y}},
                                {"ssim", m.ssim},
                                {"mean", m.mean},
                                {"mean_reference", m.mean_reference},
                                {"pixels", m.pixels}};
    if (heatmap) j["heatmap_scale"] = heatmap->scale;
    fmt::print("{}\n", j.dump(2));
}

int run(const Options& o) {
    const bool halves = !o.reference_a.empty();
    if (o.reference.empty() && !halves) {
        std::cerr << "compare: REFERENCE is missing, or --ref-a and --ref-b (compare --help lists the options)\n";
        return irradia::app::kBadCommandLine;
    }
    const Image picture = irradia::read_image(o.picture);
    const Image reference = irradia::read_image(halves ? o.reference_a : o.reference);
    std::optional<Image> second, mask;
    irradia::MetricsOptions options;
    options.reference_rel_rmse = o.reference_error;
    if (halves) options.reference_b = &second.emplace(irradia::read_image(o.reference_b));
    if (!o.mask.empty()) options.mask = &mask.emplace(irradia::read_image(o.mask));

    const Metrics metrics = irradia::compare_images(picture, reference, options);
    std::optional<irradia::ErrorPicture> heatmap;
    if (!o.heatmap.empty()) {
        heatmap = irradia::error_picture(picture, reference, options, o.heatmap_scale);
        irradia::write_image(o.heatmap, heatmap->image);
    }
    if (o.json) {
        print_json(metrics, heatmap);
    } else {
        print_table(metrics);
        if (heatmap) fmt::print("{}: errors of 0 (black) to {:.3g} % (yellow)\n", o.heatmap, 100 * heatmap->scale);
    }
    return 0;
}

}  // namespace

int main(int argc, char** argv) {
    CLI::App app("How far a picture is from its reference.", "compare");
    Options options;
    declare(app, options);
    if (const int status = irradia::app::parse(app, argc, argv, std::cerr); status >= 0) return status;
    try {
        return run(options);
    } catch (const irradia::Error& error) {
        std::cerr << "compare: " << error.what() << '\n';
        return error.exit_status();
    } catch (const std::exception& error) {
        std::cerr << "compare: " << error.what() << '\n';
        return irradia::app::kBadInput;
    }
}
