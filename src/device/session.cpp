#include "device/session.h"

#include <algorithm>
#include <thread>
#include <utility>

#include "irradia/Error.h"

namespace irradia::device {
namespace {
// Events a queue may gather before the complete ones are counted and dropped.
constexpr std::size_t kManyPending = 256;
}  // namespace

Session::Session(const DeviceOptions& options) : device(select_device(options.select)) {
    if (options.threads < 0) throw Error("--threads: " + std::to_string(options.threads) + " is negative");
    if (options.threads > 0 && device.description.is_cpu && !device.in_caller) limit_threads(options.threads);
    const auto all = static_cast<int>(device.description.is_cpu ? device.description.compute_units
                                                                : std::max(std::thread::hardware_concurrency(), 1u));
    host_threads = options.threads > 0 ? std::min(options.threads, all) : all;
    cl_int status = CL_SUCCESS;
    const cl_context_properties properties[] = {CL_CONTEXT_PLATFORM,
                                                reinterpret_cast<cl_context_properties>(device.platform), 0};
    context = clCreateContext(properties, 1, &device.id, nullptr, nullptr, &status);
    check(status, "opening device '" + device.description.name + "'");
    queue = clCreateCommandQueue(context, device.id, CL_QUEUE_PROFILING_ENABLE, &status);
    check(status, "making a queue on device '" + device.description.name + "'");
    if (device.in_caller) shared_launch = std::make_unique<SharedLaunch>(context, device.id, queue, host_threads);
}

Session::~Session() {
    shared_launch.reset();
    if (queue != nullptr) clFinish(queue);
    for (const Pending& p : pending_) clReleaseEvent(p.event);
    // PoCL 3.1 reports a command complete before its worker thread has let go of the command's event, which refers to
    // queue and context: releasing them here is a use after free in that thread (seen about once in 100 devices). A
    // process opens few devices; they stay open until it ends. Buffers and programs are released all the same.
    if (device.description.platform == "Portable Computing Language") return;
    if (queue != nullptr) clReleaseCommandQueue(queue);
    if (context != nullptr) clReleaseContext(context);
    if (split_) clReleaseDevice(device.id);
}

// A sub-device of `threads` compute units rather than PoCL's POCL_MAX_PTHREAD_COUNT: that is read once a process, so it
// would depend on who asked for the platforms first. PoCL gives a sub-device of one unit one worker thread.
void Session::limit_threads(int threads) {
    if (static_cast<unsigned>(threads) >= device.description.compute_units) return;
    const cl_device_partition_property how[] = {CL_DEVICE_PARTITION_BY_COUNTS, threads,
                                                CL_DEVICE_PARTITION_BY_COUNTS_LIST_END, 0};
    cl_device_id part = nullptr;
    cl_uint count = 0;
    const cl_int status = clCreateSubDevices(device.id, how, 1, &part, &count);
    if (status != CL_SUCCESS || count != 1)
        throw Error("--threads: device '" + device.description.name + "' cannot be limited to " +
                    std::to_string(threads) + " of its " + std::to_string(device.description.compute_units) +
                    " units: " + status_name(status));
    device.id = part;
    split_ = true;
}

void Session::track(const std::string& stage, cl_event event, std::vector<unsigned char> staging) {
    pending_.push_back({&stages_[stage], event, std::move(staging)});
    if (pending_.size() % kManyPending != 0) return;
    clFlush(queue);
    harvest();
}

void Session::harvest() {
    while (!pending_.empty()) {
        const cl_event event = pending_.front().event;
        StageTime& stage = *pending_.front().stage;
        cl_int state = CL_QUEUED;
        check(clGetEventInfo(event, CL_EVENT_COMMAND_EXECUTION_STATUS, sizeof state, &state, nullptr),
              "asking for the state of a command");
        if (state > CL_COMPLETE) return;
        cl_ulong start = 0, end = 0;
        if (state == CL_COMPLETE) {
            check(clGetEventProfilingInfo(event, CL_PROFILING_COMMAND_START, sizeof start, &start, nullptr),
                  "asking for a command's time");
            check(clGetEventProfilingInfo(event, CL_PROFILING_COMMAND_END, sizeof end, &end, nullptr),
                  "asking for a command's time");
        }
        clReleaseEvent(event);
        pending_.pop_front();
        if (state < 0) {
            for (const auto& [name, time] : stages_)
                if (&time == &stage) check(state, "running '" + name + "' on the device");
        }
        stage.seconds += end > start ? static_cast<double>(end - start) * 1e-9 : 0.0;
        ++stage.launches;
    }
}

void Session::add_time(const std::string& stage, std::chrono::steady_clock::time_point start, std::uint64_t launches) {
    StageTime& s = stages_[stage];
    s.seconds += std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
    s.launches += launches;
}

std::map<std::string, StageTime> Session::times() {
    harvest();
    return stages_;
}

void Session::allocated(std::uint64_t bytes) {
    allocated_ += bytes;
    peak_ = std::max(peak_, allocated_);
}

}  // namespace irradia::device
