#include "app/progress.h"

#include <sys/ioctl.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <cstdio>

namespace irradia::app {
namespace {

constexpr int kBarCells = 20;

template <class... T>
std::string print(const char* format, T... values) {
    char buffer[128];
    std::snprintf(buffer, sizeof buffer, format, values...);
    return buffer;
}

}  // namespace

std::string count_text(double count) {
    if (count >= 1e9) return print("%.3g G", count / 1e9);
    if (count >= 1e6) return print("%.3g M", count / 1e6);
    const long long whole = std::llround(count);
    return whole < 1000 ? print("%lld", whole) : print("%lld %03lld", whole / 1000, whole % 1000);
}

std::string time_text(double seconds) {
    if (seconds < 9.95) return print("%.1f s", seconds);
    const long long s = std::llround(seconds);
    if (s < 60) return print("%lld s", s);
    if (s < 3600) return print("%lld:%02lld", s / 60, s % 60);
    return print("%lld:%02lld:%02lld", s / 3600, s / 60 % 60, s % 60);
}

double seconds_left(const Progress& p) {
    // Early estimates are worse than none.
    return p.fraction > 0.01 ? p.elapsed * (1 - std::min(p.fraction, 1.0)) / p.fraction : -1;
}

std::string progress_text(const Progress& p) {
    const double fraction = std::clamp(p.fraction, 0.0, 1.0);
    std::string out = p.stage + ": " + print("%.0f %%", std::floor(100 * fraction));
    if (p.records > 0) out += ", " + count_text(static_cast<double>(p.records)) + " records";
    if (p.elapsed > 0 && p.rays > 0) out += ", " + count_text(static_cast<double>(p.rays) / p.elapsed) + " rays/s";
    if (const double left = seconds_left(p); left > 0) out += ", " + time_text(left) + " left";
    return out;
}

std::string progress_bar(const Progress& p, int columns) {
    const int full = static_cast<int>(std::clamp(p.fraction, 0.0, 1.0) * kBarCells);
    std::string out = "[" + std::string(static_cast<std::size_t>(full), '=') +
                      std::string(static_cast<std::size_t>(kBarCells - full), ' ') + "] " + progress_text(p);
    // The last column is left free: some terminals wrap when it is written.
    if (static_cast<int>(out.size()) >= columns) out.resize(static_cast<std::size_t>(std::max(columns - 1, 0)));
    return out;
}

int terminal_columns() {
    if (!::isatty(STDERR_FILENO)) return 0;
    winsize size{};
    return ::ioctl(STDERR_FILENO, TIOCGWINSZ, &size) == 0 && size.ws_col > 0 ? size.ws_col : 80;
}

}  // namespace irradia::app
