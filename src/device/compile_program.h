// A program from its source, by the driver's compiler.
#pragma once
#include <string>

#include "device/opencl.h"

namespace irradia::device {

class Session;

/// A program that was compiled; or none, and why.
struct CompiledProgram {
    cl_program program = nullptr;
    cl_int status = CL_SUCCESS;
    std::string log;           ///< the compiler's, of a program that it refused
    bool own_builtins = true;  ///< false: it took OpenCL's header to compile a text that declares its built-ins itself
};

/// Compiles `source`. Where the text declares the built-ins that it uses (cl/builtins_cpu.h), PoCL is kept from reading
/// OpenCL's header first, unless it refuses such a text. Throws Error if the driver has no room for its files.
CompiledProgram compile_program(const Session& session, const std::string& source, const std::string& options);

}  // namespace irradia::device
