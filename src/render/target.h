// Rendering to an error: in steps that keep what is there, until the error's interval lies below what is asked.
#pragma once
#include <memory>
#include <vector>

#include "render/error_probes.h"
#include "render/methods.h"

namespace irradia {

class TargetSearch {
public:
    /// `settings`, which `run` refers to, are changed from step to step.
    TargetSearch(Run& run, RenderSettings& settings, Film& film);
    ~TargetSearch();
    TargetSearch(const TargetSearch&) = delete;
    TargetSearch& operator=(const TargetSearch&) = delete;

    /// Goes on from where it is. Returns the pixels of all records; the report is that of the film as it is left. Stops
    /// early at settings.time_limit, but not before the first step is done.
    std::vector<std::uint32_t> run(ErrorReport& report);
    /// All but run and film. Whole between steps.
    void state(Checkpoint& checkpoint);
    /// What the search has made; null for methods that only take samples.
    [[nodiscard]] const CachingRenderer* caching() const;

private:
    class Steps;
    std::unique_ptr<Steps> steps_;
};

}  // namespace irradia
