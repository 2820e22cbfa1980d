// Charts as inline SVG. Widths are percentages, so that text keeps its size on a narrow screen.
#pragma once
#include <string>
#include <vector>

#include "app/report_pictures.h"

namespace irradia::app {

struct Bar {
    std::string name;
    double value = 0;
    std::string label;  ///< the value with its unit, for people
};

/// Horizontal bars from zero, each below its name and value. "" if there are none.
std::string bar_chart(const std::string& title, const std::vector<Bar>& bars);

/// A point and an interval about it on an axis from `low` to `high` (percentages).
struct IntervalRow {
    std::string name;
    double value = 0, low = 0, high = 0;  ///< shares
};
/// Intervals on one common axis that includes zero.
std::string interval_chart(const std::string& title, const std::vector<IntervalRow>& rows);

/// The colours of a map with the numbers that they stand for. `id`: of this page's only legend of that name.
std::string legend(const std::string& id, const Scale& scale);

}  // namespace irradia::app
