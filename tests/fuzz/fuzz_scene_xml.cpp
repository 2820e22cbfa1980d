// Scene files.
#include "fuzz_target.h"
#include "irradia/SceneLoader.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    return irradia::test::fuzz_file(data, size, ".xml", [](const std::string& path) { irradia::load_scene(path); });
}
