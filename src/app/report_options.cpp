#include "app/report_options.h"

namespace irradia::app {

void declare_report(CLI::App& app, Options& o) {
    app.add_option("--report", o.report,
                   "Write a page that shows the render, for any browser, without a network: picture, layers, where the "
                   "records lie, times, rays, settings, the estimated error")
        ->type_name("FILE.html")
        ->group("Report");
    app.add_option(
           "--reference", o.reference,
           "For --report: a picture of the same size, the truth; the page then shows where this one is off, and "
           "how far, in the measures of `compare`")
        ->type_name("FILE")
        ->group("Report");
}

std::string wrong_report_options(const Options& o) {
    if (!o.reference.empty() && o.report.empty()) return "--reference: expected --report FILE.html too";
    if (o.report.empty()) return "";
    if (o.outputs.empty()) return "--report: nothing is rendered, expected -o FILE too";
    if (!o.points.empty()) return "--report: --points makes no picture to show";
    return "";
}

}  // namespace irradia::app
