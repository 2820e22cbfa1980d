#include <dlfcn.h>
#include <fmt/format.h>

#include <cstdlib>

#include "irradia/Error.h"
#include "pictures/oiio.h"

#define IRRADIA_TEXT_OF(x) #x
#define IRRADIA_TEXT(x) IRRADIA_TEXT_OF(x)

namespace irradia::oiio {
namespace {

constexpr const char* file_name = "libirradia_oiio.so";

/// By its bare name: the dynamic linker looks where the executable's run path says, then where libraries usually are.
const Library& load() {
    const char* folder = std::getenv("IRRADIA_MODULE_DIR");
    const std::string file = folder && *folder ? fmt::format("{}/{}", folder, file_name) : file_name;
    // Local: what asks for symbols later, OpenCL drivers above all, is not to search 260 libraries. Never closed.
    void* module = ::dlopen(file.c_str(), RTLD_LAZY | RTLD_LOCAL);
    void* symbol = module ? ::dlsym(module, IRRADIA_TEXT(IRRADIA_OIIO_SYMBOL)) : nullptr;
    if (!symbol)
        throw Error(
            fmt::format("{}: cannot be loaded, which reads and writes pictures other than .pfm: {} (it is "
                        "installed with Irradia, to ../lib from the executables; IRRADIA_MODULE_DIR names "
                        "another folder; it needs OpenImageIO, Debian: libopenimageio2.4)",
                        file, ::dlerror()));
    return *reinterpret_cast<const Library* (*)()>(symbol)();
}

}  // namespace

const Library& library() {
    static const Library& loaded = load();
    return loaded;
}

}  // namespace irradia::oiio
