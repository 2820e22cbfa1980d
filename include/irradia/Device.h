// OpenCL behind a small face: platforms, one queue, programs from embedded sources, buffers, kernels with timings.
// Knows nothing of light.
#pragma once
#include <cstddef>
#include <cstdint>
#include <future>
#include <map>
#include <memory>
#include <string>
#include <vector>

namespace irradia {

/// One line of --list-devices.
struct DeviceDescription {
    int index = 0;  ///< what --device takes
    std::string name, platform, driver;
    bool is_cpu = false;
    unsigned compute_units = 0;
    std::uint64_t global_memory = 0, local_memory = 0;  ///< bytes
};

std::vector<DeviceDescription> list_devices();

/// What a run asks of the device.
struct DeviceOptions {
    std::string select;     ///< index or a part of the name or platform, case-insensitive; "" = the default (a GPU if
                            ///< there is one, else the CPU)
    int threads = 0;        ///< worker threads (of a GPU's: the host's own); 0, or more than there are, = all
    std::string traversal;  ///< "", "cpu" or "gpu": which traversal header the kernels get ("" = by device kind)
    std::uint64_t memory_limit = 0;  ///< bytes that this process may take: on a CPU device, buffers that would pass it
                                     ///< are refused; 0 = none
    std::string compiler{};          ///< executable that, started with kCompileForParent, calls compile_for_parent():
                                     ///< Device::expect has it compile kernels; "" = all are compiled in this process
};

/// The only argument of a process that shall call compile_for_parent() as the first thing it does. Ends the process;
/// returns 2 only if it was not started by Device::expect.
inline constexpr const char* kCompileForParent = "--compile-for-parent";
int compile_for_parent();

/// What Device::kernel() takes but a kernel's name.
struct KernelSource {
    std::string file;
    std::map<std::string, std::string> defines;
    int registers = 0;  ///< as of Device::kernel()
};

class Device;

/// Device memory. Movable; freed on destruction. A zero-byte request is rounded up (OpenCL has no empty buffers).
class Buffer {
public:
    Buffer();
    Buffer(Buffer&&) noexcept;
    Buffer& operator=(Buffer&&) noexcept;
    ~Buffer();
    [[nodiscard]] std::size_t bytes() const noexcept;
    [[nodiscard]] void* handle() const noexcept;  ///< cl_mem

private:
    friend class Device;
    struct Impl;
    std::unique_ptr<Impl> impl_;
};

/// Time spent in one kernel or transfer kind: from device events, or what the host waited where its own threads work.
struct StageTime {
    double seconds = 0;
    std::uint64_t launches = 0;
};

/// A kernel with its arguments being set. Obtain by Device::kernel(); cheap to copy.
class Kernel {
public:
    Kernel& arg(const Buffer& buffer);  ///< next argument
    template <class T>
    Kernel& arg(const T& value) {
        return arg_bytes(&value, sizeof(T));
    }                                  ///< next argument, by value (4-byte scalars, PODs)
    Kernel& local(std::size_t bytes);  ///< next argument, __local memory
    /// Runs `groups` work-groups of `group_size` items (1D); in order, and mostly asynchronous (on PoCL's CPU device
    /// the host's threads run them, and it is done when this returns); no groups: nothing is launched.
    /// Starts the arguments anew: set all of them before every run.
    void run(std::size_t groups, std::size_t group_size);
    Kernel& arg_bytes(const void* data, std::size_t bytes);

private:
    friend class Device;
    struct Impl;
    std::shared_ptr<Impl> impl_;
};

/// One OpenCL device, one in-order queue. Every OpenCL failure is an Error that says what was being done
/// (out of memory names the bytes asked for; a build failure carries the compiler's log).
class Device {
public:
    explicit Device(const DeviceOptions& options);
    /// Makes one on a thread of its own: loading a driver takes 20 to 300 ms. What fails is told by get().
    static std::future<std::unique_ptr<Device>> open_ahead(const DeviceOptions& options);
    ~Device();
    Device(const Device&) = delete;
    Device& operator=(const Device&) = delete;

    [[nodiscard]] const DeviceDescription& description() const noexcept;
    [[nodiscard]] bool cpu_traversal() const noexcept;  ///< true: -D IR_CPU is given to every program
    [[nodiscard]] std::size_t tile() const noexcept;    ///< rays of one packet: IR_TILE of trace.h
    [[nodiscard]] std::size_t group_size()
        const noexcept;  ///< items of a hemisphere's work-group: 64 on CPUs, 256 on GPUs
    [[nodiscard]] std::size_t pixel_group()
        const noexcept;  ///< items of the one-item-a-pixel kernels' groups: 16 on CPUs, 64 (two warps) on GPUs
    [[nodiscard]] int host_threads() const noexcept;  ///< threads that the host itself may use

    /// Kernel `name` of cl/`file` (embedded, or an absolute path), compiled with `defines` ("IR_M" -> "16"); programs
    /// are cached by (file, defines). If the environment variable IRRADIA_CL_DIR names a folder, its files are taken
    /// before the embedded ones. `registers`: that an item may have at most, where the device's compiler can be told
    /// (NVIDIA's); 0: as many as it likes. With fewer more groups run at once, which hides what memory takes.
    Kernel kernel(const std::string& file, const std::string& name, const std::map<std::string, std::string>& defines,
                  int registers = 0);

    /// Kernels that kernel() is going to be asked for, the first one first. On CPU devices and NVIDIA's those that no
    /// earlier run has left are compiled from now on, beside this process, by as many others as the host has threads for.
    void expect(const std::vector<KernelSource>& kernels);

    Buffer allocate(std::size_t bytes);                  ///< uninitialised
    Buffer upload(const void* data, std::size_t bytes);  ///< allocate + write
    template <class T>
    Buffer upload(const std::vector<T>& v) {
        return upload(v.data(), v.size() * sizeof(T));
    }
    /// What kernels only read: on PoCL's CPU devices v itself, which must stay where and as it is while the buffer
    /// lives, and counts for nothing in peak_memory(); elsewhere as upload().
    template <class T>
    Buffer share(const std::vector<T>& v) {
        return share(v.data(), v.size() * sizeof(T));
    }
    Buffer share(const void* data, std::size_t bytes);
    /// Writes v to the start of `to`, which is made anew if it is too small.
    template <class T, class Allocator>
    void upload_to(Buffer& to, const std::vector<T, Allocator>& v) {
        const std::size_t bytes = v.size() * sizeof(T);
        if (to.bytes() < bytes) to = allocate(bytes + bytes / 2);
        write(to, v.data(), bytes);
    }
    void write(Buffer& to, const void* data, std::size_t bytes, std::size_t offset = 0);
    void read(const Buffer& from, void* data, std::size_t bytes, std::size_t offset = 0);  ///< blocks until done
    void copy(const Buffer& from, Buffer& to, std::size_t bytes);
    void fill(Buffer& buffer, std::uint32_t word, std::size_t bytes);  ///< bytes a multiple of 4
    void finish();

    [[nodiscard]] std::map<std::string, StageTime> stage_times()
        const;  ///< by kernel name, plus "read", "write", "copy", "fill", "build"
    [[nodiscard]] std::uint64_t peak_memory() const noexcept;  ///< bytes of device buffers, at most

private:
    struct Impl;
    std::unique_ptr<Impl> impl_;
};

}  // namespace irradia
