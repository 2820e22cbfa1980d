// Packed scenes.
#include "fuzz_target.h"
#include "irradia/PackedScene.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    return irradia::test::fuzz_file(data, size, ".irradia",
                                    [](const std::string& path) { irradia::read_packed_scene(path); });
}
