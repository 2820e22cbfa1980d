#include "device/launch.h"

#include <algorithm>
#include <atomic>
#include <chrono>

#include "core/worker_pool.h"

namespace irradia::device {
namespace {
// Of a part, at least: enqueueing one takes 4 to 6 microseconds.
constexpr double part_seconds = 2.5e-5;
}  // namespace

SharedLaunch::SharedLaunch(cl_context context, cl_device_id device, cl_command_queue first, int threads)
    : queues_{first} {
    for (int i = 1; i < threads; ++i) {
        cl_int status = CL_SUCCESS;
        cl_command_queue queue = clCreateCommandQueue(context, device, 0, &status);
        check(status, "making a queue for thread " + std::to_string(i + 1) + " of " + std::to_string(threads));
        queues_.push_back(queue);
    }
}

SharedLaunch::~SharedLaunch() {
    for (std::size_t i = 1; i < queues_.size(); ++i) clReleaseCommandQueue(queues_[i]);
}

// [0, count) in parts, large ones first, so that all threads end at about the same time: three quarters of each one's
// share of what is left, or least() at least.
template <class Least, class F>
cl_int SharedLaunch::share(std::size_t count, const Least& least, const F& work_on) {
    const std::size_t threads = std::clamp<std::size_t>(count / least(), 1, queues_.size());
    std::atomic<std::size_t> next = 0, arrived = 0;
    std::atomic<cl_int> outcome = CL_SUCCESS;
    const auto work = [&] {
        cl_command_queue queue = nullptr;
        for (std::size_t first = next;;) {
            std::size_t part = 0;
            do {
                if (first >= count) return;
                const std::size_t left = count - first;
                part = threads == 1 ? left : std::min(left, std::max(least(), 3 * left / (4 * threads)));
            } while (!next.compare_exchange_weak(first, first + part));
            if (queue == nullptr) queue = queues_[arrived++];
            cl_int status = work_on(queue, first, part);
            if (status == CL_SUCCESS) status = clFinish(queue);
            if (status != CL_SUCCESS) outcome = status;
            first = next;
        }
    };
    WorkerPool::shared().run(threads - 1, work);
    return outcome;
}

cl_int SharedLaunch::run(const std::string& name, cl_kernel kernel, std::size_t groups, std::size_t group_size) {
    double& known = group_seconds_[name];
    std::atomic<double> sum = 0;  // of `ended` groups and perhaps others
    std::atomic<std::size_t> ended = 0;
    const auto least = [&] {  // by what this launch's first parts took, or else the launch before
        const std::size_t n = ended;
        const double seconds = n > 0 ? sum / static_cast<double>(n) : known;
        const std::size_t groups_a_part = seconds > 0 ? static_cast<std::size_t>(std::min(part_seconds / seconds, 1e9))
                                                      : groups / (8 * queues_.size());
        return std::max<std::size_t>(groups_a_part, 1);
    };
    const std::size_t local[3] = {group_size, 1, 1};
    const cl_int status = share(groups, least, [&](cl_command_queue queue, std::size_t first, std::size_t count) {
        const std::size_t offset[3] = {0, 0, first + 1}, items[3] = {group_size, 1, count};
        const auto start = std::chrono::steady_clock::now();
        const cl_int done = clEnqueueNDRangeKernel(queue, kernel, 3, offset, items, local, 0, nullptr, nullptr);
        const std::chrono::duration<double> taken = std::chrono::steady_clock::now() - start;
        sum += taken.count();
        ended += count;
        return done;
    });
    known = sum / static_cast<double>(groups);
    return status;
}

cl_int SharedLaunch::place(cl_mem buffer) {
    const cl_int status = clEnqueueMigrateMemObjects(queues_[0], 1, &buffer, 0, 0, nullptr, nullptr);
    return status == CL_SUCCESS ? clFinish(queues_[0]) : status;
}

template <class F>
cl_int SharedLaunch::share_bytes(std::size_t bytes, const F& work_on) {
    const std::size_t parts = (bytes + least_bytes - 1) / least_bytes;
    const auto one = [] { return std::size_t{1}; };
    return share(parts, one, [&](cl_command_queue queue, std::size_t first, std::size_t count) {
        const std::size_t begin = first * least_bytes, end = std::min(bytes, (first + count) * least_bytes);
        return work_on(queue, begin, end - begin);
    });
}

cl_int SharedLaunch::fill(cl_mem buffer, cl_uint word, std::size_t bytes) {
    return share_bytes(bytes, [&](cl_command_queue queue, std::size_t begin, std::size_t count) {
        return clEnqueueFillBuffer(queue, buffer, &word, sizeof word, begin, count, 0, nullptr, nullptr);
    });
}

cl_int SharedLaunch::write(cl_mem buffer, const void* data, std::size_t bytes, std::size_t offset) {
    const auto* const from = static_cast<const unsigned char*>(data);
    return share_bytes(bytes, [&](cl_command_queue queue, std::size_t begin, std::size_t count) {
        return clEnqueueWriteBuffer(queue, buffer, CL_TRUE, offset + begin, count, from + begin, 0, nullptr, nullptr);
    });
}

cl_int SharedLaunch::read(cl_mem buffer, void* data, std::size_t bytes, std::size_t offset) {
    auto* const to = static_cast<unsigned char*>(data);
    return share_bytes(bytes, [&](cl_command_queue queue, std::size_t begin, std::size_t count) {
        return clEnqueueReadBuffer(queue, buffer, CL_TRUE, offset + begin, count, to + begin, 0, nullptr, nullptr);
    });
}

cl_int SharedLaunch::copy(cl_mem from, cl_mem to, std::size_t bytes) {
    return share_bytes(bytes, [&](cl_command_queue queue, std::size_t begin, std::size_t count) {
        return clEnqueueCopyBuffer(queue, from, to, begin, begin, count, 0, nullptr, nullptr);
    });
}

}  // namespace irradia::device
