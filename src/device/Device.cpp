#include "irradia/Device.h"

#include <algorithm>
#include <chrono>
#include <cstdlib>
#include <utility>

#include "core/in_ranges.h"
#include "core/memory.h"
#include "device/compile_program.h"
#include "device/compilers.h"
#include "device/kernel_source.h"
#include "device/program_cache.h"
#include "device/session.h"
#include "irradia/Error.h"

namespace irradia {

using device::check;
using device::format_bytes;
using device::Session;

namespace {

// Writes up to this size are copied aside and queued; larger ones wait until the device has taken them.
constexpr std::size_t kStagedWrite = std::size_t{1} << 20;

std::vector<std::string> kernel_names(cl_program program) {
    std::size_t bytes = 0;
    if (clGetProgramInfo(program, CL_PROGRAM_KERNEL_NAMES, 0, nullptr, &bytes) != CL_SUCCESS || bytes == 0) return {};
    std::string text(bytes, '\0');
    if (clGetProgramInfo(program, CL_PROGRAM_KERNEL_NAMES, bytes, text.data(), nullptr) != CL_SUCCESS) return {};
    text.resize(bytes - 1);
    std::vector<std::string> names;
    for (std::size_t at = 0; at < text.size();) {
        const std::size_t end = std::min(text.find(';', at), text.size());
        names.push_back(text.substr(at, end - at));
        at = end + 1;
    }
    return names;
}

}  // namespace

// ---- buffers ----------------------------------------------------------------------------------------------------

struct Buffer::Impl {
    std::shared_ptr<Session> session;
    cl_mem memory = nullptr;
    std::size_t bytes = 0, taken = 0;  // taken: of the device's memory
    Impl(std::shared_ptr<Session> s, cl_mem m, std::size_t n, std::size_t t)
        : session(std::move(s)), memory(m), bytes(n), taken(t) {
        session->allocated(taken);
    }
    ~Impl() {
        clReleaseMemObject(memory);
        session->freed(taken);
    }
    Impl(const Impl&) = delete;
    Impl& operator=(const Impl&) = delete;
};

Buffer::Buffer() = default;
Buffer::Buffer(Buffer&&) noexcept = default;
Buffer& Buffer::operator=(Buffer&&) noexcept = default;
Buffer::~Buffer() = default;
std::size_t Buffer::bytes() const noexcept { return impl_ ? impl_->bytes : 0; }
void* Buffer::handle() const noexcept { return impl_ ? impl_->memory : nullptr; }

// ---- kernels ----------------------------------------------------------------------------------------------------

struct Kernel::Impl {
    std::shared_ptr<Session> session;
    std::string name;
    cl_kernel kernel = nullptr;
    cl_uint argument_count = 0;
    cl_uint next = 0;
    std::size_t largest_group = 0;
    Impl(std::shared_ptr<Session> s, std::string n, cl_kernel k)
        : session(std::move(s)), name(std::move(n)), kernel(k) {}
    ~Impl() { clReleaseKernel(kernel); }
    Impl(const Impl&) = delete;
    Impl& operator=(const Impl&) = delete;

