#include "device/compile_program.h"

#include "device/driver_cache.h"
#include "device/session.h"

namespace irradia::device {
namespace {

// The header's guard, and what portable.h asks for. PoCL includes the header before the text, whatever the text says.
constexpr const char* own_builtins = "IR_OWN_BUILTINS";
constexpr const char* without_header = " -D _OPENCL_H_ -D IR_OWN_BUILTINS=1";

std::string build_log(cl_program program, cl_device_id id) {
    std::size_t bytes = 0;
    if (clGetProgramBuildInfo(program, id, CL_PROGRAM_BUILD_LOG, 0, nullptr, &bytes) != CL_SUCCESS || bytes == 0)
        return "(the compiler left no log)";
    std::string log(bytes, '\0');
    if (clGetProgramBuildInfo(program, id, CL_PROGRAM_BUILD_LOG, bytes, log.data(), nullptr) != CL_SUCCESS)
        return "(the compiler's log could not be read)";
    while (!log.empty() && (log.back() == '\0' || log.back() == '\n')) log.pop_back();
    return log;
}

CompiledProgram compile(const Session& session, const std::string& source, const std::string& options) {
    CompiledProgram compiled;
    const char* text = source.c_str();
    const std::size_t length = source.size();
    cl_program program = clCreateProgramWithSource(session.context, 1, &text, &length, &compiled.status);
    if (compiled.status != CL_SUCCESS) return compiled;
    compiled.status = clBuildProgram(program, 1, &session.device.id, options.c_str(), nullptr, nullptr);
    if (compiled.status == CL_SUCCESS) {
        compiled.program = program;
        return compiled;
    }
    compiled.log = build_log(program, session.device.id);
    clReleaseProgram(program);
    return compiled;
}

}  // namespace

CompiledProgram compile_program(const Session& session, const std::string& source, const std::string& options) {
    const DeviceDescription& device = session.device.description;
    check_driver_cache(device);
    const bool declares =
        device.platform == "Portable Computing Language" && device.is_cpu && source.find(own_builtins) != source.npos;
    if (declares) {
        CompiledProgram compiled = compile(session, source, options + without_header);
        if (compiled.program != nullptr) return compiled;
    }
    CompiledProgram compiled = compile(session, source, options);
    compiled.own_builtins = !declares;
    return compiled;
}

}  // namespace irradia::device
