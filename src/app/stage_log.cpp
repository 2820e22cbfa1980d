#include "app/stage_log.h"

#include <algorithm>
#include <cmath>

#include "app/progress.h"

namespace irradia::app {
namespace {

constexpr double kBarPeriod = 0.1;  // seconds
constexpr double kLogPeriod = 5.0;
constexpr double kStreamPeriod = 0.2;
constexpr double kShortStage = 0.1;  // is not worth a line

// Milliseconds are enough, and 0.30000000000000004 is no time.
double rounded(double seconds) { return std::round(1000 * seconds) / 1000; }

void add_counts(Fields& fields, std::uint64_t records, std::uint64_t rays) {
    if (records > 0) fields["records"] = records;
    if (rays > 0) fields["rays"] = rays;
}

Fields progress_fields(const Progress& p) {
    Fields fields{{"stage", p.stage}, {"fraction", std::round(1e4 * p.fraction) / 1e4}};
    add_counts(fields, p.records, p.rays);
    fields["elapsed"] = rounded(p.elapsed);
    if (const double left = seconds_left(p); left >= 0) fields["left"] = rounded(left);
    return fields;
}

}  // namespace

void StageLog::operator()(const Progress& given) {
    Progress p = given;
    p.fraction = std::clamp(p.fraction, 0.0, 1.0);
    const bool changed = p.stage != now_.stage;
    if (changed) {
        const bool first = now_.stage.empty() && now_.elapsed == 0;  // began with the clock
        end_stage(p.elapsed, p.rays);
        begin_ = p;
        if (first) begin_.elapsed = 0, begin_.rays = 0;
    } else {
        p.fraction = std::max(p.fraction, now_.fraction);  // threads may report out of order
    }
    now_ = p;
    if (log_.streams() && (changed || p.elapsed - streamed_ >= kStreamPeriod)) {
        log_.event("progress", progress_fields(p));
        streamed_ = p.elapsed;
    }
    if (log_.columns() > 0) {
        if (!changed && p.elapsed - shown_ < kBarPeriod) return;
        log_.bar(progress_bar(p, log_.columns()));
        shown_ = p.elapsed;
    } else if (p.elapsed - shown_ >= std::max(kLogPeriod, 0.05 * p.elapsed)) {  // long renders, fewer lines
        log_.info(progress_text(p), progress_fields(p));
        shown_ = p.elapsed;
    }
}

void StageLog::end_stage(double elapsed, std::uint64_t rays_then) {
    if (now_.stage.empty()) return;
    const double seconds = std::max(elapsed - begin_.elapsed, 0.0);
    const std::uint64_t rays = rays_then > begin_.rays ? rays_then - begin_.rays : 0;
    Fields fields{{"stage", now_.stage}, {"seconds", rounded(seconds)}};
    add_counts(fields, now_.records, rays);
    log_.event("stage", fields);
    if (log_.columns() > 0 || seconds < kShortStage) return;
    std::string text = now_.stage + ": " + time_text(seconds);
    if (now_.records > 0) text += ", " + count_text(static_cast<double>(now_.records)) + " records";
    if (rays > 0) text += ", " + count_text(static_cast<double>(rays) / seconds) + " rays/s";
    log_.info(text, fields);
    shown_ = elapsed;
}

void StageLog::finish(double elapsed) {
    if (!now_.stage.empty()) {
        now_.elapsed = std::max(elapsed, now_.elapsed);
        if (log_.streams() && streamed_ < now_.elapsed) log_.event("progress", progress_fields(now_));
        end_stage(now_.elapsed, now_.rays);
    }
    now_.stage.clear();
    log_.clear_bar();
}

}  // namespace irradia::app
