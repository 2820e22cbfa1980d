#include "render/target.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include "render/lamps.h"
#include "render/quality.h"

namespace irradia {
namespace {

constexpr double levels_a_halving = 1.1;  // of the error, about: apply_level()
constexpr double error_of_draft = 0.04;   // where the first step begins; the next ones follow what is found
constexpr double aim = 0.75;              // part of the error asked for that the picture should have, for its
                                          // interval to end below it
constexpr std::uint32_t lamp_spp = 256;   // of pixels that do not count
constexpr double first_goal = 0.05;
constexpr std::uint32_t first_spp = 16;  // of methods that only take samples
constexpr std::uint32_t most_spp = 1u << 24;
constexpr double probe_share = 0.15;  // of the effort so far: what one look at the error may take

/// What a step has to do, from the squared errors found.
struct Need {
    double levels = 0;       // of the cache
    double pixel_error = 1;  // factor
};

}  // namespace

class TargetSearch::Steps {
public:
    Steps(Run& run, RenderSettings& settings, Film& film)
        : run_(run),
          settings_(settings),
          film_(film),
          caches_(settings.method == Method::irradiance || settings.method == Method::radiance),
          target_(static_cast<double>(settings.target_error)),
          goal_(target_ > 0 ? target_ : first_goal) {}

    std::vector<std::uint32_t> run(ErrorReport& report) {
        constexpr double never = std::numeric_limits<double>::infinity();
        const double limit = settings_.time_limit > 0 ? static_cast<double>(settings_.time_limit) : never;
        run_.in_step(true);
        if (!probes_) {
            first_step();
            probes_ = std::make_unique<ErrorProbes>(run_, film_);
            spend(*probes_, film_, probe_share * run_.effort(), aim * goal_);  // something is always known of it
        }
        run_.stop_after(limit);
        try {
            for (;;) {
                run_.in_step(false);
                run_.rest();
                run_.in_step(true);
                report_ = look();
                run_.phase("probes");
                ++steps_;
                kept_.reset();
                // A search for no target ends with its time, which may be over since anything was reported.
                report_.time_is_up = target_ <= 0 && run_.elapsed() > limit;
                if (report_.time_is_up || (target_ > 0 && meets(report_))) break;
                if (limit < never) kept_ = film_;
                if (target_ <= 0) goal_ = std::clamp(0.6 * report_.rel_rmse.value, 1e-4, goal_);
                if (!next_step(report_)) break;
            }
        } catch (const Run::TimeIsUp&) {
            if (kept_) film_ = *kept_;
            if (steps_ == 0) report_ = probes_->report(film_);
            report_.time_is_up = true;
        }
        run_.stop_after(never);
        run_.in_step(false);
        report_.target = target_;
        report_.steps = steps_;
        report_.reached = target_ > 0 && meets(report_);
        report = report_;
        return pixels_;
    }

    void state(Checkpoint& c) {
        c(goal_)(level_)(pixel_factor_)(steps_)(pixels_);
        position_.state(c);
        if (c.reading()) {
            const std::uint32_t spp = run_.spp();
            if (caches_) apply();
            run_.set_spp(spp);
            if (caches_) caching_ = std::make_unique<CachingRenderer>(run_);
            probes_ = std::make_unique<ErrorProbes>(run_, film_);
        }
        if (caching_) caching_->state(c);
        probes_->state(c);
        if (c.has(kept_, [&] { kept_ = film_; })) kept_->state(c);
        ErrorReport& r = report_;
        c(r.rel_rmse)(r.mean_bias)(r.direct_rel_rmse)(r.indirect_rel_rmse)(r.counted)(r.probes)(r.paths)(r.seconds);
        c(r.doubt);
    }

    [[nodiscard]] const CachingRenderer* caching() const { return caching_.get(); }

private:
    [[nodiscard]] bool meets(const ErrorReport& found) const {
        return found.rel_rmse.high <= target_ && found.doubt.empty();
    }

    void first_step() {
        if (!caches_) {
            run_.set_spp(first_spp);
            add_samples();
            return;
        }
        // What the scene needs is not known yet; and the first step is done whatever the time limit.
        level_ = std::clamp(levels_a_halving * std::log2(error_of_draft / (aim * goal_)), 0.0,
                            settings_.time_limit > 0 ? 0.5 : 2.5);
        apply();
        // Not before now: what it sets up depends on the settings.
        caching_ = std::make_unique<CachingRenderer>(run_);
        caching_->spare(pixels_without_lamps(run_), lamp_spp);
        append(caching_->render(film_));
    }

    void apply() {
        apply_level(settings_, level_);
        // Pixels end with less noise than they may: with .9 of the goal about an eighth of the squared error.
        const double pixel_error = 0.9 * goal_ * pixel_factor_;
        settings_.pixel_error = static_cast<float>(pixel_error);
        run_.set_spp(
            static_cast<std::uint32_t>(std::clamp(2.25 / (pixel_error * pixel_error), 64.0, double{most_spp})));
    }

