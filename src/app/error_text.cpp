#include "app/error_text.h"

#include <iomanip>
#include <sstream>

#include "app/progress.h"

namespace irradia::app {
namespace {

// Three digits, of which none is lost below 1 %.
std::string percent(double share) {
    std::ostringstream out;
    out << std::setprecision(3) << 100 * share;
    return out.str();
}

std::string interval(const Interval& i) {
    return percent(i.value) + " % (95 %: " + percent(i.low) + " to " + percent(i.high) + ")";
}

}  // namespace

std::string error_text(const ErrorReport& e) {
    std::string out = "error " + interval(e.rel_rmse) + ", direct " + percent(e.direct_rel_rmse) + " %, indirect " +
                      percent(e.indirect_rel_rmse) + " %; bias " + interval(e.mean_bias) + "; " +
                      count_text(static_cast<double>(e.probes)) + " probes, " + time_text(e.seconds);
    if (e.counted < 1) out += "; " + percent(1 - e.counted) + " % of the pixels show lamps and do not count";
    if (e.steps > 0) out += "; " + std::to_string(e.steps) + (e.steps == 1 ? " step" : " steps");
    if (e.target > 0 && !e.reached)
        out += "\nthe target of " + percent(e.target) + " % was not reached" +
               (e.time_is_up ? " in the time allowed" : ": this is as good as it gets");
    if (!e.doubt.empty()) out += "\ndo not trust these intervals: " + e.doubt;
    return out;
}

}  // namespace irradia::app
