// Preloaded into a program that uses OpenCL: appends the name of each kernel that it launches to the file that the
// environment variable KERNEL_LOG names.
#define CL_TARGET_OPENCL_VERSION 120
#include <CL/cl.h>
#include <dlfcn.h>

#include <cstdio>
#include <cstdlib>

extern "C" cl_int clEnqueueNDRangeKernel(cl_command_queue queue, cl_kernel kernel, cl_uint dimensions,
                                         const size_t* offset, const size_t* global, const size_t* local, cl_uint waits,
                                         const cl_event* wait, cl_event* event) {
    const auto info = reinterpret_cast<decltype(&clGetKernelInfo)>(dlsym(RTLD_NEXT, "clGetKernelInfo"));
    const auto launch = reinterpret_cast<decltype(&clEnqueueNDRangeKernel)>(dlsym(RTLD_NEXT, "clEnqueueNDRangeKernel"));
    char name[256] = "";
    std::FILE* log = std::fopen(std::getenv("KERNEL_LOG"), "a");
    if (info == nullptr || launch == nullptr || log == nullptr ||
        info(kernel, CL_KERNEL_FUNCTION_NAME, sizeof name, name, nullptr) != CL_SUCCESS)
        std::abort();
    std::fprintf(log, "%s\n", name);
    std::fclose(log);
    return launch(queue, kernel, dimensions, offset, global, local, waits, wait, event);
}