    void set(std::size_t bytes, const void* data) {
        const cl_int status = next < argument_count ? clSetKernelArg(kernel, next, bytes, data) : CL_INVALID_ARG_INDEX;
        if (status != CL_SUCCESS)
            throw Error("OpenCL: setting argument " + std::to_string(next) + " of " + std::to_string(argument_count) +
                        " of kernel '" + name + "' (" + std::to_string(bytes) +
                        " bytes) failed: " + device::status_name(status));
        ++next;
    }
};

Kernel& Kernel::arg(const Buffer& buffer) {
    const cl_mem memory = static_cast<cl_mem>(buffer.handle());
    if (memory == nullptr)
        throw Error("kernel '" + impl_->name + "': argument " + std::to_string(impl_->next) +
                    " is a buffer that was never allocated");
    impl_->set(sizeof memory, &memory);
    return *this;
}

Kernel& Kernel::arg_bytes(const void* data, std::size_t bytes) {
    impl_->set(bytes, data);
    return *this;
}

Kernel& Kernel::local(std::size_t bytes) {
    impl_->set(std::max<std::size_t>(bytes, 4), nullptr);
    return *this;
}

void Kernel::run(std::size_t groups, std::size_t group_size) {
    const cl_uint set = std::exchange(impl_->next, 0);
    if (set != impl_->argument_count)
        throw Error("kernel '" + impl_->name + "' takes " + std::to_string(impl_->argument_count) + " arguments, " +
                    std::to_string(set) + " were set");
    if (groups == 0) return;
    if (group_size == 0 || group_size > impl_->largest_group)
        throw Error("kernel '" + impl_->name + "': a group of " + std::to_string(group_size) +
                    " items is not possible, the device takes 1 to " + std::to_string(impl_->largest_group));
    Session& session = *impl_->session;
    cl_event event = nullptr;
    cl_int status = CL_SUCCESS;
    if (session.shared_launch) {
        const auto start = std::chrono::steady_clock::now();
        status = session.shared_launch->run(impl_->name, impl_->kernel, groups, group_size);
        session.add_time(impl_->name, start);
    } else {
        const std::size_t items = groups * group_size;
        status =
            clEnqueueNDRangeKernel(session.queue, impl_->kernel, 1, nullptr, &items, &group_size, 0, nullptr, &event);
    }
    if (status != CL_SUCCESS)
        throw Error("OpenCL: launching kernel '" + impl_->name + "' (" + std::to_string(groups) + " groups of " +
                    std::to_string(group_size) + ", " + format_bytes(session.allocated_now()) +
                    " of buffers allocated) failed: " + device::status_name(status));
    if (event != nullptr) session.track(impl_->name, event);
}

namespace {
std::string program_name(const std::string& file, const std::string& options) { return file + "\n" + options; }

/// One that is going to be asked for.
struct WantedProgram {
    std::string name, file, options;
    device::ProgramKey key;
};
}  // namespace

// ---- device -----------------------------------------------------------------------------------------------------

struct Device::Impl {
    std::shared_ptr<Session> session;
    bool cpu_traversal = false;
    std::uint64_t largest_allocation = 0;
    std::uint64_t memory_limit = 0, resident_before = 0;  // of a CPU device; the resident set before any buffer
    std::string source;                                   // last expanded
    std::map<std::string, Checksums> sums;                // of sources that are not embedded, by file
    std::map<std::string, cl_program> programs;           // by file and compiler options
    std::vector<std::pair<device::ProgramKey, cl_program>> compiled;  // here, from their source
    std::string compiler;                                             // executable, and how many of it at a time
    std::size_t compiler_count = 0;
    std::unique_ptr<device::Compilers> compilers;

    ~Impl() {
        for (const auto& [key, program] : compiled) device::store_program(key, program);
        for (const auto& [key, program] : programs) clReleaseProgram(program);
    }

    void place(cl_mem memory) const {
        if (session->shared_launch) check(session->shared_launch->place(memory), "placing a buffer on the device");
    }

    [[nodiscard]] bool is_nvidia() const { return session->device.description.platform == "NVIDIA CUDA"; }

    [[nodiscard]] std::string options(const std::map<std::string, std::string>& defines, int registers) const {
        std::string text = "-cl-std=CL1.2";
        if (cpu_traversal) text += " -D IR_CPU=1";
        if (session->shared_launch) text += " -D IR_SHARED_OUT=1";
        for (const auto& [symbol, value] : defines) text += " -D " + symbol + (value.empty() ? "" : "=" + value);
        if (registers > 0 && is_nvidia()) text += " -cl-nv-maxrregcount=" + std::to_string(registers);
        return text;
    }

    const std::string& expand(const std::string& file) {
        source = device::expand_source(file, std::move(source));
        if (device::embedded_sums(file) == nullptr) sums[file] = checksums(source.data(), source.size());
        return source;
    }

    const Checksums& sums_of(const std::string& file) {
        if (const Checksums* const known = device::embedded_sums(file)) return *known;
        if (sums.count(file) == 0) expand(file);
        return sums[file];
    }

    device::ProgramKey key(const std::string& file, const std::string& options) {
        return device::program_key(*session, sums_of(file), options);
    }

    cl_program build(const std::string& file, const std::string& options) {
        const auto start = std::chrono::steady_clock::now();
        const auto time = [&] { session->add_time("build", start); };
        const device::ProgramKey kept_by = key(file, options);
        if (compilers) compilers->wait_for(kept_by);
        if (cl_program program = device::kept_program(*session, kept_by, options)) {
            time();
            return program;
        }
        const device::CompiledProgram made = device::compile_program(*session, expand(file), options);
        if (made.program == nullptr)
            throw Error("OpenCL: compiling " + file + " (" + options + ") for '" + session->device.description.name +
                        "' failed: " + device::status_name(made.status) + (made.log.empty() ? "" : "\n" + made.log));
        time();
        if (!made.own_builtins) session->add_time("build with header", std::chrono::steady_clock::now());
        compiled.emplace_back(key(file, options), made.program);
        return made.program;
    }

