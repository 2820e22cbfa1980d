#include "app/report_chart.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "app/report_html.h"

namespace irradia::app {
namespace {

using html::escape;

std::string open_svg(const std::string& kind, const std::string& title, int height) {
    return fmt::format("<svg class=\"{}\" width=\"100%\" height=\"{}\" role=\"img\" aria-label=\"{}\">", kind, height,
                       escape(title));
}

/// Round numbers from `low` to `high`: 1, 2 and 5 times powers of ten.
std::vector<double> ticks(const Scale& s) {
    std::vector<double> out;
    if (s.logarithmic) {
        for (int power = static_cast<int>(std::floor(std::log10(s.low))); std::pow(10, power) <= s.high; ++power)
            for (const double step : {1.0, 2.0, 5.0})
                if (const double t = step * std::pow(10, power); t >= s.low && t <= s.high) out.push_back(t);
    }
    return out;
}

double place(const Scale& s, double value) {
    if (!(s.high > s.low)) return 0.5;
    return s.logarithmic ? std::log(value / s.low) / std::log(s.high / s.low) : (value - s.low) / (s.high - s.low);
}

}  // namespace

std::string bar_chart(const std::string& title, const std::vector<Bar>& bars) {
    if (bars.empty()) return "";
    constexpr int row = 34;
    double most = 0;
    for (const Bar& bar : bars) most = std::max(most, bar.value);
    std::string spoken = title;
    for (const Bar& bar : bars) spoken += (&bar == &bars.front() ? ": " : "; ") + bar.name + " " + bar.label;
    std::string out =
        "<h3>" + escape(title) + "</h3>\n" + open_svg("bars", spoken, row * static_cast<int>(bars.size()) + 2) + "\n";
    int y = 0;
    for (const Bar& bar : bars) {
        out += fmt::format(
            "<text x=\"0\" y=\"{0}\">{1}</text><text x=\"100%\" y=\"{0}\" class=\"value\">{2}</text>"
            "<rect class=\"track\" x=\"0\" y=\"{3}\" width=\"100%\" height=\"8\" rx=\"3\" />"
            "<rect class=\"bar\" x=\"0\" y=\"{3}\" width=\"{4:.3f}%\" height=\"8\" rx=\"3\" />\n",
            y + 14, escape(bar.name), escape(bar.label), y + 20, most > 0 ? 100 * bar.value / most : 0);
        y += row;
    }
    return out + "</svg>\n";
}

std::string interval_chart(const std::string& title, const std::vector<IntervalRow>& rows) {
    double low = 0, high = 0;
    for (const IntervalRow& r : rows) {
        low = std::min(low, r.low);
        high = std::max(high, r.high);
    }
    if (!(high > low)) return "";
    const double margin = 0.03 * (high - low);
    if (low < 0) low -= margin;
    high += margin;
    const auto at = [&](double value) { return 100 * (value - low) / (high - low); };
    std::string spoken = title;
    for (const IntervalRow& r : rows)
        spoken += fmt::format("; {} {}, from {} to {}", r.name, html::percent(r.value), html::percent(r.low),
                              html::percent(r.high));
    constexpr int row = 44;
    const int bottom = row * static_cast<int>(rows.size());
    std::string out = open_svg("intervals", spoken, bottom + 22) + "\n";
    int y = 0;
    for (const IntervalRow& r : rows) {
        out += fmt::format(
            "<text x=\"0\" y=\"{0}\">{1}</text><text x=\"100%\" y=\"{0}\" class=\"value\">{2}</text>"
            "<line class=\"zero\" x1=\"{7:.3f}%\" x2=\"{7:.3f}%\" y1=\"{8}\" y2=\"{9}\" />"
            "<line class=\"whisker\" x1=\"{3:.3f}%\" x2=\"{4:.3f}%\" y1=\"{5}\" y2=\"{5}\" />"
            "<circle class=\"dot\" cx=\"{6:.3f}%\" cy=\"{5}\" r=\"5\" />\n",
            y + 14, escape(r.name),
            escape(html::percent(r.value) + " (" + html::percent(r.low) + " to " + html::percent(r.high) + ")"),
            at(r.low), at(r.high), y + 28, at(r.value), at(0), y + 20, y + 36);
        y += row;
    }
    out += fmt::format("<text x=\"{:.3f}%\" y=\"{}\" class=\"{}\">0</text>", at(0), bottom + 16,
                       low < 0 ? "middle" : "start");
    return out + "\n</svg>\n";
}

std::string legend(const std::string& id, const Scale& s) {
    const std::string low = html::number(s.low), high = html::number(s.high);
    std::string spoken = fmt::format("Colours from {} to {}", low, high);
    if (!s.unit.empty()) spoken += " " + s.unit;
    if (!(s.high > s.low)) spoken = "All are " + low + (s.unit.empty() ? "" : " " + s.unit);
    std::string out = open_svg("legend", spoken, 34) + "\n<defs><linearGradient id=\"" + id + "\">";
    const std::size_t n = s.colours.size();
    for (std::size_t i = 0; i < n; ++i)
        out += fmt::format("<stop offset=\"{:.1f}%\" stop-color=\"{}\" />",
                           100 * static_cast<double>(i) / static_cast<double>(std::max<std::size_t>(n - 1, 1)),
                           s.colours[i]);
    out += fmt::format(
        "</linearGradient></defs>\n<rect x=\"0\" y=\"0\" width=\"100%\" height=\"12\" rx=\"3\" fill=\"url(#{})\" />\n",
        id);
    const auto label = [&](double at, const std::string& text, const char* anchor) {
        out += fmt::format("<text x=\"{:.2f}%\" y=\"28\" class=\"{}\">{}</text>", 100 * at, anchor, escape(text));
    };
    if (!(s.high > s.low)) {
        label(0.5, low, "middle");
    } else {
        label(0, low, "start");
        label(1, high + (s.unit.empty() ? "" : " " + s.unit), "value");
        double last = 0.1;
        for (const double tick : ticks(s)) {
            const double at = place(s, tick);
            if (at < last + 0.08 || at > 0.72) continue;
            out += fmt::format("<line class=\"tick\" x1=\"{0:.2f}%\" x2=\"{0:.2f}%\" y1=\"12\" y2=\"16\" />", 100 * at);
            label(at, html::number(tick), "middle");
            last = at;
        }
    }
    return out + "\n</svg>\n";
}

}  // namespace irradia::app
