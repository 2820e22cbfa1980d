// Camera paths.
#include "fuzz_target.h"
#include "irradia/CameraPath.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    return irradia::test::fuzz_file(data, size, ".json",
                                    [](const std::string& path) { irradia::read_camera_path(path); });
}