    // The programs of `kernels` that are not there yet, each once.
    std::vector<WantedProgram> wanted(const std::vector<KernelSource>& kernels) {
        std::vector<WantedProgram> all;
        for (const KernelSource& k : kernels) {
            const std::string with = options(k.defines, k.registers), name = program_name(k.file, with);
            const bool twice =
                std::any_of(all.begin(), all.end(), [&](const WantedProgram& w) { return w.name == name; });
            if (!twice && programs.count(name) == 0) all.push_back({name, k.file, with, key(k.file, with)});
        }
        return all;
    }

    // Those of them that are kept, on all of the host's threads. What fails is tried, and told, when it is asked for.
    void load(const std::vector<WantedProgram>& all) {
        if (session->host_threads < 2 || !session->shared_launch) return;  // NVIDIA's driver takes no less time so
        const auto start = std::chrono::steady_clock::now();
        std::vector<cl_program> kept(all.size());
        const auto load_one = [&](std::size_t i, std::size_t, std::size_t) {
            try {
                kept[i] = device::kept_program(*session, all[i].key, all[i].options);
            } catch (const std::exception&) {  // memory, say
            }
        };
        in_ranges(session->host_threads, all.size(), load_one, 1);
        std::uint64_t loaded = 0;
        for (std::size_t i = 0; i < all.size(); ++i)
            if (kept[i] != nullptr) programs[all[i].name] = kept[i], ++loaded;
        if (loaded > 0) session->add_time("build", start, loaded);
    }
};

std::vector<DeviceDescription> list_devices() {
    std::vector<DeviceDescription> list;
    for (const device::FoundDevice& d : device::find_devices()) list.push_back(d.description);
    return list;
}

Device::Device(const DeviceOptions& options) : impl_(std::make_unique<Impl>()) {
    if (!options.traversal.empty() && options.traversal != "cpu" && options.traversal != "gpu")
        throw Error("traversal '" + options.traversal + "' is neither 'cpu' nor 'gpu'");
    impl_->session = std::make_shared<Session>(options);
    impl_->cpu_traversal =
        options.traversal.empty() ? impl_->session->device.description.is_cpu : options.traversal == "cpu";
    if (impl_->session->device.description.is_cpu) impl_->memory_limit = options.memory_limit;
    const DeviceDescription& found = impl_->session->device.description;
    // Where nothing is kept nothing could be handed over; and what others take is not counted in a limit.
    if (!options.compiler.empty() && (found.is_cpu || impl_->is_nvidia()) && options.memory_limit == 0 &&
        device::keeps_programs()) {
        impl_->compiler = options.compiler;
        impl_->compiler_count = device::usable_processors();
        if (options.threads > 0)
            impl_->compiler_count =
                std::min<std::size_t>(impl_->compiler_count, static_cast<std::size_t>(options.threads));
    }
    impl_->largest_allocation = device::device_info<cl_ulong>(impl_->session->device.id, CL_DEVICE_MAX_MEM_ALLOC_SIZE);
}

std::future<std::unique_ptr<Device>> Device::open_ahead(const DeviceOptions& options) {
    device::prefer_settings();  // here: the environment is not to change while other threads read it
    return std::async(std::launch::async, [options] { return std::make_unique<Device>(options); });
}

Device::~Device() = default;

const DeviceDescription& Device::description() const noexcept { return impl_->session->device.description; }
bool Device::cpu_traversal() const noexcept { return impl_->cpu_traversal; }
int Device::host_threads() const noexcept { return impl_->session->host_threads; }
std::size_t Device::tile() const noexcept { return impl_->cpu_traversal ? 16 : 1; }
std::size_t Device::group_size() const noexcept { return impl_->cpu_traversal ? 64 : 256; }
std::size_t Device::pixel_group() const noexcept { return impl_->cpu_traversal ? 16 : 64; }

Kernel Device::kernel(const std::string& file, const std::string& name,
                      const std::map<std::string, std::string>& defines, int registers) {
    const std::string options = impl_->options(defines, registers);
    cl_program& program = impl_->programs[program_name(file, options)];
    if (program == nullptr) program = impl_->build(file, options);
    cl_int status = CL_SUCCESS;
    cl_kernel k = clCreateKernel(program, name.c_str(), &status);
    if (status == CL_INVALID_KERNEL_NAME) {
        std::string known;
        for (const std::string& n : kernel_names(program)) known += (known.empty() ? "" : ", ") + n;
        throw Error("no kernel '" + name + "' in " + file + " (there are: " + known + ")");
    }
    check(status, "making kernel '" + name + "' of " + file);

    Kernel kernel;
    kernel.impl_ = std::make_shared<Kernel::Impl>(impl_->session, name, k);
    check(clGetKernelInfo(k, CL_KERNEL_NUM_ARGS, sizeof(cl_uint), &kernel.impl_->argument_count, nullptr),
          "asking for the arguments of kernel '" + name + "'");
    check(clGetKernelWorkGroupInfo(k, impl_->session->device.id, CL_KERNEL_WORK_GROUP_SIZE, sizeof(std::size_t),
                                   &kernel.impl_->largest_group, nullptr),
          "asking for the group size of kernel '" + name + "'");
    return kernel;
}

void Device::expect(const std::vector<KernelSource>& kernels) {
    if (impl_->session->host_threads < 2 && impl_->compiler_count < 2) return;  // each is made when it is asked for
    const std::vector<WantedProgram> wanted = impl_->wanted(kernels);
    impl_->load(wanted);
    if (impl_->compiler_count < 2 || (impl_->compilers && !impl_->compilers->finished())) return;
    std::vector<device::CompileJob> jobs;
    for (const WantedProgram& w : wanted)
        if (impl_->programs.count(w.name) == 0 && !device::has_program(w.key))
            jobs.push_back({w.key, impl_->sums_of(w.file), w.options, impl_->expand(w.file)});
    impl_->compilers.reset();
    if (jobs.size() < 2) return;  // one takes as long here
    impl_->compilers =
        std::make_unique<device::Compilers>(impl_->compiler, description().index, jobs, impl_->compiler_count);
}

Buffer Device::allocate(std::size_t bytes) {
    bytes = std::max<std::size_t>((bytes + 3) / 4 * 4, 4);
    const DeviceDescription& d = description();
    const std::uint64_t used = impl_->session->allocated_now();
    const auto refuse = [&](const std::string& why) {
        throw Error("device '" + d.name + "': no memory for a buffer of " + std::to_string(bytes) + " bytes (" +
                    format_bytes(bytes) + "): " + why + "; " + format_bytes(used) + " of " +
                    format_bytes(d.global_memory) +
                    " are in use: take a smaller picture or scene, or another device (--device)");
    };
    if (bytes > impl_->largest_allocation)
        refuse("one buffer may have " + std::to_string(impl_->largest_allocation) + " bytes (" +
               format_bytes(impl_->largest_allocation) + ")");
    if (used + bytes > d.global_memory) refuse("the device is full");
    if (impl_->memory_limit > 0) {
        if (used == 0) impl_->resident_before = resident_memory();
        // Buffers become resident as they are written to: those that are not yet count too.
        require_memory(impl_->memory_limit, bytes, "a buffer of device '" + d.name + "'",
                       "take a smaller picture or scene, fewer layers (--aov), or fewer records (a larger --accuracy)",
                       impl_->resident_before + used);
    }
    if (d.is_cpu) {
        // PoCL 3.1 takes memory only when a buffer is first used, and aborts the program if there is none.
        void* const probe = std::malloc(bytes);
        if (probe == nullptr) refuse("the system has no more");
        std::free(probe);
    }
    cl_int status = CL_SUCCESS;
    cl_mem memory = clCreateBuffer(impl_->session->context, CL_MEM_READ_WRITE, bytes, nullptr, &status);
    if (status != CL_SUCCESS) refuse(device::status_name(status));
    Buffer buffer;
    buffer.impl_ = std::make_unique<Buffer::Impl>(impl_->session, memory, bytes, bytes);
    impl_->place(memory);
    return buffer;
}

Buffer Device::upload(const void* data, std::size_t bytes) {
    Buffer buffer = allocate(bytes);
    write(buffer, data, bytes);
    return buffer;
}

Buffer Device::share(const void* data, std::size_t bytes) {
    // Other CPU drivers copy what they are given, or (oclgrind) take it for uninitialised.
    if (!description().is_cpu || description().platform != "Portable Computing Language" || bytes == 0)
        return upload(data, bytes);
    cl_int status = CL_SUCCESS;
    // Kernels do not write to it.
    cl_mem memory = clCreateBuffer(impl_->session->context, CL_MEM_READ_ONLY | CL_MEM_USE_HOST_PTR, bytes,
                                   const_cast<void*>(data), &status);
    if (status != CL_SUCCESS) return upload(data, bytes);  // too large, say: allocate() tells what may be done
    Buffer buffer;
    buffer.impl_ = std::make_unique<Buffer::Impl>(impl_->session, memory, bytes, 0);
    impl_->place(memory);
    return buffer;
}

namespace {

void check_range(const Buffer& buffer, std::size_t bytes, std::size_t offset, const char* doing) {
    if (offset <= buffer.bytes() && bytes <= buffer.bytes() - offset) return;
    throw Error(std::string("device memory: ") + doing + " " + std::to_string(bytes) + " bytes at offset " +
                std::to_string(offset) + " is outside a buffer of " + std::to_string(buffer.bytes()) + " bytes");
}

cl_mem memory_of(const Buffer& buffer) { return static_cast<cl_mem>(buffer.handle()); }

}  // namespace

void Device::write(Buffer& to, const void* data, std::size_t bytes, std::size_t offset) {
    check_range(to, bytes, offset, "writing");
    if (bytes == 0) return;
    Session& s = *impl_->session;
    cl_event event = nullptr;
    std::vector<unsigned char> staging;
    if (bytes <= kStagedWrite && !s.shared_launch) {
        const auto* first = static_cast<const unsigned char*>(data);
        staging.assign(first, first + bytes);
        data = staging.data();  // stays where it is when the vector moves
    }
    const auto start = std::chrono::steady_clock::now();
    const cl_bool wait = staging.empty() ? CL_TRUE : CL_FALSE;
    check(s.shares(bytes) ? s.shared_launch->write(memory_of(to), data, bytes, offset)
                          : clEnqueueWriteBuffer(s.queue, memory_of(to), wait, offset, bytes, data, 0, nullptr, &event),
          "writing " + std::to_string(bytes) + " bytes to the device");
    event != nullptr ? s.track("write", event, std::move(staging)) : s.add_time("write", start);
}

void Device::read(const Buffer& from, void* data, std::size_t bytes, std::size_t offset) {
    check_range(from, bytes, offset, "reading");
    if (bytes == 0) return;
    Session& s = *impl_->session;
    cl_event event = nullptr;
    const auto start = std::chrono::steady_clock::now();
    check(s.shares(bytes)
              ? s.shared_launch->read(memory_of(from), data, bytes, offset)
              : clEnqueueReadBuffer(s.queue, memory_of(from), CL_TRUE, offset, bytes, data, 0, nullptr, &event),
          "reading " + std::to_string(bytes) + " bytes from the device");
    event != nullptr ? s.track("read", event) : s.add_time("read", start);
    s.harvest();
}

void Device::copy(const Buffer& from, Buffer& to, std::size_t bytes) {
    check_range(from, bytes, 0, "copying");
    check_range(to, bytes, 0, "copying");
    if (bytes == 0) return;
    Session& s = *impl_->session;
    cl_event event = nullptr;
    const auto start = std::chrono::steady_clock::now();
    check(s.shares(bytes)
              ? s.shared_launch->copy(memory_of(from), memory_of(to), bytes)
              : clEnqueueCopyBuffer(s.queue, memory_of(from), memory_of(to), 0, 0, bytes, 0, nullptr, &event),
          "copying " + std::to_string(bytes) + " bytes on the device");
    event != nullptr ? s.track("copy", event) : s.add_time("copy", start);
}

void Device::fill(Buffer& buffer, std::uint32_t word, std::size_t bytes) {
    check_range(buffer, bytes, 0, "filling");
    if (bytes % 4 != 0) throw Error("device memory: filling " + std::to_string(bytes) + " bytes, not a multiple of 4");
    if (bytes == 0) return;
    Session& s = *impl_->session;
    cl_event event = nullptr;
    cl_int status = CL_SUCCESS;
    if (s.shared_launch) {
        const auto start = std::chrono::steady_clock::now();
        status = s.shared_launch->fill(memory_of(buffer), word, bytes);
        s.add_time("fill", start);
    } else if (description().platform == "Oclgrind") {
        // Its checker of uninitialised memory (21.10) overlooks fills, and would report all that is read from them.
        const std::vector<std::uint32_t> words(bytes / 4, word);
        status = clEnqueueWriteBuffer(s.queue, memory_of(buffer), CL_TRUE, 0, bytes, words.data(), 0, nullptr, &event);
    } else {
        status = clEnqueueFillBuffer(s.queue, memory_of(buffer), &word, sizeof word, 0, bytes, 0, nullptr, &event);
    }
    check(status, "filling " + std::to_string(bytes) + " bytes on the device");
    if (event != nullptr) s.track("fill", event);
}

void Device::finish() {
    check(clFinish(impl_->session->queue), "waiting for the device");
    impl_->session->harvest();
}

std::map<std::string, StageTime> Device::stage_times() const { return impl_->session->times(); }
std::uint64_t Device::peak_memory() const noexcept { return impl_->session->peak(); }

}  // namespace irradia
