// What a Device, its buffers and its kernels share: context, queue, event times, the sum of allocated bytes.
#pragma once
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "device/launch.h"
#include "device/opencl.h"

namespace irradia::device {

/// Lives as long as anything that was made by its device.
class Session {
public:
    FoundDevice device;  ///< description: of the whole device, also if `id` is a part of it
    cl_context context = nullptr;
    cl_command_queue queue = nullptr;
    int host_threads = 1;                         ///< that the host itself may use
    std::unique_ptr<SharedLaunch> shared_launch;  ///< where the device works in threads of the host; else null

    explicit Session(const DeviceOptions& options);
    ~Session();
    Session(const Session&) = delete;
    Session& operator=(const Session&) = delete;

    /// So much memory is worth more than one thread.
    [[nodiscard]] bool shares(std::size_t bytes) const {
        return shared_launch != nullptr && host_threads > 1 && bytes > SharedLaunch::least_bytes;
    }

    /// Takes over `event`; its time is added to `stage` once it is complete. `staging` is kept alive until then.
    void track(const std::string& stage, cl_event event, std::vector<unsigned char> staging = {});
    /// Adds up the events that are complete, oldest first; waits for none.
    void harvest();
    /// What a stage has taken since `start`, for `launches` of what it does.
    void add_time(const std::string& stage, std::chrono::steady_clock::time_point start, std::uint64_t launches = 1);
    [[nodiscard]] std::map<std::string, StageTime> times();

    void allocated(std::uint64_t bytes);
    void freed(std::uint64_t bytes) { allocated_ -= bytes; }
    [[nodiscard]] std::uint64_t allocated_now() const { return allocated_; }
    [[nodiscard]] std::uint64_t peak() const { return peak_; }

private:
    struct Pending {
        StageTime* stage;
        cl_event event;
        std::vector<unsigned char> staging;
    };
    std::deque<Pending> pending_;
    std::map<std::string, StageTime> stages_;  // nodes stay where they are: Pending points to them
    bool split_ = false;
    std::uint64_t allocated_ = 0, peak_ = 0;

    void limit_threads(int threads);
};

}  // namespace irradia::device
