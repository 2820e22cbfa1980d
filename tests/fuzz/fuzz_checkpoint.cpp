// Checkpoints, up to what objects read from them.
#include <cstdlib>
#include <cstring>

#include "core/checksum.h"
#include "fuzz_target.h"
#include "irradia/Checkpoint.h"

namespace {

/// Makes the checksum right, or the fuzzer would see it alone. Files of up to a step of it.
std::string forged(const std::uint8_t* data, std::size_t size) {
    std::string bytes(reinterpret_cast<const char*>(data), size);
    if (size < 16) return bytes;
    const std::uint64_t length = size - 16, sum = irradia::checksum(bytes.data(), length);
    std::memcpy(bytes.data() + length, &length, 8);
    std::memcpy(bytes.data() + length + 8, &sum, 8);
    return bytes;
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    const std::string bytes =
        size % 2 == 0 ? forged(data, size) : std::string(reinterpret_cast<const char*>(data), size);
    return irradia::test::fuzz_file(reinterpret_cast<const std::uint8_t*>(bytes.data()), bytes.size(), ".checkpoint",
                                    [](const std::string& path) {
                                        irradia::Checkpoint in = irradia::Checkpoint::read(path, {{"a", "b"}});
                                        std::vector<double> numbers;
                                        std::vector<std::string> texts;
                                        std::map<std::string, std::uint64_t> map;
                                        std::optional<std::uint32_t> maybe;
                                        in(numbers)(texts)(map);
                                        if (in.has(maybe, [&] { maybe = 0; })) in(*maybe);
                                        in.finish();
                                    });
}