    void append(const std::vector<std::uint32_t>& pixels) {
        pixels_.insert(pixels_.end(), pixels.begin(), pixels.end());
    }

    void add_samples() {
        if (settings_.method == Method::path)
            render_path(run_, film_, position_);
        else
            render_gather(run_, film_, position_);
    }

    // The error, by as many probes as it takes to tell whether it is below the goal, or that it is not worth it.
    ErrorReport look() {
        const double error = aim * goal_, allowed = goal_ * goal_;
        // What a better picture costs, to the effort so far, about; there is none beyond the highest level. Where no
        // target is asked for, a better picture is what there is to gain.
        const double worth = target_ <= 0 ? 0.5 : caches_ && level_ >= highest_level ? 4 : 1;
        for (;;) {
            const ErrorReport report = probes_->report(film_);
            const auto [square, deviation] = probes_->squared_error(film_);
            const bool doubted = !report.doubt.empty();
            if (!doubted && (report.rel_rmse.high <= goal_ || report.rel_rmse.low > goal_)) return report;
            if (doubted && probes_->effort() > 0.5 * run_.effort()) return report;
            // The deviation falls as the root of the probes' effort. Where a better picture costs less than knowing
            // that this one is good enough, there is no use in more probes.
            const double room = allowed - square, times = 2 * deviation / std::max(room, 1e-3 * allowed);
            const double effort = (times * times - 1) * probes_->effort();
            const bool good = square < 0.8 * allowed;
            if (!doubted && good && effort > worth * run_.effort()) return report;
            // Nor where it is likely that it is not, or enough has been tried: probes are kept, for the last picture
            // too.
            const bool likely =
                target_ <= 0 ? square - deviation > 0.5 * allowed
                             : square - 1.5 * deviation > allowed || probes_->effort() > 0.3 * worth * run_.effort();
            if (!doubted && !good && likely) return report;
            // What was meant may be too little for any.
            const double spent = probes_->effort();
            for (double share = std::clamp(effort, 0.03 * run_.effort(), probe_share * run_.effort());
                 probes_->effort() <= spent; share *= 2)
                spend(*probes_, film_, share, error);
        }
    }

    [[nodiscard]] Need need(const ErrorReport& found) const {
        const double allowed = goal_ * goal_, error = found.rel_rmse.value * found.rel_rmse.value;
        // Direct light has no other error than noise, and more of it than its own samples show where they missed a
        // light.
        const double noise =
            std::min(std::max(caching_->squared_noise(), found.direct_rel_rmse * found.direct_rel_rmse), error);
        const double rest = error - noise;
        Need need;
        if (noise > 0.2 * allowed) need.pixel_error = std::clamp(std::sqrt(0.15 * allowed / noise), 0.25, 0.8);
        if (rest > 0.45 * allowed)
            need.levels = std::clamp(levels_a_halving * std::log2(std::sqrt(rest / (0.35 * allowed))), 0.35, 1.0);
        if (need.levels == 0 && need.pixel_error == 1) need = {0.35, 0.8};  // little is missing
        return need;
    }

    // false: there is nothing more to do.
    bool next_step(const ErrorReport& found) {
        if (!caches_) {
            const double error = found.rel_rmse.value * found.rel_rmse.value;
            const double wanted = run_.spp() * std::max(error, 0.25 * goal_ * goal_) / (aim * goal_ * aim * goal_);
            const std::uint32_t first = run_.spp();
            if (first >= most_spp) return false;
            run_.set_spp(
                static_cast<std::uint32_t>(std::min<double>(std::clamp(wanted, 1.3 * first, 8.0 * first), most_spp)));
            add_samples();
            return true;
        }
        const Need need = this->need(found);
        if (level_ >= highest_level && need.pixel_error == 1) return false;
        const float before = settings_.accuracy;
        pixel_factor_ *= need.pixel_error;
        level_ = std::min(level_ + need.levels, highest_level);
        apply();
        append(need.levels > 0 ? caching_->refine(film_, settings_.accuracy / before) : caching_->sample_more(film_));
        return true;
    }

    Run& run_;
    RenderSettings& settings_;
    Film& film_;
    std::unique_ptr<CachingRenderer> caching_;
    std::unique_ptr<ErrorProbes> probes_;
    std::vector<std::uint32_t> pixels_;
    bool caches_;
    double target_, goal_;  // goal_: where no target is asked for, a better picture than the last one
    double level_ = 0, pixel_factor_ = 1;
    int steps_ = 0;
    SamplePosition position_;
    std::optional<Film> kept_;  // the last one whose error is known
    ErrorReport report_;        // it
};

TargetSearch::TargetSearch(Run& run, RenderSettings& settings, Film& film)
    : steps_(std::make_unique<Steps>(run, settings, film)) {}
TargetSearch::~TargetSearch() = default;
std::vector<std::uint32_t> TargetSearch::run(ErrorReport& report) { return steps_->run(report); }
void TargetSearch::state(Checkpoint& checkpoint) { steps_->state(checkpoint); }
const CachingRenderer* TargetSearch::caching() const { return steps_->caching(); }

}  // namespace irradia
