// Lists of jobs.
#include "app/batch_file.h"
#include "fuzz_target.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    return irradia::test::fuzz_file(data, size, ".json", [](const std::string& path) {
        irradia::app::read_batch(path, {{"spp", {"4"}}});
    });
}
