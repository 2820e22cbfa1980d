#include <dlfcn.h>
#include <fmt/format.h>

#include <cstdlib>

#include "irradia/Error.h"
#include "pictures/exr.h"
#include "pictures/oiio.h"

#define IRRADIA_TEXT_OF(x) #x
#define IRRADIA_TEXT(x) IRRADIA_TEXT_OF(x)

namespace irradia {
namespace {

struct Module {
    const char *file, *symbol, *purpose, *needs;
};

/// By its bare name: the dynamic linker looks where the executable's run path says, then where libraries usually are.
template <typename Library>
const Library& load(const Module& wanted) {
    const char* folder = std::getenv("IRRADIA_MODULE_DIR");
    const std::string file = folder && *folder ? fmt::format("{}/{}", folder, wanted.file) : wanted.file;
    // Local: what asks for symbols later, OpenCL drivers above all, is not to search 260 libraries. Never closed.
    void* module = ::dlopen(file.c_str(), RTLD_LAZY | RTLD_LOCAL);
    void* symbol = module ? ::dlsym(module, wanted.symbol) : nullptr;
    if (!symbol)
        throw Error(
            fmt::format("{}: cannot be loaded, which {}: {} (it is installed with Irradia, to ../lib from the "
                        "executables; IRRADIA_MODULE_DIR names another folder; it needs {})",
                        file, wanted.purpose, ::dlerror(), wanted.needs));
    return *reinterpret_cast<const Library* (*)()>(symbol)();
}

}  // namespace

const oiio::Library& oiio::library() {
    static const Library& loaded =
        load<Library>({"libirradia_oiio.so", IRRADIA_TEXT(IRRADIA_OIIO_SYMBOL),
                       "reads pictures other than .pfm, and writes .png", "OpenImageIO, Debian: libopenimageio2.4"});
    return loaded;
}

const exr::Library& exr::library() {
    static const Library& loaded = load<Library>(
        {"libirradia_exr.so", IRRADIA_TEXT(IRRADIA_EXR_SYMBOL), "writes .exr", "OpenEXR, Debian: libopenexr-3-1-30"});
    return loaded;
}

}  // namespace irradia
