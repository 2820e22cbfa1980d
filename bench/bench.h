// What the benchmarks share: which device, and how time is told.
#pragma once
#include <ctime>
#include <string>

#include "irradia/Device.h"

namespace irradia::bench {

void register_rays();
void register_octree(const DeviceOptions& options);
void register_hemispheres(const DeviceOptions& options);

/// CPU time of the process: on a busy machine wall time would measure the neighbours. (Of all its threads, those that
/// wait in a loop too: DeviceOptions::threads is 1.)
inline double cpu_seconds() {
    timespec t{};
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &t);
    return static_cast<double>(t.tv_sec) + 1e-9 * static_cast<double>(t.tv_nsec);
}

/// Seconds that a device works: CPU time where it is a CPU (host code that feeds it included), else the time of all its
/// commands by their events.
class DeviceClock {
public:
    explicit DeviceClock(Device& device) : device_(device), start_(now()) {}
    double seconds() {
        device_.finish();
        return now() - start_;
    }

private:
    [[nodiscard]] double now() const {
        if (device_.description().is_cpu) return cpu_seconds();
        double sum = 0;
        for (const auto& [stage, time] : device_.stage_times())
            if (stage != "build") sum += time.seconds;
        return sum;
    }
    Device& device_;
    double start_;
};

}  // namespace irradia::bench
