// Launches on a device whose commands run in the thread that enqueues them (FoundDevice::in_caller): the host's threads
// share the groups out, each through a queue of its own. No thread is woken for a launch that is over sooner.
#pragma once
#include <cstddef>
#include <map>
#include <string>
#include <vector>

#include "device/opencl.h"

namespace irradia::device {

class SharedLaunch {
public:
    /// What a thread takes at a time of memory that is filled or copied: less is not worth another one.
    static constexpr std::size_t least_bytes = std::size_t{1} << 18;

    /// Queues for `threads` threads, `first` one of them. Throws Error.
    SharedLaunch(cl_context context, cl_device_id device, cl_command_queue first, int threads);
    ~SharedLaunch();
    SharedLaunch(const SharedLaunch&) = delete;
    SharedLaunch& operator=(const SharedLaunch&) = delete;

    /// Runs the kernel, whose arguments are set, and returns when it is done. Groups follow each other along the third
    /// axis, from 1 on (-D IR_SHARED_OUT). For PoCL 3.1 keeps a kernel's code once a width of launches, along the
    /// first two axes, and once for those that start at 0, and mixes them up where launches overlap.
    cl_int run(const std::string& name, cl_kernel kernel, std::size_t groups, std::size_t group_size);
    /// Gives a new buffer its place in the device's memory, which its first launches would do all at once.
    cl_int place(cl_mem buffer);
    /// `bytes` of the buffer, a multiple of 4, become `word`.
    cl_int fill(cl_mem buffer, cl_uint word, std::size_t bytes);
    /// Memory to and from buffers, and between two of them.
    cl_int write(cl_mem buffer, const void* data, std::size_t bytes, std::size_t offset);
    cl_int read(cl_mem buffer, void* data, std::size_t bytes, std::size_t offset);
    cl_int copy(cl_mem from, cl_mem to, std::size_t bytes);

private:
    template <class F>
    cl_int share_bytes(std::size_t bytes, const F& work_on);
    template <class Least, class F>
    cl_int share(std::size_t count, const Least& least, const F& work_on);

    std::vector<cl_command_queue> queues_;         // of the calling thread, and of the pool's
    std::map<std::string, double> group_seconds_;  // of one thread, when the kernel ran last
};

}  // namespace irradia::device
